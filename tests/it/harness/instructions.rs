//! Instructions about six finished scenes, by writers who knew nothing of any reader, with the answers that a careful
//! reader gives. `tests/fixtures/instructions` has the scenes and the tasks.

use std::collections::BTreeMap;
use std::sync::Arc;

use editing::EditableObject;
use geometry::Rgb;
use glam::{DVec2, DVec3};
use scene::instance::SupportRelation;
use scene::predicates::PosedFootprint;
use scene::{EditOperation, InstanceId, StatedGoal, Supporter};
use serde::Deserialize;
use serde_json::Value;

#[derive(Deserialize)]
struct StoredObject {
    name: InstanceId,
    label: String,
    category: String,
    /// sRGB.
    #[serde(default)]
    color: Option<Rgb>,
    size_m: DVec3,
    position_m: DVec3,
    yaw_rad: f64,
    support: Support,
}

#[derive(Deserialize)]
struct Support {
    parent: String,
    relation: SupportRelation,
}

/// The objects of the six scenes.
pub fn scenes() -> BTreeMap<String, Arc<[EditableObject]>> {
    let text = include_str!("../../fixtures/instructions/scenes.json");
    let stored: BTreeMap<String, Vec<StoredObject>> = serde_json::from_str(text).expect("scenes");
    stored.into_iter().map(|(scene, objects)| (scene, objects_of(&objects))).collect()
}

fn objects_of(stored: &[StoredObject]) -> Arc<[EditableObject]> {
    let object = |object: &StoredObject| {
        let half = 0.5 * object.size_m.truncate();
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
            let corner = DVec2::new(x * half.x, y * half.y);
            object.position_m.truncate() + DVec2::from_angle(object.yaw_rad).rotate(corner)
        });
        let (bottom_m, top_m) = (object.position_m.z, object.position_m.z + object.size_m.z);
        let parent = stored.iter().position(|other| other.name.as_str() == object.support.parent);
        EditableObject {
            name: object.name.clone(),
            label: object.label.clone(),
            category: object.category.clone(),
            stand_in: false,
            color: object.color,
            material: None,
            size_m: object.size_m,
            footprint: PosedFootprint::new(&corners, object.yaw_rad, bottom_m, top_m),
            supporter: Supporter { parent, relation: object.support.relation },
        }
    };
    stored.iter().map(object).collect()
}

#[derive(Deserialize)]
struct Sentences {
    sentence: Vec<Sentence>,
}

#[derive(Deserialize)]
pub struct Sentence {
    pub scene: String,
    pub text: String,
    operations: Option<String>,
}

impl Sentence {
    /// The expected operations; empty where the instruction is to be refused.
    pub fn stated(&self) -> Vec<EditOperation> {
        self.operations.as_deref().map_or(Vec::new(), |json| serde_json::from_str(json).expect(json))
    }
}

/// Edits of a writer.
pub fn edits() -> Vec<Sentence> {
    let files = [
        include_str!("../../../crates/language/language/tests/sentences_fresh_1.toml"),
        include_str!("../../../crates/language/language/tests/sentences_fresh_2.toml"),
        include_str!("../../../crates/language/language/tests/sentences_fresh_3.toml"),
    ];
    files.iter().flat_map(|file| toml::from_str::<Sentences>(file).expect("sentences").sentence).collect()
}

#[derive(Deserialize)]
pub struct TaskLine {
    pub scene: String,
    pub text: String,
    goal: Option<Vec<StatedGoal>>,
    goal_any: Option<Vec<Vec<StatedGoal>>>,
}

impl TaskLine {
    /// The first of the goals that are right; `None` where the instruction is to be refused.
    pub fn stated(&self) -> Option<&Vec<StatedGoal>> {
        self.stated_any().next()
    }

    /// All goals that are right.
    pub fn stated_any(&self) -> impl Iterator<Item = &Vec<StatedGoal>> {
        self.goal.iter().chain(self.goal_any.iter().flatten())
    }
}

/// Tasks of three writers.
pub fn tasks() -> Vec<TaskLine> {
    let files = [
        include_str!("../../fixtures/instructions/tasks_1.jsonl"),
        include_str!("../../fixtures/instructions/tasks_2.jsonl"),
        include_str!("../../fixtures/instructions/tasks_3.jsonl"),
    ];
    let lines = files.iter().flat_map(|file| file.lines());
    lines.map(|line| serde_json::from_str(line).expect(line)).collect()
}

/// Equal up to rounding.
pub fn is_close(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            (a.as_f64().expect("a number") - b.as_f64().expect("a number")).abs() < 1e-3
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_close(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| is_close(a, b)))
        }
        (a, b) => a == b,
    }
}
