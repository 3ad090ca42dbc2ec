//! Variants: the operations that a seed draws for a finished scene.
//!
//! Everything that a variant changes is an ordinary operation, so that its account says in words what differs from the
//! parent. What a text states of an object is left as it is.

use std::collections::BTreeMap;

use rand::RngExt;

use crate::pipeline::composition::Composition;
use catalog::tables::TABLE_MATERIALS;
use catalog::{Category, category};
use editing::references::{color_of, material_of};
use runtime::seed::{Rng, child_rng};
use scene::edit::CameraMove;
use scene::text_account::TextMeaning;
use scene::{EditOperation, InstanceId, Light, Randomize, RecognizedObject};

/// Colors of objects whose category has none.
const COLORS: [&str; 12] =
    ["red", "orange", "yellow", "green", "teal", "blue", "purple", "pink", "brown", "beige", "white", "gray"];

/// Groups of categories that come in several materials, and the materials.
const MATERIALS: [(&[&str], &[&str]); 3] = [
    (&["vessel", "dish", "tableware"], &["ceramic", "porcelain", "plastic", "steel", "wood"]),
    (&["container", "storage", "stationery_holder", "desk_tool"], &["plastic", "wood", "steel", "cardboard"]),
    (&["board", "carrier", "kitchen_tool"], &["wood", "plastic"]),
];

/// Properties of a text that each leave an axis alone.
const KEEPS_MESH: [&str; 4] = ["size", "volume", "mass", "state"];

/// Range of each drawn quantity of light and camera.
const ELEVATION_RAD: (f64, f64) = (0.6, 1.3);
const INTENSITY: (f64, f64) = (0.7, 1.2);
const CAMERA_TURN_RAD: f64 = 0.4;
const CAMERA_RAISE_RAD: f64 = 0.15;
const CAMERA_SHARE: f64 = 0.12;

/// The operations of a variant, in the order in which they are carried out.
pub(super) fn drawn(parent: &Composition, randomize: &Randomize, seed: u64) -> Vec<EditOperation> {
    let stated = Stated::of(parent);
    let mut operations = Vec::new();
    let objects = &parent.recognition.objects;
    let each = |operations: &mut Vec<EditOperation>,
                draw: &dyn Fn(&RecognizedObject) -> Option<EditOperation>| {
        operations.extend(objects.iter().filter_map(draw));
    };
    let rng = |axis: &str, object: &RecognizedObject| child_rng(seed, &format!("{axis} of {}", object.id));
    if randomize.meshes {
        each(&mut operations, &|object| {
            let is_free = !KEEPS_MESH.iter().any(|property| stated.says(&object.id, property));
            let is_known = visible_category(object).is_some() && object.stand_in.is_none();
            (is_free && is_known && object.tipped.is_none())
                .then(|| EditOperation::Remake { target: object.id.to_string() })
        });
    }
    if randomize.sizes > 0.0 {
        each(&mut operations, &|object| {
            let is_free =
                !["size", "volume", "mass"].iter().any(|property| stated.says(&object.id, property));
            let factor = factor(&mut rng("size", object), randomize.sizes);
            is_free.then(|| EditOperation::Resize { target: object.id.to_string(), factor })
        });
    }
    if randomize.colors || randomize.materials {
        each(&mut operations, &|object| {
            let is_free = |property: &str| !stated.says(&object.id, property);
            let color = (randomize.colors && is_free("color") && is_free("material"))
                .then(|| drawn_color(object, &mut rng("color", object)));
            let material = (randomize.materials && is_free("material") && is_free("mass"))
                .then(|| drawn_material(object, &mut rng("material", object)))
                .flatten();
            // The color that a text states stays when the material changes.
            let color = color.or_else(|| material.as_ref().and_then(|_| stated.color(&object.id)));
            (color.is_some() || material.is_some()).then(|| EditOperation::Recolor {
                target: object.id.to_string(),
                color,
                material,
            })
        });
    }
    if randomize.mass > 0.0 || randomize.friction > 0.0 {
        each(&mut operations, &|object| {
            let mut rng = rng("physics", object);
            let (mass, friction) = (factor(&mut rng, randomize.mass), factor(&mut rng, randomize.friction));
            let is_free = !stated.says(&object.id, "mass");
            let mass_factor = (randomize.mass > 0.0 && is_free).then_some(mass);
            let friction_factor = (randomize.friction > 0.0).then_some(friction);
            (mass_factor.is_some() || friction_factor.is_some()).then(|| EditOperation::SetPhysics {
                target: object.id.to_string(),
                mass_factor,
                friction_factor,
            })
        });
    }
    let rng = |axis: &str| child_rng(seed, axis);
    if randomize.table && !stated.table {
        let material = TABLE_MATERIALS[rng("table").random_range(0..TABLE_MATERIALS.len())];
        operations.push(EditOperation::RestyleTable { material: Some(material.to_owned()), color: None });
    }
    if randomize.layout {
        operations.push(EditOperation::Rearrange);
    }
    if randomize.light {
        let mut rng = rng("light");
        operations.push(EditOperation::Relight(Light {
            azimuth_rad: rng.random_range(-std::f64::consts::PI..std::f64::consts::PI),
            elevation_rad: rng.random_range(ELEVATION_RAD.0..ELEVATION_RAD.1),
            intensity: rng.random_range(INTENSITY.0..INTENSITY.1),
        }));
    }
    if randomize.camera {
        let mut rng = rng("camera");
        operations.push(EditOperation::MoveCamera(CameraMove {
            turn_rad: Some(rng.random_range(-CAMERA_TURN_RAD..CAMERA_TURN_RAD)),
            raise_rad: Some(rng.random_range(-CAMERA_RAISE_RAD..CAMERA_RAISE_RAD)),
            distance_factor: Some(factor(&mut rng, CAMERA_SHARE)),
            focal_factor: Some(factor(&mut rng, CAMERA_SHARE)),
        }));
    }
    operations
}

/// A factor from 1 - share to 1 + share, in thousandths.
fn factor(rng: &mut Rng, share: f64) -> f64 {
    let factor = 1.0 + share * (2.0 * rng.random::<f64>() - 1.0);
    (1000.0 * factor).round() / 1000.0
}

fn visible_category(object: &RecognizedObject) -> Option<&'static Category> {
    category(&object.category).filter(|category| category.group != "stand_in")
}

/// One of the colors that objects of its category have.
fn drawn_color(object: &RecognizedObject, rng: &mut Rng) -> String {
    match visible_category(object).map(|category| category.palette.as_slice()) {
        Some(palette) if !palette.is_empty() => palette[rng.random_range(0..palette.len())].clone(),
        _ => COLORS[rng.random_range(0..COLORS.len())].to_owned(),
    }
}

fn drawn_material(object: &RecognizedObject, rng: &mut Rng) -> Option<String> {
    let group = visible_category(object)?.group.as_str();
    let (_, materials) = MATERIALS.iter().find(|(groups, _)| groups.contains(&group))?;
    Some(materials[rng.random_range(0..materials.len())].to_owned())
}

/// Statements of the scene's text, which no variant changes.
struct Stated {
    properties: BTreeMap<InstanceId, BTreeMap<String, String>>,
    /// Whether it says what the table is made of, or its color.
    table: bool,
}

impl Stated {
    fn of(scene: &Composition) -> Self {
        let mut stated = Self { properties: BTreeMap::new(), table: false };
        for understood in scene.account.iter().flat_map(|account| &account.understood) {
            match &understood.meaning {
                TextMeaning::Property { property, value, objects } => {
                    for object in objects {
                        let of_object = stated.properties.entry(object.clone()).or_default();
                        of_object.insert(property.clone(), value.clone());
                    }
                }
                TextMeaning::Table => stated.table |= states_finish(&understood.span.text),
                _ => {}
            }
        }
        stated
    }

    fn says(&self, object: &InstanceId, property: &str) -> bool {
        self.properties.get(object).is_some_and(|stated| stated.contains_key(property))
    }

    fn color(&self, object: &InstanceId) -> Option<String> {
        self.properties.get(object)?.get("color").cloned()
    }
}

/// Whether words about a table name a color or a material.
pub(super) fn states_finish(words: &str) -> bool {
    let words = words.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase);
    let is_finish = |word: &str| TABLE_MATERIALS.contains(&word);
    words
        .into_iter()
        .any(|word| color_of(&word).is_some() || material_of(&word).is_some() || is_finish(&word))
}

/// The phrase of which another object of the same kind is made: its category, and what a text states of its appearance.
pub(super) fn phrase_of(parent: &Composition, name: &str) -> Option<String> {
    let object = parent.recognition.objects.iter().find(|object| object.id.as_str() == name)?;
    let kind = &visible_category(object)?.label;
    let stated = Stated::of(parent);
    let words = ["color", "material"].into_iter().filter_map(|property| {
        stated.properties.get(&object.id).and_then(|properties| properties.get(property)).cloned()
    });
    Some(words.chain([kind.clone()]).collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_of_table_leaves_its_finish_open_and_a_color_or_material_does_not() {
        for (words, expected) in [
            ("kitchen table", false),
            ("A round dining table", false),
            ("wooden desk", true),
            ("white table", true),
            ("Oak workbench", true),
            ("a glass-topped table", true),
        ] {
            assert_eq!(states_finish(words), expected, "{words}");
        }
    }

    #[test]
    fn factors_stay_within_their_share() {
        let mut rng = child_rng(7, "size");
        let drawn: Vec<f64> = (0..1000).map(|_| factor(&mut rng, 0.1)).collect();
        assert!(drawn.iter().all(|factor| (0.9..=1.1).contains(factor)));
        let mean = drawn.iter().sum::<f64>() / 1000.0;
        assert!((mean - 1.0).abs() < 0.01, "{mean}");
    }
}
