//! Noun phrases for objects: shorter and longer ones that mean one object, and a wide one.

use catalog::category;
use editing::EditableObject;
use editing::references::resolve_one;

use crate::task_scene::TaskScene;

const COLORS: &[&str] = &[
    "red", "blue", "green", "brown", "beige", "yellow", "white", "black", "gray", "orange", "purple", "pink",
];
const MATERIALS: &[&str] = &["wooden", "metal", "glass", "plastic", "ceramic", "cardboard"];
const SIZES: &[&str] = &["large", "small", "tall", "largest", "smallest"];
const PLACES: &[&str] = &["leftmost", "rightmost", "middle", "front", "back"];
const RANKS: &[&str] = &["second", "third", "fourth"];

/// Distance from the center line of the table from which an object is said to be on the left or right, meters.
const MIN_SIDE_M: f64 = 0.15;

/// Beginnings of nouns that name the table.
const TABLES: &[&str] = &["desk ", "table "];

/// Nouns of groups of the catalog, wider than those of its categories.
const GROUPS: &[(&str, &str)] = &[
    ("fruit", "fruit"),
    ("vegetable", "vegetable"),
    ("cutlery", "cutlery"),
    ("toy", "toy"),
    ("toy_animal", "toy animal"),
    ("hand_tool", "tool"),
    ("tool", "tool"),
    ("bottle", "bottle"),
    ("can", "can"),
];

/// The phrases of one object.
#[derive(Clone, Debug)]
pub(super) struct References {
    /// May mean several objects.
    pub vague: String,
    /// The shortest that means this object.
    pub default: String,
    /// With its color and place.
    pub specific: String,
}

impl References {
    /// The phrases of an object.
    pub fn of(scene: &TaskScene, object: usize) -> Self {
        let objects = scene.described();
        let means = |phrase: &String| resolve_one(objects, phrase) == Ok(object);
        let noun = noun_of(&objects[object]);
        let name = objects[object].name.to_string();
        // The text parser does not know what objects without a category are called.
        let is_known = category(&objects[object].category).is_some();
        let short = if is_known { shorter(objects, object) } else { Vec::new() };
        let default = short.into_iter().find(means).unwrap_or_else(|| name.clone());
        let longer = longer(scene, object, &default);
        let specific = longer.into_iter().find(means).unwrap_or_else(|| default.clone());
        let group = category(&objects[object].category).map(|category| category.group.as_str());
        let wide = GROUPS.iter().find(|(known, _)| Some(*known) == group).map(|(_, word)| *word);
        // "the lamp" for "the desk lamp".
        let last = noun.rsplit(' ').next().unwrap_or(&noun);
        Self { vague: format!("the {}", wide.unwrap_or(last)), default, specific }
    }
}

/// Noun for the object, without a color.
fn noun_of(object: &EditableObject) -> String {
    match category(&object.category) {
        Some(category) if !object.stand_in => category.label.clone(),
        _ => object.label.to_lowercase(),
    }
}

/// Phrases from the shortest on.
fn shorter(objects: &[EditableObject], object: usize) -> Vec<String> {
    let (label, noun) = (objects[object].label.to_lowercase(), noun_of(&objects[object]));
    // "To the right of the desk lamp" is understood as the right of the desk.
    let mut phrases: Vec<String> = [&label, &noun]
        .into_iter()
        .filter_map(|words| TABLES.iter().find_map(|table| words.strip_prefix(table)))
        .map(|rest| format!("the {rest}"))
        .collect();
    phrases.extend([format!("the {label}"), format!("the {noun}")]);
    let with =
        |words: &[&str]| -> Vec<String> { words.iter().map(|word| format!("the {word} {noun}")).collect() };
    phrases.extend(with(COLORS));
    phrases.extend(with(MATERIALS));
    phrases.extend(with(PLACES));
    phrases.extend(with(SIZES));
    phrases.extend(RANKS.iter().map(|rank| format!("the {rank} {noun} from the left")));
    phrases
}

/// Phrases with more than is needed: a color where the label has no word beside the noun, and its support, or the side
/// of the table where it clearly is.
fn longer(scene: &TaskScene, object: usize, default: &str) -> Vec<String> {
    let objects = scene.described();
    let (label, noun) = (objects[object].label.to_lowercase(), noun_of(&objects[object]));
    let colors: &[&str] = if label == noun { COLORS } else { &[] };
    let colored = |rest: &str| -> Vec<String> {
        let named = colors.iter().map(|color| format!("the {color} {noun}{rest}"));
        named.chain([format!("the {label}{rest}")]).collect()
    };
    let mut phrases = Vec::new();
    if let Some(parent) = objects[object].supporter.parent {
        let relation = if objects[object].supporter.is_container() { "in" } else { "on" };
        phrases.extend(colored(&format!(" {relation} the {}", objects[parent].label.to_lowercase())));
    }
    match objects[object].footprint.center().x {
        x if x < -MIN_SIDE_M => phrases.extend(colored(" on the left")),
        x if x > MIN_SIDE_M => phrases.extend(colored(" on the right")),
        _ => {}
    }
    phrases.extend(colored(""));
    phrases.push(default.to_owned());
    phrases
}
