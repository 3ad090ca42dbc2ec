//! What groups are placed on: the table or the top of a thing.

use glam::DVec2;
use rand::RngExt;

use super::{Footprint, Placement, Relief};
use catalog::Zone;
use geometry::Outline;
use runtime::seed::Rng;
use scene::RelationKind;

/// A surface.
pub(super) enum Ground<'a> {
    Table {
        outline: &'a Outline,
        margin_m: f64,
        seats: Vec<(usize, Placement)>,
    },
    /// In the supporter's frame.
    Top {
        footprint: &'a Footprint,
        relief: &'a Relief,
    },
}

impl Ground<'_> {
    fn bounds(&self) -> (DVec2, DVec2) {
        match self {
            Ground::Table { outline, .. } => outline.bounds(),
            Ground::Top { footprint, .. } => footprint.bounds(),
        }
    }

    /// Half its extents, meters.
    pub fn half_m(&self) -> DVec2 {
        let (low, high) = self.bounds();
        0.5 * (high - low)
    }

    /// -1..1 from left to right and from front to back.
    pub fn shares(&self, at: DVec2) -> DVec2 {
        let (low, high) = self.bounds();
        (at - 0.5 * (low + high)) / self.half_m().max(DVec2::splat(1e-9))
    }

    fn at_shares(&self, shares: DVec2) -> DVec2 {
        let (low, high) = self.bounds();
        0.5 * (low + high) + shares * self.half_m()
    }

    /// Whether something may stand so.
    pub fn allows(&self, footprint: &Footprint) -> bool {
        match self {
            Ground::Table { outline, margin_m, .. } => footprint.depth_inside_m(outline) >= *margin_m,
            Ground::Top { footprint: top, .. } => {
                let middle = Footprint::around([footprint.center()].into_iter());
                middle.depth_in_m(top) > 0.0
            }
        }
    }

    /// How far the surface reaches from a point in a direction, at most `enough_m`, meters.
    pub fn room_m(&self, from: DVec2, direction: DVec2, enough_m: f64) -> f64 {
        const STEP_M: f64 = 0.01;
        let Ground::Table { outline, margin_m, .. } = self else { return enough_m };
        let steps = (enough_m / STEP_M).ceil() as u32;
        (1..=steps)
            .map(|step| STEP_M * f64::from(step))
            .find(|way_m| outline.depth_inside_m(from + *way_m * direction) < *margin_m)
            .map_or(enough_m, |beyond_m| beyond_m - STEP_M)
    }

    /// How unlike people's habit the place is.
    pub fn cost(&self, footprint: &Footprint, zone: Zone) -> f64 {
        match self {
            Ground::Table { .. } => {
                let at = self.shares(footprint.center());
                match zone {
                    Zone::Back => 1.2 * (at.y - 0.65).powi(2) + 0.1 * at.x * at.x,
                    Zone::Center => 0.7 * at.length_squared(),
                    Zone::Front => 0.8 * (at.y + 0.5).powi(2) + 0.3 * at.x * at.x,
                    Zone::Side => 0.8 * (at.x.abs() - 0.65).powi(2),
                    Zone::Any => 0.2 * at.length_squared(),
                }
            }
            Ground::Top { footprint: top, relief } => {
                let overhang_m = (-footprint.depth_in_m(top)).max(0.0);
                let off_m = footprint.center().distance(top.center());
                30.0 * overhang_m + 4.0 * off_m + relief.unevenness(footprint)
            }
        }
    }

    /// A place to try for a thing of that zone.
    pub fn candidate(&self, zone: Zone, rng: &mut Rng) -> DVec2 {
        let anywhere = matches!(self, Ground::Top { .. }) || rng.random_bool(0.2);
        let zone = if anywhere { Zone::Any } else { zone };
        let (x, y): ((f64, f64), (f64, f64)) = match zone {
            Zone::Back => ((-0.95, 0.95), (0.2, 0.98)),
            Zone::Center => ((-0.5, 0.5), (-0.5, 0.5)),
            Zone::Front => ((-0.9, 0.9), (-0.98, 0.0)),
            Zone::Side if rng.random_bool(0.5) => ((-0.98, -0.4), (-0.8, 0.9)),
            Zone::Side => ((0.4, 0.98), (-0.8, 0.9)),
            Zone::Any => ((-0.98, 0.98), (-0.98, 0.98)),
        };
        self.at_shares(DVec2::new(rng.random_range(x.0..x.1), rng.random_range(y.0..y.1)))
    }

    /// A place to try at a named part; `None` for relations that name none.
    pub fn named_candidate(&self, place: RelationKind, rng: &mut Rng) -> Option<DVec2> {
        let (x, y) = part(place)?;
        Some(self.at_shares(DVec2::new(rng.random_range(x.0..x.1), rng.random_range(y.0..y.1))))
    }

    /// Whether a point lies at the named part; other relations hold anyway.
    pub fn is_at(&self, at: DVec2, place: RelationKind, slack: f64) -> bool {
        let Some((x, y)) = part(place) else { return true };
        let shares = self.shares(at);
        let more = 0.1 * (slack - 1.0);
        let within = |value: f64, (low, high): (f64, f64)| value >= low - more && value <= high + more;
        within(shares.x, x) && within(shares.y, y)
    }
}

/// Shares of the surface a named part spans: x from left to right, y from front to back.
fn part(place: RelationKind) -> Option<((f64, f64), (f64, f64))> {
    Some(match place {
        RelationKind::AtCenter => ((-0.4, 0.4), (-0.4, 0.4)),
        RelationKind::AtBack => ((-0.95, 0.95), (0.12, 1.0)),
        RelationKind::AtFront => ((-0.95, 0.95), (-1.0, -0.12)),
        RelationKind::AtLeft => ((-1.0, -0.2), (-0.95, 0.95)),
        RelationKind::AtRight => ((0.2, 1.0), (-0.95, 0.95)),
        _ => return None,
    })
}
