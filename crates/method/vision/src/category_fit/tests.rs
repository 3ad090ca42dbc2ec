//! Catalog objects are recognized in renderings; an object of no category gets no name.

use glam::{DQuat, DVec3};

use super::*;
use crate::{ObjectReading, TableReading, TopShape, fit_solid};
use catalog::{Recipe, build, category};
use geometry::shapes::{block, cone};
use geometry::{Material, Pose, Rgb, TexturedMesh};
use render::{Background, Lighting, RenderObject, RenderScene, RenderSettings, View, render};

const QUALITY: RenderSettings =
    RenderSettings { supersampling: 1, shadow_map_px: 256, sky_directions: 8, sky_map_px: 64 };

/// The object rendered on a gray table, with a perfect reading.
pub(super) fn seen(mesh: &TexturedMesh, yaw_rad: f64) -> (Image, ImageReading) {
    let mut table = TexturedMesh::default();
    let top = block(DVec3::new(1.2, 0.8, 0.02)).translated(-0.02 * DVec3::Z);
    table.add(top, &Material::plain("top", Rgb([0.6, 0.6, 0.6]), 0.8));
    let camera = Camera::orbit(480, 360, 0.5, DVec3::ZERO, 0.1, 0.55, 1.0);
    let pose = Pose::upright(DVec3::new(0.03, 0.02, 0.0), yaw_rad);
    let scene = RenderScene {
        objects: vec![
            RenderObject { mesh: &table, world_from_object: Pose::IDENTITY, id: 1 },
            RenderObject { mesh, world_from_object: pose, id: 2 },
        ],
        lighting: Lighting::studio(-0.6, 0.95, 0.6),
        background: Background::light(),
    };
    let rendered = render(&scene, &View::Perspective(camera), &QUALITY);
    let bits = rendered.ids.iter().map(|id| *id == 2).collect();
    let mask = Mask::from_bits(480, 360, bits);
    let solid = fit_solid(&mask, &camera, Some(&rendered.color), None).expect("a solid");
    let reading = ImageReading {
        camera,
        table: TableReading {
            shape: TopShape::Rectangle,
            depth: 0.67,
            outline: Vec::new(),
            outline_px: Vec::new(),
            color: Rgb([0.6; 3]),
            height: None,
            fit: 1.0,
        },
        objects: vec![ObjectReading { mask, solid, color: Rgb([0.5; 3]), stands_on: None }],
        left_out: Vec::new(),
        unread: Mask::empty(480, 360),
        bare_top: Mask::empty(480, 360),
        depth: None,
    };
    (rendered.color, reading)
}

/// A slightly lower confidence than the default.
fn settings() -> CategoryFitSettings {
    CategoryFitSettings {
        min_confidence: 0.4,
        ..test_settings::section::<CategoryFitSettings>("category_fit")
    }
}

/// Guesses with these probabilities.
fn guesses(of: &[(&str, f64)]) -> Vec<CategoryGuess> {
    let guess = |(name, probability): &(&str, f64)| CategoryGuess {
        category: category(name).expect("in the catalog"),
        probability: *probability,
    };
    of.iter().map(guess).collect()
}

fn named(image: &Image, reading: &ImageReading, guessed: &[(&str, f64)]) -> (Vec<ObjectEvidence>, Naming) {
    let settings = settings();
    let guesses = [guesses(guessed)];
    let found =
        evidence(image, reading, &guesses, &settings, &CancelFlag::default()).expect("not interrupted");
    let naming = assign_categories(&found, &settings, |_, _| true);
    (found, naming)
}

#[test]
fn catalog_objects_are_recognized_at_other_yaws_and_sizes() {
    for (name, yaw_rad, factor) in [("mug", 0.7, 1.15), ("banana", 2.1, 0.9)] {
        let size_m = factor * category(name).expect("in the catalog").size.typical_m();
        let (category, color) = (name.to_owned(), Some(Rgb::hex(0x3a7a5c)));
        let mesh = build(&Recipe { category, size_m, color, material: None, seed: 77 }).expect("a mesh");
        let (image, reading) = seen(&mesh, yaw_rad);
        // Shape and size decide between two guesses.
        let (found, naming) =
            named(&image, &reading, &[("mug", 0.3), ("banana", 0.3), ("laptop", 0.2), ("fork", 0.1)]);
        let Some(given) = &naming.objects[0] else { panic!("{name} has no name: {found:?}") };
        assert_eq!(given.category_match.category, name, "{found:?}");
        let off = (given.category_match.yaw_rad - yaw_rad).rem_euclid(TAU);
        assert!(
            off.min(TAU - off) < 0.35,
            "{name} is turned by {} for {yaw_rad}",
            given.category_match.yaw_rad
        );
        let ratio = given.category_match.size_m / size_m;
        assert!(ratio.max_element() < 1.25 && ratio.min_element() > 0.8, "{name} {ratio}");
        assert!(given.category_match.overlap > 0.88, "{name} {}", given.category_match.overlap);
        // With its own category left out, the object has no name.
        let without = assign_categories(&found, &settings(), |_, category| category != name);
        assert_eq!(without.objects, [None]);
    }
}

#[test]
fn guess_that_fits_no_outline_keeps_place_and_size_of_the_primitive() {
    let size_m = category("laptop").expect("in the catalog").size.typical_m();
    let mesh =
        build(&Recipe { category: "laptop".to_owned(), size_m, color: None, material: None, seed: 77 });
    let (image, reading) = seen(&mesh.expect("a mesh"), -0.4);
    let (found, naming) = named(&image, &reading, &[("dice", 0.5), ("laptop", 0.4)]);
    let [dice, laptop] = [0, 1].map(|k| &found[0].matches[k]);
    assert!(
        laptop.is_fitted && laptop.overlap > 0.88 && laptop.overlap > found[0].solid_overlap,
        "{laptop:?}"
    );
    assert!((laptop.yaw_rad + 0.4).abs() < 0.2, "{laptop:?}");
    assert!(
        !dice.is_fitted && dice.size_m == reading.objects[0].solid.size && dice.oversize > 2.0,
        "{dice:?}"
    );
    let given = naming.objects[0].as_ref().map(|given| given.category_match.category);
    assert_eq!(given, Some("laptop"));
}

#[test]
fn object_of_no_category_gets_no_name() {
    let mut mesh = TexturedMesh::default();
    let material = |hex: u32| Material::plain(&format!("paint_{hex:x}"), Rgb::hex(hex), 0.6);
    mesh.add(block(DVec3::new(0.16, 0.04, 0.03)), &material(0xaa3355));
    let leaning = DQuat::from_rotation_y(0.7);
    mesh.add(
        block(DVec3::new(0.03, 0.03, 0.2)).rotated(leaning).translated(DVec3::X * -0.04),
        &material(0x33aa55),
    );
    mesh.add(cone(0.05, 0.0, 0.09, 24).translated(DVec3::new(0.06, 0.07, 0.0)), &material(0x3355aa));
    let (image, reading) = seen(&mesh.seated(), 0.5);
    let (found, naming) = named(&image, &reading, &[("hammer", 0.1), ("toy_truck", 0.1), ("stapler", 0.05)]);
    assert_eq!(naming.objects, [None], "{found:?}");
    assert_eq!(naming.scale, None);
}

#[test]
fn empty_mask_yields_empty_evidence() {
    let mesh = build(&Recipe {
        category: "apple".to_owned(),
        size_m: DVec3::splat(0.08),
        color: None,
        material: None,
        seed: 3,
    });
    let (image, mut reading) = seen(&mesh.expect("a mesh"), 0.0);
    reading.objects[0].mask = Mask::empty(480, 360);
    let (found, naming) = named(&image, &reading, &[("apple", 0.9)]);
    assert_eq!((found, naming.objects), (vec![ObjectEvidence::default()], vec![None]));
    let stop = CancelFlag::default();
    stop.cancel();
    assert!(evidence(&image, &reading, &[Vec::new()], &settings(), &stop).is_err());
}
