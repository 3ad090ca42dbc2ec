//! Tests of the shapes in the data files and of the validation of shapes.

use super::*;
use crate::{Category, Recipe, build, categories};

fn with_shape() -> impl Iterator<Item = (&'static Category, &'static Shape)> {
    let all = categories().iter().chain(crate::stand_in::hidden_categories());
    all.filter_map(|category| category.shape.as_ref().map(|shape| (category, shape.get())))
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
        ("part = [{ tube = { path = [[0, 0, 0], [0, 0, 1]], radii = [0.1] } }]", "needs 2"),
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
    assert_eq!(
        shape("like = \"glass_of_milk\"").expect("parses").check(),
        Err(ShapeError::NotLike("glass_of_milk".into()))
    );
    let inverted =
        "part = [{ ball = { size = [0.1, 0.1, 0.1] } }, { turned = { profile = [[0.1, 0.1], [0.1, 0.0]] } }]";
    assert_eq!(shape(inverted).expect("parses").check(), Err(ShapeError::NoSolid(1)));
    let flat = "part = [{ box = { size = [0.1, 0.1, 0.0] } }]";
    assert_eq!(shape(flat).expect("parses").check(), Err(ShapeError::NoSolid(0)));
    let absent = "variants = 2\npart = [{ ball = { size = [0.1, 0.1, 0.1] }, only_in = [1] }]";
    assert_eq!(shape(absent).expect("parses").check(), Err(ShapeError::EmptyVariant(2)));
    let rim =
        "part = [{ ball = { size = [0.1, 0.1, 0.1] }, faces = [{ facing = \"up\", surface = \"rim\" }] }]";
    assert_eq!(shape(rim).expect("parses").check(), Err(ShapeError::UnknownSurface("rim".into())));
    let odd = "part = [{ ball = { size = [0.1, 0.1, 0.1] }, surface = \"felt\" }]";
    assert_eq!(shape(odd).expect("parses").check(), Err(ShapeError::UnknownSurface("felt".into())));
}

/// An order of a black cube.
fn order(seed: u64) -> Order<'static> {
    Order {
        category: category("cube").expect("in the catalog"),
        size_m: DVec3::ONE,
        color: geometry::Rgb::hex(0),
        material: None,
        rng: runtime::seed::child_rng(seed, "copies"),
    }
}

#[test]
fn copies_are_where_rows_circles_and_mirrors_put_them() {
    let centers = |placement: &str| -> Vec<[i64; 3]> {
        let text = format!("part = [{{ box = {{ size = [0.01, 0.01, 0.01] }}, {placement} }}]");
        let shape = shape(&text).expect("parses");
        let mut centers: Vec<[i64; 3]> = shape.part[0]
            .pieces(&mut order(1))
            .iter()
            .map(|(_, solid)| {
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

#[test]
fn objects_of_different_seeds_have_different_variants_and_surfaces() {
    let text = r##"
        variants = 3
        part = [
            { box = { size = [0.1, 0.1, 0.1] }, surface = "side", only_in = [1, 3] },
            { ball = { size = [0.1, 0.1, 0.1] }, surface = "side", only_in = [2] },
        ]
        surface.side = [{ color = "#ff0000" }, { color = "#00ff00" }]
    "##;
    let shape = shape(text).expect("parses");
    assert_eq!(shape.check(), Ok(()));
    let kinds: std::collections::BTreeSet<(bool, [u8; 4])> = (0..40)
        .map(|seed| shape.assembled(&mut order(seed)))
        .map(|mesh| (mesh.triangle_count() > 12, mesh.materials[0].base_color.to_rgba8()))
        .collect();
    assert_eq!(kinds.len(), 4, "{kinds:?}");
}

#[test]
fn faces_have_surfaces_of_their_own_and_the_solid_stays_closed() {
    let text = r##"
        part = [{ turned = { profile = [[0.04, 0], [0.05, 0.1]], wall = 0.004 }, faces = [
            { above = 0.0999, surface = "gold" },
            { facing = "inside", surface = "white" },
            { facing = "down", within = 0.06, surface = "black" },
        ] }]
    "##;
    let shape = shape(text).expect("parses");
    let pieces = shape.part[0].pieces(&mut order(1));
    let [rim, inside, below, outside] = ["gold", "white", "black", "main"].map(|name| {
        let mut pieces = pieces.iter().filter(|(surface, _)| *surface == name);
        let (Some((_, piece)), None) = (pieces.next(), pieces.next()) else { panic!("{name}") };
        piece
    });
    let lowest = |solid: &geometry::Solid| solid.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    assert!(lowest(rim) > 0.098 && (lowest(inside) - 0.004).abs() < 1e-9, "{}", lowest(inside));
    assert!(below.positions.iter().all(|p| p.z == 0.0) && lowest(outside) == 0.0);
    let mesh = shape.assembled(&mut order(1));
    assert_eq!(mesh.materials.len(), 4);
    let recipe = Recipe::typical("cube", None, None).expect("in the catalog");
    assert_eq!(crate::checks::closed(&recipe, &mesh), None);
}

#[test]
fn tubes_holes_and_helices_have_their_sizes() {
    let size = |form: &str| {
        let shape = shape(&format!("part = [{{ {form} }}]")).expect("parses");
        assert_eq!(shape.check(), Ok(()), "{form}");
        let mesh = shape.assembled(&mut order(1));
        (1000.0 * mesh.size_m()).round()
    };
    let bulb =
        "tube = { path = [[0, 0, 0], [0, 0, 0.1], [0, 0, 0.2]], radii = [0.01, 0.03, 0.01], segments = 32 }";
    assert_eq!(size(bulb), DVec3::new(60.0, 60.0, 200.0));
    let spring = "tube = { helix = { radius = 0.02, pitch = 0.01, turns = 4 }, radius = 0.001 }";
    assert!((size(spring) - DVec3::new(42.0, 42.0, 42.0)).abs().max_element() <= 2.0, "{}", size(spring));
    let washer = "plate = { outline = [[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]], thickness = 0.003, hole = { radius = 0.01, sides = 6 } }";
    let part = &shape(&format!("part = [{{ {washer} }}]")).expect("parses").part[0];
    let (_, solid) = &part.pieces(&mut order(1))[0];
    let expected_m3 = 0.003 * (0.04 * 0.04 - 1.5 * 3.0_f64.sqrt() * 0.01 * 0.01);
    assert!((solid.volume_m3() / expected_m3 - 1.0).abs() < 0.01, "{}", solid.volume_m3() / expected_m3);
}
