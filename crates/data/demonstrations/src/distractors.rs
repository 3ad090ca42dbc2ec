//! Other objects beside those of the scene: at any free place of the table, away from the robot and from all else.

use std::f64::consts::PI;

use geometry::{DVec3, Pose, TexturedMesh};
use physics::Body;
use rand::{Rng, RngExt as _};

use crate::arrangement::{depth_inside_m, is_apart};
use crate::setup::{Setup, Work};
use crate::spread::spread;

/// Places that are tried for each.
const PLACES: usize = 30;
/// Distance that distractors keep from everything else, meters: room for a finger.
const GAP_M: f64 = 0.03;
/// Distance that distractors keep from the edge of the table, meters.
const FROM_EDGE_M: f64 = 0.01;
/// Minimum distance of their origins from the axis of the robot's base, meters.
const FROM_BASE_M: f64 = 0.3;

/// An object that the scene does not have. It stands upright in its frame: its lowest point is at z = 0.
pub struct Distractor {
    pub body: Body,
    pub mesh: TexturedMesh,
}

/// Draws the number of distractors: evenly from 0 to `max_count`.
pub(crate) fn count(rng: &mut impl Rng, max_count: f64) -> usize {
    (rng.random::<f64>() * (max_count + 1.0)).floor() as usize
}

/// Poses of the setup's distractors; `None` for those that are absent. One for which no free place is found is left
/// out. `present` and `poses` are of the objects of the scene.
pub(crate) fn places(
    setup: &Setup,
    work: &Work,
    present: &[bool],
    poses: &[Pose],
    count: usize,
    rng: &mut impl Rng,
) -> Vec<Option<Pose>> {
    let own = poses.len();
    let mut candidates: Vec<usize> = (own..setup.shapes.len()).collect();
    let mut all: Vec<Pose> = poses.to_vec();
    all.resize(setup.shapes.len(), Pose::IDENTITY);
    let mut placed: Vec<usize> = (0..own).filter(|object| present[*object]).collect();
    let (low, high) = setup.scene.outline.bounds();
    let base_m = work.world_from_base.translation_m.truncate();
    for _ in 0..count.min(candidates.len()) {
        let object = candidates.swap_remove(rng.random_range(0..candidates.len()));
        let pose = (0..PLACES).find_map(|_| {
            let [x, y] = [(low.x, high.x), (low.y, high.y)].map(|(low, high)| rng.random_range(low..=high));
            let pose = Pose::upright(DVec3::new(x, y, 0.0), spread(rng, PI));
            let is_free = pose.translation_m.truncate().distance(base_m) > FROM_BASE_M
                && depth_inside_m(setup, object, &pose) > FROM_EDGE_M
                && is_apart(setup, object, &pose, &placed, &all, GAP_M);
            is_free.then_some(pose)
        });
        if let Some(pose) = pose {
            all[object] = pose;
            placed.push(object);
        }
    }
    let is_there = |object: &usize| placed.contains(object);
    (own..all.len()).map(|object| is_there(&object).then_some(all[object])).collect()
}
