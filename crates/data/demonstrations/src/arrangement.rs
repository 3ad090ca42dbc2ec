//! Objects at other places of the table: each that stands on it moves with all that it carries.

use geometry::drop_cast::{PosedShape, are_closer};
use geometry::{DQuat, DVec3, Pose};
use rand::Rng;

use crate::randomization::Randomization;
use crate::setup::{Setup, Work};
use crate::spread::spread;

/// Places that are tried for what stands on the table, and arrangements of all.
const PLACES: usize = 20;
const ARRANGEMENTS: usize = 10;
/// Distance that moved objects keep from everything else, meters.
const GAP_M: f64 = 0.004;
/// Points of objects may reach over the edge of the table by this, meters, or by as much as they did.
const OVERHANG_M: f64 = 0.0;

/// The object on the table that carries an object, perhaps itself.
fn root(setup: &Setup, object: usize) -> usize {
    let mut at = object;
    while let Some(below) = setup.supporters[at].parent {
        at = below;
    }
    at
}

/// For each object of the scene, whether it is present. A stack stays if the task names any of it, or if its lowest
/// object was not drawn as absent.
pub(crate) fn present(setup: &Setup, work: &Work, absent: &[bool]) -> Vec<bool> {
    let is_named = |object: usize| {
        let name = setup.scene.objects[object].name.as_str();
        work.task.goal.named_objects().iter().any(|named| named.as_str() == name)
    };
    let objects = 0..setup.own_objects();
    let stays = |root_index: usize| {
        !absent[root_index]
            || objects.clone().any(|other| root(setup, other) == root_index && is_named(other))
    };
    objects.clone().map(|object| stays(root(setup, object))).collect()
}

/// Poses of all objects of the scene. Those that are absent keep theirs and are not in the way. `None` if no
/// arrangement was found.
pub(crate) fn poses(
    setup: &Setup,
    present: &[bool],
    ranges: &Randomization,
    rng: &mut impl Rng,
) -> Option<Vec<Pose>> {
    let mut start = setup.scene.poses();
    start.truncate(setup.own_objects());
    if ranges.position_m == 0.0 && ranges.yaw_rad == 0.0 {
        return Some(start);
    }
    (0..ARRANGEMENTS).find_map(|_| arranged(setup, present, &start, ranges, rng))
}

fn arranged(
    setup: &Setup,
    present: &[bool],
    start: &[Pose],
    ranges: &Randomization,
    rng: &mut impl Rng,
) -> Option<Vec<Pose>> {
    let mut poses = start.to_vec();
    let mut placed: Vec<usize> = Vec::new();
    let all = 0..start.len();
    for base in all.clone().filter(|object| present[*object] && root(setup, *object) == *object) {
        let group: Vec<usize> = all.clone().filter(|object| root(setup, *object) == base).collect();
        let moved = (0..PLACES).find_map(|_| {
            let shift_m = DVec3::new(spread(rng, ranges.position_m), spread(rng, ranges.position_m), 0.0);
            let turn = DQuat::from_rotation_z(spread(rng, ranges.yaw_rad));
            let center_m = start[base].translation_m;
            let of = |pose: &Pose| Pose {
                translation_m: center_m + shift_m + turn * (pose.translation_m - center_m),
                rotation: (turn * pose.rotation).normalize(),
            };
            let moved: Vec<Pose> = group.iter().map(|object| of(&start[*object])).collect();
            is_free(setup, start, &group, &moved, &placed, &poses).then_some(moved)
        })?;
        for (object, pose) in group.iter().zip(moved) {
            poses[*object] = pose;
        }
        placed.extend(group);
    }
    Some(poses)
}

fn is_free(
    setup: &Setup,
    start: &[Pose],
    group: &[usize],
    moved: &[Pose],
    placed: &[usize],
    poses: &[Pose],
) -> bool {
    group.iter().zip(moved).all(|(object, pose)| {
        let stays_on = depth_inside_m(setup, *object, pose)
            >= depth_inside_m(setup, *object, &start[*object]).min(-OVERHANG_M);
        stays_on && is_apart(setup, *object, pose, placed, poses, GAP_M)
    })
}

/// Whether an object at a pose is at least `gap_m` from each of those that are placed.
pub(crate) fn is_apart(
    setup: &Setup,
    object: usize,
    pose: &Pose,
    placed: &[usize],
    poses: &[Pose],
    gap_m: f64,
) -> bool {
    let posed =
        |object: usize, pose: &Pose| PosedShape { shape: &setup.shapes[object], world_from_object: *pose };
    placed.iter().all(|other| !are_closer(&posed(object, pose), &posed(*other, &poses[*other]), gap_m))
}

/// Smallest depth of an object's points inside the edge of the table, seen from above, meters; negative where it
/// reaches over the edge.
pub(crate) fn depth_inside_m(setup: &Setup, object: usize, world_from_object: &Pose) -> f64 {
    let points = setup.shapes[object].points(world_from_object);
    points.map(|point| setup.scene.outline.depth_inside_m(point.truncate())).fold(f64::INFINITY, f64::min)
}
