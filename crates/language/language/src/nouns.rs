//! Nouns for objects: those of the catalog, of its groups, and of English.

use crate::vocabulary::{vague_sets, vocabulary};

/// Words for objects of several groups of the catalog, with the groups.
pub const SUPERCLASSES: &[(&[&str], &[&str])] = &[
    (&["fruit", "piece of fruit"], &["fruit"]),
    (&["vegetable", "veggie"], &["vegetable"]),
    (&["cutlery", "silverware", "flatware"], &["cutlery"]),
    (&["utensil"], &["cutlery", "kitchen_tool"]),
    (&["dishes", "crockery", "dishware", "tableware", "dinnerware"], &["dish"]),
    (&["drinkware", "drinking vessel"], &[]),
    (&["cookware"], &["cookware"]),
    (&["toy", "plaything"], &["toy", "toy_animal", "musical_toy", "model"]),
    (&["toy animal", "animal"], &["toy_animal"]),
    (&["tool"], &["hand_tool", "tool", "power_tool", "measuring_tool", "garden_tool"]),
    (&["drink", "beverage"], &[]),
    (
        &["food", "snack"],
        &["fruit", "vegetable", "bakery", "baked_good", "meal", "meat", "food", "sweet", "nut", "fish"],
    ),
    (&["pastry"], &["bakery", "baked_good"]),
    (&["plant"], &["plant"]),
    (&["clothes", "clothing"], &["clothing"]),
    (
        &["electronics", "device", "gadget"],
        &["electronics", "handheld_device", "screen", "audio", "input_device"],
    ),
    (&["stationery"], &["stationery", "writing_tool", "pen", "desk_tool"]),
    (&["decoration", "ornament"], &["decoration"]),
    (&["bottle"], &["bottle"]),
    (&["can"], &["can"]),
];

/// Nouns for any object.
pub const ANY: &[&str] = &["object", "item", "thing", "one", "stuff"];

/// Whether the word is a noun of English or of the catalog, also in the plural.
pub fn is_noun(noun: &str) -> bool {
    let singular = vocabulary().singular_of(noun);
    let is_known = |noun: &str| {
        ANY.contains(&noun) || catalog::stand_in::placeability(noun).is_some() || is_of_catalog(noun)
    };
    [Some(noun), singular.as_deref()].into_iter().flatten().any(is_known)
}

/// Whether the singular noun names objects of the catalog.
pub fn is_of_catalog(noun: &str) -> bool {
    vocabulary().is_alias_of_any(noun)
        || SUPERCLASSES.iter().any(|(words, _)| words.contains(&noun))
        || vague_sets().iter().any(|set| set.words.iter().any(|word| word == noun))
        || catalog::categories().iter().any(|category| is_name(category, noun))
}

/// Whether a noun is the name of a category or one of its synonyms.
pub fn is_name(category: &catalog::Category, noun: &str) -> bool {
    category.label == noun
        || category.name.replace('_', " ") == noun
        || category.synonyms.iter().any(|synonym| synonym == noun)
        || category.stands_in_for.iter().any(|other| other == noun)
}
