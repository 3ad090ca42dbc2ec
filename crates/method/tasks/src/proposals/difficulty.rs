//! Difficulty of a task, from its goal and the scene.

use glam::{DVec2, DVec3};
use scene::predicates::NEXT_TO_M;
use scene::text_account::{GoalPredicate, PredicateKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::evaluation::{LIFT_M, MOVE_M, SWAP_M};
use crate::goal::Goal;
use crate::posed_object::PosedObject;
use crate::robot_limits::narrowest_m;
use crate::task_scene::TaskScene;

/// Distance up to which other objects are in the way of the hand, meters.
const NEAR_M: f64 = 0.06;
/// Precision that is half as difficult as none is, meters.
const USUAL_PRECISION_M: f64 = 0.03;
/// Point from which the table is seen: before the front edge and above it, meters.
const VIEW_M: [f64; 2] = [0.5, 0.7];

/// Difficulty of a task and its causes. `overall` is the mean of five terms, each from 0 to 1: `(objects - 1) / 3` and
/// `(steps - 1) / 3` up to 1, `clutter / 6` up to 1, `occlusion`, and `0.03 m / (0.03 m + precision_m)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Difficulty {
    /// Objects that the goal names.
    #[schemars(range(min = 1, max = 1000))]
    pub objects: usize,
    /// Other objects within 6 cm of one of these.
    #[schemars(range(min = 0, max = 1000))]
    pub clutter: usize,
    /// Share of these that is hidden to a viewer at the front edge, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub occlusion: f64,
    /// Tolerance of placements, meters: the smallest of the steps.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub precision_m: f64,
    /// Objects picked up and put down; a swap takes three.
    #[schemars(range(min = 1, max = 1000))]
    pub steps: usize,
    /// 0 (easy) to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub overall: f64,
}

impl Difficulty {
    /// The difficulty of a goal whose objects are in the scene.
    pub fn of(goal: &Goal, scene: &TaskScene) -> Self {
        let named: Vec<usize> =
            goal.named_objects().into_iter().filter_map(|name| scene.index_of(name)).collect();
        let steps = |predicate: &GoalPredicate| match predicate.predicate {
            PredicateKind::Swapped => 3,
            _ => 1,
        };
        let steps: usize = goal.predicates().iter().map(steps).sum();
        let precision_m =
            goal.predicates().iter().map(|predicate| precision_m(predicate, scene)).fold(1.0, f64::min);
        let clutter = clutter(&named, scene);
        let hidden = named.iter().map(|object| hidden_share(*object, scene));
        let occlusion = hidden.sum::<f64>() / named.len().max(1) as f64;
        let share = |count: usize, full: f64| (count as f64 / full).min(1.0);
        let terms = [
            share(named.len().saturating_sub(1), 3.0),
            share(steps.saturating_sub(1), 3.0),
            share(clutter, 6.0),
            occlusion,
            USUAL_PRECISION_M / (USUAL_PRECISION_M + precision_m.max(0.0)),
        ];
        let overall = terms.iter().sum::<f64>() / terms.len() as f64;
        Self { objects: named.len(), clutter, occlusion, precision_m, steps, overall }
    }
}

/// Tolerance of the placement that the predicate asks for, meters.
fn precision_m(predicate: &GoalPredicate, scene: &TaskScene) -> f64 {
    let posed = |name: &scene::InstanceId| scene.index_of(name).map(|index| &scene.posed()[index]);
    let target = predicate.target.as_ref().and_then(posed);
    match (predicate.predicate, posed(&predicate.object), target) {
        (PredicateKind::In, Some(object), Some(target)) => {
            let opening_m = target.shape.opening().map_or(0.0, |opening| opening.narrowest_m());
            0.5 * (opening_m - narrowest_m(&object.shape)).max(0.0)
        }
        (PredicateKind::On | PredicateKind::StackedOn, _, Some(target)) => 0.5 * narrowest_m(&target.shape),
        (PredicateKind::Swapped, ..) => SWAP_M,
        (PredicateKind::Lifted, ..) => LIFT_M,
        (PredicateKind::Moved | PredicateKind::AwayFrom, ..) => MOVE_M,
        _ => NEXT_TO_M,
    }
}

/// Objects near those that the goal names, without what carries them.
fn clutter(named: &[usize], scene: &TaskScene) -> usize {
    let others = (0..scene.posed().len()).filter(|other| !named.contains(other));
    let is_near = |other: &usize| {
        named.iter().any(|object| {
            let carries = scene.described()[*object].supporter.parent == Some(*other);
            let (a, b) = (&scene.described()[*object].footprint, &scene.described()[*other].footprint);
            !carries && a.distance_m(b) <= NEAR_M
        })
    };
    others.filter(is_near).count()
}

/// Share of the center and the corners of an object's box whose line of sight another object's box interrupts.
fn hidden_share(object: usize, scene: &TaskScene) -> f64 {
    let (from, _) = scene.table.bounds();
    let [before_m, above_m] = VIEW_M;
    let viewer = DVec3::new(0.0, from.y - before_m, above_m);
    let (low, high) = bounds(&scene.posed()[object]);
    let corner = |k: usize| {
        let pick = |bit: usize| if k & bit == 0 { 0.0 } else { 1.0 };
        low + (high - low) * DVec3::new(pick(1), pick(2), pick(4))
    };
    let points: Vec<DVec3> = (0..8).map(corner).chain([0.5 * (low + high)]).collect();
    let others: Vec<(DVec3, DVec3)> = scene
        .posed()
        .iter()
        .enumerate()
        .filter(|(k, _)| *k != object)
        .map(|(_, other)| bounds(other))
        .collect();
    let is_hidden = |point: &&DVec3| {
        others.iter().any(|(low, high)| {
            // What contains the point does not hide it from this side.
            let contains = point.cmpge(*low).all() && point.cmple(*high).all();
            !contains && crosses(**point, viewer, *low, *high)
        })
    };
    points.iter().filter(is_hidden).count() as f64 / points.len() as f64
}

fn bounds(object: &PosedObject) -> (DVec3, DVec3) {
    let footprint = object.footprint();
    let (low, high): (DVec2, DVec2) = footprint.bounds();
    (low.extend(footprint.bottom_m), high.extend(footprint.top_m))
}

/// Whether a segment crosses an axis-aligned box (slab test).
fn crosses(from: DVec3, to: DVec3, low: DVec3, high: DVec3) -> bool {
    let way = to - from;
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        if way[axis].abs() < 1e-12 {
            if from[axis] < low[axis] || from[axis] > high[axis] {
                return false;
            }
            continue;
        }
        let (a, b) = ((low[axis] - from[axis]) / way[axis], (high[axis] - from[axis]) / way[axis]);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter <= leave
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segment_crosses_boxes_in_its_way_only() {
        let (from, to) = (DVec3::ZERO, DVec3::new(0.0, -1.0, 1.0));
        let half = DVec3::splat(0.1);
        for (center, expected) in [
            (DVec3::new(0.0, -0.5, 0.5), true),
            (DVec3::new(0.3, -0.5, 0.5), false),
            (DVec3::new(0.0, -0.5, 0.1), false),
            (DVec3::new(0.0, -1.5, 1.5), false),
        ] {
            assert_eq!(crosses(from, to, center - half, center + half), expected, "{center}");
        }
    }
}
