//! Description of a scene by the analyst: objects with sizes and relations, and the table.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{InstanceId, TableSpec};
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
    /// In the order of the text. Relations refer to objects by id, in any order.
    pub objects: Vec<ObjectSpec>,
    /// Nouns of the text that no category of the catalog matches.
    pub unrecognized_terms: Vec<String>,
    /// The description in plain language.
    pub prose: String,
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
    pub relations: Vec<Relation>,
}

/// Spatial relation of an object to another one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Relation {
    pub kind: RelationKind,
    /// The other object; `None` means the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<InstanceId>,
}

/// Kinds of spatial relations. Directions are as seen from the front edge of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RelationKind {
    On,
    In,
    LeftOf,
    RightOf,
    InFrontOf,
    Behind,
    NextTo,
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
}

impl RelationKind {
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
