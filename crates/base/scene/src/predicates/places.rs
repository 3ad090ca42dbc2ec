//! Places of the table top: named regions and distances to edges.

use glam::DVec2;

use super::PosedFootprint;
use crate::description::RelationKind;
use geometry::Outline;

/// Regions of a table top in shares of its box: -1..1 from left to right (x) and from front to back (y). `None` for
/// relations without a region.
pub fn place_shares(place: RelationKind) -> Option<(DVec2, DVec2)> {
    // Corners leave out the central third, so that they exist on round tables.
    const CORNER: f64 = 1.0 / 3.0;
    let range = |low: (f64, f64), high: (f64, f64)| Some((DVec2::from(low), DVec2::from(high)));
    match place {
        RelationKind::AtCenter => range((-0.4, -0.4), (0.4, 0.4)),
        RelationKind::AtBack => range((-1.0, 0.12), (1.0, 1.0)),
        RelationKind::AtFront => range((-1.0, -1.0), (1.0, -0.12)),
        RelationKind::AtLeft => range((-1.0, -1.0), (-0.2, 1.0)),
        RelationKind::AtRight => range((0.2, -1.0), (1.0, 1.0)),
        RelationKind::AtBackLeft => range((-1.0, CORNER), (-CORNER, 1.0)),
        RelationKind::AtBackRight => range((CORNER, CORNER), (1.0, 1.0)),
        RelationKind::AtFrontLeft => range((-1.0, -1.0), (-CORNER, -CORNER)),
        RelationKind::AtFrontRight => range((CORNER, -1.0), (1.0, -CORNER)),
        _ => None,
    }
}

/// Whether a point lies in a named region of the table, with a tolerance of a twentieth of half its width and depth;
/// `None` for relations without a region.
pub fn is_at_place(place: RelationKind, at: DVec2, table: &Outline) -> Option<bool> {
    const TOLERANCE: f64 = 0.05;
    let (low, high) = place_shares(place)?;
    let (from, to) = table.bounds();
    let shares = (at - 0.5 * (from + to)) / (0.5 * (to - from));
    Some(shares.cmpge(low - TOLERANCE).all() && shares.cmple(high + TOLERANCE).all())
}

/// Free distance between a footprint and an edge of the table's box, meters; `None` for relations without an edge.
pub fn edge_distance_m(edge: RelationKind, object: &PosedFootprint, table: &Outline) -> Option<f64> {
    let (low, high) = object.bounds();
    let (from, to) = table.bounds();
    Some(match edge {
        RelationKind::FromLeftEdge => low.x - from.x,
        RelationKind::FromRightEdge => to.x - high.x,
        RelationKind::FromFrontEdge => low.y - from.y,
        RelationKind::FromBackEdge => to.y - high.y,
        _ => return None,
    })
}
