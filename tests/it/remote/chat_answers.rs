//! Answers of the chat server: a fork beside an apple on a plate, asked for in words or seen in an image.

use std::sync::Arc;

use serde_json::{Value, json};

use crate::remote::chat_server::Answers;

/// Always the same table.
pub fn breakfast() -> Answers {
    Arc::new(|schema, _| Box::pin(async move { answer(&schema) }))
}

/// The answer to one question.
pub fn answer(schema: &str) -> Value {
    match schema {
        "describe" => description(),
        "recognize" | "recognize_named" => seen(),
        "measure" => sizes(),
        "stacking" => stacking(),
        "check_top" => json!({
            "straight_down": true, "no_perspective": true, "front_below": true, "all_there": true, "none_added": false,
            "told": "leave the spoon out",
        }),
        "upright" => json!({ "top": "top", "front": "front" }),
        "judge_picture" => ratings(&["visual_fidelity", "image_alignment", "physical_plausibility"]),
        "judge_text" => {
            ratings(&["consistency_with_text", "object_quality", "layout_coherence", "physical_plausibility"])
        }
        "propose_tasks" => json!({ "tasks": [
            { "instruction": "Put the apple beside the plate.", "kind": "pick_and_place", "objects": ["apple_1", "plate_1"] },
            { "instruction": "Swap apple and fork.", "kind": "swap", "objects": ["apple_1", "fork_1"] },
        ] }),
        other => panic!("nobody asks for {other}"),
    }
}

fn ratings(criteria: &[&str]) -> Value {
    let mut answer = json!({});
    for (criterion, score) in criteria.iter().zip([6, 5, 7, 4]) {
        answer[*criterion] = json!({ "score": score, "why": "It looks like it." });
    }
    answer
}

fn description() -> Value {
    let object = |name: &str, category: &str, size: [f64; 3], relations: Value| {
        json!({
            "name": name, "label": category, "category": category, "width_m": size[0], "depth_m": size[1],
            "height_m": size[2], "color": null, "material": null, "requested": true, "relations": relations,
        })
    };
    json!({
        "theme": "breakfast_table", "family": "dining_kitchen",
        "table": {
            "model": "dining_table", "material": "oak", "color": null, "width_m": 1.4, "depth_m": 0.8, "height_m": 0.74,
        },
        "objects": [
            object("plate_1", "plate", [0.26, 0.26, 0.025], json!([{ "kind": "at_front", "target": null }])),
            object("apple_1", "apple", [0.08, 0.08, 0.08], json!([{ "kind": "on", "target": "plate_1" }])),
            object("fork_1", "fork", [0.025, 0.19, 0.02], json!([{ "kind": "left_of", "target": "plate_1" }])),
        ],
        "unrecognized_terms": [], "prose": "An apple on a plate, a fork beside it.",
    })
}

fn seen() -> Value {
    let object = |name: &str, category: &str, [x0, y0, x1, y1]: [u32; 4]| {
        let place = json!({ "x0": x0, "y0": y0, "x1": x1, "y1": y1 });
        json!({ "name": name, "label": category, "category": category, "box": place })
    };
    json!({
        "table": {
            "label": "dining table", "model": "dining_table",
            "box": { "x0": 100, "y0": 300, "x1": 900, "y1": 800 },
        },
        "camera": { "elevation_deg": 45, "azimuth_deg": 5, "horizontal_fov_deg": 35 },
        "objects": [
            object("plate_1", "plate", [420, 500, 580, 620]),
            object("apple_1", "apple", [470, 480, 530, 560]),
            object("fork_1", "fork", [380, 500, 400, 620]),
        ],
    })
}

fn sizes() -> Value {
    let size = |size: [f64; 3], material: &str| {
        json!({
            "width_m": size[0], "depth_m": size[1], "height_m": size[2], "color": "#c0c0c0", "material": material,
        })
    };
    let named = |name: &str, extents: [f64; 3], material: &str| {
        let mut object = size(extents, material);
        object["name"] = json!(name);
        object
    };
    json!({
        "table": size([1.4, 0.8, 0.74], "oak"),
        "objects": [
            named("plate_1", [0.26, 0.26, 0.025], "ceramic"),
            named("apple_1", [0.08, 0.08, 0.08], "fruit"),
            named("fork_1", [0.025, 0.19, 0.02], "steel"),
        ],
    })
}

fn stacking() -> Value {
    json!({
        "objects": [
            { "name": "plate_1", "relation": "on", "carried_by": "table" },
            { "name": "apple_1", "relation": "on", "carried_by": "plate_1" },
            { "name": "fork_1", "relation": "on", "carried_by": "table" },
        ],
    })
}
