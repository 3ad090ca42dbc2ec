//! Random layers for tests: written in both formats, compared by OpenUSD and by this crate's readers.

use std::path::Path as FilePath;

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::layer::{Interpolation, Layer, Path, Prim, VariantSet};
use super::value::{Dictionary, Quaternion, Text, Value};
use super::{crate_file, text_file};

/// Number of layers; OpenUSD compares them in a second.
pub const LAYERS: u64 = 24;

/// Maximum numbers of properties, of children, and of generations below the root.
const MAX_PROPERTIES: usize = 24;
const MAX_CHILDREN: usize = 4;
const MAX_GENERATIONS: usize = 3;

const TYPES: [&str; 5] = ["Xform", "Mesh", "Scope", "Material", "Shader"];
const SCHEMAS: [&str; 4] = ["PhysicsMassAPI", "MaterialBindingAPI", "SemanticsLabelsAPI:class", "MadeUpAPI"];
const TEXTS: [&str; 9] = [
    "",
    "a",
    "a \"red\" <b>mug</b> & 'co'\n--> ]]> \\ {rows} | 🍎\u{7}",
    "\\",
    "tab\tand\r\nline",
    "@.@ /not/a/path <x>",
    "zero\0inside",
    "Ünïcödé \u{2028} \u{7f}",
    "'''\"\"\"",
];

/// Array lengths around the compression threshold of integers, and one long enough for several blocks of codes.
const LENGTHS: [usize; 8] = [0, 1, 3, 15, 16, 17, 64, 2000];

/// A random layer in the text format and in the crate format.
pub fn written(seed: u64) -> (String, Vec<u8>) {
    let layer = random_layer(seed);
    (text_file::write(&layer), crate_file::write(&layer))
}

/// A layer with every value type and every other feature of [`Layer`].
fn random_layer(seed: u64) -> Layer {
    let mut chance = ChaCha8Rng::seed_from_u64(seed);
    let custom_data = dictionary(&mut chance, 2);
    let mut root = prim(&mut chance, "root", 0);
    for (k, value) in one_of_each(&mut chance).into_iter().enumerate() {
        root.set(&format!("each:value_{k}"), value);
    }
    Layer { custom_data, root }
}

fn prim(chance: &mut ChaCha8Rng, name: &str, generation: usize) -> Prim {
    let mut prim = match chance.random_bool(0.2) {
        true => Prim::over(name),
        false => Prim::new(picked(chance, &TYPES), name),
    };
    prim.schemas = SCHEMAS.iter().copied().filter(|_| chance.random_bool(0.3)).collect();
    if chance.random_bool(0.3) {
        prim.asset_info = dictionary(chance, 0);
    }
    prim.display_name = chance.random_bool(0.3).then(|| text(chance));
    prim.kind = chance.random_bool(0.3).then_some("component");
    prim.reference = chance.random_bool(0.2).then(|| asset(chance));
    for name in ["Newton", "MuJoCo", "aSet"] {
        if chance.random_bool(0.15) {
            prim.variant_sets.push(VariantSet { name, payload: asset(chance) });
        }
    }
    for k in 0..chance.random_range(0..=MAX_PROPERTIES) {
        let name = format!("{}:value_{k}", picked(chance, &["physics", "inputs", "a:b_1:C"]));
        let value_type = one_of_each(chance).choose(chance).expect("some").value_type();
        match chance.random_range(0..9) {
            0 => prim.declare(&name, value_type),
            1 => prim.connect(&name, value_type, path(chance).property("outputs:rgb")),
            2 => prim.relate(&name, path(chance)),
            3 => prim.set_uniform(&name, value(chance)),
            4 => prim.set_interpolated(&name, value(chance), Interpolation::Uniform),
            5 => prim.set_interpolated(&name, value(chance), Interpolation::FaceVarying),
            6 => prim.set_interpolated(&name, value(chance), Interpolation::Constant),
            7 => prim.set_custom(&name, value(chance)),
            _ => prim.set(&name, value(chance)),
        }
    }
    if generation < MAX_GENERATIONS {
        for k in 0..chance.random_range(0..=MAX_CHILDREN) {
            let name = format!("{}_{k}", picked(chance, &["a", "B2", "hull"]));
            prim.add(self::prim(chance, &name, generation + 1));
        }
    }
    prim
}

/// A random path; its target need not exist.
fn path(chance: &mut ChaCha8Rng) -> Path {
    let names = ["root", "a_0", "B2_1", "hull_0", "elsewhere"];
    let path: Vec<&str> = (0..chance.random_range(1..=3)).map(|_| picked(chance, &names)).collect();
    Path::prim(&path)
}

fn value(chance: &mut ChaCha8Rng) -> Value {
    one_of_each(chance).choose(chance).expect("some").clone()
}

fn one_of_each(chance: &mut ChaCha8Rng) -> Vec<Value> {
    let length = *LENGTHS.choose(chance).expect("some");
    let float3 = vector(chance);
    let float3s: Vec<[f32; 3]> = (0..length).map(|_| vector(chance)).collect();
    vec![
        Value::Bool(chance.random()),
        Value::Int(chance.random()),
        Value::Float(float(chance)),
        Value::Double(double(chance)),
        Value::String(text(chance)),
        Value::Token(text(chance)),
        Value::Asset(asset(chance)),
        Value::Float2(vector(chance)),
        Value::Float3(float3),
        Value::Float4(vector(chance)),
        Value::Double3([double(chance), double(chance), double(chance)]),
        Value::Point3f(float3),
        Value::Vector3f(vector(chance)),
        Value::Color3f(vector(chance)),
        Value::Normal3f(vector(chance)),
        Value::Quatf(Quaternion { w: float(chance), xyz: vector(chance) }),
        Value::Quatd(Quaternion { w: double(chance), xyz: [double(chance), double(chance), double(chance)] }),
        Value::Ints(integers(chance, length)),
        Value::Tokens((0..length % 100).map(|_| text(chance)).collect()),
        Value::Float3s(float3s.clone()),
        Value::Point3fs(float3s.clone()),
        Value::Normal3fs(float3s.clone()),
        Value::Color3fs(float3s),
        Value::Floats((0..length).map(|_| float(chance)).collect()),
        Value::TexCoord2fs((0..length).map(|_| vector(chance)).collect()),
    ]
}

/// Small integers, arbitrary integers, or a consecutive range.
fn integers(chance: &mut ChaCha8Rng, length: usize) -> Vec<i32> {
    match chance.random_range(0..3) {
        0 => (0..length).map(|_| chance.random_range(-200..200)).collect(),
        1 => (0..length).map(|_| chance.random()).collect(),
        _ => (0..length as i32).collect(),
    }
}

fn dictionary(chance: &mut ChaCha8Rng, generations: usize) -> Dictionary {
    let mut made = Dictionary::default();
    for k in 0..chance.random_range(1..6) {
        made = made.with(&format!("{}_{k}", picked(chance, &["z", "Author", "mass"])), value(chance));
    }
    match generations {
        0 => made,
        _ => made.with_dictionary("inside", dictionary(chance, generations - 1)),
    }
}

fn text(chance: &mut ChaCha8Rng) -> Text {
    picked(chance, &TEXTS).into()
}

fn asset(chance: &mut ChaCha8Rng) -> Text {
    picked(chance, &["./a.png", "./assets/mug_1/simready_usd/mug_1.usdc", "textures/with space.png"]).into()
}

fn vector<const N: usize>(chance: &mut ChaCha8Rng) -> [f32; N] {
    // Small integers are inlined, all others go to the heap.
    if chance.random_bool(0.3) {
        std::array::from_fn(|_| chance.random_range(-130_i16..=130).into())
    } else {
        std::array::from_fn(|_| float(chance))
    }
}

/// Half of the values are of ordinary size. OpenUSD warns of text with more digits than an integer has.
fn float(chance: &mut ChaCha8Rng) -> f32 {
    if chance.random() {
        return chance.random_range(-10.0..10.0);
    }
    let any = f32::from_bits(chance.random());
    if any.abs() < 1e15 { any } else { 0.0 }
}

fn double(chance: &mut ChaCha8Rng) -> f64 {
    match chance.random_range(0..3) {
        0 => float(chance).into(),
        1 => chance.random_range(-10.0..10.0),
        _ => chance.random_range(-130_i16..=130).into(),
    }
}

fn picked<'a>(chance: &mut ChaCha8Rng, of: &[&'a str]) -> &'a str {
    of.choose(chance).expect("some")
}

/// Writes each layer in both formats under `target/usd_layers/` for `tests/judges/usd_layers.py`.
#[test]
fn random_layers_are_written_for_openusd() {
    let folder = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../../target/usd_layers");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("target is writable");
    }
    std::fs::create_dir_all(&folder).expect("target is writable");
    for seed in 0..LAYERS {
        let (text, bytes) = written(seed);
        std::fs::write(folder.join(format!("{seed:02}.usda")), text).expect("target is writable");
        std::fs::write(folder.join(format!("{seed:02}.usdc")), bytes).expect("target is writable");
    }
}

#[test]
fn crate_file_is_deterministic() {
    for seed in 0..LAYERS {
        assert_eq!(written(seed), written(seed));
    }
}
