//! Facts about a server: its queue, its catalog, its robots, and the schema of requests.

use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

#[tokio::test]
async fn the_queue_has_what_waits_and_who_works_on_what() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::with(&script, &[("worker.concurrency", "1")]).await;
    let empty = server.get("/queue").await.json();
    assert_eq!(empty, json!({ "paused": null, "kinds": [], "workers": [], "storage": "ok" }));
    let (scene, job) = server.submit("a mug").await;
    script.reaches("alpha").await;
    let mut waiting = Vec::new();
    for text in ["a bowl", "a vase"] {
        waiting.push(server.submit(text).await.1);
    }
    let queue = server.get("/queue").await.json();
    assert_eq!(queue["kinds"], json!([{ "kind": "generate", "waiting": 2, "running": 1 }]));
    let workers = queue["workers"].as_array().unwrap();
    assert_eq!(workers.len(), 1, "{queue}");
    let held = &workers[0]["jobs"];
    assert_eq!((&held[0]["job_id"], &held[0]["scene_id"]), (&json!(job), &json!(scene)));
    assert_eq!(workers[0]["since"], held[0]["since"]);
    let claimed = server.get(&format!("/jobs/{job}")).await.json();
    assert_eq!(held[0]["since"], claimed["started_at"]);
    script.open_gate();
    for job in [&job, &waiting[0], &waiting[1]] {
        server.job_is(job, "succeeded").await;
    }
    assert_eq!(server.get("/queue").await.json()["kinds"], json!([]));
}

#[tokio::test]
async fn the_catalog_and_the_robots_are_those_of_the_program() {
    let server = Server::start(&Script::new(&[])).await;
    let answer = server.get("/catalog").await;
    let document = answer.json();
    let listed = document["categories"].as_array().unwrap();
    assert_eq!(listed.len(), catalog::categories().len());
    let mug = listed.iter().find(|category| category["name"] == "mug").expect("there is a mug");
    let known = catalog::category("mug").expect("there is a mug");
    assert_eq!((&mug["label"], &mug["group"]), (&json!(known.label), &json!(known.group)));
    assert_eq!(mug["size"]["high_m"], json!(known.size.high_m.to_array()));
    assert!(mug["affordances"].as_array().unwrap().contains(&json!("graspable")), "{mug}");
    let headers = [("if-none-match", answer.header("etag"))];
    assert_eq!(server.call(Method::GET, "/catalog", &headers, "").await.status, 304);

    let robots = server.get("/robots").await.json();
    let panda = robots["robots"].as_array().unwrap().iter().find(|robot| robot["name"] == "panda");
    let panda = panda.expect("there is a panda");
    assert_eq!(panda["dof"], 7);
    assert_eq!(panda["gripper"]["max_opening_m"], 0.08);
    let model = server.get("/robots/panda/model").await;
    assert_eq!((model.header("content-type"), &model.body[..4]), ("model/gltf-binary", &b"glTF"[..]));
    let headers = [("if-none-match", model.header("etag"))];
    assert_eq!(server.call(Method::GET, "/robots/panda/model", &headers, "").await.status, 304);
    assert_eq!(server.get("/robots/hal/model").await.problem(), (404, "not_found".into()));
}

#[tokio::test]
async fn the_schema_of_requests_has_every_option_with_the_values_of_the_server() {
    let set = [("analyst.fewest_objects", "5")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let schema = server.get("/settings/schema").await.json();
    let options = schema["$defs"]["Options"]["properties"].as_object().expect("options");
    assert!(options.contains_key("max_objects") && options.contains_key("robot"), "{options:?}");
    assert_eq!(
        (&options["max_objects"]["minimum"], &options["max_objects"]["maximum"]),
        (&json!(1), &json!(64))
    );
    let settings = &schema["$defs"]["SceneSettings"]["properties"];
    let fewest = &settings["analyst.fewest_objects"];
    assert_eq!((&fewest["type"], &fewest["default"]), (&json!("integer"), &json!(5)));
    assert_eq!((&fewest["minimum"], &fewest["maximum"]), (&json!(1.0), &json!(64.0)));
    assert_eq!(settings["appraise.ratings"]["type"], "boolean");
    assert_eq!(schema["properties"]["options"]["$ref"], "#/$defs/Options");
    // Every reference leads somewhere.
    fn walk(value: &Value, schema: &Value) {
        if let Some(target) = value.get("$ref").and_then(Value::as_str) {
            assert!(schema.pointer(target.trim_start_matches('#')).is_some(), "{target}");
        }
        match value {
            Value::Object(map) => map.values().for_each(|value| walk(value, schema)),
            Value::Array(items) => items.iter().for_each(|value| walk(value, schema)),
            _ => {}
        }
    }
    walk(&schema, &schema);
}
