//! Edits: operations that derive a scene from a finished one.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::InstanceId;
use crate::description::RelationKind;
use crate::validation::{Violation, Violations};

/// Largest number of operations of one edit.
pub const MAX_OPERATIONS: usize = 64;

/// Largest number of objects that one operation adds.
pub const MAX_ADDED: u32 = 32;

/// Largest factor by which an object grows, and the inverse of the smallest.
pub const MAX_RESIZE: f64 = 2.0;

/// One operation. Objects are named by their name in the parent scene (`mug_1`), or by a phrase: "the red mug", "the
/// second book from the left", "all spoons". A phrase that fits several objects where one is meant is an error.
/// Operations are carried out in order; a later one sees the result of the earlier ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "op", rename_all = "snake_case", deny_unknown_fields)]
pub enum EditOperation {
    /// New objects: a phrase as in a scene's text ("a red mug"), without a place.
    Add {
        object: String,
        #[serde(default = "one", skip_serializing_if = "is_one")]
        count: u32,
        /// Anywhere on the table unless it is given.
        #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
        place: Option<EditPlace>,
    },
    /// Removes objects. What stood on or in a removed object is removed with it where `with_contents` is set;
    /// otherwise it comes to rest below.
    Remove {
        target: String,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        with_contents: bool,
    },
    /// Another object at the same place, on or in the same supporter.
    Replace { target: String, object: String },
    /// Another place. Objects on or in the target move with it.
    Move {
        target: String,
        #[serde(rename = "where")]
        place: EditPlace,
    },
    /// A turn about the vertical axis, counter-clockwise seen from above: by an angle, to an angle (0 faces the front
    /// edge), or toward another object. One of the three.
    Rotate {
        target: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        by_rad: Option<f64>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        to_rad: Option<f64>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        facing: Option<String>,
    },
    /// Another size, by a factor on all three extents.
    Resize { target: String, factor: f64 },
    /// Another color, another material, or both. Materials change mass and friction.
    Recolor {
        target: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        color: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        material: Option<String>,
    },
    /// Another label; the mesh stays.
    Relabel { target: String, label: String },
    /// Another color or material of the table. Its shape and size stay.
    RestyleTable {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        material: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        color: Option<String>,
    },
    /// One object on the other, the first at the bottom. One phrase ("the books") stacks the largest first.
    Stack { targets: Vec<String> },
    /// Objects that stand on the table are aligned with its edges and moved apart.
    Tidy,
    /// More objects of the scene's theme, or of the one that is given.
    Clutter {
        count: u32,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        theme: Option<String>,
    },
}

/// A place: a relation to another object or to the table, coordinates, or a displacement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EditPlace {
    /// `on`, `in`, `left_of`, `right_of`, `in_front_of`, `behind`, `next_to`, `between`, a region of the table
    /// (`at_center`, `at_back_left`, ...), or a distance from an edge (`from_left_edge`, ...).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relation: Option<RelationKind>,
    /// The other object; absent for the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// The second object of `between`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_target: Option<String>,
    /// Free distance to the target or to the edge, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_m: Option<f64>,
    /// Center of the object on the table top, from its center: x to the right, y to the back, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_m: Option<DVec2>,
    /// Displacement from where a moved object is: x to the right, y to the back, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_m: Option<DVec2>,
    /// Rotation about the vertical axis; 0 faces the front edge. Chosen where it is absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_rad: Option<f64>,
}

impl EditPlace {
    /// A relation to an object.
    pub fn related(relation: RelationKind, target: impl Into<String>) -> Self {
        Self { relation: Some(relation), target: Some(target.into()), ..Self::default() }
    }

    /// A region of the table.
    pub fn at(region: RelationKind) -> Self {
        Self { relation: Some(region), ..Self::default() }
    }

    fn violations(&self) -> Vec<Violation> {
        use RelationKind::{Around, Between, Facing, In, ParallelTo, StackedOn};
        let mut violations = Violations::default();
        let given = usize::from(self.relation.is_some())
            + usize::from(self.position_m.is_some())
            + usize::from(self.offset_m.is_some());
        violations.require(given == 1, "", "give one of `relation`, `position_m` and `offset_m`");
        if let Some(relation) = self.relation {
            let supported = !matches!(relation, Around | Facing | ParallelTo | StackedOn);
            violations.require(supported, "/relation", "is no place; give on, in, left_of, ... or a region");
            let needs_target = relation.target_is_object() || relation == In;
            violations.require(
                !needs_target || self.target.is_some(),
                "/target",
                "names the object that the relation is to; it is missing",
            );
            violations.require(
                needs_target || relation == RelationKind::On || self.target.is_none(),
                "/target",
                "a region of the table has no target",
            );
            violations.require(
                (relation == Between) == self.second_target.is_some(),
                "/second_target",
                "is the second object of `between`, and of nothing else",
            );
        }
        let distance = self.distance_m.is_none_or(|distance_m| (0.0..=5.0).contains(&distance_m));
        violations.require(distance, "/distance_m", "must be from 0 to 5 meters");
        let position = self.position_m.is_none_or(|at| at.is_finite() && at.abs().max_element() <= 5.0);
        violations.require(position, "/position_m", "must be within 5 meters of the center of the table");
        let offset = self.offset_m.is_none_or(|by| by.is_finite() && by.abs().max_element() <= 5.0);
        violations.require(offset, "/offset_m", "must be up to 5 meters");
        violations.require(is_angle(self.yaw_rad), "/yaw_rad", ANGLE);
        violations.into_vec()
    }
}

const ANGLE: &str = "must be from -6.3 to 6.3 radians";

fn is_angle(angle_rad: Option<f64>) -> bool {
    angle_rad.is_none_or(|angle_rad| (-6.3..=6.3).contains(&angle_rad))
}

fn one() -> u32 {
    1
}

fn is_one(count: &u32) -> bool {
    *count == 1
}

impl EditOperation {
    /// The word of the JSON form (`add`).
    pub fn name(&self) -> &'static str {
        match self {
            Self::Add { .. } => "add",
            Self::Remove { .. } => "remove",
            Self::Replace { .. } => "replace",
            Self::Move { .. } => "move",
            Self::Rotate { .. } => "rotate",
            Self::Resize { .. } => "resize",
            Self::Recolor { .. } => "recolor",
            Self::Relabel { .. } => "relabel",
            Self::RestyleTable { .. } => "restyle_table",
            Self::Stack { .. } => "stack",
            Self::Tidy => "tidy",
            Self::Clutter { .. } => "clutter",
        }
    }

    /// Every value that is out of its range, with a JSON pointer relative to the operation.
    pub fn violations(&self) -> Vec<Violation> {
        let mut violations = Violations::default();
        let mut phrase = |pointer: &str, text: &str| {
            let length = (1..=200).contains(&text.trim().chars().count());
            violations.require(length, pointer, "must have 1 to 200 characters");
        };
        match self {
            Self::Add { object, .. } => phrase("/object", object),
            Self::Replace { target, object } => {
                phrase("/target", target);
                phrase("/object", object);
            }
            Self::Relabel { target, label } => {
                phrase("/target", target);
                phrase("/label", label);
            }
            Self::Remove { target, .. }
            | Self::Move { target, .. }
            | Self::Rotate { target, .. }
            | Self::Resize { target, .. }
            | Self::Recolor { target, .. } => phrase("/target", target),
            Self::Stack { targets } => {
                targets.iter().enumerate().for_each(|(k, target)| phrase(&format!("/targets/{k}"), target));
            }
            Self::RestyleTable { .. } | Self::Tidy | Self::Clutter { .. } => {}
        }
        match self {
            Self::Add { count, place, .. } => {
                let range = (1..=MAX_ADDED).contains(count);
                violations.require(range, "/count", format!("must be from 1 to {MAX_ADDED}"));
                violations.extend("/where", place.as_ref().map_or(Vec::new(), EditPlace::violations));
                let is_displaced = place.as_ref().is_some_and(|place| place.offset_m.is_some());
                violations.require(!is_displaced, "/where/offset_m", "needs an object that is on the table");
            }
            Self::Move { place, .. } => violations.extend("/where", place.violations()),
            Self::Rotate { by_rad, to_rad, facing, .. } => {
                let given = usize::from(by_rad.is_some())
                    + usize::from(to_rad.is_some())
                    + usize::from(facing.is_some());
                violations.require(given == 1, "", "give one of `by_rad`, `to_rad` and `facing`");
                violations.require(is_angle(*by_rad), "/by_rad", ANGLE);
                violations.require(is_angle(*to_rad), "/to_rad", ANGLE);
            }
            Self::Resize { factor, .. } => {
                let range = (1.0 / MAX_RESIZE..=MAX_RESIZE).contains(factor);
                violations.require(
                    range,
                    "/factor",
                    format!("must be from {} to {MAX_RESIZE}", 1.0 / MAX_RESIZE),
                );
            }
            Self::Recolor { color, material, .. } | Self::RestyleTable { color, material } => {
                let any = color.is_some() || material.is_some();
                violations.require(any, "", "give `color`, `material`, or both");
            }
            Self::Stack { targets } => {
                let count = (1..=MAX_ADDED as usize).contains(&targets.len());
                violations.require(count, "/targets", format!("must name 1 to {MAX_ADDED} objects"));
            }
            Self::Clutter { count, .. } => {
                let range = (1..=MAX_ADDED).contains(count);
                violations.require(range, "/count", format!("must be from 1 to {MAX_ADDED}"));
            }
            _ => {}
        }
        violations.into_vec()
    }
}

/// What an edit did: part of `scene.json`, the report, and what the API shows of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EditAccount {
    /// Id of the parent in its `scene.json`.
    pub parent: String,
    /// One entry per operation, in order.
    pub operations: Vec<OperationResult>,
    /// Objects that no operation names and that moved nevertheless. All others have exactly the parent's poses.
    pub moved: Vec<MovedObject>,
}

/// The result of one operation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OperationResult {
    /// [`EditOperation::name`].
    pub op: String,
    /// The objects it acted on, by their names in the new scene; removed ones by their names in the parent.
    pub objects: Vec<InstanceId>,
    /// What was done, in one sentence.
    pub sentence: String,
}

/// A movement that no operation asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovedObject {
    pub name: InstanceId,
    /// Of its origin.
    pub distance_m: f64,
    pub angle_rad: f64,
    /// Why it had to move.
    pub cause: String,
}

/// Every violation of a list of operations, with JSON pointers relative to the list.
pub fn violations(operations: &[EditOperation]) -> Vec<Violation> {
    let mut violations = Violations::default();
    let count = (1..=MAX_OPERATIONS).contains(&operations.len());
    violations.require(count, "", format!("must have 1 to {MAX_OPERATIONS} operations"));
    for (index, operation) in operations.iter().enumerate().take(MAX_OPERATIONS) {
        violations.extend(&format!("/{index}"), operation.violations());
    }
    violations.into_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(json: &str) -> EditOperation {
        serde_json::from_str(json).expect(json)
    }

    #[test]
    fn operations_are_read_from_their_wire_form_and_written_the_same() {
        for json in [
            r#"{"op":"add","object":"a spoon","where":{"relation":"in","target":"mug_1"}}"#,
            r#"{"op":"remove","target":"the desk lamp"}"#,
            r#"{"op":"move","target":"mug_1","where":{"position_m":[0.1,-0.2],"yaw_rad":1.5}}"#,
            r#"{"op":"move","target":"mug_1","where":{"offset_m":[-0.1,0.0]}}"#,
            r#"{"op":"rotate","target":"mug_1","by_rad":0.5}"#,
            r#"{"op":"stack","targets":["the books"]}"#,
            r#"{"op":"tidy"}"#,
        ] {
            let operation = read(json);
            assert_eq!(operation.violations(), [], "{json}");
            assert_eq!(serde_json::to_string(&operation).expect("text"), json);
        }
    }

    #[test]
    fn violations_point_at_the_wrong_field() {
        let pointers = |json: &str| -> Vec<String> {
            violations(&[read(json)]).into_iter().map(|violation| violation.pointer).collect()
        };
        let cases = [
            (r#"{"op":"add","object":"","count":99}"#, vec!["/0/object", "/0/count"]),
            (r#"{"op":"move","target":"a","where":{}}"#, vec!["/0/where"]),
            (r#"{"op":"move","target":"a","where":{"relation":"left_of"}}"#, vec!["/0/where/target"]),
            (
                r#"{"op":"move","target":"a","where":{"relation":"at_left","target":"b"}}"#,
                vec!["/0/where/target"],
            ),
            (
                r#"{"op":"move","target":"a","where":{"relation":"between","target":"b"}}"#,
                vec!["/0/where/second_target"],
            ),
            (
                r#"{"op":"move","target":"a","where":{"offset_m":[0.1,0],"relation":"at_left"}}"#,
                vec!["/0/where"],
            ),
            (r#"{"op":"move","target":"a","where":{"offset_m":[9,0]}}"#, vec!["/0/where/offset_m"]),
            (r#"{"op":"add","object":"a","where":{"offset_m":[0.1,0]}}"#, vec!["/0/where/offset_m"]),
            (r#"{"op":"rotate","target":"a"}"#, vec!["/0"]),
            (r#"{"op":"resize","target":"a","factor":9}"#, vec!["/0/factor"]),
            (r#"{"op":"recolor","target":"a"}"#, vec!["/0"]),
            (r#"{"op":"stack","targets":[]}"#, vec!["/0/targets"]),
        ];
        for (json, expected) in cases {
            assert_eq!(pointers(json), expected, "{json}");
        }
        assert_eq!(violations(&[]).len(), 1);
    }

    #[test]
    fn unknown_fields_are_refused() {
        assert!(serde_json::from_str::<EditOperation>(r#"{"op":"remove","target":"a","x":1}"#).is_err());
        assert!(serde_json::from_str::<EditOperation>(r#"{"op":"explode"}"#).is_err());
    }
}
