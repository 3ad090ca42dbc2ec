//! Objects that a noun names: by label, by category, as a superclass, by synonym.

use std::collections::BTreeSet;

use super::vocabulary::{vague_sets, vocabulary};
use crate::EditableObject;

/// Grammatical number of a noun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Singular,
    Plural,
}

/// The objects that a noun names.
#[derive(Debug)]
pub(super) struct NamedObjects {
    /// From the closest meaning to the widest; each level includes those before it.
    pub levels: Vec<Vec<usize>>,
    pub number: Number,
}

/// Nouns for any object.
const ANY: &[&str] = &["object", "item", "thing", "one", "stuff"];

/// Words for objects of several groups of the catalog.
const SUPERCLASSES: &[(&[&str], &[&str])] = &[
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

/// Categories that superclasses have beside whole groups.
const SUPERCLASS_MEMBERS: &[(&str, &[&str])] = &[
    ("dishes", &["mug", "teacup", "drinking_glass", "wine_glass", "bowl", "saucer", "plate"]),
    ("drinkware", &["mug", "teacup", "drinking_glass", "wine_glass"]),
    (
        "drink",
        &[
            "mug",
            "teacup",
            "drinking_glass",
            "wine_glass",
            "soda_can",
            "water_bottle",
            "wine_bottle",
            "milk_carton",
        ],
    ),
];

/// Mass nouns and plurals that mean all objects of a kind: "the fruit" of three apples.
const COLLECTIVE: &[&str] = &[
    "fruit",
    "cutlery",
    "silverware",
    "flatware",
    "dishes",
    "crockery",
    "dishware",
    "tableware",
    "dinnerware",
    "drinkware",
    "cookware",
    "food",
    "clothes",
    "clothing",
    "electronics",
    "stationery",
    "stuff",
];

type Test = fn(&EditableObject, &str) -> bool;

/// From the closest meaning to the widest.
const LEVELS: [Test; 5] = [is_labeled, is_category, is_of_superclass, is_synonym, is_of_group];

/// The objects of the pool that a noun names; `None` if there is none.
pub(super) fn named(objects: &[EditableObject], pool: &[usize], noun: &str) -> Option<NamedObjects> {
    let singular = vocabulary().singular_of(noun);
    if let Some(number) = any_number(noun, singular.as_deref()) {
        let levels = vec![pool.to_vec()];
        return (!pool.is_empty()).then_some(NamedObjects { levels, number });
    }
    let by_number = |number: Number| {
        let form = if number == Number::Singular { Some(noun) } else { singular.as_deref() }?;
        let level = |is: Test| -> BTreeSet<usize> {
            pool.iter().copied().filter(|&index| is(&objects[index], form)).collect()
        };
        Some(LEVELS.map(level))
    };
    let (as_is, as_plural) = (by_number(Number::Singular), by_number(Number::Plural));
    let mut levels: Vec<Vec<usize>> = Vec::new();
    let mut number = None;
    let mut all = BTreeSet::new();
    for level in 0..LEVELS.len() {
        let of =
            |sets: &Option<[BTreeSet<usize>; 5]>| sets.as_ref().map_or(BTreeSet::new(), |s| s[level].clone());
        let (singulars, plurals) = (of(&as_is), of(&as_plural));
        if number.is_none() && !(singulars.is_empty() && plurals.is_empty()) {
            let plural = singulars.is_empty() || COLLECTIVE.contains(&noun);
            number = Some(if plural { Number::Plural } else { Number::Singular });
        }
        let before = all.len();
        all.extend(singulars);
        all.extend(plurals);
        if all.len() > before {
            levels.push(all.iter().copied().collect());
        }
    }
    number.map(|number| NamedObjects { levels, number })
}

/// The number of a noun for any object; `None` for other nouns.
fn any_number(noun: &str, singular: Option<&str>) -> Option<Number> {
    match noun {
        "stuff" => Some(Number::Plural),
        noun if ANY.contains(&noun) => Some(Number::Singular),
        _ => singular.filter(|singular| ANY.contains(singular)).map(|_| Number::Plural),
    }
}

/// Whether the word is a noun of English or of the catalog, also in the plural.
pub(crate) fn is_noun(noun: &str) -> bool {
    let singular = vocabulary().singular_of(noun);
    let is_known = |noun: &str| catalog::stand_in::placeability(noun).is_some() || is_of_catalog(noun);
    [Some(noun), singular.as_deref()].into_iter().flatten().any(is_known)
}

/// Whether the singular noun names objects of the catalog.
pub(crate) fn is_of_catalog(noun: &str) -> bool {
    vocabulary().is_alias_of_any(noun)
        || SUPERCLASSES.iter().any(|(words, _)| words.contains(&noun))
        || vague_sets().iter().any(|set| set.words.iter().any(|word| word == noun))
        || catalog::categories().iter().any(|category| is_name(category, noun))
}

fn is_name(category: &catalog::Category, noun: &str) -> bool {
    category.label == noun
        || category.name.replace('_', " ") == noun
        || category.synonyms.iter().any(|synonym| synonym == noun)
        || category.stands_in_for.iter().any(|other| other == noun)
}

/// "desk lamp" and "lamp" name what is labeled "red desk lamp"; "cup" what is labeled "cup of coffee".
fn is_labeled(object: &EditableObject, noun: &str) -> bool {
    let label = object.label.to_lowercase().replace(['-', '_'], " ");
    let head = label.split(" of ").next().unwrap_or_default();
    ends_with_noun(&label, noun) || ends_with_noun(head, noun)
}

fn ends_with_noun(label: &str, noun: &str) -> bool {
    let start = label.strip_suffix(noun);
    start.is_some_and(|start| start.is_empty() || start.ends_with(' '))
        || label.replace(' ', "") == noun.replace(' ', "")
}

fn is_category(object: &EditableObject, noun: &str) -> bool {
    let named = !object.stand_in;
    named && ends_with_noun(&object.category.replace('_', " "), noun)
        || catalog::category(&object.category)
            .is_some_and(|category| named && ends_with_noun(&category.label, noun))
}

fn is_synonym(object: &EditableObject, noun: &str) -> bool {
    vocabulary().is_alias(&object.category, noun)
        || catalog::category(&object.category).is_some_and(|category| is_name(category, noun))
}

/// The category of an object of the catalog; else the one that is nearest in meaning to its label.
fn catalog_category(object: &EditableObject) -> Option<&'static catalog::Category> {
    if !object.category.starts_with("stand_in_") {
        return catalog::category(&object.category);
    }
    let label = object.label.to_lowercase();
    let last = label.rsplit(' ').next().unwrap_or_default();
    let stand_in = [label.as_str(), last].into_iter().find_map(catalog::stand_in::stand_in)?;
    catalog::category(stand_in.nearest?)
}

fn is_of_superclass(object: &EditableObject, noun: &str) -> bool {
    let Some(category) = catalog_category(object) else { return false };
    SUPERCLASSES.iter().filter(|(words, _)| words.contains(&noun)).any(|(words, groups)| {
        let members = SUPERCLASS_MEMBERS.iter().find(|(word, _)| words.contains(word));
        groups.contains(&category.group.as_str())
            || members.is_some_and(|(_, names)| names.contains(&category.name.as_str()))
    })
}

fn is_of_group(object: &EditableObject, noun: &str) -> bool {
    let Some(category) = catalog_category(object) else { return false };
    let mut vague = vague_sets().iter().filter(|set| set.words.iter().any(|word| word == noun));
    category.group.replace('_', " ") == noun || vague.any(|set| set.members.contains(&category.name))
}
