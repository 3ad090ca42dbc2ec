//! More candidates, for objects that none of the first ones holds, and the order in which they are tried.
//!
//! The first search draws few lines and ranks hands by what suits most objects. This one draws more, closes also along
//! lines that are tilted against the normals, turns the hand about them by any angle, and lets the fingers reach deeper
//! and less deep. Where a trial dropped the object, hands near it wait; where the object almost stayed, they come
//! first.

use geometry::{DVec3, Pose};
use physics::Body;
use rand::{Rng, RngExt};

use super::antipodal::{Candidate, Draft, Search, turn_between_rad};
use super::hand_shape::HandShape;
use super::settings::GraspSettings;
use super::{Grasp, Verdict};

/// Number of points drawn, as a multiple of that of the first search.
const MORE_POINTS: usize = 2;
/// Lines through each point whose angle against the normal is random.
const TILTED_LINES: usize = 2;
/// Hands along each line.
const HANDS: usize = 3;
/// The most candidates that are kept.
const MAX_KEPT: usize = 400;
/// The most hands whose collisions are computed.
const MAX_TRIED: usize = 2500;
/// Trials say something about hands within this distance and angle.
const NEAR_M: f64 = 0.015;
const NEAR_RAD: f64 = 0.5;
/// Patches whose centers are farther apart turn the object, meters.
const FULL_SKEW_M: f64 = 0.01;
/// A grasp that slips by less than so many times what stable ones may is almost stable.
const ALMOST: f64 = 4.0;

/// Finds more candidates than [`candidates`](super::antipodal::candidates), in no order.
pub fn more_candidates(
    object: &Body,
    hand: &HandShape,
    settings: &GraspSettings,
    rng: &mut impl Rng,
) -> Vec<Candidate> {
    let search = Search::new(object, hand, settings);
    let mut drafts: Vec<Draft> = Vec::new();
    for _ in 0..MORE_POINTS * settings.surface_points {
        let Some((point, normal)) = search.solid.draw(rng) else { continue };
        let inward = -normal;
        let tilted: Vec<DVec3> = (0..TILTED_LINES).map(|_| tilted(inward, search.max_rad(), rng)).collect();
        for direction in std::iter::once(inward).chain(search.flat(inward)).chain(tilted) {
            let Some(line) = search.line(point, direction) else { continue };
            for _ in 0..HANDS {
                let angle_rad = rng.random_range(0.0..std::f64::consts::TAU);
                let deeper_m = rng.random_range(-1.0..1.0) * hand.pad_half_m[1];
                drafts.extend(search.draft(&line, angle_rad, deeper_m));
            }
        }
    }
    search.free(drafts, MAX_KEPT, MAX_TRIED)
}

/// A direction within the cone about another, evenly by angle.
fn tilted(axis: DVec3, max_rad: f64, rng: &mut impl Rng) -> DVec3 {
    let aside = axis.any_orthonormal_vector();
    let turn_rad = rng.random_range(0.0..std::f64::consts::TAU);
    let tilt_rad = rng.random_range(0.0..max_rad);
    let aside = turn_rad.cos() * aside + turn_rad.sin() * axis.cross(aside);
    tilt_rad.cos() * axis + tilt_rad.sin() * aside
}

/// Results of earlier trials, which lower the expectation of similar candidates.
#[derive(Default)]
pub struct Experience {
    /// Poses of hands and by how much a hand at the same place promises less.
    said: Vec<(Pose, f64)>,
}

impl Experience {
    pub fn add(&mut self, grasp: &Grasp, settings: &GraspSettings) {
        let malus = match grasp.verdict {
            Verdict::Slipped if excess(grasp, settings) < ALMOST => -0.15,
            Verdict::Slipped => 0.05,
            Verdict::Dropped if grasp.slip_m > 0.0 => 0.15,
            Verdict::Dropped => 0.3,
            Verdict::Stable | Verdict::Untested => 0.0,
        };
        self.said.push((grasp.object_from_tool, malus));
    }

    /// Takes the candidate that promises most, the first of equal ones.
    pub fn take_best(&self, candidates: &mut Vec<Candidate>) -> Option<Candidate> {
        let mut best: Option<(usize, f64)> = None;
        for (index, candidate) in candidates.iter().enumerate() {
            let malus: f64 = self.said.iter().map(|(pose, malus)| malus * nearness(pose, candidate)).sum();
            let worth = promise(candidate) - malus;
            if best.is_none_or(|(_, other)| worth > other) {
                best = Some((index, worth));
            }
        }
        best.map(|(index, _)| candidates.remove(index))
    }
}

/// Distance of a grasp from stability: 1 where slip or turn is just as much as stable ones may have.
pub fn excess(grasp: &Grasp, settings: &GraspSettings) -> f64 {
    let slip = grasp.slip_m / settings.trial.max_slip_m.max(f64::MIN_POSITIVE);
    slip.max(grasp.turn_rad / settings.trial.max_turn_rad.max(f64::MIN_POSITIVE))
}

/// 1 for a hand at the same pose, with or without swapping the fingers, and 0 for one that is far.
fn nearness(pose: &Pose, candidate: &Candidate) -> f64 {
    let other = candidate.object_from_tool;
    let between_rad = turn_between_rad(pose, &other);
    let between_m = pose.translation_m.distance(other.translation_m);
    (-(between_m / NEAR_M).powi(2) - (between_rad / NEAR_RAD).powi(2)).exp()
}

/// Quality of a candidate by itself: large patches that face each other resist turning.
fn promise(candidate: &Candidate) -> f64 {
    candidate.score + 0.2 * candidate.contact.share + 0.1 * candidate.margin
        - 0.2 * (candidate.contact.skew_m / FULL_SKEW_M).min(1.0)
}

#[cfg(test)]
mod tests;
