//! Objects outside a goal that an execution moved.

use scene::InstanceId;
use schemars::JsonSchema;
use serde::Serialize;

use crate::goal::Goal;
use crate::posed_object::{PosedObject, find};
use crate::task::Limits;

/// An object that moved farther than the limits of the task permit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Disturbance {
    pub object: InstanceId,
    /// Of its origin, meters.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub displacement_m: f64,
    /// Of its orientation, about any axis, radians.
    #[schemars(range(min = 0.0, max = 3.2))]
    pub rotation_rad: f64,
}

/// Objects that the goal does not move and that were displaced or turned farther than the limits. What rested on or in
/// a moved object at the start may go along: `carried` lists these ([`crate::TaskScene::carried`]). Objects that are
/// missing now are skipped.
pub fn disturbed_others(
    goal: &Goal,
    limits: &Limits,
    start: &[PosedObject],
    now: &[PosedObject],
    carried: &[InstanceId],
) -> Vec<Disturbance> {
    let moved = goal.moved_objects();
    start
        .iter()
        .filter(|object| !moved.contains(&&object.name) && !carried.contains(&object.name))
        .filter_map(|before| {
            let (from, to) = (before.world_from_object, find(now, &before.name)?.world_from_object);
            let displacement_m = from.translation_m.distance(to.translation_m);
            let rotation_rad = from.rotation.angle_between(to.rotation);
            let is_disturbed = displacement_m > limits.max_displacement_of_others_m
                || rotation_rad > limits.max_rotation_of_others_rad;
            is_disturbed.then(|| Disturbance { object: before.name.clone(), displacement_m, rotation_rad })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{id, solid_box};
    use geometry::Pose;
    use glam::{DQuat, DVec3};

    #[test]
    fn others_that_moved_or_turned_are_found() {
        let goal: Goal = serde_json::from_str(r#"[{"predicate": "lifted", "object": "a"}]"#).expect("a goal");
        let size_m = [0.05; 3];
        let start: Vec<PosedObject> =
            ["a", "b", "c", "d", "e"].map(|name| solid_box(name, size_m, [0.0; 3])).to_vec();
        let shifted = |x_m: f64| Pose::upright(DVec3::X * x_m, 0.0);
        let fallen = Pose { translation_m: DVec3::ZERO, rotation: DQuat::from_rotation_x(1.0) };
        let poses = [shifted(0.5), shifted(0.02), shifted(0.04), fallen, shifted(0.5)];
        let now: Vec<PosedObject> = start.iter().zip(poses).map(|(object, pose)| object.at(pose)).collect();
        let found = disturbed_others(&goal, &Limits::USUAL, &start, &now, &[id("e")]);
        let names: Vec<&str> = found.iter().map(|found| found.object.as_str()).collect();
        assert_eq!(names, ["c", "d"]);
        assert!((found[0].displacement_m - 0.04).abs() < 1e-9 && (found[1].rotation_rad - 1.0).abs() < 1e-9);
    }
}
