//! Recipes as clients write them: expansion, names, errors, and what holds for all.

use std::collections::BTreeSet;

use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;
use crate::request::check_custom_id;

fn recipe(document: &Value) -> Recipe {
    Recipe::parse(document.to_string().as_bytes()).unwrap_or_else(|errors| panic!("{document}: {errors}"))
}

fn expanded(document: &Value) -> Vec<BatchRequest> {
    recipe(document).requests().collect()
}

fn names(document: &Value) -> Vec<String> {
    expanded(document).into_iter().map(|request| request.custom_id).collect()
}

#[test]
fn a_recipe_is_the_product_of_templates_slots_options_and_seeds() {
    let document = json!({
        "templates": ["a {color} mug next to {count} spoons", "a plain table with {count} forks"],
        "slots": { "color": ["red", "dark blue"], "count": [2, "three"] },
        "seeds": { "first": 5, "count": 2 },
        "options": [{}, { "max_objects": 4 }],
        "labels": { "split": "train" },
    });
    let requests = expanded(&document);
    assert_eq!(requests.len(), (2 * 2 + 2) * 2 * 2);
    let shown: Vec<_> =
        requests.iter().map(|r| (r.custom_id.as_str(), r.body.text.as_deref().expect("a text"))).collect();
    assert_eq!(shown[0], ("t0_red_2_o0_s5", "a red mug next to 2 spoons"));
    assert_eq!(shown[1], ("t0_red_2_o0_s6", "a red mug next to 2 spoons"));
    assert_eq!(shown[2], ("t0_red_2_o1_s5", "a red mug next to 2 spoons"));
    assert_eq!(shown[4], ("t0_red_three_o0_s5", "a red mug next to three spoons"));
    assert_eq!(shown[8], ("t0_dark-blue_2_o0_s5", "a dark blue mug next to 2 spoons"));
    assert_eq!(shown[23], ("t1_three_o1_s6", "a plain table with three forks"));
    assert_eq!(requests[23].body.options.max_objects, Some(4));
    assert_eq!((requests[23].body.seed, requests[23].body.labels["split"].as_str()), (Some(6), "train"));
}

#[test]
fn options_and_seeds_are_named_where_they_vary() {
    assert_eq!(names(&json!({ "templates": ["a mug", "a cup"] })), ["t0", "t1"]);
    assert_eq!(names(&json!({ "templates": ["a mug"], "seeds": [9, 3], "options": {} })), ["t0_s9", "t0_s3"]);
    assert_eq!(expanded(&json!({ "templates": ["a mug"] }))[0].body.seed, None);
}

#[test]
fn long_names_are_cut_until_they_fit() {
    let long = |k: usize| format!("a very long description of an object, number {k}");
    let values: Vec<String> = (0..20).map(long).collect();
    for slot_count in [1, 2, 5, 12, 40] {
        let slot = |k: usize| format!("s{k}");
        let slots: serde_json::Map<String, Value> =
            (0..slot_count).map(|k| (slot(k), json!(values))).collect();
        let template: String = (0..slot_count).map(|k| format!("{{{}}} ", slot(k))).collect();
        let select = json!({ "mode": "sample", "count": 20, "seed": 1 });
        let mut document = json!({ "templates": [template], "slots": slots });
        if slot_count > 12 {
            // More combinations than a number can count are refused.
            document["slots"] = (0..slot_count)
                .map(|k| (slot(k), json!(["x", "y"])))
                .collect::<serde_json::Map<_, _>>()
                .into();
        }
        document["select"] = select;
        document["seeds"] = json!([scene::request::MAX_SEED]);
        let names = names(&document);
        assert!(names.iter().all(|name| check_custom_id(name).is_ok()), "{names:?}");
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), 20, "{names:?}");
    }
}

#[test]
fn wrong_recipes_state_every_place() {
    let template = || json!(["a {color} mug"]);
    let colors = || json!({ "color": ["red", "blue"] });
    let sample = |count: u64| json!({ "mode": "sample", "count": count, "seed": 0 });
    let many: Vec<usize> = (0..1001).collect();
    for (document, pointer, says) in [
        (json!({ "templates": ["a mug\u{7}"] }), "/templates/0", "control characters"),
        (json!({ "templates": ["x".repeat(4001)] }), "/templates/0", "at most 4000"),
        (json!({ "templates": ["a mug"], "options": [[null, null]] }), "/options/0", "must be an object"),
        (
            json!({ "templates": ["a mug"], "options": { "table": ["desk"] } }),
            "/options/table",
            "must be an object",
        ),
        (json!({ "templates": ["a mug"], "select": ["product"] }), "/select", "must be an object"),
        (json!({ "templates": ["a mug"], "labels": { "k": "\u{84}" } }), "/labels/k", "none of control"),
        (json!({ "templates": ["a mug"], "labels": { "a key": "v" } }), "/labels", "keys have"),
        (json!({}), "", "must have `templates`"),
        (json!([]), "", "must be an object"),
        (json!({ "templates": "a mug" }), "/templates", "must be a list"),
        (json!({ "templates": [] }), "/templates", "has no templates"),
        (json!({ "templates": ["a mug", 7] }), "/templates/1", "must be a string"),
        (json!({ "templates": ["a mug", " "] }), "/templates/1", "is empty"),
        (json!({ "templates": ["a mug", "a mug"] }), "/templates/1", "twice"),
        (json!({ "templates": ["a {color mug"], "slots": {} }), "/templates/0", "not closed"),
        (json!({ "templates": ["a mug}"] }), "/templates/0", "closes nothing"),
        (json!({ "templates": template() }), "/templates/0", "\"color\", which has no values"),
        (json!({ "templates": template(), "slots": { "color": [] } }), "/slots/color", "has no values"),
        (json!({ "templates": template(), "slots": { "color": "red" } }), "/slots/color", "must be a list"),
        (
            json!({ "templates": template(), "slots": { "color": ["red", null] } }),
            "/slots/color/1",
            "text or a number",
        ),
        (
            json!({ "templates": template(), "slots": { "color": ["red", " red"] } }),
            "/slots/color/1",
            "twice",
        ),
        (json!({ "templates": ["a mug"], "slots": colors() }), "/slots/color", "no template uses it"),
        (json!({ "templates": ["a mug"], "slots": { "a/b": [1] } }), "/slots/a~1b", "no template uses it"),
        (json!({ "templates": ["a mug"], "seeds": [] }), "/seeds", "is empty"),
        (json!({ "templates": ["a mug"], "seeds": [1, -1] }), "/seeds/1", "whole numbers"),
        (json!({ "templates": ["a mug"], "seeds": [1, 1] }), "/seeds/1", "twice"),
        (json!({ "templates": ["a mug"], "seeds": 7 }), "/seeds", "a list, or an object"),
        (json!({ "templates": ["a mug"], "seeds": { "first": 0 } }), "/seeds", "must have `count`"),
        (
            json!({ "templates": ["a mug"], "seeds": { "first": 0, "count": 0 } }),
            "/seeds/count",
            "at least 1",
        ),
        (
            json!({ "templates": ["a mug"], "seeds": { "first": 9, "count": u64::MAX } }),
            "/seeds",
            "whole numbers",
        ),
        (
            json!({ "templates": ["a mug"], "options": { "max_objects": 99 } }),
            "/options/max_objects",
            "1 to 64",
        ),
        (json!({ "templates": ["a mug"], "options": [{}, { "max": 1 }] }), "/options/1/max", "not known"),
        (json!({ "templates": ["a mug"], "options": [{}, {}] }), "/options/1", "twice"),
        (json!({ "templates": ["a mug"], "options": [] }), "/options", "is empty"),
        (json!({ "templates": ["a mug"], "select": { "mode": "all" } }), "/select/mode", "product"),
        (
            json!({ "templates": ["a mug"], "select": { "mode": "product", "count": 3 } }),
            "/select",
            "not known",
        ),
        (
            json!({ "templates": template(), "slots": colors(), "select": sample(3) }),
            "/select/count",
            "from 1 to 2",
        ),
        (
            json!({ "templates": ["a mug"], "select": { "mode": "sample", "count": 1 } }),
            "/select",
            "must have `seed`",
        ),
        (
            json!({ "templates": ["{a} {b}"], "slots": { "a": many, "b": many } }),
            "",
            "makes 1002001 requests; at most 1000000",
        ),
        (
            json!({ "templates": ["a mug"], "seeds": { "first": 0, "count": 1_000_001 } }),
            "",
            "makes 1000001 requests",
        ),
        (json!({ "templates": ["a mug"], "text": "x" }), "/text", "not known"),
    ] {
        let errors = Recipe::parse(document.to_string().as_bytes()).expect_err(&document.to_string()).0;
        let found = errors.iter().any(|error| error.pointer == pointer && error.detail.contains(says));
        assert!(found, "{document}: {errors:?}");
    }
    let malformed = Recipe::parse(b"{\n\"templates\": [").expect_err("no JSON").to_string();
    assert!(malformed.contains("line 2, column 14"), "{malformed}");
}

#[test]
fn all_errors_are_found_at_once() {
    let document = json!({ "templates": ["a {x mug", ""], "slots": { "y": [] }, "seeds": [] });
    let errors = Recipe::parse(document.to_string().as_bytes()).expect_err("wrong").0;
    let pointers: Vec<&str> = errors.iter().map(|error| error.pointer.as_str()).collect();
    assert_eq!(pointers, ["/slots/y", "/templates/0", "/templates/1", "/slots/y", "/seeds"]);
}

/// Recipes with one or two templates over two slots.
fn documents() -> impl Strategy<Value = Value> {
    let values = || prop::collection::btree_set("[a-c]{1,2}", 1..5);
    let templates = prop::sample::subsequence(vec!["{a} mug", "cup {b}", "{b} on {a}"], 1..=3);
    (templates, values(), values(), 1_u64..4, any::<bool>()).prop_map(
        |(templates, a, b, count, has_options)| {
            let uses = |slot: &str| templates.iter().any(|template| template.contains(slot));
            let mut slots = serde_json::Map::new();
            for (name, values) in [("a", a), ("b", b)] {
                if uses(&format!("{{{name}}}")) {
                    slots.insert(name.to_owned(), json!(values));
                }
            }
            let options = if has_options { json!([{}, { "max_objects": 9 }]) } else { json!({}) };
            let seeds = json!({ "first": 3, "count": count });
            json!({ "templates": templates, "slots": slots, "seeds": seeds, "options": options })
        },
    )
}

proptest! {
    #[test]
    fn a_recipe_gives_the_same_distinct_requests_every_time(document in documents()) {
        let requests = expanded(&document);
        prop_assert_eq!(&requests, &expanded(&document));
        let names: BTreeSet<&str> = requests.iter().map(|request| request.custom_id.as_str()).collect();
        let contents: BTreeSet<_> = requests.iter().map(|request| request.body.digest()).collect();
        prop_assert_eq!((names.len(), contents.len()), (requests.len(), requests.len()));
        prop_assert!(requests.iter().all(|request| request.violations().is_empty()));
    }

    #[test]
    fn a_sample_has_distinct_requests_of_the_product(
        document in documents(),
        share in 0.01_f64..=1.0,
        seed in 0_u64..99,
    ) {
        let all: Vec<BatchRequest> = expanded(&document);
        let count = ((all.len() as f64 * share).ceil() as usize).min(all.len());
        let mut sampled = document;
        sampled["select"] = json!({ "mode": "sample", "count": count, "seed": seed });
        let requests = expanded(&sampled);
        prop_assert_eq!(&requests, &expanded(&sampled));
        let contents: BTreeSet<_> = requests.iter().map(|request| request.body.digest()).collect();
        prop_assert_eq!((requests.len(), contents.len()), (count, count));
        prop_assert!(requests.iter().all(|request| all.contains(request)));
    }
}
