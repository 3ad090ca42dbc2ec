//! Meaning of phrases in one made scene, as `references.toml` states it.

use glam::{DVec2, DVec3};
use serde::Deserialize;

use editing::EditableObject;
use editing::references::{ReferenceError, resolve, resolve_newest, resolve_one};
use geometry::Rgb;
use scene::predicates::PosedFootprint;
use scene::{InstanceId, Supporter};

/// Everything on the table of the made scene; directions as seen from the front edge.
fn made_scene() -> Vec<EditableObject> {
    let mut objects = vec![
        object("laptop_1", "laptop", "laptop", 0x85_88_8c, "plastic", [0.34, 0.24, 0.22], [0.0, 0.15]),
        object("mug_1", "red mug", "mug", 0xb5_35_2b, "ceramic", [0.12, 0.09, 0.10], [-0.30, 0.12]),
        object("mug_2", "mug", "mug", 0x2f_5f_ae, "ceramic", [0.12, 0.09, 0.10], [0.27, 0.12]),
        object("plate_1", "plate", "plate", 0xf2_f0_ea, "porcelain", [0.26, 0.26, 0.02], [-0.38, -0.25]),
        object("plate_2", "plate", "plate", 0xf2_f0_ea, "porcelain", [0.20, 0.20, 0.02], [0.38, -0.25]),
        object("spoon_1", "spoon", "spoon", 0xb0_b2_b5, "steel", [0.03, 0.03, 0.16], [-0.30, 0.12]),
        object("spoon_2", "wooden spoon", "spoon", 0xb0_80_50, "wood", [0.22, 0.04, 0.02], [0.0, -0.40]),
        object("tray_1", "tray", "tray", 0x7a_52_30, "wood", [0.40, 0.26, 0.03], [0.0, -0.20]),
        object("apple_1", "apple", "apple", 0xb9_2b_27, "fruit", [0.08, 0.08, 0.08], [-0.10, -0.20]),
        object("banana_1", "banana", "banana", 0xf0_c3_30, "fruit", [0.18, 0.06, 0.04], [0.08, -0.20]),
        object("book_1", "book", "book", 0x2f_63_b5, "paper", [0.15, 0.20, 0.02], [-0.58, 0.27]),
        object("book_2", "green book", "book", 0x3f_8f_4f, "paper", [0.15, 0.20, 0.02], [-0.32, 0.36]),
        object("book_3", "book", "book", 0xc0_39_2b, "paper", [0.15, 0.20, 0.02], [0.10, 0.42]),
        object("lamp_1", "desk lamp", "desk_lamp", 0x25_26_2a, "steel", [0.15, 0.15, 0.45], [0.52, 0.38]),
        object("wine_glass_1", "wine glass", "wine_glass", 0xdd_e6_ea, "glass", [0.08; 3], [0.55, -0.02]),
        object("box_1", "cardboard box", "storage_box", 0xc0_94_60, "cardboard", [0.2; 3], [-0.65, -0.05]),
        object("car_1", "toy car", "model_car", 0x30_9f_40, "plastic", [0.12, 0.06, 0.05], [-0.65, -0.05]),
    ];
    let parents = [(5, Supporter::containing(1)), (8, Supporter::on(7)), (9, Supporter::on(7))];
    for (index, supporter) in parents.into_iter().chain([(16, Supporter::containing(15))]) {
        objects[index].supporter = supporter;
    }
    objects
}

fn object(
    name: &str,
    label: &str,
    category: &str,
    color: u32,
    material: &str,
    size_m: [f64; 3],
    at_m: [f64; 2],
) -> EditableObject {
    let (size_m, at_m) = (DVec3::from(size_m), DVec2::from(at_m));
    let half_m = 0.5 * size_m.truncate();
    let signs = [DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0), DVec2::ONE, DVec2::new(-1.0, 1.0)];
    EditableObject {
        name: InstanceId::new(name).expect(name),
        label: label.to_owned(),
        category: category.to_owned(),
        stand_in: category.starts_with("stand_in_"),
        color: Some(Rgb::hex(color)),
        material: Some(material.to_owned()),
        size_m,
        footprint: PosedFootprint::new(&signs.map(|sign| at_m + sign * half_m), 0.0, 0.0, size_m.z),
        supporter: Supporter::TABLE,
    }
}

#[derive(Deserialize)]
struct Table {
    phrases: Vec<[String; 2]>,
}

fn kind(error: &ReferenceError) -> &'static str {
    match error {
        ReferenceError::NotFound { .. } => "!not_found",
        ReferenceError::Ambiguous { .. } => "!ambiguous",
        ReferenceError::TooFew { .. } => "!too_few",
        ReferenceError::NotUnderstood { .. } => "!not_understood",
    }
}

fn names(objects: &[EditableObject], indices: &[usize]) -> String {
    indices.iter().map(|&index| objects[index].name.as_str()).collect::<Vec<_>>().join(" ")
}

#[test]
fn phrases_mean_what_the_table_states() {
    let table: Table = toml::from_str(include_str!("references.toml")).expect("the table parses");
    assert!(table.phrases.len() >= 40);
    let objects = made_scene();
    let mut wrong = Vec::new();
    for [phrase, expected] in &table.phrases {
        let (found, detail) = match resolve(&objects, phrase) {
            Ok(indices) => (names(&objects, &indices), String::new()),
            Err(error) => (kind(&error).to_owned(), error.to_string()),
        };
        if found != *expected {
            wrong.push(format!("{phrase:?} means {expected}, not {found}: {detail}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn one_object_is_meant_where_one_is_asked_for() {
    let objects = made_scene();
    assert_eq!(resolve_one(&objects, "the red mug"), Ok(1));
    let error = resolve_one(&objects, "both mugs").expect_err("two objects");
    assert_eq!(kind(&error), "!ambiguous");
}

#[test]
fn errors_name_candidates_and_near_names() {
    let objects = made_scene();
    let ambiguous = resolve(&objects, "the mug").expect_err("two mugs").to_string();
    assert!(ambiguous.contains("mug_1") && ambiguous.contains("mug_2"), "{ambiguous}");
    let unknown = resolve(&objects, "labtop_1").expect_err("a misspelled name").to_string();
    assert!(unknown.contains("laptop_1"), "{unknown}");
    let words = resolve(&objects, "the shiny mug").expect_err("an unknown word").to_string();
    assert!(words.contains("shiny"), "{words}");
}

#[test]
fn newest_object_is_preferred_among_several_that_fit() {
    let objects = made_scene();
    assert_eq!(resolve_newest(&objects, "the mug", &[2]), Ok(vec![2]));
    assert_eq!(resolve_newest(&objects, "the red mug", &[2]), Ok(vec![1]));
    assert_eq!(resolve_newest(&objects, "the two books", &[11, 12]), Ok(vec![11, 12]));
    assert!(resolve_newest(&objects, "the mug", &[3]).is_err());
}
