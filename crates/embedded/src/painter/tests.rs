//! Paintings: what they show is what they know.

use std::sync::Arc;

use super::*;
use crate::analyst;
use crate::analyst::{DescribeOptions, describe};
use catalog::{Recipe, build, build_table};
use geometry::DVec3;
use imaging::Mask;
use ports::Reference;
use runtime::Cpu;
use scene::{RelationKind, StandsOn};

/// The built-in settings, painting small.
fn painter() -> EmbeddedPainter {
    let defaults: toml::Table =
        toml::from_str(include_str!("../../../../config/default.toml")).expect("the built-in settings");
    fn section<T: serde::de::DeserializeOwned>(defaults: &toml::Table, name: &str) -> T {
        defaults[name].clone().try_into().expect(name)
    }
    EmbeddedPainter {
        photograph: PhotographSettings {
            vision: section(&defaults, "vision"),
            sizes: section(&defaults, "photograph"),
            naming: section(&defaults, "category_fit"),
        },
        layout: section(&defaults, "layout"),
        painter: PainterSettings {
            width_px: 320,
            height_px: 240,
            alone_px: 96,
            top_px: 240,
            ..section(&defaults, "painter")
        },
        render: RenderSettings { supersampling: 1, shadow_map_px: 256, sky_directions: 6, sky_map_px: 64 },
        decompose: section(&defaults, "decompose"),
        settle: section(&defaults, "settle"),
        resolve: section(&defaults, "resolve"),
        certify: section(&defaults, "certify"),
    }
}

fn call(threads: usize) -> Call {
    Call::without_budget(Cpu::new(threads).expect("a pool"), Interrupt::default())
}

fn described(text: &str, seed: u64) -> Arc<SceneDescription> {
    let settings = analyst::Settings {
        max_text_chars: 4000,
        fewest_objects: 8,
        most_objects: 15,
        kinds_that_close_a_text: 3,
        table_area_per_footprint: 3.0,
    };
    let options = DescribeOptions { max_objects: 64, table: None };
    Arc::new(describe(text, seed, &options, &settings).expect(text))
}

const TEXT: &str = "a round table with a stack of two books, a plate with an apple on it, a fork to the left of \
                    the plate, a mug with a spoon in it and a soda can";

#[tokio::test]
async fn a_painting_knows_itself() {
    let description = described(TEXT, 3);
    let painting = painter().reference(&call(2), description.clone(), 3).await.expect("a painting");
    let aside = painting.aside.expect("it is a program");
    let recognition = &aside.known.recognition;
    assert_eq!(recognition.objects.len(), description.objects.len());

    // Visible masks are apart, lie in the whole silhouettes, and each shows.
    let mut covered = aside.known.table_mask.clone();
    for ((mask, alone), object) in aside.known.masks.iter().zip(&aside.alone).zip(&recognition.objects) {
        assert_eq!((&mask.id, &alone.id), (&object.id, &object.id));
        let whole = &alone.completion.silhouette;
        let shows = mask.visible.area_px();
        let outside = (0..240)
            .flat_map(|y| (0..320).map(move |x| (x, y)))
            .filter(|&(x, y)| mask.visible.contains(x, y) && !whole.contains(x, y))
            .count();
        assert!(shows > 0 && outside == 0, "{}: {shows} pixels, {outside} outside", object.id);
        let share = 1.0 - shows as f64 / whole.area_px() as f64;
        assert!((alone.completion.completed_share - share).abs() < 1e-9);
        let (x, y) = first_pixel(&mask.visible);
        assert!(!covered.contains(x, y));
        covered.set(x, y, true);
        let picture = &alone.completion.picture;
        assert!(picture.width_px().max(picture.height_px()) >= 95);
        let opaque = picture.as_rgba().chunks_exact(4).filter(|p| p[3] == 255).count();
        let size = (picture.width_px() * picture.height_px()) as usize;
        assert!(opaque > size / 50 && opaque < size, "{}: {opaque} of {size}", object.id);
    }

    // The recognized sizes, colors and seeds build the painted meshes.
    let table = &recognition.table;
    let built = build_table(&table.model, table.size_m, table.color, table.material.as_deref(), table.seed);
    assert!(built.is_some_and(|built| (built.mesh.size_m() - table.size_m).abs().max_element() < 0.03));
    for (object, instance) in recognition.objects.iter().zip(&aside.truth.instances) {
        let recipe = Recipe {
            category: object.category.clone(),
            size_m: object.size_m,
            color: object.color,
            material: object.material.clone(),
            seed: object.seed,
        };
        assert_eq!(build(&recipe).expect("a category").size_m(), instance.size_m);
    }

    // Settled as described: the apple above the plate, the fork left of it, the spoon in the mug.
    let at = |name: &str| {
        let found = aside.truth.instances.iter().find(|i| i.name.as_str() == name).expect(name);
        found.translation_m
    };
    assert!(at("fork_1").x < at("plate_1").x - 0.1);
    assert!((at("apple_1") - at("plate_1")).truncate().length() < 0.1 && at("apple_1").z > 0.003);
    assert!((at("book_2").z - at("book_1").z) > 0.01);
    let spoon = recognition.objects.iter().find(|o| o.id.as_str() == "spoon_1").expect("a spoon");
    assert!(matches!(&spoon.stands_on, StandsOn::In(id) if id.as_str() == "mug_1"));
    assert!(description.objects.iter().any(|o| o.relations.iter().any(|r| r.kind == RelationKind::In)));

    // From above: the picture's middle is the table's, and things are where they stand.
    let top = aside.top.known.expect("it is a program");
    let [x0, y0, x1, y1] = top.table.bbox_px().expect("a table").map(f64::from);
    let meters_per_px = table.size_m.x / (x1 - x0);
    for (mask, instance) in top.objects.iter().zip(&aside.truth.instances) {
        let upright = (instance.rotation_xyzw * DVec3::Z).z > 0.999;
        let [a, b, c, d] = mask.visible.bbox_px().expect("an outline").map(f64::from);
        let x = (0.5 * (a + c) - 0.5 * (x0 + x1)) * meters_per_px;
        let y = (0.5 * (y0 + y1) - 0.5 * (b + d)) * meters_per_px;
        let off = (x - instance.translation_m.x).hypot(y - instance.translation_m.y);
        assert!(!upright || off < 0.04, "{}: {off}", instance.name);
    }
}

fn first_pixel(mask: &Mask) -> (u32, u32) {
    let at = mask.bits().iter().position(|&bit| bit).expect("it shows") as u32;
    (at % mask.width_px(), at / mask.width_px())
}

#[tokio::test]
async fn the_same_seed_gives_the_same_bytes_with_any_number_of_threads_and_another_seed_another_picture() {
    let description = described("a bowl with two apples, a mug and a book", 1);
    let paint = |threads: usize, seed: u64| {
        let description = description.clone();
        async move { painter().reference(&call(threads), description, seed).await.expect("a painting") }
    };
    let (one, two, other) = (paint(1, 4).await, paint(2, 4).await, paint(2, 5).await);
    assert!(one.picture == two.picture);
    let one_picture = one.picture;
    let (one, two) = (one.aside.expect("aside"), two.aside.expect("aside"));
    assert_eq!(
        (one.truth, one.known, one.alone, one.top),
        (two.truth.clone(), two.known, two.alone, two.top)
    );
    assert!(other.picture != one_picture);
    assert_ne!(other.aside.expect("aside").truth, two.truth);
}

#[tokio::test]
async fn own_pictures_are_completed_as_painted_and_unknown_things_refused() {
    let description = described("a mug and an apple", 2);
    let painting = painter().reference(&call(2), description, 2).await.expect("a painting");
    let aside = painting.aside.expect("aside");
    let reference = Reference { picture: Arc::new(painting.picture), known: None };
    let request = |alone: Option<Completion>| CompletionRequest {
        reference: reference.clone(),
        object: aside.known.recognition.objects[0].clone(),
        visible: aside.known.masks[0].visible.clone(),
        others: Mask::empty(320, 240),
        camera: None,
        alone,
    };
    let own = aside.alone[0].completion.clone();
    let answer = painter().complete(&call(1), request(Some(own.clone()))).await.expect("it knows it");
    assert_eq!(answer, own);
    let mut nonsense = (*described("a mug and an apple", 2)).clone();
    nonsense.objects[0].category = "unicorn".into();
    let refused = painter().reference(&call(1), Arc::new(nonsense), 1).await.expect_err("no unicorns");
    assert!(matches!(refused, ProviderError::Rejected { code: "not_in_catalog", .. }), "{refused}");
}
