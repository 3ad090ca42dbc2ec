//! Layouts of sentences: disjoint, inside the outline, and consistent with the stated relations.

mod place_settings;

use super::*;
use crate::text_parser::{DescribeOptions, TextParserSettings, describe};
use catalog::{Recipe, TableModel, build, build_table, category, table_models};
use scene::{ObjectSpec, SceneDescription, Supporter};

fn settings() -> LayoutSettings {
    LayoutSettings {
        attempts: 60,
        candidates: 90,
        gap_m: 0.018,
        min_gap_m: 0.005,
        edge_margin_m: 0.02,
        jitter_rad: 0.05,
        placement_cost_noise: 0.5,
    }
}

fn described(text: &str, seed: u64) -> SceneDescription {
    let settings = TextParserSettings {
        max_text_chars: 4000,
        fewest_objects: 8,
        default_max_objects: 15,
        table_area_per_footprint: 3.0,
    };
    describe(
        text,
        seed,
        &DescribeOptions { max_objects: 64, table: None, on_unknown: Default::default() },
        &settings,
    )
    .expect(text)
}

fn meshes(objects: &[ObjectSpec]) -> Vec<TexturedMesh> {
    objects
        .iter()
        .map(|object| {
            build(&Recipe {
                category: object.category.clone(),
                size_m: object.size_m,
                color: object.color,
                material: object.material.clone(),
                seed: object.seed,
            })
            .expect("a category of the catalog")
        })
        .collect()
}

fn objects<'a>(objects: &[ObjectSpec], meshes: &'a [TexturedMesh]) -> Vec<LayoutObject<'a>> {
    let index = |id| objects.iter().position(|other| other.id == id);
    objects
        .iter()
        .zip(meshes)
        .map(|(object, mesh)| LayoutObject {
            name: object.id.to_string(),
            category: category(&object.category).expect("a category of the catalog"),
            mesh,
            relations: object.relations.iter().map(|r| (r.kind, r.target.clone().and_then(index))).collect(),
        })
        .collect()
}

/// A sentence with its layout.
struct SampledLayout {
    description: SceneDescription,
    meshes: Vec<TexturedMesh>,
    outline: Outline,
    poses: Vec<Pose>,
}

impl SampledLayout {
    fn sample(text: &str, seed: u64) -> Self {
        Self::sample_on_first_with_room(text, seed, &[1.0])
    }

    /// On the first table with room, of those that are so many times as wide and deep as the described one.
    fn sample_on_first_with_room(text: &str, seed: u64, growths: &[f64]) -> Self {
        let description = described(text, seed);
        let meshes = meshes(&description.objects);
        let model: &TableModel = table_models()
            .iter()
            .find(|model| Some(model.name) == description.table.model.as_deref())
            .expect("the analyst names a model");
        let size_m = description.table.size_m.expect("the analyst gives a size");
        let objects = objects(&description.objects, &meshes);
        let on_grown = |growth: &f64| {
            let size_m = (growth * size_m.truncate()).extend(size_m.z);
            let outline = build_table(model.name, size_m, None, None, 1).expect("a model").outline_m;
            let poses = arrange(&objects, &outline, seed, &settings(), &CancelFlag::default());
            poses.map(|poses| (outline, poses))
        };
        let last = growths.len() - 1;
        let smaller = growths[..last].iter().find_map(|growth| on_grown(growth).ok());
        let (outline, poses) = smaller.unwrap_or_else(|| {
            on_grown(&growths[last]).unwrap_or_else(|error| panic!("{text} ({seed}): {error}"))
        });
        Self { description, meshes, outline, poses }
    }

    /// Footprint in the world frame.
    fn footprint(&self, object: usize) -> Footprint {
        let placed = self.meshes[object].positions.iter().map(|p| self.poses[object].transform_point(*p));
        Footprint::around(placed.map(|p| p.truncate()))
    }

    fn check(&self, text: &str) {
        let objects = objects(&self.description.objects, &self.meshes);
        let supports = support_tree(&objects);
        let prints: Vec<Footprint> = (0..objects.len()).map(|k| self.footprint(k)).collect();
        for a in 0..objects.len() {
            let name = &objects[a].name;
            if supports.supporter(a).parent.is_none() {
                let depth_m = prints[a].depth_inside_m(&self.outline);
                assert!(depth_m > 0.015, "{text}: {name} is {depth_m} m from the edge");
                for b in (0..a).filter(|&b| supports.supporter(b).parent.is_none()) {
                    let gap_m = prints[a].gap_m(&prints[b]);
                    assert!(gap_m > 0.003, "{text}: {name} and {} are {gap_m} m apart", objects[b].name);
                }
            }
            for &(kind, target) in &objects[a].relations {
                let at = prints[a].center();
                let Some(b) = target else {
                    assert_eq!(supports.supporter(a), Supporter::TABLE);
                    let (low, high) = self.outline.bounds();
                    let share = (at - 0.5 * (low + high)) / (0.5 * (high - low));
                    let holds = match kind {
                        RelationKind::AtLeft => share.x < 0.0,
                        RelationKind::AtRight => share.x > 0.0,
                        RelationKind::AtFront => share.y < 0.0,
                        RelationKind::AtBack => share.y > 0.0,
                        RelationKind::AtCenter => share.abs().max_element() < 0.7,
                        _ => true,
                    };
                    assert!(holds, "{text}: {name} {kind:?} at {share}");
                    continue;
                };
                let way = at - prints[b].center();
                let holds = match kind {
                    RelationKind::LeftOf => way.x < 0.0,
                    RelationKind::RightOf => way.x > 0.0,
                    RelationKind::InFrontOf => way.y < 0.0,
                    RelationKind::Behind => way.y > 0.0,
                    RelationKind::NextTo => prints[a].gap_m(&prints[b]) < 0.3,
                    RelationKind::Around => prints[a].gap_m(&prints[b]) < 1.3,
                    RelationKind::On | RelationKind::StackedOn | RelationKind::In => {
                        Footprint::around([at].into_iter()).depth_in_m(&prints[b]) > -0.05
                    }
                    _ => true,
                };
                assert!(holds, "{text}: {name} {kind:?} {} by {way}", objects[b].name);
            }
        }
    }
}

const SENTENCES: &[&str] = &[
    "an office desk",
    "a dinner for two",
    "a workbench with tools",
    "a sewing table",
    "a round breakfast table",
    "tea time on an oval table",
    "a triangular table with a bowl of apples, a vase and two candles",
    "a kidney-shaped table with a laptop, a mouse to its right and a mug with a spoon in it",
    "a stack of three books with a mug on top, a desk lamp and four pencils in a pen holder",
    "four plates around a vase, each with a fork and a knife",
    "a hammer to the left of a toolbox, three screwdrivers in front of it and a wrench next to the hammer",
    "a tray with two mugs and a teapot on it, a lemon at the front left and a candle at the back",
];

#[test]
fn lamp_behind_laptop_behind_keyboard_fits_on_a_desk_that_grows() {
    let text = "An office desk with a laptop, a keyboard in front of it, and a mouse to the right of the \
                keyboard. Behind the laptop stands a lamp.";
    // Desks are chosen by area, and three deep objects in a row want depth: the image generator grows such desks.
    for seed in 1..=3 {
        SampledLayout::sample_on_first_with_room(text, seed, &[1.0, 1.15, 1.35]).check(text);
    }
}

#[test]
fn lamp_behind_laptop_fits_on_shallow_desk() {
    let text = "A wooden desk with a pair of headphones, a pair of scissors, an hourglass, a laptop, a desk lamp behind the \
                laptop, a tissue box and a coaster with a mug on it";
    for seed in [50_052, 1, 2, 3] {
        SampledLayout::sample(text, seed).check(text);
    }
}

#[test]
fn sentences_give_disjoint_layouts_inside_outline_with_stated_relations() {
    for text in SENTENCES {
        for seed in 1..=3 {
            SampledLayout::sample(text, seed).check(text);
        }
    }
}

#[test]
fn arrange_repeats_with_same_seed_and_varies_with_another() {
    let (once, again, other) = (
        SampledLayout::sample(SENTENCES[0], 5),
        SampledLayout::sample(SENTENCES[0], 5),
        SampledLayout::sample(SENTENCES[0], 5),
    );
    assert_eq!(once.poses, again.poses);
    let objects = objects(&other.description.objects, &other.meshes);
    let moved = arrange(&objects, &other.outline, 6, &settings(), &CancelFlag::default()).expect("room");
    let far = moved.iter().zip(&once.poses).filter(|(a, b)| a.translation_m.distance(b.translation_m) > 0.05);
    assert!(far.count() > once.poses.len() / 2);
}

#[test]
fn arrange_names_objects_without_space_and_honors_cancellation() {
    let description = described("two laptops and a monitor", 1);
    let meshes = meshes(&description.objects);
    let objects = objects(&description.objects, &meshes);
    let small = Outline::new([(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)].map(DVec2::from).to_vec())
        .expect("a square");
    let few = LayoutSettings { attempts: 6, ..settings() };
    let refused =
        arrange(&objects, &small, 1, &few, &CancelFlag::default()).expect_err("40 cm are not enough");
    assert!(matches!(&refused, LayoutError::NoRoom { names, .. } if !names.is_empty()), "{refused}");
    let cancel = CancelFlag::default();
    cancel.cancel();
    let stopped = arrange(&objects, &small, 1, &few, &cancel);
    assert_eq!(stopped, Err(LayoutError::Cancelled(Cancelled)));
}
