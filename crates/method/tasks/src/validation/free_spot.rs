//! A quick test whether there may be a free place, before the exact search.
//!
//! The exact search takes tens of seconds to find that there is none. Here the footprint of the object is laid over a
//! grid of 1 cm in sixteen yaws; in its way are the convex parts of other objects at the heights that it would occupy.
//! With [`NO_SPACE_M`] the test errs toward free places; with [`AMPLE_SPACE_M`] the exact search finds one soon. At
//! most a tenth of a second.

use editing::{PlaceQuery, Workspace, WorkspaceObject};
use geometry::ConvexHull;
use geometry::polygon::{convex_distance_m, convex_hull_2d, depth_in_convex_m};
use glam::DVec2;
use scene::predicates::{PosedFootprint, PosedRelation, holds};
use scene::{RelationKind, SupportTree};

use crate::evaluation::OVERHANG_M;
use crate::posed_object::PosedObject;

const STEP_M: f64 = 0.01;
/// Free distance to others: overlaps of up to half a step count as free, meters.
pub(super) const NO_SPACE_M: f64 = -0.5 * STEP_M;
/// Free distance to others that is more than the exact search keeps at first, meters.
pub(super) const AMPLE_SPACE_M: f64 = 0.012;
/// Yaws, those of the exact search.
const YAWS: u32 = 16;
/// Heights of parts that may be touched on top of a support, meters.
const SKIN_M: f64 = 0.002;

/// A convex part of an obstacle, seen from above.
struct Part {
    corners: Vec<DVec2>,
    low: DVec2,
    high: DVec2,
}

/// Whether the object may have a place that meets the query, with this distance to others; `true` for containers, which
/// are not tested.
pub(super) fn may_be_free(
    workspace: &Workspace,
    posed: &PosedObject,
    object: usize,
    query: &PlaceQuery,
    space_m: f64,
) -> bool {
    let target = query.target.map(|target| workspace.objects[target].footprint());
    let support = match query.relation {
        Some(RelationKind::In) => return true,
        Some(kind) if kind.is_support() => target.as_ref(),
        // Beside what does not stand on the table, another surface may be meant.
        Some(_) if query.target.is_some_and(|t| workspace.objects[t].supporter.parent.is_some()) => {
            return true;
        }
        _ => None,
    };
    let footprint = workspace.objects[object].footprint();
    let height_m = footprint.top_m - footprint.bottom_m;
    let floor_m = support.map_or(0.0, |support| support.top_m);
    let skip = |other: usize| support.is_some() && query.target == Some(other);
    let parts = parts_between(workspace, object, [floor_m + SKIN_M, floor_m + height_m], skip);
    let second = query.second_target.map(|second| workspace.objects[second].footprint());
    let (low, high) = support.map_or_else(|| workspace.outline.bounds(), PosedFootprint::bounds);
    let counts = ((high - low) / STEP_M).ceil();
    let mass_offset_m = posed.center_of_mass_m().truncate() - footprint.center();
    (0..YAWS).any(|turn| {
        let rotation = DVec2::from_angle(std::f64::consts::TAU * f64::from(turn) / f64::from(YAWS));
        let corners: Vec<DVec2> =
            footprint.corners().iter().map(|corner| rotation.rotate(*corner - footprint.center())).collect();
        let reach = corners.iter().fold(DVec2::ZERO, |reach, corner| reach.max(corner.abs()));
        let mass_m = rotation.rotate(mass_offset_m);
        (0..=counts.y as u32).any(|row| {
            (0..=counts.x as u32).any(|column| {
                let center = low + STEP_M * DVec2::new(f64::from(column), f64::from(row));
                let moved: Vec<DVec2> = corners.iter().map(|corner| center + *corner).collect();
                let carried = match support {
                    Some(support) => {
                        depth_in_convex_m(support.corners(), center) >= 0.0
                            && depth_in_convex_m(support.corners(), center + mass_m) >= -OVERHANG_M
                    }
                    None => {
                        is_related(workspace, query, [target.as_ref(), second.as_ref()], &moved, &footprint)
                    }
                };
                carried
                    && moved.iter().all(|corner| workspace.outline.contains(*corner))
                    && !parts.iter().any(|part| {
                        let apart =
                            (center - reach).cmpgt(part.high).any() || part.low.cmpgt(center + reach).any();
                        !apart && convex_distance_m(&part.corners, &moved) < space_m
                    })
            })
        })
    })
}

/// Whether the relation of the query holds for a footprint; yaws do not matter for these.
fn is_related(
    workspace: &Workspace,
    query: &PlaceQuery,
    [target, second_target]: [Option<&PosedFootprint>; 2],
    corners: &[DVec2],
    now: &PosedFootprint,
) -> bool {
    let Some(kind) = query.relation else { return true };
    let object = PosedFootprint::new(corners, now.yaw_rad, now.bottom_m, now.top_m);
    let relation =
        PosedRelation { kind, object: &object, target, second_target, distance_m: query.distance_m };
    holds(&relation, &workspace.outline)
}

/// Convex parts of other objects between two heights, but not of what moves along.
fn parts_between(
    workspace: &Workspace,
    object: usize,
    [low_m, high_m]: [f64; 2],
    skip: impl Fn(usize) -> bool,
) -> Vec<Part> {
    let supports: SupportTree = workspace.supports();
    let branch: Vec<usize> = supports.branch(object).collect();
    let others = workspace.objects.iter().enumerate();
    others
        .filter(|(index, other)| other.is_placed && !branch.contains(index) && !skip(*index))
        .flat_map(|(_, other)| {
            other.body.hulls.iter().filter_map(move |hull| part(other, hull, [low_m, high_m]))
        })
        .collect()
}

fn part(object: &WorkspaceObject, hull: &ConvexHull, [low_m, high_m]: [f64; 2]) -> Option<Part> {
    let points: Vec<_> =
        hull.points.iter().map(|point| object.body.world_from_object.transform_point(*point)).collect();
    let bottom_m = points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
    let top_m = points.iter().map(|point| point.z).fold(f64::NEG_INFINITY, f64::max);
    if top_m <= low_m || bottom_m >= high_m {
        return None;
    }
    let corners = convex_hull_2d(&points.iter().map(|point| point.truncate()).collect::<Vec<_>>());
    let low = corners.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    Some(Part { corners, low, high })
}
