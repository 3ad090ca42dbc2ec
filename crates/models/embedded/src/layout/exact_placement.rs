//! Exact placement: moves a candidate placement until it meets its demands.
//!
//! Method: cyclic projection. Each demand moves or turns the group by the smallest amount that meets it; the sweep
//! repeats until nothing moves. A placement is feasible if another sweep would move it by less than half a centimeter
//! and turn it by less than four degrees. Demands whose other objects are not placed yet wait for them. World frame (or
//! the supporter's frame), meters, radians.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;

use super::group::LayoutAttempt;
use super::placement_sampler::PartialLayout;
use super::stated_demands::{Demand, DemandKind};
use super::support_surface::SupportSurface;
use super::yielding::Yielding;
use super::{Footprint, Placement};
use geometry::polygon::convex_distance_m;
use geometry::pose::wrap_angle_rad;
use scene::RelationKind;
use scene::predicates::{NEXT_TO_M, direction_of, long_side_rad, place_shares};

/// Sweeps over the demands.
const SWEEPS: usize = 16;
/// Movement of a sweep that still counts as met.
const MAX_RESIDUAL_M: f64 = 0.005;
const MAX_RESIDUAL_RAD: f64 = 0.07;
/// Range of an object between two others, as a share of the segment between their centers.
const BETWEEN_SHARES: (f64, f64) = (0.37, 0.63);
/// Distance from that segment, as a share of its length.
const BETWEEN_OFF_SHARE: f64 = 0.15;

impl LayoutAttempt<'_> {
    /// The placement nearest to `at` that meets the demands on the group as far as possible; `at` without demands.
    pub(super) fn projected(&self, layout: &PartialLayout, group: usize, at: Placement) -> Placement {
        let demands = self.demands_on(layout, group);
        let own = &layout.groups[group];
        let mut placement = at;
        if own.bases.len() > 1 && layout.surface.setting_of(own.root).is_none() {
            // Rows are parallel to the front edge.
            placement = turned_about_center(&own.footprint, &placement, 0.0);
        }
        if demands.is_empty() {
            return placement;
        }
        for _ in 0..SWEEPS {
            let before = placement;
            for demand in &demands {
                placement = self.step(layout, group, demand, placement);
            }
            placement = self.step_to_places(layout, group, placement);
            let moved_m = before.xy_m.distance(placement.xy_m);
            if moved_m < 1e-4 && (before.yaw_rad - placement.yaw_rad).abs() < 1e-3 {
                break;
            }
        }
        placement
    }

    /// Whether the placement meets the demands on the group.
    pub(super) fn meets_demands(&self, layout: &PartialLayout, group: usize, at: &Placement) -> bool {
        self.demands_on(layout, group).iter().all(|demand| {
            let next = self.step(layout, group, demand, *at);
            // A turn about the center also moves the origin.
            let own = &layout.groups[group].footprint;
            let moved_m = own.placed(&next).center().distance(own.placed(at).center());
            let is_turn = matches!(
                demand.kind,
                DemandKind::Yaw { .. } | DemandKind::Facing { .. } | DemandKind::Parallel { .. }
            );
            let turned_rad = wrap_angle_rad(next.yaw_rad - at.yaw_rad).abs();
            if is_turn && turned_rad > 0.0 { turned_rad < MAX_RESIDUAL_RAD } else { moved_m < MAX_RESIDUAL_M }
        })
    }

    /// Smallest free distance between two groups: the usual gap, or less where a smaller distance is stated.
    pub(super) fn pair_gap_m(&self, layout: &PartialLayout, a: usize, b: usize) -> f64 {
        let stated = self.stated.demands.iter().filter_map(|demand| match demand.kind {
            DemandKind::Distance { target, distance_m, .. } => {
                let pair = [layout.group_of(demand.object)?, layout.group_of(target)?];
                (pair == [a, b] || pair == [b, a]).then_some(distance_m - 0.004)
            }
            _ => None,
        });
        stated.fold(self.gap_m, f64::min)
    }

    /// Smallest distance of a group to the edge: the usual margin, or less where a smaller distance is stated.
    pub(super) fn margin_m(&self, layout: &PartialLayout, group: usize) -> f64 {
        let stated = self.stated.demands.iter().filter_map(|demand| match demand.kind {
            DemandKind::Edge { distance_m: Some(distance_m), .. }
                if layout.group_of(demand.object) == Some(group) =>
            {
                Some((distance_m - 0.002).max(0.0))
            }
            _ => None,
        });
        stated.fold(self.settings.edge_margin_m, f64::min)
    }

    /// The demands that can be evaluated for the group: on its objects, with placed targets, or on placed objects with
    /// a target in the group.
    fn demands_on(&self, layout: &PartialLayout, group: usize) -> Vec<Demand> {
        if self.yielding >= Yielding::Relations {
            return Vec::new();
        }
        let own = &layout.groups[group];
        let is_table = matches!(layout.surface, SupportSurface::Table { .. });
        let is_exact = self.yielding < Yielding::Distances;
        let is_here = |object: usize| layout.group_of(object) == Some(group);
        let is_placed = |object: usize| layout.group_of(object).is_some_and(|g| layout.placed[g].is_some());
        let applies = |demand: &&Demand| {
            let object = demand.object;
            match demand.kind {
                DemandKind::Yaw { .. } => is_exact && own.bases == [object],
                DemandKind::Position { .. } => is_exact && is_table && is_here(object),
                DemandKind::Edge { distance_m, .. } => {
                    let holds =
                        if distance_m.is_some() { is_exact } else { self.yielding < Yielding::Places };
                    holds && is_table && is_here(object)
                }
                DemandKind::Facing { target: None } | DemandKind::Parallel { target: None } => {
                    is_table && own.bases == [object]
                }
                DemandKind::Facing { target: Some(target) } => {
                    (own.bases == [object] && is_placed(target)) || (is_here(target) && is_placed(object))
                }
                DemandKind::Parallel { target: Some(target) } => {
                    (own.bases == [object] && is_placed(target))
                        || (own.bases == [target] && is_placed(object))
                }
                DemandKind::Distance { target, .. } => {
                    is_exact
                        && ((is_here(object) && is_placed(target)) || (is_here(target) && is_placed(object)))
                }
                DemandKind::Between { first, second } => {
                    let known = [object, first, second].map(|k| is_here(k) || is_placed(k));
                    let here = [object, first, second].iter().filter(|k| is_here(**k)).count();
                    here == 1 && known[1] && known[2]
                }
            }
        };
        self.stated.demands.iter().filter(applies).copied().collect()
    }

    /// The placement after the smallest movement that meets one demand.
    fn step(&self, layout: &PartialLayout, group: usize, demand: &Demand, at: Placement) -> Placement {
        let own = &layout.groups[group];
        let find = |object: usize| -> Option<(Footprint, f64)> {
            let g = layout.group_of(object)?;
            let placement = if g == group { at } else { layout.placed[g]? };
            layout.groups[g].member_at(object, &placement)
        };
        let is_here = |object: usize| layout.group_of(object) == Some(group);
        let moved = |by: DVec2| Placement { xy_m: at.xy_m + by, ..at };
        let turned = |object: usize, yaw_rad: f64| {
            let by = find(object).map_or(0.0, |(_, current)| wrap_angle_rad(yaw_rad - current));
            turned_about_center(&own.footprint, &at, at.yaw_rad + by)
        };
        if let DemandKind::Between { first, second } = demand.kind {
            return self.step_between(layout, group, [demand.object, first, second], &find, at);
        }
        let Some((footprint, yaw_rad)) = find(demand.object) else { return at };
        let (low, high) = layout.surface.bounds();
        match demand.kind {
            DemandKind::Yaw { yaw_rad } => turned(demand.object, yaw_rad),
            DemandKind::Facing { target } => {
                let center = match target {
                    Some(target) => find(target).map(|(footprint, _)| footprint.center()),
                    None => Some(0.5 * (low + high)),
                };
                let Some(center) = center else { return at };
                let toward = center - footprint.center();
                if toward.length() < 1e-6 {
                    at
                } else if is_here(demand.object) {
                    turned(demand.object, toward.to_angle() + FRAC_PI_2)
                } else {
                    let front = DVec2::from_angle(yaw_rad - FRAC_PI_2);
                    moved(footprint.center() + toward.length() * front - center)
                }
            }
            DemandKind::Parallel { target } => {
                let along = |(footprint, yaw_rad): (Footprint, f64)| {
                    (long_side_rad(footprint.corners(), yaw_rad), yaw_rad)
                };
                let of_target = match target {
                    Some(target) => find(target).map(along),
                    None => Some((0.0, 0.0)),
                };
                let Some((target_rad, target_yaw)) = of_target else { return at };
                // Half turns are parallel.
                let own_rad = long_side_rad(footprint.corners(), yaw_rad);
                let off = 0.5 * wrap_angle_rad(2.0 * (target_rad - own_rad));
                match target {
                    Some(target) if is_here(target) => turned(target, target_yaw - off),
                    _ => turned(demand.object, yaw_rad + off),
                }
            }
            DemandKind::Position { at_m } => moved(0.5 * (low + high) + at_m - footprint.center()),
            DemandKind::Edge { edge, distance_m } => {
                let (from, to) = footprint.bounds();
                let (inward, free_m) = match edge {
                    RelationKind::FromLeftEdge => (DVec2::X, from.x - low.x),
                    RelationKind::FromRightEdge => (-DVec2::X, high.x - to.x),
                    RelationKind::FromFrontEdge => (DVec2::Y, from.y - low.y),
                    _ => (-DVec2::Y, high.y - to.y),
                };
                let wanted_m = distance_m.unwrap_or_else(|| free_m.min(NEXT_TO_M - 0.03));
                moved((wanted_m - free_m) * inward)
            }
            DemandKind::Distance { relation, target, distance_m } => {
                let Some((other, _)) = find(target) else { return at };
                let offset = footprint.center() - other.center();
                let way =
                    direction_of(relation).unwrap_or_else(|| offset.try_normalize().unwrap_or(DVec2::X));
                let missing_m = distance_m - convex_distance_m(footprint.corners(), other.corners());
                moved(if is_here(demand.object) { missing_m * way } else { -missing_m * way })
            }
            DemandKind::Between { .. } => at,
        }
    }

    /// The step for the demand that the first object is between the other two.
    fn step_between(
        &self,
        layout: &PartialLayout,
        group: usize,
        [object, first, second]: [usize; 3],
        find: &dyn Fn(usize) -> Option<(Footprint, f64)>,
        at: Placement,
    ) -> Placement {
        let is_here = |object: usize| layout.group_of(object) == Some(group);
        let moved = |by: DVec2| Placement { xy_m: at.xy_m + by, ..at };
        let (Some((a, _)), Some((b, _))) = (find(first), find(second)) else { return at };
        let segment = b.center() - a.center();
        let Some(way) = segment.try_normalize() else { return at };
        let length_m = segment.length();
        match find(object) {
            Some((footprint, _)) if is_here(object) => {
                // As far from the one as from the other.
                let free = (a.extent_m(way), length_m - b.extent_m(-way));
                let wanted = 0.5 * (free.0 + free.1) / length_m;
                let wanted = wanted.clamp(BETWEEN_SHARES.0, BETWEEN_SHARES.1);
                let max_off_m = BETWEEN_OFF_SHARE * length_m;
                let off_m = (footprint.center() - a.center()).dot(way.perp()).clamp(-max_off_m, max_off_m);
                let center = a.center() + wanted * segment + off_m * way.perp();
                moved(center - footprint.center())
            }
            // The object is placed: the mirror image of the other end.
            Some((footprint, _)) => moved(2.0 * footprint.center() - a.center() - b.center()),
            // Space for the object.
            None => {
                let outward = if is_here(first) { -way } else { way };
                let size_m = 2.0 * self.objects[object].footprint.radius_m() + 2.0 * self.gap_m + 0.005;
                let (one_m, other_m) = (a.extent_m(way), b.extent_m(-way));
                let needed_m = (one_m + other_m + size_m).max(1.6 * (one_m.max(other_m) + 0.5 * size_m));
                moved((needed_m - length_m).max(0.0) * outward)
            }
        }
    }

    /// The placement moved into the named places of the group and inside the box of the table.
    fn step_to_places(&self, layout: &PartialLayout, group: usize, at: Placement) -> Placement {
        let SupportSurface::Table { .. } = layout.surface else { return at };
        let own = &layout.groups[group];
        let mut at = at;
        if self.yielding < Yielding::Places {
            for &base in &own.bases {
                for (place, target) in &self.requests[base].relations {
                    let Some((low, high)) = place_shares(*place).filter(|_| target.is_none()) else {
                        continue;
                    };
                    let Some((footprint, _)) = own.member_at(base, &at) else { continue };
                    let shares = layout.surface.shares(footprint.center());
                    // A little inside the region, so that settling does not leave it.
                    let inner = DVec2::splat(0.02);
                    let wanted = shares.clamp(low + inner, (high - inner).max(low + inner));
                    at.xy_m += (wanted - shares) * layout.surface.half_m();
                }
            }
        }
        let margin_m = DVec2::splat(self.margin_m(layout, group) + 0.001);
        let (low, high) = layout.surface.bounds();
        let (from, to) = own.footprint.placed(&at).bounds();
        at.xy_m += (low + margin_m - from).max(DVec2::ZERO) - (to - (high - margin_m)).max(DVec2::ZERO);
        at
    }
}

/// The placement with another yaw, and the same center of the footprint.
fn turned_about_center(footprint: &Footprint, at: &Placement, yaw_rad: f64) -> Placement {
    let center = footprint.placed(at).center();
    let turned = footprint.placed(&Placement { xy_m: DVec2::ZERO, yaw_rad: wrap_angle_rad(yaw_rad) });
    Placement { xy_m: center - turned.center(), yaw_rad: wrap_angle_rad(yaw_rad).clamp(-PI, PI) }
}
