//! Consistency of rendered images with their ground truth.

use std::sync::Arc;

use super::*;
use crate::text_parser::{DescribeOptions, TextParserSettings, describe};
use catalog::{Recipe, build, build_table};
use geometry::DVec3;
use imaging::Mask;
use ports::ReferenceImage;
use runtime::CpuPool;
use scene::{RelationKind, StandsOn};

/// The built-in settings with small images.
pub(super) fn image_generator() -> EmbeddedImageGenerator {
    let defaults: toml::Table =
        toml::from_str(include_str!("../../../../../config/default.toml")).expect("the built-in settings");
    fn section<T: serde::de::DeserializeOwned>(defaults: &toml::Table, name: &str) -> T {
        defaults[name].clone().try_into().expect(name)
    }
    EmbeddedImageGenerator {
        photograph: SingleViewSettings {
            sizes: section(&defaults, "photograph"),
            naming: section(&defaults, "category_fit"),
        },
        layout: section(&defaults, "layout"),
        image_generator: ImageGeneratorSettings {
            width_px: 320,
            height_px: 240,
            alone_px: 96,
            top_px: 240,
            ..section(&defaults, "image_generator")
        },
        render: RenderSettings { supersampling: 1, shadow_map_px: 256, sky_directions: 6, sky_map_px: 64 },
        decompose: section(&defaults, "decompose"),
        settle: section(&defaults, "settle"),
        resolve: section(&defaults, "resolve"),
        certify: section(&defaults, "certify"),
    }
}

pub(super) fn call(threads: usize) -> Call {
    Call::without_budget(CpuPool::new(threads).expect("a pool"), CancelFlag::default())
}

fn described(text: &str, seed: u64) -> Arc<SceneDescription> {
    let settings = TextParserSettings {
        max_text_chars: 4000,
        fewest_objects: 8,
        default_max_objects: 15,
        table_area_per_footprint: 3.0,
    };
    let options = DescribeOptions { max_objects: 64, table: None, on_unknown: Default::default() };
    Arc::new(describe(text, seed, &options, &settings).expect(text))
}

const TEXT: &str = "a round table with a stack of two books, a plate with an apple on it, a fork to the left of \
                    the plate, a mug with a spoon in it and a soda can";

#[tokio::test]
async fn ground_truth_matches_image_description_and_top_view() {
    let description = described(TEXT, 3);
    let generated =
        image_generator().reference(&call(2), description.clone(), 3).await.expect("a reference image");
    let ground_truth = generated.ground_truth.expect("ground truth");
    let recognition = &ground_truth.known.recognition;
    assert_eq!(recognition.objects.len(), description.objects.len());

    // Visible masks are disjoint, nonempty and inside the complete silhouettes.
    let mut covered = ground_truth.known.table_mask.clone();
    for ((mask, alone), object) in
        ground_truth.known.masks.iter().zip(&ground_truth.alone).zip(&recognition.objects)
    {
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
        let image = &alone.completion.image;
        assert!(image.width_px().max(image.height_px()) >= 95);
        let opaque = image.as_rgba().chunks_exact(4).filter(|p| p[3] == 255).count();
        let size = (image.width_px() * image.height_px()) as usize;
        assert!(opaque > size / 50 && opaque < size, "{}: {opaque} of {size}", object.id);
    }

    // The recognized sizes, colors and seeds build the rendered meshes.
    let table = &recognition.table;
    let built = build_table(&table.model, table.size_m, table.color, table.material.as_deref(), table.seed);
    assert!(built.is_some_and(|built| (built.mesh.size_m() - table.size_m).abs().max_element() < 0.03));
    for (object, instance) in recognition.objects.iter().zip(&ground_truth.truth.instances) {
        let recipe = Recipe {
            category: object.category.clone(),
            size_m: object.size_m,
            color: object.color,
            material: object.material.clone(),
            seed: object.seed,
        };
        assert_eq!(build(&recipe).expect("a category").size_m(), instance.size_m);
    }

    // Poses satisfy the description: the apple on the plate, the fork left of it, the spoon in the mug.
    let at = |name: &str| {
        let found = ground_truth.truth.instances.iter().find(|i| i.name.as_str() == name).expect(name);
        found.translation_m
    };
    assert!(at("fork_1").x < at("plate_1").x - 0.1);
    assert!((at("apple_1") - at("plate_1")).truncate().length() < 0.1 && at("apple_1").z > 0.003);
    assert!((at("book_2").z - at("book_1").z) > 0.01);
    let spoon = recognition.objects.iter().find(|o| o.id.as_str() == "spoon_1").expect("a spoon");
    assert!(matches!(&spoon.stands_on, StandsOn::In(id) if id.as_str() == "mug_1"));
    assert!(description.objects.iter().any(|o| o.relations.iter().any(|r| r.kind == RelationKind::In)));

    // The top view is centered on the table, and the masks agree with the poses.
    let top = ground_truth.top.expect("a view from above").known.expect("ground truth");
    let [x0, y0, x1, y1] = top.table.bbox_px().expect("a table").map(f64::from);
    let meters_per_px = table.size_m.x / (x1 - x0);
    for (mask, instance) in top.objects.iter().zip(&ground_truth.truth.instances) {
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
async fn reference_is_deterministic_across_thread_counts_and_varies_with_seed() {
    let description = described("a bowl with two apples, a mug and a book", 1);
    let render = |threads: usize, seed: u64| {
        let description = description.clone();
        async move {
            image_generator().reference(&call(threads), description, seed).await.expect("a reference image")
        }
    };
    let (one, two, other) = (render(1, 4).await, render(2, 4).await, render(2, 5).await);
    assert!(one.image == two.image);
    let one_image = one.image;
    let (one, two) = (one.ground_truth.expect("ground_truth"), two.ground_truth.expect("ground_truth"));
    assert_eq!(
        (one.truth, one.known, one.alone, one.top),
        (two.truth.clone(), two.known, two.alone, two.top)
    );
    assert!(other.image != one_image);
    assert_ne!(other.ground_truth.expect("ground_truth").truth, two.truth);
}

#[tokio::test]
async fn complete_returns_isolated_view_and_reference_rejects_unknown_category() {
    let description = described("a mug and an apple", 2);
    let generated = image_generator().reference(&call(2), description, 2).await.expect("a reference image");
    let ground_truth = generated.ground_truth.expect("ground_truth");
    let reference = ReferenceImage { image: Arc::new(generated.image), known: None, depth: None };
    let request = |alone: Option<Completion>| CompletionRequest {
        reference: reference.clone(),
        object: ground_truth.known.recognition.objects[0].clone(),
        visible: ground_truth.known.masks[0].visible.clone(),
        others: Mask::empty(320, 240),
        camera: None,
        alone,
    };
    let own = ground_truth.alone[0].completion.clone();
    let answer =
        image_generator().complete(&call(1), request(Some(own.clone()))).await.expect("the isolated view");
    assert_eq!(answer, own);
    let mut nonsense = (*described("a mug and an apple", 2)).clone();
    nonsense.objects[0].category = "unicorn".into();
    let refused =
        image_generator().reference(&call(1), Arc::new(nonsense), 1).await.expect_err("an unknown category");
    assert!(matches!(refused, ProviderError::Rejected { code: "not_in_catalog", .. }), "{refused}");
}
