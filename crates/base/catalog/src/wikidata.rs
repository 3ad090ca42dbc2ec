//! Wikidata items of categories (`config/catalog/wikidata.toml`): the item of the object itself if known, else of a
//! superclass.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

/// Contents of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    /// The item that all others belong to.
    anything: String,
    /// Items by category.
    exact: BTreeMap<String, String>,
    kind: Vec<Kind>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Kind {
    item: String,
    /// Wikidata's label of the item, for readers of the file.
    #[cfg_attr(not(test), expect(dead_code, reason = "read by people and by the test"))]
    label: String,
    categories: Vec<String>,
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../config/catalog/wikidata.toml"))
        .expect("the built-in table parses (a test loads it)")
});

/// The item of the category or of a superclass; `Q` and digits.
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
    fn wikidata_names_each_category_once_and_only_existing_ones() {
        let of_kinds = TABLE.kind.iter().flat_map(|kind| &kind.categories);
        let all: Vec<&String> = TABLE.exact.keys().chain(of_kinds).collect();
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
        for name in all {
            assert!(name == "table" || category(name).is_some(), "{name}");
        }
    }

    #[test]
    fn wikidata_items_are_q_and_digits() {
        let of_kinds = TABLE.kind.iter().map(|kind| &kind.item);
        for item in TABLE.exact.values().chain(of_kinds).chain([&TABLE.anything]) {
            let digits = item.strip_prefix('Q').expect("begins with Q");
            assert!(!digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit()), "{item}");
        }
        assert!(TABLE.kind.iter().all(|kind| !kind.label.is_empty()));
    }

    #[test]
    fn wikidata_item_prefers_the_object_over_its_superclass() {
        assert_eq!(wikidata_item("mug"), "Q386215");
        assert_eq!(wikidata_item("chisel"), wikidata_item("wrench"));
        assert_eq!(wikidata_item("no such thing"), "Q223557");
    }
}
