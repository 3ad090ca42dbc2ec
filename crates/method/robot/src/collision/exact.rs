//! The slow check in `f64`: exact distances, and paths that are certified between the points they are given by.

use nalgebra::{Isometry3, Point3};

use super::arm::Arm;
use super::obstacle::Obstacle;

/// Pair of bodies, or of body and obstacle, that is nearest to touching, and its distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// The least distance; negative where spheres reach into something.
    pub distance_m: f64,
    pub between: Contact,
}

impl Clearance {
    const NOTHING: Self = Self { distance_m: f64::INFINITY, between: Contact::Nothing };

    fn nearer(self, other: Self) -> Self {
        if other.distance_m < self.distance_m { other } else { self }
    }
}

/// Two shapes that are near each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// Nothing can touch: there are no obstacles and no pairs.
    Nothing,
    /// A body of the arm and an obstacle, by index.
    Obstacle { body: usize, obstacle: usize },
    /// Two bodies of the arm.
    Bodies(usize, usize),
}

/// A place where a path is too near to something.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the arm is {} m from touching {:?} on segment {segment} of its path, at share {share}",
    clearance.distance_m, clearance.between)]
pub struct PathContact {
    /// Index of the segment: it begins at this configuration of the path.
    pub segment: usize,
    /// Position on the segment, 0..1.
    pub share: f64,
    pub clearance: Clearance,
}

impl Arm {
    /// The centers of the spheres of each body in the frame of the base.
    fn placed_spheres(&self, positions: &[f64]) -> Vec<Vec<(Point3<f64>, f64)>> {
        let frames: Vec<Isometry3<f64>> = self.frames(positions);
        let place = |body: &super::arm::ArmBody| {
            body.spheres.iter().map(|s| (frames[body.frame] * s.center_m, s.radius_m)).collect()
        };
        self.bodies().iter().map(place).collect()
    }

    /// Clearances of each body from its nearest obstacle, and of each checked pair of bodies.
    fn clearances(&self, positions: &[f64], obstacles: &[Obstacle]) -> Vec<Clearance> {
        let placed = self.placed_spheres(positions);
        let to_obstacles =
            placed.iter().enumerate().map(|(body, spheres)| nearest_obstacle(body, spheres, obstacles));
        let to_bodies = self.pairs().iter().map(|&(a, b)| {
            let all = placed[a].iter().flat_map(|a| placed[b].iter().map(move |b| (a, b)));
            let distances_m = all
                .map(|((a_m, a_radius_m), (b_m, b_radius_m))| (a_m - b_m).norm() - a_radius_m - b_radius_m);
            Clearance {
                distance_m: distances_m.fold(f64::INFINITY, f64::min),
                between: Contact::Bodies(a, b),
            }
        });
        to_obstacles.chain(to_bodies).collect()
    }

    /// The least distance between the arm and obstacles, and between its bodies, in one configuration.
    pub fn clearance(&self, positions: &[f64], obstacles: &[Obstacle]) -> Clearance {
        self.clearances(positions, obstacles).into_iter().fold(Clearance::NOTHING, Clearance::nearer)
    }

    /// Certifies that nothing comes nearer than `min_clearance_m - tolerance_m` anywhere on a path, also between its
    /// points.
    ///
    /// A piece of a segment is certified if, at its midpoint, each body has more clearance than it can lose on half of
    /// the piece; otherwise it is halved. Where pieces get so short that a body moves less than `tolerance_m` on
    /// them, a clearance of `min_clearance_m` at their midpoint is enough. `tolerance_m` must be greater than 0.
    ///
    /// # Errors
    /// The first place where the clearance is less than `min_clearance_m`.
    pub fn certify_path(
        &self,
        path: &[Vec<f64>],
        obstacles: &[Obstacle],
        min_clearance_m: f64,
        tolerance_m: f64,
    ) -> Result<(), PathContact> {
        for (segment, ends) in path.windows(2).enumerate() {
            let mut pieces = vec![(0.0, 1.0)];
            while let Some((from, to)) = pieces.pop() {
                let share = 0.5 * (from + to);
                let clearances = self.clearances(&between(&ends[0], &ends[1], share), obstacles);
                let moves_m = |body: usize| 0.5 * (to - from) * self.motion_bound_m(body, &ends[0], &ends[1]);
                if let Some(&clearance) =
                    clearances.iter().find(|clearance| clearance.distance_m < min_clearance_m)
                {
                    return Err(PathContact { segment, share, clearance });
                }
                let certified = clearances.iter().all(|clearance| {
                    let loses_m = match clearance.between {
                        Contact::Nothing => 0.0,
                        Contact::Obstacle { body, .. } => moves_m(body),
                        Contact::Bodies(a, b) => moves_m(a) + moves_m(b),
                    };
                    clearance.distance_m - loses_m >= min_clearance_m || loses_m <= tolerance_m
                });
                if !certified {
                    pieces.extend([(share, to), (from, share)]);
                }
            }
        }
        Ok(())
    }
}

/// Clearance of a body, given as spheres by their centers and radii, from its nearest obstacle. Obstacles whose boxes
/// are farther away than the nearest one so far are left out.
fn nearest_obstacle(body: usize, spheres: &[(Point3<f64>, f64)], obstacles: &[Obstacle]) -> Clearance {
    let bound_m = |solid: &Obstacle| {
        spheres.iter().map(|(c, r)| solid.min_distance_m(c) - r).fold(f64::INFINITY, f64::min)
    };
    let mut by_bound: Vec<(f64, usize)> =
        obstacles.iter().enumerate().map(|(index, solid)| (bound_m(solid), index)).collect();
    by_bound.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut nearest = Clearance::NOTHING;
    for (bound_m, obstacle) in by_bound {
        if bound_m >= nearest.distance_m {
            break;
        }
        let solid = &obstacles[obstacle];
        for (center, radius_m) in spheres {
            if solid.min_distance_m(center) - radius_m < nearest.distance_m {
                let distance_m = solid.signed_distance_m(center) - radius_m;
                nearest =
                    nearest.nearer(Clearance { distance_m, between: Contact::Obstacle { body, obstacle } });
            }
        }
    }
    nearest
}

/// The configuration at a share of the way from one to another.
fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect()
}
