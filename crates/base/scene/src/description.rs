//! Description of a scene by the analyst: objects with sizes and relations, and the table.

use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::text_account::{Goal, TextAccount, Understood, Unrecognized};
use super::{InstanceId, StandIn, TableSpec};
use geometry::Rgb;

/// A detailed, layout-aware description: style, objects with counts, functional layout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneDescription {
    /// Name of the theme that supplies objects the text leaves open (`hobby_desk`).
    pub theme: String,
    /// One of the four families of the paper's test set: `office_living`, `dining_kitchen`,
    /// `workbench_utility`, `crafting_hobby`.
    pub family: String,
    pub table: TableSpec,
    /// Whether text or options state the size of the table; otherwise it grows where space is missing.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub table_size_is_stated: bool,
    /// In the order of the text. Relations refer to objects by id, in any order.
    pub objects: Vec<ObjectSpec>,
    /// Groups of objects in a regular arrangement.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub arrangements: Vec<Arrangement>,
    /// The goal of a task instruction; the objects are in its start state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<Goal>,
    /// Categories that must be absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub excluded_categories: Vec<String>,
    /// Parts of the text with a meaning, in the order of the text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub understood: Vec<Understood>,
    /// Parts of the text without effect, in the order of the text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unrecognized: Vec<Unrecognized>,
    /// The description in plain language.
    pub prose: String,
}

impl SceneDescription {
    /// The account of the text that this describes, before its layout.
    pub fn account(&self) -> TextAccount {
        let ids = |chosen: fn(&ObjectSpec) -> bool| {
            self.objects.iter().filter(|object| chosen(object)).map(|object| object.id.clone()).collect()
        };
        TextAccount {
            understood: self.understood.clone(),
            unrecognized: self.unrecognized.clone(),
            goal: self.goal.clone(),
            stand_ins: ids(|object| object.stand_in.is_some()),
            fillings: ids(|object| !object.requested),
            ..TextAccount::default()
        }
    }
}

/// One requested object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectSpec {
    pub id: InstanceId,
    /// The user's words ("red coffee mug").
    pub label: String,
    /// Catalog category.
    pub category: String,
    /// Upright extents: width (x), depth (y), height (z), meters. The port method `measure` returns them.
    pub size_m: DVec3,
    /// The color the text asks for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<Rgb>,
    /// The material the text asks for (a name of `config/materials.toml`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Seed of the details of its shape and texture, derived from the request's seed and the id.
    pub seed: u64,
    /// Whether the text names it; otherwise the theme added it.
    pub requested: bool,
    /// The requested object that this category replaces, where the catalog does not have it.
    #[serde(flatten, with = "crate::stand_in::fields")]
    pub stand_in: Option<StandIn>,
    /// The orientation the text asks for.
    #[serde(default, skip_serializing_if = "RequestedPose::is_upright")]
    pub pose: RequestedPose,
    /// Rotation about the vertical axis that the text asks for, counter-clockwise seen from above; 0 faces the front
    /// edge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_rad: Option<f64>,
    /// Center that the text asks for, from the center of the table top: x to the right, y to the back, meters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_m: Option<DVec2>,
    /// A state of its category (`open`, `closed`) that the text asks for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<String>,
    /// The mass that the text asks for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    pub relations: Vec<Relation>,
}

/// Spatial relation of an object to another one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Relation {
    pub kind: RelationKind,
    /// The other object; `None` means the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<InstanceId>,
    /// The second object of [`RelationKind::Between`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_target: Option<InstanceId>,
    /// Free distance between the nearest points of the two objects, or of the object and the edge of the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_m: Option<f64>,
    /// Whether left, right, in front and behind are those of the person who sits at the target, at the edge of the
    /// table that is nearest to it, instead of those of a viewer at the front edge.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub seated: bool,
}

impl Relation {
    /// A relation to one object, or to the table, without a distance.
    pub fn new(kind: RelationKind, target: Option<InstanceId>) -> Self {
        Self { kind, target, second_target: None, distance_m: None, seated: false }
    }
}

/// The orientation of an object that a text asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RequestedPose {
    #[default]
    Upright,
    /// Vertical axis of the object horizontal.
    LyingOnSide,
    /// Bottom of the object on top.
    UpsideDown,
}

impl RequestedPose {
    pub fn is_upright(&self) -> bool {
        *self == Self::Upright
    }
}

/// A regular arrangement of objects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arrangement {
    pub kind: ArrangementKind,
    /// At least two, in order: left to right, front to back, counter-clockwise, or from the bottom up.
    pub objects: Vec<InstanceId>,
    /// Free distance between neighbors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap_m: Option<f64>,
    /// The object at the center of a circle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<InstanceId>,
}

/// Kinds of arrangements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", tag = "arrangement")]
pub enum ArrangementKind {
    /// Along the front edge.
    Row,
    /// From the front to the back.
    Column,
    Circle,
    /// Rows of `columns` objects each.
    Grid {
        #[schemars(range(min = 1))]
        columns: usize,
    },
    /// Loosely on top of and beside each other.
    Pile,
    /// Layers of a triangle: each object of a layer stands on two of the layer below.
    Pyramid,
}

/// Kinds of spatial relations. Directions are as seen from the front edge of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RelationKind {
    On,
    In,
    LeftOf,
    RightOf,
    InFrontOf,
    Behind,
    NextTo,
    /// Between the target and the second target.
    Between,
    /// Front pointing to the target.
    Facing,
    /// Front parallel to the front of the target.
    ParallelTo,
    /// One of several objects distributed around the target.
    Around,
    /// One of a stack of equal objects: on top of the previous one.
    StackedOn,
    /// At a named part of the table top; likewise the variants below.
    AtCenter,
    AtBack,
    AtFront,
    AtLeft,
    AtRight,
    AtBackLeft,
    AtBackRight,
    AtFrontLeft,
    AtFrontRight,
    /// At a distance from an edge of the table; likewise the variants below.
    FromLeftEdge,
    FromRightEdge,
    FromFrontEdge,
    FromBackEdge,
}

impl RelationKind {
    /// Whether the relation is to another object, never to the table.
    pub fn target_is_object(self) -> bool {
        use RelationKind::{Behind, Between, InFrontOf, LeftOf, NextTo, RightOf, StackedOn};
        matches!(self, LeftOf | RightOf | InFrontOf | Behind | NextTo | Between | StackedOn)
    }

    /// Whether the relation makes the target the support.
    pub fn is_support(self) -> bool {
        matches!(self, Self::On | Self::In | Self::StackedOn)
    }
}

impl ObjectSpec {
    /// The supporting object; `None` = the table.
    pub fn supporter(&self) -> Option<&InstanceId> {
        self.relations.iter().find(|r| r.kind.is_support()).and_then(|r| r.target.as_ref())
    }
}
