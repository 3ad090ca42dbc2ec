//! The lexicon against tables of expected answers, and its data against the rest of the configuration.

use std::collections::BTreeSet;

use glam::DVec3;

use super::lexicon::lexicon;
use super::rules::rules;
use super::*;
use crate::{build, categories, category, physical_properties, substance};

/// Share of the tables' nouns that must have the expected answer.
const ACCURACY: f64 = 0.95;

/// Noun and alternatives, of a table with a header; written before the rules.
fn expected(table: &'static str) -> Vec<(&'static str, Vec<&'static str>)> {
    let row = |line: &'static str| {
        let (noun, answers) = line.split_once('\t').expect("two columns");
        (noun, answers.split('|').collect())
    };
    table.lines().skip(1).map(row).collect()
}

/// The plain form that the tables expect of a family; they were written when each had only that.
fn plain_form(family: &'static str) -> &'static str {
    match family {
        "device" | "equipment" | "appliance" | "camera" | "instrument" | "carton" | "chest" => "box",
        "suitcase" | "book" | "toy" | "bar" => "box",
        "can" | "barrel" | "drum" | "battery" | "cake" | "lamp" => "cylinder",
        "cup" | "pot" | "bucket" | "hat" => "bowl",
        "fruit" | "vegetable" | "leafy" | "mushroom" | "stone" | "bun" | "loaf" | "ball" => "produce",
        "coin" | "card" | "sheet" | "dish" | "board" | "disc" | "flatbread" | "cookie" | "steak" => "plate",
        "tool" | "pen" | "broom" | "blade" | "stalk" => "rod",
        "garment" | "glove" | "bag" | "shoe" => "pillow",
        "insect" | "statue" => "figure",
        "hoop" => "ring",
        other => other,
    }
}

fn answer(noun: &str) -> &'static str {
    match placeability(noun) {
        Some(Placeability::Placeable(stand_in)) => plain_form(stand_in.family),
        Some(Placeability::NotPlaceable(obstacle)) => obstacle.name(),
        None => "unknown",
    }
}

fn assert_accurate(table: &'static str, at_the_fewest: usize) {
    let rows = expected(table);
    assert!(rows.len() >= at_the_fewest, "{} rows", rows.len());
    let wrong: Vec<String> = rows
        .iter()
        .filter(|(noun, answers)| !answers.contains(&answer(noun)))
        .map(|(noun, answers)| format!("{noun}: {} instead of {}", answer(noun), answers.join(" or ")))
        .collect();
    let share = 1.0 - wrong.len() as f64 / rows.len() as f64;
    assert!(share >= ACCURACY, "{share:.3} of {}:\n{}", rows.len(), wrong.join("\n"));
}

#[test]
fn stand_in_has_the_expected_family() {
    assert_accurate(include_str!("tests/expected_families.tsv"), 150);
}

#[test]
fn placeability_states_the_expected_obstacle() {
    assert_accurate(include_str!("tests/expected_refusals.tsv"), 60);
}

#[test]
fn lexicon_has_thousands_of_nouns_each_once() {
    let nouns: Vec<_> = lexicon().all().collect();
    assert!(nouns.iter().filter(|(_, stand_in)| stand_in.is_some()).count() >= 8000);
    assert_eq!(nouns.iter().map(|(noun, _)| noun).collect::<BTreeSet<_>>().len(), nouns.len());
    let is_plain = |noun: &str| noun.chars().all(|c| c.is_ascii_lowercase() || c == ' ' || c == '\'');
    assert_eq!(nouns.iter().find(|(noun, _)| !is_plain(noun)), None);
}

#[test]
fn rules_have_known_substances_and_sizes_for_a_table() {
    for rule in rules() {
        assert!(substance(&rule.substance).is_some(), "{}: {}", rule.name, rule.substance);
        assert!(rule.low_m.cmple(rule.high_m).all(), "{}", rule.name);
        assert!(rule.low_m.min_element() >= 0.002 && rule.high_m.max_element() <= 0.6, "{}", rule.name);
    }
}

#[test]
fn nearest_categories_are_in_the_catalog() {
    for (noun, stand_in) in lexicon().all() {
        if let Some(nearest) = stand_in.and_then(|stand_in| stand_in.nearest) {
            assert!(categories().iter().any(|category| category.name == nearest), "{noun}: {nearest}");
        }
    }
    assert_eq!(nearest_by_meaning("wineglass"), Some("drinking glass"));
    assert_eq!(nearest_by_meaning("tangerine"), Some("orange"));
    assert_eq!(nearest_by_meaning("teaspoon"), Some("spoon"));
    assert_eq!(nearest_by_meaning("democracy"), None);
}

#[test]
fn stand_in_finds_other_spellings_and_toys() {
    assert_eq!(stand_in("cash box"), stand_in("cashbox"));
    assert_eq!(stand_in("tweezers"), stand_in("tweezer"));
    assert_eq!(stand_in("pop-bottle"), stand_in("pop bottle"));
    assert!(
        stand_in("cashbox").is_some() && stand_in("tweezer").is_some() && stand_in("pop bottle").is_some()
    );
    assert_eq!(stand_in("truck"), None);
    assert_eq!(stand_in("toy truck").map(|toy| toy.family), Some("toy"));
    assert_eq!(stand_in("toy bear"), stand_in("bear"));
    assert_eq!(placeability("frobnicator"), None);
}

#[test]
fn hidden_categories_are_found_by_name_only() {
    let built: BTreeSet<String> = rule_samples().iter().map(StandIn::category_name).collect();
    for name in &built {
        assert!(is_stand_in(name) && category(name).is_some(), "{name}");
        assert!(categories().iter().all(|category| category.name != *name), "{name}");
    }
    assert!(!is_stand_in("mug") && category("mug").is_some());
}

#[test]
fn recipe_follows_the_request() {
    let stick = stand_in("walking stick").expect("known");
    let usual = stick.recipe(None, None, None, 1);
    assert_eq!(usual.material.as_deref(), Some("wood"));
    assert_eq!(usual.color, None);
    let size_m = DVec3::new(0.02, 0.3, 0.02);
    let red = geometry::Rgb::hex(0xc0_20_20);
    let asked = stick.recipe(Some(size_m), Some(red), Some("steel".to_owned()), 1);
    assert_eq!((asked.size_m, asked.color, asked.material.as_deref()), (size_m, Some(red), Some("steel")));
}

/// A stand-in of every rule.
pub(crate) fn rule_samples() -> Vec<StandIn> {
    let sample = |rule: &'static rules::Rule| StandIn {
        family: &rule.family,
        size: crate::SizeRange { low_m: rule.low_m, high_m: rule.high_m },
        substance: &rule.substance,
        nearest: None,
    };
    rules().iter().map(sample).collect()
}

#[test]
fn every_rule_gives_a_plausible_mass() {
    for (rule, sample) in rules().iter().zip(rule_samples()) {
        let recipe = sample.recipe(None, None, None, 5);
        let mesh = build(&recipe).expect("a shape");
        let found =
            physical_properties(&mesh, &recipe.category, recipe.material.as_deref()).expect("a solid");
        let mass_kg = found.mass.mass_kg;
        // From a seed to a keg.
        assert!((0.0005..10.0).contains(&mass_kg), "{} weighs {mass_kg} kg", rule.name);
    }
}
