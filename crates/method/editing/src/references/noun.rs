//! Objects that a noun names: by label, by category, as a superclass, by synonym.

use std::collections::BTreeSet;

use crate::EditableObject;
use language::nouns::{ANY, SUPERCLASSES, is_name};
use language::vocabulary::{vague_sets, vocabulary};

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
    let label = object.label.to_lowercase();
    let head = label.rsplit([' ', '-']).next().unwrap_or_default();
    // "cup" of a teacup.
    let ends_compound = noun.len() > 2 && head.len() > noun.len() && head.ends_with(noun);
    ends_compound
        || vocabulary().is_alias(&object.category, noun)
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
