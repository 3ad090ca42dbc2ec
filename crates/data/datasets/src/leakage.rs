//! The check of splits: what scenes of different splits share.
//!
//! It compares splits value by value and knows nothing of groups, so that an error of the assignment shows.

use std::collections::BTreeMap;
use std::fmt;

use crate::sharing::{LeakageRules, Shareable};

/// A value that scenes of two splits share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Leak {
    /// `scene:<id>`, `text:<sha256>`, `image:<sha256>` or `mesh:<sha256>`.
    pub key: String,
    /// One scene of each of two splits: id and split.
    pub scenes: [(String, String); 2],
}

impl fmt::Display for Leak {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [(a, split_a), (b, split_b)] = &self.scenes;
        write!(f, "{a} in {split_a} and {b} in {split_b} share {}", self.key)
    }
}

/// Every shared value that counts, once, in the order of the keys. `scenes` are scenes with their splits.
pub fn leaks(scenes: &[(Shareable, String)], rules: &LeakageRules) -> Vec<Leak> {
    let mut holders: BTreeMap<(&str, &str), Vec<(&str, &str)>> = BTreeMap::new();
    for (scene, split) in scenes {
        let mut values: Vec<(&str, &str)> = Vec::new();
        if rules.lineage {
            values.push(("scene", &scene.id));
            values.extend(scene.parent.iter().map(|parent| ("scene", parent.as_str())));
        }
        if rules.text {
            values.extend(scene.text_sha256.iter().map(|text| ("text", text.as_str())));
        }
        if rules.image {
            values.extend(scene.image_sha256.iter().map(|image| ("image", image.as_str())));
        }
        if rules.mesh {
            values.extend(scene.mesh_sha256.iter().map(|mesh| ("mesh", mesh.as_str())));
        }
        for value in values {
            holders.entry(value).or_default().push((&scene.id, split));
        }
    }
    let mut leaks = Vec::new();
    for ((kind, value), scenes) in holders {
        let (first, split) = scenes[0];
        if let Some((other, other_split)) = scenes.iter().find(|(_, other)| *other != split) {
            leaks.push(Leak {
                key: format!("{kind}:{value}"),
                scenes: [
                    (first.to_owned(), split.to_owned()),
                    ((*other).to_owned(), (*other_split).to_owned()),
                ],
            });
        }
    }
    leaks
}
