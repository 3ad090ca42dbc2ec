//! Items of Wikidata for categories (`config/catalog/wikidata.toml`): of the thing itself where its item is known, else
//! of a kind it belongs to.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    /// The item that everything belongs to.
    anything: String,
    /// Category to item.
    exact: BTreeMap<String, String>,
    kind: Vec<Kind>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Kind {
    item: String,
    /// As Wikidata labels the item, for whoever reads the file.
    #[cfg_attr(not(test), expect(dead_code, reason = "read by people and by the test"))]
    label: String,
    categories: Vec<String>,
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../config/catalog/wikidata.toml"))
        .expect("the built-in table parses (a test loads it)")
});

/// The item of a thing of that category, or of something it is a kind of; `Q` and digits.
pub fn wikidata_item(category: &str) -> &'static str {
    let of_kind = || TABLE.kind.iter().find(|kind| kind.categories.iter().any(|known| known == category));
    match TABLE.exact.get(category) {
        Some(item) => item,
        None => of_kind().map_or(&TABLE.anything, |kind| &kind.item),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::category;

    #[test]
    fn each_category_is_named_once_and_exists() {
        let of_kinds = TABLE.kind.iter().flat_map(|kind| &kind.categories);
        let all: Vec<&String> = TABLE.exact.keys().chain(of_kinds).collect();
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
        for name in all {
            assert!(name == "table" || category(name).is_some(), "{name}");
        }
    }

    #[test]
    fn items_are_numbers_of_wikidata() {
        let of_kinds = TABLE.kind.iter().map(|kind| &kind.item);
        for item in TABLE.exact.values().chain(of_kinds).chain([&TABLE.anything]) {
            let digits = item.strip_prefix('Q').expect("begins with Q");
            assert!(!digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit()), "{item}");
        }
        assert!(TABLE.kind.iter().all(|kind| !kind.label.is_empty()));
    }

    #[test]
    fn a_thing_is_told_as_exactly_as_it_is_known() {
        assert_eq!(wikidata_item("mug"), "Q386215");
        assert_eq!(wikidata_item("chisel"), wikidata_item("wrench"));
        assert_eq!(wikidata_item("no such thing"), "Q223557");
    }
}
