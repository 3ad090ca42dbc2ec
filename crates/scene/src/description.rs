//! What the analyst makes of a text: which objects, how large, in which relations, on which table.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{InstanceId, TableSpec};
use geometry::Rgb;

/// A detailed, layout-aware description: style, object set with counts, functional layout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneDescription {
    /// Name of the theme that fills gaps (`hobby_desk`).
    pub theme: String,
    /// One of the four families of the paper's test set: `office_living`, `dining_kitchen`,
    /// `workbench_utility`, `crafting_hobby`.
    pub family: String,
    pub table: TableSpec,
    /// In the order in which the text names them; relations refer to earlier or later ones by id.
    pub objects: Vec<ObjectSpec>,
    /// Words of the text that mean a thing nobody here knows.
    pub unrecognized_terms: Vec<String>,
    /// The description in plain words, as a person would read it.
    pub prose: String,
}

/// One object to stand on the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectSpec {
    pub id: InstanceId,
    /// The user's words ("red coffee mug").
    pub label: String,
    /// Catalog category.
    pub category: String,
    /// Extents as it stands: width (x), depth (y), height (z), meters. `measure` answers with this.
    pub size_m: DVec3,
    /// The color the text asks for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<Rgb>,
    /// The material the text asks for (a name of `config/materials.toml`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Draws the details of its shape and texture; a child of the request's seed and the id.
    pub seed: u64,
    /// Whether the text asked for it by name (else the theme added it).
    pub requested: bool,
    pub relations: Vec<Relation>,
}

/// Where an object stands relative to another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Relation {
    pub kind: RelationKind,
    /// The other object; `None` means the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<InstanceId>,
}

/// Relations the grammar understands. Directions are those of somebody at the front edge.
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
    /// One of several spread about the target.
    Around,
    /// One of a pile of equals: stands on the previous one.
    StackedOn,
    /// At a named part of the table top.
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
    /// The object this one stands on or in; `None` = the table.
    pub fn supporter(&self) -> Option<&InstanceId> {
        self.relations.iter().find(|r| r.kind.is_support()).and_then(|r| r.target.as_ref())
    }
}
