//! Tests of the words, masses and volumes in the data files.

use std::collections::BTreeMap;

use glam::DVec3;

use super::*;
use crate::added::normalized;
use crate::{Recipe, build, physical_properties};

#[test]
fn no_word_denotes_two_categories() {
    let mut owners: BTreeMap<String, &str> = BTreeMap::new();
    let mut clashes = Vec::new();
    for category in categories() {
        for word in category.words().map(normalized) {
            match owners.insert(word.clone(), &category.name) {
                Some(other) if other != category.name => {
                    clashes.push(format!("{word}: {other}, {}", category.name));
                }
                _ => {}
            }
        }
    }
    assert!(clashes.is_empty(), "{}", clashes.join("\n"));
}

#[test]
fn synonyms_are_lower_case_and_listed_once() {
    for category in categories() {
        let mut seen = std::collections::BTreeSet::new();
        for synonym in &category.synonyms {
            assert_eq!(synonym, &synonym.to_lowercase(), "{}", category.name);
            assert!(
                !synonym.trim().is_empty() && synonym.trim() == synonym,
                "{}: `{synonym}`",
                category.name
            );
            assert!(seen.insert(normalized(synonym)), "{}: {synonym} twice", category.name);
        }
        let name = &category.name;
        assert!(name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'), "{name}");
    }
}

/// Nouns that a category stands in for have no category of their own.
#[test]
fn categories_stand_in_for_what_the_catalog_lacks() {
    let words = |category: &Category| -> Vec<String> { category.words().map(normalized).collect() };
    let known: std::collections::BTreeSet<String> = categories().iter().flat_map(words).collect();
    let mut seen = std::collections::BTreeSet::new();
    for category in categories() {
        for noun in &category.stands_in_for {
            assert_eq!(noun, &noun.trim().to_lowercase(), "{}", category.name);
            assert!(!known.contains(&normalized(noun)), "{}: {noun} is a name of a category", category.name);
            assert!(seen.insert(normalized(noun)), "{}: {noun} twice", category.name);
        }
    }
    assert!(seen.contains("parsnip"));
}

/// Words that robots' instructions use, and the category that they denote.
#[test]
fn words_of_robot_instructions_denote_the_expected_category() {
    let expected = [
        ("cube", "cube"),
        ("wooden block", "block"),
        ("ball", "ball"),
        ("dowel", "stick"),
        ("bottle cap", "bottle_cap"),
        ("baseball cap", "cap"),
        ("watering can", "watering_can"),
        ("oil can", "oil_can"),
        ("tomato soup can", "soup_can"),
        ("can of tuna", "tuna_can"),
        ("soda", "soda_can"),
        ("bell pepper", "bell_pepper"),
        ("pepper", "pepper_mill"),
        ("trash can", "trash_can"),
        ("toilet paper", "toilet_paper"),
        ("paper", "paper_stack"),
        ("mouse pad", "mouse_pad"),
        ("chips can", "chips_tube"),
        ("nut", "nut"),
        ("walnut", "walnut"),
        ("magazine", "magazine"),
        ("tee block", "t_block"),
        ("hotdog bun", "hot_dog_bun"),
        ("bottle of whiskey", "liquor_bottle"),
        ("bookcase", "shelf"),
    ];
    for (word, name) in expected {
        let owner = categories().iter().find(|category| {
            let mut own = [&category.name, &category.label].into_iter().chain(&category.synonyms);
            own.any(|known| normalized(known) == word)
        });
        assert_eq!(owner.map(|category| category.name.as_str()), Some(name), "{word}");
    }
}

fn mass_kg(name: &str) -> f64 {
    let recipe = Recipe { seed: 5, ..Recipe::typical(name, None, None).expect(name) };
    let mesh = build(&recipe).expect(name);
    physical_properties(&mesh, name, None).expect(name).mass.mass_kg
}

/// Masses of common products as weighed or printed on packages.
#[test]
fn typical_masses_are_those_of_common_products() {
    let weighed = [
        ("cube", 0.062),
        ("block", 0.058),
        ("ball", 0.08),
        ("tennis_ball", 0.058),
        ("baseball", 0.145),
        ("golf_ball", 0.046),
        ("cylinder", 0.075),
        ("peg", 0.033),
        ("ketchup_bottle", 0.6),
        ("soup_can", 0.35),
        ("tuna_can", 0.17),
        ("coffee_can", 0.41),
        ("cracker_box", 0.41),
        ("sugar_box", 0.51),
        ("pudding_box", 0.1),
        ("meat_can", 0.37),
        ("chips_tube", 0.2),
        ("yogurt_cup", 0.17),
        ("flour_bag", 1.0),
        ("strawberry", 0.018),
        ("peach", 0.15),
        ("plum", 0.066),
        ("onion", 0.15),
        ("potato", 0.2),
        ("pineapple", 1.1),
        ("watermelon", 5.0),
        ("mushroom", 0.018),
        ("walnut", 0.011),
        ("hamburger", 0.2),
        ("cookie", 0.016),
        ("toast", 0.03),
        ("sponge", 0.011),
        ("towel", 0.4),
        ("shoe", 0.3),
        ("soap", 0.1),
        ("toothbrush", 0.017),
        ("paper_towel", 0.35),
        ("bleach_bottle", 1.13),
        ("bucket", 0.4),
        ("ramekin", 0.2),
        ("microwave", 11.5),
        ("moka_pot", 0.55),
        ("dutch_oven", 4.5),
        ("mortar", 2.0),
        ("padlock", 0.2),
        ("battery", 0.024),
        ("light_bulb", 0.06),
        ("eraser", 0.02),
        ("key", 0.011),
        ("clipboard", 0.3),
        ("pyramid", 0.05),
        ("utensil_holder", 0.8),
    ];
    let off: Vec<String> = weighed
        .iter()
        .map(|&(name, expected_kg)| (name, expected_kg, mass_kg(name)))
        .filter(|(_, expected_kg, found_kg)| !(0.6..1.4).contains(&(found_kg / expected_kg)))
        .map(|(name, expected_kg, found_kg)| format!("{name}: {found_kg:.4} kg, weighed {expected_kg} kg"))
        .collect();
    assert!(off.is_empty(), "{}", off.join("\n"));
}

#[test]
fn stated_mass_belongs_to_the_typical_size() {
    let category = category("soup_can").expect("in the catalog");
    let typical = Recipe::typical("soup_can", None, None).expect("in the catalog");
    let larger = Recipe { size_m: 2.0 * typical.size_m, ..typical.clone() };
    let weigh = |recipe: &Recipe| {
        let mesh = build(recipe).expect("builds");
        physical_properties(&mesh, "soup_can", None).expect("a solid").mass.mass_kg
    };
    let stated_kg = category.mass_kg.expect("a can has contents");
    assert!((weigh(&typical) / stated_kg - 1.0).abs() < 1e-6);
    assert!((weigh(&larger) / weigh(&typical) - 8.0).abs() < 1e-6);
}

/// A container holds less than its box, more than a hundredth of it, and in proportion to its size.
#[test]
fn containers_hold_less_than_their_box() {
    for category in categories() {
        let typical_m = category.size.typical_m();
        let Some(volume_m3) = category.holds_m3(typical_m) else {
            let holds = category.affords(Affordance::Container) && category.shape.is_some();
            assert!(!holds, "{} is a container of unknown volume", category.name);
            continue;
        };
        let share = volume_m3 / typical_m.element_product();
        assert!((0.01..1.0).contains(&share), "{}: {share:.3} of its box", category.name);
        let doubled = category.holds_m3(DVec3::new(2.0, 1.0, 1.0) * typical_m);
        assert!((doubled.expect("as before") / volume_m3 - 2.0).abs() < 1e-9);
    }
}
