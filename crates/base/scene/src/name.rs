//! Instance names, valid in every export format and file system.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// Stable name of an instance: `[a-z][a-z0-9_]{0,62}`, unique in its scene (`mug_1`). Seeds, keys and file names are
/// derived from it, not from a list position.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct InstanceId(String);

/// The text is not a valid instance name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not a name of the form [a-z][a-z0-9_]{{0,62}}")]
pub struct InvalidName(String);

impl InstanceId {
    /// Parses a name.
    ///
    /// # Errors
    ///
    /// [`InvalidName`] unless the text has the form `[a-z][a-z0-9_]{0,62}`.
    pub fn new(name: &str) -> Result<Self, InvalidName> {
        let mut characters = name.chars();
        let valid = characters.next().is_some_and(|c| c.is_ascii_lowercase())
            && name.len() <= 63
            && characters.all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        if valid { Ok(Self(name.to_owned())) } else { Err(InvalidName(name.to_owned())) }
    }

    /// Name of the `number`-th instance of a label: ASCII letters and digits are kept, all else becomes `_`.
    pub fn numbered(label: &str, number: usize) -> Self {
        let mut stem = String::new();
        for c in label.chars().flat_map(char::to_lowercase).take(48) {
            if c.is_ascii_alphanumeric() {
                stem.push(c);
            } else if !stem.is_empty() && !stem.ends_with('_') {
                stem.push('_');
            }
        }
        let stem = stem.trim_matches('_');
        let stem = if stem.starts_with(|c: char| c.is_ascii_lowercase()) {
            stem.to_owned()
        } else {
            format!("object_{stem}").trim_end_matches('_').to_owned()
        };
        Self(format!("{stem}_{number}"))
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl JsonSchema for InstanceId {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Name".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "pattern": "^[a-z][a-z0-9_]{0,62}$" })
    }
}

/// Names of objects.
#[derive(JsonSchema)]
pub struct Names(pub Vec<InstanceId>);

impl fmt::Display for InstanceId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl TryFrom<String> for InstanceId {
    type Error = InvalidName;
    fn try_from(name: String) -> Result<Self, InvalidName> {
        Self::new(&name)
    }
}

impl From<InstanceId> for String {
    fn from(id: InstanceId) -> Self {
        id.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbered_gives_valid_names_for_any_label() {
        for label in
            ["Coffee mug", "../../etc", "", "7up \"can\"", "Tasse à café", "<b>🍎</b>", &"x".repeat(300)]
        {
            let id = InstanceId::numbered(label, 3);
            assert_eq!(InstanceId::new(id.as_str()), Ok(id.clone()), "{label:?}");
        }
        assert!(InstanceId::new("Mug").is_err() && InstanceId::new("a/b").is_err());
    }
}
