//! Tests of the shapes in the data files and of the validation of shapes.

use super::*;
use crate::{Category, Recipe, build, categories};

fn with_shape() -> impl Iterator<Item = (&'static Category, &'static Shape)> {
    categories().iter().filter_map(|category| category.shape.as_ref().map(|shape| (category, shape.get())))
}

#[test]
fn every_shape_has_parts_and_surfaces() {
    let objections: Vec<String> = with_shape()
        .filter_map(|(category, shape)| {
            shape.check().err().map(|error| format!("{}: {error}", category.name))
        })
        .collect();
    assert!(objections.is_empty(), "{}", objections.join("\n"));
}

/// The parts are in meters: before scaling, the shape has about the category's typical size, and its proportions within
/// a quarter. A shape like that of another category may have another size.
#[test]
fn parts_are_modeled_at_the_typical_size() {
    let mut objections = Vec::new();
    for (category, shape) in with_shape().filter(|(_, shape)| shape.like.is_none()) {
        let recipe = Recipe::typical(&category.name, None, None).expect("a category of the catalog");
        let mut order = Order {
            category,
            size_m: recipe.size_m,
            color: geometry::Rgb::hex(0x80_80_80),
            material: None,
            rng: runtime::seed::child_rng(1, "size"),
        };
        let ratio = shape.assembled(&mut order).size_m() / recipe.size_m;
        let scale = ratio.element_product().cbrt();
        if (ratio / scale - 1.0).abs().max_element() > 0.25 || !(0.6..1.7).contains(&scale) {
            objections.push(format!("{}: built {ratio:.2} times its typical size", category.name));
        }
    }
    assert!(objections.is_empty(), "{}", objections.join("\n"));
}

fn shape(text: &str) -> Result<Shape, String> {
    toml::from_str::<Shape>(text).map_err(|error| error.to_string())
}

#[test]
fn shapes_that_cannot_be_built_are_refused_with_the_reason() {
    let cases = [
        ("part = [{ surface = \"steel\" }]", "exactly one form"),
        (
            "part = [{ ball = { size = [0.1, 0.1, 0.1] }, box = { size = [0.1, 0.1, 0.1] } }]",
            "exactly one form",
        ),
        ("part = [{ turned = { profile = [[0.1, 0.0]] } }]", "needs 2"),
        ("part = [{ box = { size = [0.1, 0.1, 0.1], radius = 0.1 } }]", "unknown field `radius`"),
        ("finish = \"velvet\"", "no finish is called `velvet`"),
        ("surface.cap = { color = \"#12\" }", "`#12` is no color"),
        ("part = [{ ball = { size = [0.1, 0.1, 0.1] }, lumpy = 0.7 }]", "below one half"),
    ];
    for (text, reason) in cases {
        let error = shape(text).expect_err(text);
        assert!(error.contains(reason), "{text}: {error}");
    }
    assert_eq!(shape("").expect("parses").check(), Err(ShapeError::NoParts));
    assert_eq!(shape("like = \"mug\"").expect("parses").check(), Err(ShapeError::NotLike("mug".into())));
    let inverted =
        "part = [{ ball = { size = [0.1, 0.1, 0.1] } }, { turned = { profile = [[0.1, 0.1], [0.1, 0.0]] } }]";
    assert_eq!(shape(inverted).expect("parses").check(), Err(ShapeError::NoSolid(1)));
    let flat = "part = [{ box = { size = [0.1, 0.1, 0.0] } }]";
    assert_eq!(shape(flat).expect("parses").check(), Err(ShapeError::NoSolid(0)));
    let odd = "part = [{ ball = { size = [0.1, 0.1, 0.1] }, surface = \"felt\" }]";
    assert_eq!(shape(odd).expect("parses").check(), Err(ShapeError::UnknownSurface("felt".into())));
}

#[test]
fn copies_are_where_rows_circles_and_mirrors_put_them() {
    let centers = |placement: &str| -> Vec<[i64; 3]> {
        let text = format!("part = [{{ box = {{ size = [0.01, 0.01, 0.01] }}, {placement} }}]");
        let shape = shape(&text).expect("parses");
        let category = category("cube").expect("in the catalog");
        let mut order = Order {
            category,
            size_m: DVec3::ONE,
            color: geometry::Rgb::hex(0),
            material: None,
            rng: runtime::seed::child_rng(1, "copies"),
        };
        let mut centers: Vec<[i64; 3]> = shape.part[0]
            .solids(&mut order)
            .iter()
            .map(|solid| {
                let sum: DVec3 = solid.positions.iter().sum();
                (1000.0 * sum / solid.positions.len() as f64).round().to_array().map(|c| c as i64)
            })
            .collect();
        centers.sort_unstable();
        centers
    };
    assert_eq!(centers("at = [0.1, 0, 0]"), [[100, 0, 5]]);
    let row =
        "at = [0.1, 0, 0], rows = [{ count = 2, step = [0, 0.02, 0] }, { count = 2, step = [0, 0, 0.03] }]";
    assert_eq!(centers(row), [[100, 0, 5], [100, 0, 35], [100, 20, 5], [100, 20, 35]]);
    assert_eq!(centers("at = [0.1, 0, 0], circle = { count = 2 }"), [[-100, 0, 5], [100, 0, 5]]);
    assert_eq!(centers("at = [0.1, 0.2, 0], mirror = \"y\""), [[100, -200, 5], [100, 200, 5]]);
    assert_eq!(centers("at = [0.1, 0.2, 0], mirror = \"xy\"").len(), 4);
    assert_eq!(centers("turn = [0, 90, 0]"), [[5, 0, 0]]);
}

#[test]
fn main_parts_take_the_requested_color_and_material() {
    let red = geometry::Rgb::hex(0xc8_20_20);
    let plain = Recipe { color: Some(red), ..Recipe::typical("cube", None, None).expect("in the catalog") };
    let mesh = build(&plain).expect("builds");
    assert_eq!(mesh.materials[0].base_color, red);
    let steel = Recipe { material: Some("steel".into()), ..plain };
    assert_eq!(build(&steel).expect("builds").materials[0].metalness, 1.0);
}
