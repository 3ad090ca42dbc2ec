//! Support surfaces: the table top or the top of an object.

use glam::DVec2;
use rand::RngExt;

use super::{Footprint, HeightMap, Placement};
use catalog::Zone;
use geometry::Outline;
use runtime::seed::Rng;
use scene::RelationKind;

/// A surface on which groups are placed.
pub(super) enum SupportSurface<'a> {
    Table {
        outline: &'a Outline,
        margin_m: f64,
        place_settings: Vec<(usize, Placement)>,
        /// Share of the table's width and depth, about its center, that objects without a stated place use.
        used_share: f64,
    },
    /// The top of an object, in its frame.
    Top { footprint: &'a Footprint, height_map: &'a HeightMap },
}

impl SupportSurface<'_> {
    /// Lowest and highest corner of the surface's box.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        match self {
            SupportSurface::Table { outline, .. } => outline.bounds(),
            SupportSurface::Top { footprint, .. } => footprint.bounds(),
        }
    }

    /// The place setting of a plate.
    pub fn setting_of(&self, object: usize) -> Option<&Placement> {
        let SupportSurface::Table { place_settings, .. } = self else { return None };
        place_settings.iter().find(|(plate, _)| *plate == object).map(|(_, setting)| setting)
    }

    /// Half extents, meters.
    pub fn half_m(&self) -> DVec2 {
        let (low, high) = self.bounds();
        0.5 * (high - low)
    }

    /// Normalized coordinates: -1..1 from left to right and from front to back.
    pub fn shares(&self, at: DVec2) -> DVec2 {
        let (low, high) = self.bounds();
        (at - 0.5 * (low + high)) / self.half_m().max(DVec2::splat(1e-9))
    }

    fn at_shares(&self, shares: DVec2) -> DVec2 {
        let (low, high) = self.bounds();
        0.5 * (low + high) + shares * self.half_m()
    }

    /// Whether a footprint lies on the surface, this far from the edge of a table.
    pub fn allows(&self, footprint: &Footprint, margin_m: f64) -> bool {
        match self {
            SupportSurface::Table { outline, .. } => footprint.depth_inside_m(outline) >= margin_m,
            SupportSurface::Top { footprint: top, .. } => {
                let center = Footprint::around([footprint.center()].into_iter());
                center.depth_in_m(top) > 0.0
            }
        }
    }

    /// Distance to the edge of the surface from a point in a direction, at most `max_m`, meters.
    pub fn free_distance_m(&self, from: DVec2, direction: DVec2, max_m: f64) -> f64 {
        const STEP_M: f64 = 0.01;
        let SupportSurface::Table { outline, margin_m, .. } = self else { return max_m };
        let steps = (max_m / STEP_M).ceil() as u32;
        (1..=steps)
            .map(|step| STEP_M * f64::from(step))
            .find(|distance_m| outline.depth_inside_m(from + *distance_m * direction) < *margin_m)
            .map_or(max_m, |beyond_m| beyond_m - STEP_M)
    }

    /// Cost of a position: the deviation from the category's zone, or overhang and unevenness on an object.
    pub fn cost(&self, footprint: &Footprint, zone: Zone) -> f64 {
        match self {
            SupportSurface::Table { used_share, .. } => {
                let at = self.shares(footprint.center()) / *used_share;
                match zone {
                    Zone::Back => 1.2 * (at.y - 0.65).powi(2) + 0.1 * at.x * at.x,
                    Zone::Center => 0.7 * at.length_squared(),
                    Zone::Front => 0.8 * (at.y + 0.5).powi(2) + 0.3 * at.x * at.x,
                    Zone::Side => 0.8 * (at.x.abs() - 0.65).powi(2),
                    Zone::Any => 0.2 * at.length_squared(),
                }
            }
            SupportSurface::Top { footprint: top, height_map } => {
                let overhang_m = (-footprint.depth_in_m(top)).max(0.0);
                let off_m = footprint.center().distance(top.center());
                30.0 * overhang_m + 4.0 * off_m + height_map.unevenness(footprint)
            }
        }
    }

    /// A random position for an object of this zone, within the used part of a table.
    pub fn candidate(&self, zone: Zone, rng: &mut Rng) -> DVec2 {
        let anywhere = matches!(self, SupportSurface::Top { .. }) || rng.random_bool(0.2);
        let zone = if anywhere { Zone::Any } else { zone };
        let (x, y): ((f64, f64), (f64, f64)) = match zone {
            Zone::Back => ((-0.95, 0.95), (0.2, 0.98)),
            Zone::Center => ((-0.5, 0.5), (-0.5, 0.5)),
            Zone::Front => ((-0.9, 0.9), (-0.98, 0.0)),
            Zone::Side if rng.random_bool(0.5) => ((-0.98, -0.4), (-0.8, 0.9)),
            Zone::Side => ((0.4, 0.98), (-0.8, 0.9)),
            Zone::Any => ((-0.98, 0.98), (-0.98, 0.98)),
        };
        let used_share = match self {
            SupportSurface::Table { used_share, .. } => *used_share,
            SupportSurface::Top { .. } => 1.0,
        };
        self.at_shares(used_share * DVec2::new(rng.random_range(x.0..x.1), rng.random_range(y.0..y.1)))
    }

    /// A random position in a named region; `None` for relations without a region.
    pub fn named_candidate(&self, place: RelationKind, rng: &mut Rng) -> Option<DVec2> {
        let (x, y) = region(place)?;
        Some(self.at_shares(DVec2::new(rng.random_range(x.0..x.1), rng.random_range(y.0..y.1))))
    }

    /// Cost of a point in a named corner: the deviation from the corner's usual position, 0 for other places.
    pub fn corner_cost(&self, at: DVec2, place: RelationKind) -> f64 {
        let Some(((x0, x1), (y0, y1))) = region(place).filter(|_| is_corner(place)) else { return 0.0 };
        let usual = 0.8 * DVec2::new(x0 + x1, y0 + y1).signum();
        1.5 * self.shares(at).distance(usual)
    }

    /// Whether a point lies in the named region; true for relations without a region.
    pub fn is_at(&self, at: DVec2, place: RelationKind, tolerance_factor: f64) -> bool {
        let Some((x, y)) = region(place) else { return true };
        let shares = self.shares(at);
        // Corners are smaller than sides.
        let share = if is_corner(place) { 0.02 } else { 0.1 };
        let tolerance = share * (tolerance_factor - 1.0);
        let within =
            |value: f64, (low, high): (f64, f64)| value >= low - tolerance && value <= high + tolerance;
        within(shares.x, x) && within(shares.y, y)
    }
}

fn is_corner(place: RelationKind) -> bool {
    use RelationKind::{AtBackLeft, AtBackRight, AtFrontLeft, AtFrontRight};
    matches!(place, AtBackLeft | AtBackRight | AtFrontLeft | AtFrontRight)
}

/// Range of a named region in normalized coordinates: x from left to right, y from front to back.
fn region(place: RelationKind) -> Option<((f64, f64), (f64, f64))> {
    // Thirds of the table. Late attempts, and the relation itself, are content with less.
    const THIRD: f64 = 0.34;
    Some(match place {
        RelationKind::AtCenter => ((-0.32, 0.32), (-0.32, 0.32)),
        RelationKind::AtBack => ((-0.95, 0.95), (THIRD, 1.0)),
        RelationKind::AtFront => ((-0.95, 0.95), (-1.0, -THIRD)),
        RelationKind::AtLeft => ((-1.0, -THIRD), (-0.95, 0.95)),
        RelationKind::AtRight => ((THIRD, 1.0), (-0.95, 0.95)),
        RelationKind::AtBackLeft => ((-0.98, -THIRD), (THIRD, 0.98)),
        RelationKind::AtBackRight => ((THIRD, 0.98), (THIRD, 0.98)),
        RelationKind::AtFrontLeft => ((-0.98, -THIRD), (-0.98, -THIRD)),
        RelationKind::AtFrontRight => ((THIRD, 0.98), (-0.98, -THIRD)),
        _ => return None,
    })
}
