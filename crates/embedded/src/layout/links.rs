//! What ties the places of two things: relations of the text (firm) and habits (wishes).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;
use rand::RngExt;

use super::tree::{Carrier, rests_on};
use super::{Footprint, Thing, habits};
use geometry::pose::wrap_angle_rad;
use runtime::seed::Rng;
use scene::RelationKind;

/// Where a thing stands as seen from another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Spot {
    /// In a direction: the angle in the other's frame or the world's, radians (0 = +x).
    Toward(f64),
    /// On any side of it, close by.
    Beside,
    /// The `slot`-th of `of` spread about it.
    Around { slot: usize, of: usize },
}

pub(super) const LEFT: Spot = Spot::Toward(PI);
pub(super) const RIGHT: Spot = Spot::Toward(0.0);
pub(super) const FRONT: Spot = Spot::Toward(-FRAC_PI_2);
pub(super) const BEHIND: Spot = Spot::Toward(FRAC_PI_2);

/// `from` stands at a spot of `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    pub from: usize,
    pub to: usize,
    pub spot: Spot,
    /// Directions turn with `to` (cutlery at a place on the far side of the table).
    pub turns: bool,
    /// The text says so, or habit only.
    pub firm: bool,
}

/// All links: what the text states, then what habit adds where the text is silent.
pub(super) fn links(things: &[Thing], carriers: &[Option<Carrier>]) -> Vec<Link> {
    let mut links = Vec::new();
    for (from, thing) in things.iter().enumerate() {
        for &(kind, target) in &thing.relations {
            let Some(to) = target.filter(|&to| {
                // A thing on a plate is neither left nor right of that plate.
                to != from && !rests_on(carriers, from, to) && !rests_on(carriers, to, from)
            }) else {
                continue;
            };
            let spot = match kind {
                RelationKind::LeftOf => LEFT,
                RelationKind::RightOf => RIGHT,
                RelationKind::InFrontOf => FRONT,
                RelationKind::Behind => BEHIND,
                RelationKind::NextTo => Spot::Beside,
                RelationKind::Around => around(things, from, to),
                _ => continue,
            };
            links.push(Link { from, to, spot, turns: false, firm: true });
        }
    }
    habits::add_links(things, carriers, &mut links);
    links
}

fn around(things: &[Thing], from: usize, to: usize) -> Spot {
    let ring: Vec<usize> = (0..things.len())
        .filter(|&k| things[k].relations.contains(&(RelationKind::Around, Some(to))))
        .collect();
    let slot = ring.iter().position(|&k| k == from).unwrap_or(0);
    Spot::Around { slot, of: ring.len().max(1) }
}

impl Spot {
    /// World direction toward the spot, where it has one.
    pub fn direction(&self, turned_by_rad: f64) -> Option<DVec2> {
        match *self {
            Spot::Toward(angle) => Some(DVec2::from_angle(angle + turned_by_rad)),
            Spot::Around { slot, of } => {
                // Two stand left and right; more begin at the front.
                let first = if of == 2 { PI } else { -FRAC_PI_2 };
                Some(DVec2::from_angle(first + TAU * slot as f64 / of as f64))
            }
            Spot::Beside => None,
        }
    }
}

impl Link {
    /// Straight to the left, right, front or back.
    pub fn is_at_a_side(&self) -> bool {
        [LEFT, RIGHT, FRONT, BEHIND].contains(&self.spot)
    }

    fn turned_by(&self, to_yaw_rad: f64) -> f64 {
        if self.turns { to_yaw_rad } else { 0.0 }
    }

    /// Whether the footprints stand as the link says; `slack` 1 is strict, more is more generous.
    pub fn holds(&self, from: &Footprint, to: &Footprint, to_yaw_rad: f64, slack: f64) -> bool {
        let way = from.center() - to.center();
        let gap_m = from.gap_m(to);
        match (self.spot, self.spot.direction(self.turned_by(to_yaw_rad))) {
            (Spot::Around { of, .. }, Some(direction)) => {
                let off = wrap_angle_rad(way.to_angle() - direction.to_angle()).abs();
                off < slack * (0.8 * PI / of as f64).min(0.8) && gap_m < 0.45 * slack
            }
            (_, Some(direction)) => {
                let along = way.dot(direction);
                let across = way.dot(direction.perp()).abs();
                let clear_m = along - from.reach_m(-direction) - to.reach_m(direction);
                let sideways = 0.5 * (to.reach_m(direction.perp()) + to.reach_m(-direction.perp()));
                along > 0.0
                    && clear_m > -0.004 * slack
                    && across < (0.7 * along).max(sideways) * slack.min(1.4)
                    && clear_m < 0.4 * slack
            }
            (_, None) => gap_m < 0.1 * slack,
        }
    }

    /// How far the footprints are from where they should be; a miss of 10 cm costs 1.
    pub fn cost(&self, from: &Footprint, to: &Footprint, to_yaw_rad: f64) -> f64 {
        let way = from.center() - to.center();
        let gap_m = from.gap_m(to).max(0.0);
        match self.spot.direction(self.turned_by(to_yaw_rad)) {
            Some(direction) => {
                let along = way.dot(direction);
                let across = way.dot(direction.perp()).abs();
                let wrong_side = if along < 0.0 { 3.0 } else { 0.0 };
                let usual_m = if matches!(self.spot, Spot::Around { .. }) { 0.12 } else { 0.02 };
                10.0 * ((gap_m - usual_m).max(0.0) + 0.6 * across) + wrong_side
            }
            None => 10.0 * (gap_m - 0.02).max(0.0),
        }
    }

    /// A place to try for the center of `from` (turned already, centered anywhere).
    pub fn candidate(
        &self,
        from: &Footprint,
        to: &Footprint,
        to_yaw_rad: f64,
        gap_m: f64,
        rng: &mut Rng,
    ) -> DVec2 {
        let turned = self.turned_by(to_yaw_rad);
        let direction = self.spot.direction(turned).unwrap_or_else(|| {
            // Beside is more often left or right than in front or behind.
            let side: f64 = if rng.random_bool(0.5) { 0.0 } else { PI };
            let spread = if rng.random_bool(0.7) { 0.7 } else { FRAC_PI_2 };
            DVec2::from_angle(turned + side + rng.random_range(-spread..spread))
        });
        let squared: f64 = rng.random_range(0.0..1.0);
        let extra_m = match self.spot {
            Spot::Around { .. } => 0.03 + 0.2 * squared,
            _ if self.firm => 0.18 * squared * squared,
            _ => 0.05 * squared * squared,
        };
        let distance_m = to.reach_m(direction) + from.reach_m(-direction) + gap_m + extra_m;
        let sideways = match self.spot {
            Spot::Beside => 0.0,
            Spot::Around { .. } => 0.2 * distance_m,
            Spot::Toward(_) => 0.25 * to.reach_m(direction.perp()).max(0.02),
        };
        let drift_m = if sideways > 0.0 { rng.random_range(-sideways..sideways) } else { 0.0 };
        to.center() + distance_m * direction + drift_m * direction.perp()
    }
}
