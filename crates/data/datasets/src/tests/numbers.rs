//! Statistics and licenses against values computed by hand.

use super::fixture::{MUG, ObjectSpec, Place, SceneSpec};
use crate::bundle::Bundle;
use crate::facts::{SceneFacts, normalized};
use crate::licences;
use crate::selection::Selection;
use crate::splits::SplitPlan;
use crate::statistics::{CategoryCount, Statistics, page};

/// A plate of 0.4 x 0.5 m with a bowl on it, in which a spoon is: a fifth of the table is covered, and the plate covers
/// what stands on it.
fn stacked() -> SceneSpec {
    let plate =
        ObjectSpec { name: "plate_1", category: "plate", size_m: [0.4, 0.5, 0.02], mass_kg: 0.7, ..MUG };
    let bowl = ObjectSpec {
        name: "bowl_1",
        category: "bowl",
        at_m: [0.0, 0.0, 0.02],
        mass_kg: 0.3,
        support: ("plate_1", "on"),
        ..MUG
    };
    let spoon = ObjectSpec {
        name: "spoon_1",
        category: "spoon",
        size_m: [0.15, 0.03, 0.02],
        at_m: [0.0, 0.0, 0.03],
        mass_kg: 0.02,
        support: ("bowl_1", "in"),
        ..MUG
    };
    SceneSpec { objects: vec![plate, bowl, spoon], ..SceneSpec::of_text("stacked", "A plate with a bowl") }
}

/// Two mugs of 0.02 square meters; half of the second lies beyond the edge.
fn at_the_edge() -> SceneSpec {
    let second = ObjectSpec { name: "mug_2", at_m: [0.5, 0.3, 0.0], ..MUG };
    let reasons = vec!["over_the_edge", "not_at_rest", "over_the_edge"];
    SceneSpec { objects: vec![MUG, second], reasons, ..SceneSpec::of_text("edge", "Two mugs") }
}

fn facts(spec: &SceneSpec) -> SceneFacts {
    let place = Place::new();
    let mut bundle = Bundle::open(&spec.write_folder(&place.path("bundles"))).expect("a bundle");
    SceneFacts::read(&mut bundle).expect("facts")
}

fn near(actual: Option<f64>, expected: f64) {
    let actual = actual.expect("a value");
    assert!((actual - expected).abs() < 2e-3, "{actual} is not {expected}");
}

#[test]
fn statistics_are_those_computed_by_hand() {
    let (stacked, edge) = (facts(&stacked()), facts(&at_the_edge()));
    let selection = Selection { requested: 4, read: 3, passed: 2, ..Selection::default() };
    let plan: SplitPlan = "train=0.5,test=0.5".parse().expect("a plan");
    let splits = ["train".to_owned(), "test".to_owned()];
    let statistics = Statistics::of(&[&stacked, &edge], &splits, &selection, &plan);
    assert_eq!((statistics.scenes, statistics.objects), (2, 5));
    assert_eq!(statistics.objects_per_scene.edges, [2.0, 3.0, 4.0]);
    assert_eq!(statistics.objects_per_scene.counts, [1, 1]);
    assert_eq!(statistics.objects_per_scene.mean, Some(2.5));
    let count =
        |category: &str, objects, scenes| CategoryCount { category: category.to_owned(), objects, scenes };
    let expected = [count("mug", 2, 1), count("bowl", 1, 1), count("plate", 1, 1), count("spoon", 1, 1)];
    assert_eq!(statistics.categories, expected);
    near(statistics.covered_share.max, 0.2);
    near(statistics.covered_share.min, 0.03);
    assert_eq!(statistics.covered_share.counts[0], 1);
    assert_eq!(statistics.support_depth.edges, [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(statistics.support_depth.counts, [3, 1, 1]);
    assert_eq!(statistics.support_relations, [("in".to_owned(), 1), ("on".to_owned(), 4)].into());
    // 0.5 | 0.2, 0.2, 0.2 | 0.15: bins of 0.1, 0.2 and 0.5.
    assert_eq!(statistics.largest_extent_m.counts, [0, 0, 0, 1, 3, 1, 0]);
    assert_eq!(statistics.largest_extent_m.median, Some(0.2));
    // 0.02 | 0.3, 0.3, 0.3, 0.7.
    assert_eq!(statistics.mass_kg.counts, [0, 0, 1, 0, 0, 4, 0, 0, 0]);
    near(statistics.mass_kg.mean, 1.62 / 5.0);
    assert_eq!(statistics.table_shapes, [("square".to_owned(), 2)].into());
    assert_eq!(statistics.table_area_m2.median, Some(1.0));
    assert_eq!(statistics.licences, [("CC0-1.0".to_owned(), 5)].into());
    assert_eq!(statistics.yield_share, Some(0.5));
    let splits: Vec<(usize, usize)> = statistics.splits.iter().map(|s| (s.scenes, s.objects)).collect();
    assert_eq!(splits, [(1, 3), (1, 2)]);
    let read: Statistics = serde_json::from_str(&statistics.json()).expect("the same form");
    assert_eq!(read, statistics);
}

#[test]
fn reasons_of_a_scene_count_once() {
    let facts = facts(&at_the_edge());
    assert_eq!(facts.reason_codes, ["not_at_rest", "over_the_edge"]);
    assert!(!facts.passed());
}

#[test]
fn the_page_escapes_names_and_loads_nothing() {
    let mut facts = facts(&stacked());
    facts.objects[0].category = "<script>alert(1)</script>".to_owned();
    let plan: SplitPlan = "train=1".parse().expect("a plan");
    let selection = Selection { requested: 1, read: 1, passed: 1, ..Selection::default() };
    let statistics = Statistics::of(&[&facts], &["train".to_owned()], &selection, &plan);
    let text = page::write("mugs v1", &statistics);
    assert!(text.contains("&lt;script&gt;"));
    for foreign in ["<script", "<img", "<link", "href=", "src=", "url("] {
        assert!(!text.contains(foreign), "{foreign}");
    }
    for title in
        ["Objects per scene", "Clutter", "Support depth", "Sizes", "Masses", "Table shapes", "yield 100.0 %"]
    {
        assert!(text.contains(title), "{title}");
    }
}

#[test]
fn licenses_are_counted_from_the_provenance_of_objects() {
    let (mut stacked, edge) = (facts(&stacked()), facts(&at_the_edge()));
    stacked.objects[0].licence = "CC-BY-4.0 | x".to_owned();
    stacked.objects[0].mesh_by = "remote/maker".to_owned();
    let text = licences::text("mugs", 1, [&stacked, &edge]);
    for line in [
        "| CC-BY-4.0 \\| x | 1 | 0 | 1 |",
        "| CC0-1.0 | 4 | 2 | 2 |",
        "| CC-BY-4.0 \\| x | remote/maker | 1 |",
        "| CC0-1.0 | embedded/catalog | 4 |",
    ] {
        assert!(text.contains(line), "{line} in {text}");
    }
}

#[test]
fn texts_are_equal_without_case_spaces_and_punctuation() {
    assert_eq!(normalized("  A mug,\n and a PLATE! "), "a mug and a plate");
    assert_eq!(normalized("Ünï 2"), "ünï 2");
    assert_eq!(normalized("?!"), "");
}
