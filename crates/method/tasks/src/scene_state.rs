//! A later state of a scene, as any simulator can report it, and the verdict of a task in it.

use std::collections::BTreeMap;

use geometry::Pose;
use scene::InstanceId;
use serde::{Deserialize, Serialize};

use crate::contact::{Contact, ContactBody};
use crate::disturbance::{Disturbance, disturbed_others};
use crate::evaluation::{PredicateOutcome, Situation, evaluate};
use crate::posed_object::PosedObject;
use crate::task::Task;
use crate::task_scene::TaskScene;

/// Poses and contacts of the objects of a scene at one time. World frame: the origin at the center of the table top.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneState {
    /// `world_from_object` by name; objects that are not here are where the scene has them.
    pub objects: BTreeMap<InstanceId, Pose>,
    /// Contacts with a force. Without contacts, hulls that are close touch; the gripper touches nothing.
    #[serde(default)]
    pub contacts: Vec<Contact>,
}

/// Result of a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskVerdict {
    /// Whether every predicate holds.
    pub reached: bool,
    pub predicates: Vec<PredicateOutcome>,
    /// Objects beside the goal that moved farther than the task permits.
    pub disturbed: Vec<Disturbance>,
}

/// A state that does not belong to the scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the state has {name}, which is no object of the scene; name the objects as scene.json does")]
pub struct UnknownObject {
    pub name: InstanceId,
}

impl TaskScene {
    /// Decides a task in a later state of the scene.
    ///
    /// # Errors
    ///
    /// [`UnknownObject`] if the state names an object that the scene does not have.
    pub fn judge(&self, task: &Task, state: &SceneState) -> Result<TaskVerdict, UnknownObject> {
        let touching = state.contacts.iter().flat_map(|contact| [&contact.first, &contact.second]);
        let touching = touching.filter_map(|body| match body {
            ContactBody::Object(name) => Some(name),
            ContactBody::Table | ContactBody::Gripper => None,
        });
        if let Some(name) = state.objects.keys().chain(touching).find(|name| self.index_of(name).is_none()) {
            return Err(UnknownObject { name: name.clone() });
        }
        let moved = |object: &PosedObject| match state.objects.get(&object.name) {
            Some(pose) => object.at(*pose),
            None => object.clone(),
        };
        let now: Vec<PosedObject> = self.posed().iter().map(moved).collect();
        let situation = Situation { now: &now, contacts: &state.contacts, ..self.situation() };
        let predicates = evaluate(&task.goal, &situation);
        let carried = self.carried(&task.goal);
        Ok(TaskVerdict {
            reached: predicates.iter().all(|outcome| outcome.holds),
            disturbed: disturbed_others(&task.goal, &task.limits, self.posed(), &now, &carried),
            predicates,
        })
    }
}

#[cfg(test)]
mod tests {
    use geometry::Rgb;
    use glam::DVec3;
    use scene::Supporter;

    use super::*;
    use crate::test_scenes::{container, id, solid_box, table};
    use editing::EditableObject;

    /// A bowl at the origin, a cube to its left, and a cup to its right.
    fn scene() -> TaskScene {
        let posed = vec![
            container("bowl_1", [0.2, 0.2, 0.1], [0.0, 0.0, 0.0]),
            solid_box("cube_1", [0.04; 3], [-0.3, 0.0, 0.0]),
            solid_box("cup_1", [0.08; 3], [0.3, 0.0, 0.0]),
        ];
        let described = posed
            .iter()
            .map(|object| EditableObject {
                name: object.name.clone(),
                label: object.name.to_string(),
                category: "cube".to_owned(),
                stand_in: false,
                color: None::<Rgb>,
                material: None,
                size_m: DVec3::splat(0.1),
                footprint: object.footprint(),
                supporter: Supporter::TABLE,
            })
            .collect();
        TaskScene::new(table(), posed, described).expect("as many")
    }

    fn task() -> Task {
        let goal = r#"[{"predicate": "in", "object": "cube_1", "target": "bowl_1"}]"#;
        Task::new("put the cube in the bowl", serde_json::from_str(goal).expect("a goal"), "panda")
    }

    fn state(objects: &[(&str, [f64; 3])]) -> SceneState {
        let posed = objects.iter().map(|(name, at)| (id(name), Pose::upright(DVec3::from_array(*at), 0.0)));
        SceneState { objects: posed.collect(), contacts: Vec::new() }
    }

    #[test]
    fn poses_of_another_simulator_decide() {
        let (scene, task) = (scene(), task());
        let verdict = scene.judge(&task, &state(&[])).expect("known");
        assert!(!verdict.reached, "the start");
        let inside = scene.judge(&task, &state(&[("cube_1", [0.0, 0.0, 0.02])])).expect("known");
        assert!(inside.reached && inside.disturbed.is_empty(), "{:?}", inside.predicates);
        let shoved = state(&[("cube_1", [0.0, 0.0, 0.02]), ("cup_1", [0.5, 0.0, 0.0])]);
        let shoved = scene.judge(&task, &shoved).expect("known");
        assert_eq!(shoved.disturbed.iter().map(|d| d.object.as_str()).collect::<Vec<_>>(), ["cup_1"]);
    }

    #[test]
    fn unknown_objects_are_refused() {
        let refused = scene().judge(&task(), &state(&[("spoon_1", [0.0; 3])])).expect_err("no spoon");
        assert!(refused.to_string().contains("spoon_1"), "{refused}");
        let contact = Contact { first: ContactBody::Table, second: ContactBody::Object(id("spoon_1")) };
        let touching = SceneState { contacts: vec![contact], ..SceneState::default() };
        assert!(scene().judge(&task(), &touching).is_err());
    }
}
