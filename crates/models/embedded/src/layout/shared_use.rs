//! Objects that are used together, which people keep close to each other.

use catalog::Category;

/// Functional groups of categories by what they are used for. A group can have several uses.
const USES: &[&[&str]] = &[
    // Eating and drinking.
    &[
        "dish",
        "cutlery",
        "vessel",
        "meal",
        "bakery",
        "baked_good",
        "sweet",
        "meat",
        "fish",
        "condiment",
        "tableware",
        "table_service",
    ],
    &["fruit", "vegetable", "nut"],
    // Cooking.
    &["kitchen_tool", "cookware", "food", "condiment", "board"],
    &["bottle", "can", "package"],
    // Writing, reading and drawing.
    &[
        "writing_tool",
        "pen",
        "paper",
        "stationery",
        "stationery_holder",
        "desk_tool",
        "reading",
        "drawing",
        "desk",
    ],
    &["screen", "input_device", "handheld_device", "cable", "electronics", "audio"],
    // Making and repairing.
    &["hand_tool", "tool", "power_tool", "hardware", "measuring_tool", "adhesive"],
    &["sewing", "spool", "cloth"],
    &["paint", "brush", "drawing"],
    &["garden_tool", "plant"],
    // Playing.
    &["toy", "toy_animal", "game", "musical_toy", "model", "sport"],
    &["bathroom", "personal_item", "cleaning"],
    &["laboratory"],
    &["decoration", "light", "lamp", "clock"],
];

/// Whether both are of a kind, or have a use in common.
pub(super) fn share_a_use(a: &Category, b: &Category) -> bool {
    let has = |uses: &&&[&str]| uses.contains(&a.group.as_str()) && uses.contains(&b.group.as_str());
    a.name == b.name || USES.iter().any(|uses| has(&uses))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use catalog::{categories, category};

    #[test]
    fn groups_of_the_catalog_share_uses() {
        let share = |a: &str, b: &str| {
            let [a, b] = [a, b].map(|name| category(name).expect(name));
            share_a_use(a, b)
        };
        assert!(share("plate", "fork") && share("hammer", "bolt") && share("keyboard", "monitor"));
        assert!(share("apple", "banana") && share("notebook", "pen"));
        assert!(!share("hammer", "fork") && !share("mug", "keyboard"));
        let known: BTreeSet<&str> = categories().iter().map(|category| category.group.as_str()).collect();
        let unknown: Vec<_> =
            USES.iter().flat_map(|uses| uses.iter()).filter(|g| !known.contains(*g)).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
    }
}
