//! Pairwise spatial constraints: relations of the text (hard) and co-occurrence priors (soft).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;
use rand::RngExt;

use super::{Footprint, LayoutObject, StatedDemands};
use geometry::pose::wrap_angle_rad;
use runtime::seed::Rng;
use scene::{RelationKind, SupportTree};

/// Position of an object relative to another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RelativePosition {
    /// In a direction: the angle in the target's frame or the world frame, radians (0 = +x).
    Toward(f64),
    /// Near the target on any side.
    Beside,
    /// The `slot`-th of `of` objects in a ring around the target.
    Around { slot: usize, of: usize },
}

pub(super) const LEFT: RelativePosition = RelativePosition::Toward(PI);
pub(super) const RIGHT: RelativePosition = RelativePosition::Toward(0.0);
pub(super) const FRONT: RelativePosition = RelativePosition::Toward(-FRAC_PI_2);
pub(super) const BEHIND: RelativePosition = RelativePosition::Toward(FRAC_PI_2);

/// Required or preferred position of the object `from` relative to the object `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpatialConstraint {
    pub from: usize,
    pub to: usize,
    pub position: RelativePosition,
    /// Whether directions are in the frame of `to` (cutlery at a setting on the far side of the table).
    pub in_target_frame: bool,
    /// Whether the constraint is stated by the text (hard) or comes from a prior (soft).
    pub hard: bool,
    /// Stated free distance, meters.
    pub distance_m: Option<f64>,
}

/// The constraints stated by the text.
pub(super) fn hard_constraints(
    objects: &[LayoutObject],
    supports: &SupportTree,
    stated: &StatedDemands,
) -> Vec<SpatialConstraint> {
    let mut constraints = Vec::new();
    for (from, object) in objects.iter().enumerate() {
        for &(kind, target) in &object.relations {
            let Some(to) = target.filter(|&to| {
                // Directions between an object and its supporter have no meaning.
                to != from && !supports.rests_on(from, to) && !supports.rests_on(to, from)
            }) else {
                continue;
            };
            let position = match kind {
                RelationKind::LeftOf => LEFT,
                RelationKind::RightOf => RIGHT,
                RelationKind::InFrontOf => FRONT,
                RelationKind::Behind => BEHIND,
                RelationKind::NextTo => RelativePosition::Beside,
                RelationKind::Around => around(objects, from, to),
                _ => continue,
            };
            let distance_m = stated.distance_m(from, kind, to);
            let in_target_frame = stated.is_seated(from, kind, to);
            let constraint =
                SpatialConstraint { from, to, position, in_target_frame, hard: true, distance_m };
            constraints.push(constraint);
        }
    }
    constraints
}

fn around(objects: &[LayoutObject], from: usize, to: usize) -> RelativePosition {
    let ring: Vec<usize> = (0..objects.len())
        .filter(|&k| objects[k].relations.contains(&(RelationKind::Around, Some(to))))
        .collect();
    let slot = ring.iter().position(|&k| k == from).unwrap_or(0);
    RelativePosition::Around { slot, of: ring.len().max(1) }
}

impl RelativePosition {
    /// World direction toward the position; `None` for `Beside`.
    pub fn direction(&self, turned_by_rad: f64) -> Option<DVec2> {
        match *self {
            RelativePosition::Toward(angle) => Some(DVec2::from_angle(angle + turned_by_rad)),
            RelativePosition::Around { slot, of } => {
                // Two objects are left and right; three and more start at the front.
                let first = if of == 2 { PI } else { -FRAC_PI_2 };
                Some(DVec2::from_angle(first + TAU * slot as f64 / of as f64))
            }
            RelativePosition::Beside => None,
        }
    }
}

impl SpatialConstraint {
    /// Whether the position is straight to the left, right, front or back.
    pub fn is_on_axis(&self) -> bool {
        [LEFT, RIGHT, FRONT, BEHIND].contains(&self.position)
    }

    fn turned_by(&self, to_yaw_rad: f64) -> f64 {
        if self.in_target_frame { to_yaw_rad } else { 0.0 }
    }

    /// Whether the footprints satisfy the constraint; `tolerance_factor` 1 is strict, higher is looser.
    pub fn holds(&self, from: &Footprint, to: &Footprint, to_yaw_rad: f64, tolerance_factor: f64) -> bool {
        let offset = from.center() - to.center();
        let gap_m = from.gap_m(to);
        // Stated distances are tested exactly elsewhere.
        let is_near =
            |free_m: f64, max_m: f64| self.distance_m.is_some() || free_m < max_m * tolerance_factor;
        match (self.position, self.position.direction(self.turned_by(to_yaw_rad))) {
            (RelativePosition::Around { of, .. }, Some(direction)) => {
                let off = wrap_angle_rad(offset.to_angle() - direction.to_angle()).abs();
                off < tolerance_factor * (0.8 * PI / of as f64).min(0.8) && is_near(gap_m, 0.45)
            }
            (_, Some(direction)) => {
                let along = offset.dot(direction);
                let across = offset.dot(direction.perp()).abs();
                let clear_m = along - from.extent_m(-direction) - to.extent_m(direction);
                let sideways = 0.5 * (to.extent_m(direction.perp()) + to.extent_m(-direction.perp()));
                along > 0.0
                    && clear_m > -0.004 * tolerance_factor
                    && across < (0.7 * along).max(sideways) * tolerance_factor.min(1.4)
                    && is_near(clear_m, 0.4)
            }
            (_, None) => is_near(gap_m, 0.1),
        }
    }

    /// Deviation of the footprints from the preferred position; 10 cm costs 1.
    pub fn cost(&self, from: &Footprint, to: &Footprint, to_yaw_rad: f64) -> f64 {
        let offset = from.center() - to.center();
        let gap_m = self.distance_m.map_or_else(|| from.gap_m(to).max(0.0), |_| 0.0);
        match self.position.direction(self.turned_by(to_yaw_rad)) {
            Some(direction) => {
                let along = offset.dot(direction);
                let across = offset.dot(direction.perp()).abs();
                let wrong_side = if along < 0.0 { 3.0 } else { 0.0 };
                let usual_m =
                    if matches!(self.position, RelativePosition::Around { .. }) { 0.12 } else { 0.02 };
                // Cutlery lies straight beside its plate.
                let across_weight = if self.in_target_frame { 2.0 } else { 0.6 };
                10.0 * ((gap_m - usual_m).max(0.0) + across_weight * across) + wrong_side
            }
            None => 10.0 * (gap_m - 0.02).max(0.0),
        }
    }

    /// A random position for the center of `from`, which is rotated already and centered anywhere.
    pub fn candidate(
        &self,
        from: &Footprint,
        to: &Footprint,
        to_yaw_rad: f64,
        gap_m: f64,
        rng: &mut Rng,
    ) -> DVec2 {
        let turned = self.turned_by(to_yaw_rad);
        let direction = self.position.direction(turned).unwrap_or_else(|| {
            // `Beside` is left or right more often than in front or behind.
            let side: f64 = if rng.random_bool(0.5) { 0.0 } else { PI };
            let spread = if rng.random_bool(0.7) { 0.7 } else { FRAC_PI_2 };
            DVec2::from_angle(turned + side + rng.random_range(-spread..spread))
        });
        let squared: f64 = rng.random_range(0.0..1.0);
        let extra_m = match self.position {
            RelativePosition::Around { .. } => 0.03 + 0.2 * squared,
            _ if self.hard => 0.18 * squared * squared,
            _ => 0.05 * squared * squared,
        };
        let free_m = self.distance_m.unwrap_or(gap_m + extra_m);
        let distance_m = to.extent_m(direction) + from.extent_m(-direction) + free_m;
        let sideways = match self.position {
            RelativePosition::Beside => 0.0,
            RelativePosition::Around { .. } => 0.2 * distance_m,
            RelativePosition::Toward(_) => 0.25 * to.extent_m(direction.perp()).max(0.02),
        };
        let drift_m = if sideways > 0.0 { rng.random_range(-sideways..sideways) } else { 0.0 };
        to.center() + distance_m * direction + drift_m * direction.perp()
    }
}
