//! Edits: operations that derive a scene from a finished one.

mod place;
mod camera_move;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::name::Names;
use crate::validation::{Violation, Violations};
use crate::{InstanceId, Light};

pub use camera_move::CameraMove;
pub use place::EditPlace;

/// Largest number of operations of one edit.
pub const MAX_OPERATIONS: usize = 64;

/// Largest number of objects that one operation adds.
pub const MAX_ADDED: u32 = 32;

/// Largest factor by which an object grows, and the inverse of the smallest.
pub const MAX_RESIZE: f64 = 2.0;

/// One operation. Objects are named by their name in the parent scene (`mug_1`), or by a phrase: "the red mug", "the
/// second book from the left", "all spoons". A phrase that fits several objects where one is meant is an error.
/// Operations are carried out in order; a later one sees the result of the earlier ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Two objects change places: two phrases, or one that means two.
    Swap { targets: Vec<String> },
    /// Objects in a row or a column, in the order of the phrases, or sorted.
    Arrange {
        targets: Vec<String>,
        arrangement: ArrangedAs,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sort_by: Option<SortedBy>,
        /// The place of their center; the mean of their places unless it is given.
        #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
        place: Option<EditPlace>,
    },
    /// Objects that stand on the table are aligned with its edges and moved apart.
    Tidy,
    /// More objects of the scene's theme, or of the one that is given.
    Clutter {
        count: u32,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        theme: Option<String>,
    },
    /// Another mesh of the same kind, with the same name, in the same place.
    Remake { target: String },
    /// New places for what stands on the table. Relations that a text states still hold, and what rests on or in an
    /// object moves with it.
    Rearrange,
    /// Another mass or friction, by factors.
    SetPhysics {
        target: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        mass_factor: Option<f64>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        friction_factor: Option<f64>,
    },
    /// Another light.
    Relight(Light),
    /// Another view of the reference camera: turned about the center of the table and raised, nearer or farther, or
    /// with another focal length.
    MoveCamera(CameraMove),
}

/// Directions in which objects are lined up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ArrangedAs {
    /// From the left to the right.
    Row,
    /// From the front to the back.
    Column,
}

/// Orders of objects that are lined up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SortedBy {
    /// The smallest footprint first.
    Size,
    /// The lowest first.
    Height,
    /// By hue, those without a color last.
    Color,
    /// By category.
    Kind,
}

const ANGLE: &str = "must be from -6.3 to 6.3 radians";

fn is_angle(angle_rad: Option<f64>) -> bool {
    angle_rad.is_none_or(|angle_rad| (-6.3..=6.3).contains(&angle_rad))
}

const FACTOR: &str = "must be from 0.25 to 4";

fn is_factor(factor: Option<f64>) -> bool {
    factor.is_none_or(|factor| (0.25..=4.0).contains(&factor))
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
            Self::Swap { .. } => "swap",
            Self::Arrange { .. } => "arrange",
            Self::Tidy => "tidy",
            Self::Clutter { .. } => "clutter",
            Self::Remake { .. } => "remake",
            Self::Rearrange => "rearrange",
            Self::SetPhysics { .. } => "set_physics",
            Self::Relight(_) => "relight",
            Self::MoveCamera(_) => "move_camera",
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
            | Self::Remake { target }
            | Self::SetPhysics { target, .. }
            | Self::Recolor { target, .. } => phrase("/target", target),
            Self::Stack { targets } | Self::Swap { targets } | Self::Arrange { targets, .. } => {
                targets.iter().enumerate().for_each(|(k, target)| phrase(&format!("/targets/{k}"), target));
            }
            Self::RestyleTable { .. }
            | Self::Tidy
            | Self::Clutter { .. }
            | Self::Rearrange
            | Self::Relight(_)
            | Self::MoveCamera(_) => {}
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
            Self::Swap { targets } => {
                violations.require((1..=2).contains(&targets.len()), "/targets", "must name two objects");
            }
            Self::Arrange { targets, place, .. } => {
                let count = (1..=MAX_ADDED as usize).contains(&targets.len());
                violations.require(count, "/targets", format!("must name 1 to {MAX_ADDED} objects"));
                violations.extend("/where", place.as_ref().map_or(Vec::new(), EditPlace::violations));
                let is_displaced = place.as_ref().is_some_and(|place| place.offset_m.is_some());
                violations.require(
                    !is_displaced,
                    "/where/offset_m",
                    "the whole row has no place to be displaced from",
                );
            }
            Self::Clutter { count, .. } => {
                let range = (1..=MAX_ADDED).contains(count);
                violations.require(range, "/count", format!("must be from 1 to {MAX_ADDED}"));
            }
            Self::SetPhysics { mass_factor, friction_factor, .. } => {
                let any = mass_factor.is_some() || friction_factor.is_some();
                violations.require(any, "", "give `mass_factor`, `friction_factor`, or both");
                violations.require(is_factor(*mass_factor), "/mass_factor", FACTOR);
                violations.require(is_factor(*friction_factor), "/friction_factor", FACTOR);
            }
            Self::Relight(light) => violations.extend("", light.violations()),
            Self::MoveCamera(change) => violations.extend("", change.violations()),
            _ => {}
        }
        violations.into_vec()
    }
}

/// Result of an edit: part of `scene.json`, of the report, and of the scene in the API.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EditAccount {
    /// Id of the parent in its `scene.json`.
    #[schemars(length(min = 1))]
    pub parent: String,
    /// One entry per operation, in order.
    pub operations: Vec<OperationResult>,
    /// Words of the instruction that ask for nothing, where the edit was given in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub asides: Vec<String>,
    /// Objects that no operation names and that moved nevertheless. All others have exactly the parent's poses.
    pub moved: Vec<MovedObject>,
}

/// The result of one operation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OperationResult {
    /// Word of the operation, such as `add`.
    pub op: String,
    /// The objects it acted on, by their names in the new scene; removed ones by their names in the parent.
    #[schemars(with = "Names")]
    pub objects: Vec<InstanceId>,
    /// Change made by the operation, in one sentence.
    pub sentence: String,
    /// The words of the instruction that ask for it, where the edit was given in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub words: Option<String>,
}

/// A movement that no operation asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MovedObject {
    pub name: InstanceId,
    /// Of its origin.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub distance_m: f64,
    #[schemars(range(min = 0.0, max = 3.2))]
    pub angle_rad: f64,
    /// Reason why the object had to move.
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
mod tests;
