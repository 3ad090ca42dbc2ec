//! Shape rules (`config/catalog/stand_in_rules.toml`): family, size and substance of the nouns of each rule.
//!
//! The file also says which meanings of WordNet a rule covers; only the script that writes the lexicon reads that.

use std::sync::LazyLock;

use glam::DVec3;
use serde::Deserialize;

/// Shape of all nouns of a rule.
#[derive(Debug, Deserialize)]
pub(super) struct Rule {
    pub name: String,
    /// The hidden category `stand_in_` with this name builds it.
    pub family: String,
    /// Extents of small and large specimens, meters.
    pub low_m: DVec3,
    pub high_m: DVec3,
    /// One of `config/materials.toml`.
    pub substance: String,
}

#[derive(Deserialize)]
struct RuleFile {
    shape: Vec<Rule>,
}

static RULES: LazyLock<Vec<Rule>> = LazyLock::new(|| {
    let file: RuleFile = toml::from_str(include_str!("../../../../../config/catalog/stand_in_rules.toml"))
        .expect("the built-in rules parse (a test loads them)");
    file.shape
});

/// Every rule, in file order.
#[cfg(test)]
pub(super) fn rules() -> &'static [Rule] {
    &RULES
}

/// The rule of that name.
pub(super) fn rule(name: &str) -> Option<&'static Rule> {
    RULES.iter().find(|rule| rule.name == name)
}
