//! Properties of groups and splits.

use std::collections::BTreeMap;

use proptest::prelude::*;

use crate::leakage::leaks;
use crate::sharing::{LeakageRules, Shareable};
use crate::splits::{Group, SplitPlan, assign, groups};

fn scene(id: &str) -> Shareable {
    Shareable {
        id: id.to_owned(),
        parent: None,
        text_sha256: None,
        image_sha256: None,
        mesh_sha256: Vec::new(),
    }
}

fn with_splits(scenes: &[Shareable], rules: &LeakageRules, plan: &SplitPlan) -> Vec<(Shareable, String)> {
    let groups = groups(scenes, rules);
    let assigned = assign(&groups, plan, &BTreeMap::new());
    let of: BTreeMap<&str, &String> = groups
        .iter()
        .zip(&assigned)
        .flat_map(|(group, split)| group.scenes().iter().map(move |id| (id.as_str(), split)))
        .collect();
    scenes.iter().map(|scene| (scene.clone(), of[scene.id.as_str()].clone())).collect()
}

fn any_scenes() -> impl Strategy<Value = Vec<Shareable>> {
    let number = || proptest::option::of(0..40_u32);
    let facts = (number(), number(), number(), proptest::collection::vec(0..60_u32, 0..3));
    proptest::collection::vec(facts, 1..60).prop_map(|facts| {
        let scenes = facts.into_iter().enumerate().map(|(k, (parent, text, image, meshes))| Shareable {
            id: format!("s{k}"),
            parent: parent.map(|parent| format!("s{parent}")),
            text_sha256: text.map(|text| text.to_string()),
            image_sha256: image.map(|image| image.to_string()),
            mesh_sha256: meshes.iter().map(u32::to_string).collect(),
        });
        scenes.collect()
    })
}

fn any_rules() -> impl Strategy<Value = LeakageRules> {
    any::<[bool; 4]>().prop_map(|[lineage, text, image, mesh]| LeakageRules { lineage, text, image, mesh })
}

proptest! {
    #[test]
    fn splits_of_random_scenes_share_nothing(scenes in any_scenes(), rules in any_rules(), seed in 0..5_u64) {
        let plan = SplitPlan { seed, ..plan("a=0.6,b=0.3,c=0.1") };
        prop_assert_eq!(leaks(&with_splits(&scenes, &rules, &plan), &rules), []);
    }

    #[test]
    fn ratios_hold_within_the_size_of_the_largest_group(
        sizes in proptest::collection::vec(1..9_usize, 1..40),
        weights in proptest::collection::vec(0..5_u32, 1..5),
    ) {
        let sum: u32 = weights.iter().sum();
        prop_assume!(sum > 0);
        let text: Vec<String> = weights
            .iter()
            .enumerate()
            .map(|(k, weight)| format!("s{k}={}", f64::from(*weight) / f64::from(sum)))
            .collect();
        let plan = plan(&text.join(","));
        let groups: Vec<Group> = sizes
            .iter()
            .enumerate()
            .map(|(k, size)| Group::of((0..*size).map(|m| format!("g{k}-{m}"))))
            .collect();
        let assigned = assign(&groups, &plan, &BTreeMap::new());
        let total: usize = sizes.iter().sum();
        let largest = sizes.iter().copied().max().unwrap_or(0) as f64;
        for split in &plan.ratios {
            let inside = sizes.iter().zip(&assigned).filter(|(_, name)| **name == split.name);
            let count: usize = inside.map(|(size, _)| size).sum();
            let off = (count as f64 - split.ratio * total as f64).abs();
            prop_assert!(off < largest + 1e-9, "{} is off by {off} scenes, largest group {largest}", split.name);
        }
    }

    #[test]
    fn the_order_of_scenes_does_not_matter(scenes in any_scenes(), seed in 0..5_u64) {
        let plan = SplitPlan { seed, ..plan("a=0.5,b=0.5") };
        let mut forward = with_splits(&scenes, &LeakageRules::ALL, &plan);
        let reversed: Vec<Shareable> = scenes.into_iter().rev().collect();
        let mut backward = with_splits(&reversed, &LeakageRules::ALL, &plan);
        forward.sort_by(|a, b| a.0.id.cmp(&b.0.id));
        backward.sort_by(|a, b| a.0.id.cmp(&b.0.id));
        prop_assert_eq!(forward, backward);
    }
}

fn plan(text: &str) -> SplitPlan {
    text.parse().expect("a plan")
}

#[test]
fn sharing_is_transitive_and_each_rule_can_be_switched_off() {
    let scenes = [
        Shareable { text_sha256: Some("t".into()), ..scene("a") },
        Shareable { text_sha256: Some("t".into()), mesh_sha256: vec!["m".into()], ..scene("b") },
        Shareable { mesh_sha256: vec!["m".into()], ..scene("c") },
        Shareable { parent: Some("c".into()), ..scene("d") },
        scene("e"),
    ];
    let members = |rules: &LeakageRules| -> Vec<Vec<String>> {
        groups(&scenes, rules).iter().map(|group| group.scenes().to_vec()).collect()
    };
    assert_eq!(members(&LeakageRules::ALL), [vec!["a", "b", "c", "d"], vec!["e"]]);
    assert_eq!(members(&"text,lineage".parse().expect("rules")), [vec!["a", "b"], vec!["c", "d"], vec!["e"]]);
    assert_eq!(members(&LeakageRules::NONE).len(), 5);
}

#[test]
fn children_of_an_absent_parent_form_a_group() {
    let child = |id: &str| Shareable { parent: Some("absent".into()), ..scene(id) };
    assert_eq!(groups(&[child("a"), child("b")], &LeakageRules::ALL).len(), 1);
}

#[test]
fn the_checker_finds_a_leak_of_every_kind() {
    let text = |id: &str| Shareable { text_sha256: Some("t".into()), ..scene(id) };
    let image = |id: &str| Shareable { image_sha256: Some("i".into()), ..scene(id) };
    let mesh = |id: &str| Shareable { mesh_sha256: vec!["m".into()], ..scene(id) };
    let child = Shareable { parent: Some("p".into()), ..scene("c") };
    let pairs = [
        (text("a"), text("b"), "text:t", LeakageRules { text: false, ..LeakageRules::ALL }),
        (image("a"), image("b"), "image:i", LeakageRules { image: false, ..LeakageRules::ALL }),
        (mesh("a"), mesh("b"), "mesh:m", LeakageRules { mesh: false, ..LeakageRules::ALL }),
        (scene("p"), child, "scene:p", LeakageRules { lineage: false, ..LeakageRules::ALL }),
    ];
    for (first, second, key, without) in pairs {
        let apart = [(first.clone(), "train".to_owned()), (second.clone(), "test".to_owned())];
        let together = [(first, "train".to_owned()), (second, "train".to_owned())];
        let keys: Vec<String> = leaks(&apart, &LeakageRules::ALL).into_iter().map(|leak| leak.key).collect();
        assert_eq!(keys, [key]);
        assert_eq!(leaks(&apart, &without), []);
        assert_eq!(leaks(&together, &LeakageRules::ALL), []);
    }
}

#[test]
fn another_seed_gives_another_assignment() {
    let groups: Vec<Group> = (0..20).map(|k| Group::of([format!("s{k}")])).collect();
    let of_seed = |seed| assign(&groups, &SplitPlan { seed, ..plan("a=0.5,b=0.5") }, &BTreeMap::new());
    assert_eq!(of_seed(1), of_seed(1));
    assert_ne!(of_seed(1), of_seed(2));
}

#[test]
fn groups_keep_the_split_that_the_majority_of_their_scenes_had() {
    let groups = [Group::of(["a", "b", "c"]), Group::of(["d"]), Group::of(["e", "f"]), Group::of(["g"])];
    let earlier = [("a", "test"), ("b", "train"), ("c", "train"), ("d", "test"), ("e", "gone")];
    let earlier = earlier.map(|(id, split)| (id.to_owned(), split.to_owned())).into();
    let assigned = assign(&groups, &plan("test=0.5,train=0.5"), &earlier);
    // Tests lack 2.5 scenes of the others, training half a scene.
    assert_eq!(assigned, ["train", "test", "test", "test"]);
    let tied = [("a", "train"), ("b", "test")].map(|(id, split)| (id.to_owned(), split.to_owned())).into();
    assert_eq!(assign(&groups[..1], &plan("test=0.5,train=0.5"), &tied), ["test"]);
}

#[test]
fn malformed_plans_are_refused_with_the_correction() {
    for (text, words) in [
        ("train", "NAME=RATIO"),
        ("train=0.5", "sum 1"),
        ("train=0.5,train=0.5", "given once"),
        ("train=1.5,test=-0.5", "from 0 to 1"),
        ("a/b=1", "lower-case"),
    ] {
        let error = text.parse::<SplitPlan>().expect_err(text).to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
    assert!("lineage,sound".parse::<LeakageRules>().is_err());
}
