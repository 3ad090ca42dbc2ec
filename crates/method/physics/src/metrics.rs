//! The method's physical metrics: collisions on visual meshes and stability under gravity (support has its
//! own file), and the thresholds of all three.
//!
//! Definitions follow the method (Sec. Interactive Simulation of the paper, made exact): see each
//! function. Rates are fractions. World frame, meters, radians, seconds.

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Body;
use super::hull_set::HullSet;
use super::settle::{SettleError, SettleSettings, simulate_to_the_end};
use geometry::Pose;
use geometry::collide::{CollisionRule, PlacedSolid, penetration};
use geometry::collision_shape::to_parry;
use runtime::{CancelFlag, Cancelled};

/// Section `[certify]`: the thresholds of the certificate.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CertifySettings {
    /// An overlap deeper than this is a collision, meters. The method's is 0.001.
    pub penetration_m: f64,
    /// An overlap deeper than this share of the local wall is a collision, too, 0..1. The method's is 0.25.
    pub wall_share: f64,
    /// Minimum wall thickness, meters; smaller values examine shallower contacts and take longer.
    pub min_wall_m: f64,
    /// Largest distance between surface samples of an overlap, meters; at most 0.001.
    pub sample_spacing_m: f64,
    /// Surfaces closer than this touch, meters.
    pub contact_gap_m: f64,
    /// The support region is widened by this, meters.
    pub support_dilation_m: f64,
    /// Contacts with objects other than the declared supporter count where those carry from below: a
    /// step down must lead into them by at least this share, 0..1.
    pub carrying_slope: f64,
    /// A stable object moves less than this, meters.
    pub dss_displacement_m: f64,
    /// A stable object turns less than this, radians.
    pub dss_rotation_rad: f64,
    /// In this time under gravity, seconds.
    pub dss_duration_s: f64,
    /// An object at rest moves in that time by less than this share of its smallest side, and overlaps no other body
    /// deeper in the end, 0..1. DSS alone would let a stack of coins fall.
    pub rest_side_share: f64,
    /// An object at rest turns less than this, radians.
    pub rest_rotation_rad: f64,
}

impl CertifySettings {
    /// Distance that a body may move, and depth that it may overlap, at rest, meters.
    pub(crate) fn rest_limit_m(&self, body: &Body) -> f64 {
        let corners = body.hulls.iter().flat_map(|hull| &hull.points);
        let (low, high) =
            corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        self.rest_side_share * (high - low).min_element().max(0.0)
    }

    pub fn collision_rule(&self) -> CollisionRule {
        CollisionRule {
            penetration_m: self.penetration_m,
            wall_share: self.wall_share,
            min_wall_m: self.min_wall_m,
            spacing_m: self.sample_spacing_m,
        }
    }
}

/// One colliding pair, as indices into the solids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollidingPair {
    pub a: usize,
    pub b: usize,
    pub depth_m: f64,
    pub at_world: DVec3,
}

/// Collisions of a layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Collisions {
    /// All pairs, the table included.
    pub pairs: usize,
    pub colliding: Vec<CollidingPair>,
}

impl Collisions {
    /// Colliding pairs over all pairs.
    pub fn col_o(&self) -> f64 {
        if self.pairs == 0 { 0.0 } else { self.colliding.len() as f64 / self.pairs as f64 }
    }

    /// 1 if any pair collides, else 0.
    pub fn col_s(&self) -> f64 {
        if self.colliding.is_empty() { 0.0 } else { 1.0 }
    }
}

/// Col_O and Col_S on the visual meshes of everything, the table included.
pub fn collisions(
    solids: &[PlacedSolid],
    settings: &CertifySettings,
    cancel: &CancelFlag,
) -> Result<Collisions, Cancelled> {
    let rule = settings.collision_rule();
    let boxes: Vec<(DVec3, DVec3)> = solids.iter().map(world_box).collect();
    let pairs: Vec<(usize, usize)> =
        (0..solids.len()).flat_map(|a| (a + 1..solids.len()).map(move |b| (a, b))).collect();
    let near: Vec<(usize, usize)> = pairs
        .iter()
        .copied()
        .filter(|&(a, b)| (boxes[a].0 - boxes[b].1).max(boxes[b].0 - boxes[a].1).max_element() < 0.0)
        .collect();
    let colliding: Vec<Option<CollidingPair>> = near
        .par_iter()
        .map(|&(a, b)| {
            let found = penetration(&solids[a], &solids[b], &rule, cancel)?;
            Ok(found.map(|p| CollidingPair { a, b, depth_m: p.depth_m, at_world: p.at_world }))
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(Collisions { pairs: pairs.len(), colliding: colliding.into_iter().flatten().collect() })
}

pub(super) fn world_box(placed: &PlacedSolid) -> (DVec3, DVec3) {
    let (low, high) = placed.solid.bounds();
    (0..8)
        .map(|k| {
            let pick = |bit: usize, l: f64, h: f64| if k & bit == 0 { l } else { h };
            let corner = DVec3::new(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z));
            placed.world_from_object.transform_point(corner)
        })
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Movement of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Movement {
    pub displacement_m: f64,
    pub rotation_rad: f64,
    /// By the definition of DSS.
    pub stable: bool,
    /// Deepest overlap of its hulls with those of another body in the end, meters.
    pub overlap_m: f64,
    /// Distance that the body may move, and depth that it may overlap, at rest, meters.
    pub limit_m: f64,
    /// Whether it moves, turns and overlaps less than that; true for fixed bodies.
    pub at_rest: bool,
}

/// Movements during five seconds of gravity.
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// In the order of the bodies; the fixed ones do not move.
    pub movements: Vec<Movement>,
    /// Stable movable bodies over movable bodies (1 where there are none).
    pub dss: f64,
    /// Poses on the way, as in [`SettledPoses::track`](super::SettledPoses::track).
    pub track: Vec<Vec<Pose>>,
}

/// DSS: movable bodies that move less than 3 cm and turn less than 30 degrees in 5 s under gravity, sleeping
/// off, simulated to the end.
pub fn stability(
    bodies: &[Body],
    settings: &CertifySettings,
    settle: &SettleSettings,
    cancel: &CancelFlag,
) -> Result<Stability, SettleError> {
    let settle = SettleSettings { duration_s: settings.dss_duration_s, ..settle.clone() };
    let settled = simulate_to_the_end(bodies, &settle, cancel)?;
    let overlaps_m = overlaps_m(bodies, &settled.poses);
    let movements: Vec<Movement> = (0..bodies.len())
        .map(|k| {
            let (displacement_m, rotation_rad) = (settled.displacements_m[k], settled.rotations_rad[k]);
            let (overlap_m, limit_m) = (overlaps_m[k], settings.rest_limit_m(&bodies[k]));
            Movement {
                displacement_m,
                rotation_rad,
                stable: displacement_m < settings.dss_displacement_m
                    && rotation_rad < settings.dss_rotation_rad,
                overlap_m,
                limit_m,
                at_rest: bodies[k].fixed
                    || displacement_m.max(overlap_m) < limit_m && rotation_rad < settings.rest_rotation_rad,
            }
        })
        .collect();
    let movable = bodies.iter().filter(|b| !b.fixed).count();
    let stable = bodies.iter().zip(&movements).filter(|(b, m)| !b.fixed && m.stable).count();
    let dss = if movable == 0 { 1.0 } else { stable as f64 / movable as f64 };
    Ok(Stability { movements, dss, track: settled.track })
}

/// Deepest overlap of each body's hulls with those of any other, meters; the fixed bodies have none among each other.
fn overlaps_m(bodies: &[Body], poses: &[Pose]) -> Vec<f64> {
    let sets: Vec<HullSet> = bodies.iter().map(|body| HullSet::new(&body.hulls)).collect();
    let mut deepest_m = vec![0.0_f64; bodies.len()];
    for b in 1..bodies.len() {
        for a in (0..b).filter(|&a| !(bodies[a].fixed && bodies[b].fixed)) {
            let a_from_b = to_parry(&(poses[a].inverse() * poses[b]));
            let patches = sets[a].patches(&sets[b], &a_from_b, 0.0);
            let depths_m = patches.iter().flat_map(|patch| &patch.points).map(|point| -point.gap_m);
            let depth_m = depths_m.fold(0.0, f64::max);
            deepest_m[a] = deepest_m[a].max(depth_m);
            deepest_m[b] = deepest_m[b].max(depth_m);
        }
    }
    deepest_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bodies::{body, certify_settings, mesh, settle_settings, table};
    use geometry::Solid;
    use geometry::shapes::{block, cylinder};
    use geometry::solid_query::MeshSolid;

    fn solid(solid: Solid) -> MeshSolid {
        MeshSolid::new(&mesh(solid)).expect("a solid")
    }

    fn at(solid: &MeshSolid, x: f64, z: f64) -> PlacedSolid<'_> {
        PlacedSolid { solid, world_from_object: Pose::upright(DVec3::new(x, 0.0, z), 0.0) }
    }

    #[test]
    fn collisions_count_two_of_six_pairs() {
        let (top, cube) = (
            solid(block(DVec3::new(1.0, 1.0, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03))),
            solid(block(DVec3::splat(0.05))),
        );
        let scene = [at(&top, 0.0, 0.0), at(&cube, 0.0, 0.0), at(&cube, 0.04, 0.0), at(&cube, 0.3, -0.01)];
        let found = collisions(&scene, &certify_settings(), &CancelFlag::default()).expect("no interrupt");
        assert_eq!(found.pairs, 6);
        assert_eq!(found.colliding.iter().map(|c| (c.a, c.b)).collect::<Vec<_>>(), [(0, 3), (1, 2)]);
        assert!((found.colliding[0].depth_m - 0.01).abs() < 1e-6);
        assert!((found.col_o() - 2.0 / 6.0).abs() < 1e-12 && found.col_s() == 1.0);
    }

    #[test]
    fn stability_fails_leaning_board_and_passes_cube() {
        let cube = body("cube", block(DVec3::splat(0.05)), Pose::IDENTITY);
        let mut board = body("board", block(DVec3::new(0.01, 0.1, 0.3)), Pose::IDENTITY);
        board.world_from_object =
            Pose { translation_m: DVec3::new(0.3, 0.0, 0.004), rotation: glam::DQuat::from_rotation_y(0.3) };
        let found = stability(
            &[table(), cube, board],
            &certify_settings(),
            &settle_settings(),
            &CancelFlag::default(),
        )
        .expect("a simulation");
        assert_eq!(found.movements.iter().map(|m| m.stable).collect::<Vec<_>>(), [true, true, false]);
        assert!((found.dss - 0.5).abs() < 1e-12);
    }

    /// A stack of coins within 30 mm, the limit of DSS, may have fallen.
    #[test]
    fn rest_is_relative_to_the_smallest_side() {
        let coin = |name, x, z| {
            body(name, cylinder(0.012, 0.0018, 0.0, 32), Pose::upright(DVec3::new(x, 0.0, z), 0.0))
        };
        let stacked = [table(), coin("low", 0.0, 0.0), coin("high", 0.0, 0.0018)];
        let falls = [table(), coin("coin", 0.0, 0.001)];
        let found = |bodies: &[Body]| {
            stability(bodies, &certify_settings(), &settle_settings(), &CancelFlag::default()).expect("coins")
        };
        let rests = found(&stacked).movements;
        assert!(rests.iter().all(|m| m.stable && m.at_rest), "{rests:?}");
        assert!((rests[1].limit_m - 0.00045).abs() < 1e-9 && rests[2].overlap_m < 1e-4, "{rests:?}");
        let moves = found(&falls).movements[1];
        assert!(moves.stable && !moves.at_rest && moves.overlap_m < 1e-4, "{moves:?}");
        // What starts inside another and stays there is not at rest, either.
        let mut bodies = stacked;
        bodies[2].world_from_object.translation_m.z = 0.0008;
        let poses: Vec<Pose> = bodies.iter().map(|body| body.world_from_object).collect();
        let overlaps = overlaps_m(&bodies, &poses);
        assert!(
            overlaps[0] < 1e-9 && overlaps[1..].iter().all(|depth_m| (depth_m - 0.001).abs() < 1e-6),
            "{overlaps:?}"
        );
    }
}
