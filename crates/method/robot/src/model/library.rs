//! The robots of `config/robots/`, compiled in.

use crate::model::error::ModelError;

const FILES: &[(&str, &str)] = &[
    ("panda", include_str!("../../../../../config/robots/panda.toml")),
    ("piper", include_str!("../../../../../config/robots/piper.toml")),
];

/// The names of the robots that are built in.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

pub(super) fn text(name: &str) -> Result<&'static str, ModelError> {
    let file = FILES.iter().find(|(known, _)| *known == name);
    file.map(|(_, text)| *text).ok_or_else(|| ModelError::UnknownRobot {
        name: name.to_owned(),
        known: names().map(str::to_owned).collect(),
    })
}
