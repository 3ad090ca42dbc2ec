//! Clutter: objects that lie as they fell, as a request asks for them and as a finished scene has them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::InstanceId;
use geometry::json_numbers::Fraction;

/// Clutter that a request asks for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(
    description = "Clutter: objects without a stated place are dropped onto each other until they rest."
)]
pub struct Clutter {
    /// Share of the area under the heap that objects are to cover. 0 spreads them over the table at random, 1 drops
    /// them as close to each other as they can lie.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub density: f64,
}

/// Clutter of a finished scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "Measurements of a scene whose objects were dropped.")]
pub struct ClutterFinding {
    /// The density that was asked for.
    #[schemars(with = "Fraction")]
    pub density: f64,
    /// Share of the area under the heap that dropped objects cover, seen from above. The area is that of the smallest
    /// disk around the center of what they cover that holds nine tenths of it, without what is beyond the table's edge.
    #[schemars(with = "Fraction")]
    pub covered_share: f64,
    /// Mean number of other objects that an object touches; the table does not count.
    #[schemars(range(min = 0.0))]
    pub mean_contacts: f64,
    /// Number of objects that touch another one.
    #[schemars(range(min = 0, max = 10_000))]
    pub touching: usize,
    /// Share of objects of which at least a quarter is hidden by others, in the hero view or from above.
    #[schemars(with = "Fraction")]
    pub hidden_share: f64,
    /// In the order of the scene.
    pub objects: Vec<ClutteredObject>,
}

/// One object among clutter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClutteredObject {
    #[schemars(with = "String")]
    pub name: InstanceId,
    pub placement: ClutterPlacement,
    /// Number of other objects that it touches.
    #[schemars(range(min = 0, max = 10_000))]
    pub contacts: usize,
    /// Share of its pixels that other objects hide in the hero view.
    #[schemars(with = "Fraction")]
    pub hidden_in_hero: f64,
    /// Share of its pixels that other objects hide from above.
    #[schemars(with = "Fraction")]
    pub hidden_from_above: f64,
}

/// Origin of an object's place among clutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ClutterPlacement {
    /// In its place without clutter: the text demands the place, or the object is too large or heavy to be dropped.
    Kept,
    /// At rest where it fell.
    Dropped,
    /// Upright on a free place, after it did not come to rest on the table where it fell.
    SetDown,
}

impl ClutterFinding {
    /// Share of an object's pixels from which on it counts as hidden.
    pub const HIDDEN: f64 = 0.25;
}
