//! Parts that two scenes may share, and the kinds of sharing that keep them in one split.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::facts::SceneFacts;

/// Kinds of sharing that count as leakage between splits. Scenes that share a key of a counted kind form one group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeakageRules {
    /// Parent and child, and children of one parent, also where the parent is not in the dataset.
    pub lineage: bool,
    /// The same text, in lower case and without punctuation.
    pub text: bool,
    /// The same input image.
    pub image: bool,
    /// The same file of an object's mesh. Tables do not count.
    pub mesh: bool,
}

impl LeakageRules {
    pub const ALL: Self = Self { lineage: true, text: true, image: true, mesh: true };
    pub const NONE: Self = Self { lineage: false, text: false, image: false, mesh: false };

    /// One sentence per kind: what the splits guarantee, or do not.
    pub fn statement(&self) -> Vec<String> {
        let kinds = [
            (self.lineage, "a scene and a scene edited from it, or two scenes edited from the same scene"),
            (self.text, "a text (in lower case, without punctuation)"),
            (self.image, "an input image"),
            (self.mesh, "a mesh of an object (SHA-256 of its GLB file)"),
        ];
        let sentence = |(counts, kind): (bool, &str)| match counts {
            true => format!("No two splits share {kind}."),
            false => format!("Splits may share {kind}."),
        };
        kinds.into_iter().map(sentence).collect()
    }

    /// The shared values that count, as keys. Scenes with a key in common belong together.
    pub fn keys(&self, scene: &Shareable) -> Vec<String> {
        let mut keys = Vec::new();
        if self.lineage {
            keys.push(format!("scene:{}", scene.id));
            keys.extend(scene.parent.iter().map(|parent| format!("scene:{parent}")));
        }
        if self.text {
            keys.extend(scene.text_sha256.iter().map(|text| format!("text:{text}")));
        }
        if self.image {
            keys.extend(scene.image_sha256.iter().map(|image| format!("image:{image}")));
        }
        if self.mesh {
            keys.extend(scene.mesh_sha256.iter().map(|mesh| format!("mesh:{mesh}")));
        }
        keys
    }
}

/// A word that names no kind of sharing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{kind:?} is no kind; give lineage, text, image, mesh, or none")]
pub struct UnknownKind {
    pub kind: String,
}

impl FromStr for LeakageRules {
    type Err = UnknownKind;

    /// A list such as `lineage,text`; `none` for no rule.
    fn from_str(text: &str) -> Result<Self, UnknownKind> {
        let mut rules = Self::NONE;
        for kind in text.split(',').map(str::trim).filter(|kind| !kind.is_empty()) {
            match kind {
                "lineage" => rules.lineage = true,
                "text" => rules.text = true,
                "image" => rules.image = true,
                "mesh" => rules.mesh = true,
                "none" if text.trim() == "none" => {}
                _ => return Err(UnknownKind { kind: kind.to_owned() }),
            }
        }
        Ok(rules)
    }
}

/// The values of a scene that other scenes may have, too.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shareable {
    #[serde(skip)]
    pub id: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text_sha256: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image_sha256: Option<String>,
    #[serde(default)]
    pub mesh_sha256: Vec<String>,
}

impl Shareable {
    pub fn of(facts: &SceneFacts) -> Self {
        Self {
            id: facts.id.clone(),
            parent: facts.parent.clone(),
            text_sha256: facts.text_sha256.clone(),
            image_sha256: facts.image_sha256.clone(),
            mesh_sha256: facts.mesh_sha256.clone(),
        }
    }
}
