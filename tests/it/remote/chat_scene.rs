//! A whole scene with the analyst behind a chat endpoint: the server inspects the render as a model would,
//! and everything else is the embedded adapters' work.

use std::io::Cursor;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use glam::DVec3;
use ports::{ImageAnnotations, Truth};
use runtime::CpuPool;
use scene::{Scene, SceneId, StandsOn};
use serde_json::{Value, json};
use store::{DEFAULT_TENANT, Store};
use tabletopgen::app::instructions::Reading;
use tabletopgen::app::pipeline;

use crate::harness::server::{Server, reading, settings};
use crate::remote::chat_answers;
use crate::remote::chat_server::{Answers, ChatServer, Fault};
use crate::remote::instructions::instruction_of;

/// The store and the scene that is being made.
type Made = Arc<OnceLock<(Store, SceneId)>>;

async fn artifact(made: &Made, name: &str) -> Vec<u8> {
    loop {
        if let Some((store, scene_id)) = made.get()
            && let Some(row) = store.artifact(&DEFAULT_TENANT, scene_id, name).await.unwrap()
        {
            return store.blobs().get(&row.file.digest).await.unwrap().unwrap().to_vec();
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// A good model: it reads the image off what its image generator knows, with angles to half a degree, boxes to a
/// thousandth and sizes to a millimeter.
fn good_model(made: Made) -> Answers {
    Arc::new(move |schema, asked| {
        let made = made.clone();
        Box::pin(async move {
            match schema.as_str() {
                "describe" => return chat_answers::answer("describe"),
                "read_edit" | "read_task" => return read(&instruction_of(&asked)),
                _ => {}
            }
            let known: ImageAnnotations =
                serde_json::from_slice(&artifact(&made, "reference/known.json").await).unwrap();
            match schema.as_str() {
                "recognize" => recognized(&known),
                "measure" => measured(&known),
                "stacking" => stacked(&known),
                // It does not see the meshes: of those that are turned, what it says is wrong.
                other => chat_answers::answer(other),
            }
        })
    })
}

/// The program of an instruction.
fn read(instruction: &str) -> Value {
    let program = |fields: Value| {
        let mut statement = json!({ "words": instruction });
        statement.as_object_mut().expect("an object").extend(fields.as_object().expect("an object").clone());
        json!({ "statements": [statement], "not_understood": [], "asides": [] })
    };
    match instruction {
        "the cutlery has to go" => program(json!({ "op": "remove", "target": "fork_1" })),
        "fruit off the dish, onto the wood" => program(json!({
            "predicate": "off", "object": "apple_1", "target": "plate_1", "second_target": null,
        })),
        "say nothing" => json!({ "statements": [], "not_understood": [], "asides": [] }),
        _ => json!({ "statements": [], "not_understood": [instruction], "asides": [] }),
    }
}

fn recognized(known: &ImageAnnotations) -> Value {
    let (seen, camera) = (&known.recognition, &known.recognition.camera);
    let (width, height) = (f64::from(camera.width_px), f64::from(camera.height_px));
    let in_thousandths = |[x0, y0, x1, y1]: [f64; 4]| {
        let part = |value: f64, whole: f64| (1000.0 * value / whole).round();
        json!({ "x0": part(x0, width), "y0": part(y0, height), "x1": part(x1, width), "y1": part(y1, height) })
    };
    let objects: Vec<Value> = seen
        .objects
        .iter()
        .zip(&known.masks)
        .map(|(object, mask)| {
            let place = mask.visible.bbox_px().expect("shows").map(f64::from);
            json!({
                "name": object.id, "label": object.label, "category": object.category, "box": in_thousandths(place),
            })
        })
        .collect();
    let size = seen.table.size_m;
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| {
        camera.project(DVec3::new(x * size.x, y * size.y, 0.0)).expect("is before the camera").0
    });
    let low = corners.iter().fold(glam::DVec2::INFINITY, |low, corner| low.min(*corner));
    let high = corners.iter().fold(glam::DVec2::NEG_INFINITY, |high, corner| high.max(*corner));
    let half_degrees = |angle: f64| (2.0 * angle.to_degrees()).round() / 2.0;
    json!({
        "table": {
            "label": seen.table.label, "model": seen.table.model,
            "box": in_thousandths([low.x, low.y, high.x, high.y]),
        },
        "camera": {
            "elevation_deg": half_degrees(camera.elevation_rad()),
            "azimuth_deg": half_degrees(camera.azimuth_rad()),
            "horizontal_fov_deg": half_degrees(2.0 * (0.5 * width / camera.fx).atan()),
        },
        "objects": objects,
    })
}

fn measured(known: &ImageAnnotations) -> Value {
    let rounded = |value: f64| (1000.0 * value).round() / 1000.0;
    let sized = |size: DVec3| {
        json!({
            "width_m": rounded(size.x), "depth_m": rounded(size.y), "height_m": rounded(size.z), "color": null,
            "material": null,
        })
    };
    let objects: Vec<Value> = known
        .recognition
        .objects
        .iter()
        .map(|object| {
            let mut answer = sized(object.size_m);
            answer["name"] = json!(object.id);
            answer
        })
        .collect();
    json!({ "table": sized(known.recognition.table.size_m), "objects": objects })
}

fn stacked(known: &ImageAnnotations) -> Value {
    let objects: Vec<Value> = known
        .recognition
        .objects
        .iter()
        .map(|object| {
            let (relation, carrier) = match &object.stands_on {
                StandsOn::Table => ("on", "table"),
                StandsOn::On(id) => ("on", id.as_str()),
                StandsOn::In(id) => ("in", id.as_str()),
            };
            json!({ "name": object.id, "relation": relation, "carried_by": carrier })
        })
        .collect();
    json!({ "objects": objects })
}

async fn instructions_are_read_by_the_model_and_paid_once(
    server: &Server,
    chat: &ChatServer,
    scene_id: &str,
) {
    // The job of the edit asks for ratings meanwhile.
    let paid = || {
        let bill = chat.bill();
        bill.iter().filter(|billed| billed.schema.starts_with("read_")).count()
    };
    let edits = format!("/scenes/{scene_id}/edits");
    let words = json!({ "text": "the cutlery has to go", "seed": 1 });
    let edit = server.post(&edits, words.clone()).await;
    assert_eq!(edit.status, 202, "{edit:?}");
    assert_eq!(
        edit.json()["request"]["input"]["operations"],
        json!([{ "op": "remove", "target": "fork_1" }])
    );
    // The same instruction about the same scene is the same question.
    let validated =
        server.post(&format!("{edits}/validate"), json!({ "text": "the cutlery has to go" })).await;
    assert_eq!(
        validated.json()["prediction"]["operations"][0]["objects"],
        json!(["fork_1"]),
        "{validated:?}"
    );
    assert_eq!(paid(), 1);
    let tasks = format!("/scenes/{scene_id}/tasks?text=fruit%20off%20the%20dish,%20onto%20the%20wood");
    let task = server.get(&tasks).await;
    let goal = json!([{ "predicate": "off", "object": "apple_1", "target": "plate_1" }]);
    assert_eq!(task.json()["instructed"]["goal"], goal, "{task:?}");
    let order = json!({ "text": "fruit off the dish, onto the wood" });
    let execution = server.post(&format!("/scenes/{scene_id}/executions"), order).await;
    assert_eq!(execution.status, 202, "{execution:?}");
    assert_eq!(paid(), 2, "a task is read once, whoever asks");
    let refused = server.post(&edits, json!({ "text": "fry the apple" })).await;
    assert_eq!(refused.problem(), (422, "invalid_body".into()));
    assert!(refused.json()["errors"][0]["detail"].as_str().unwrap().contains("fry the apple"), "{refused:?}");
    let scene = server.get(&format!("/scenes/{scene_id}")).await.json();
    let calls = scene["spending"]["calls"].as_array().unwrap();
    let read: Vec<&Value> = calls.iter().filter(|call| call["stage"] == "instruction").collect();
    let operations: Vec<&Value> = read.iter().map(|call| &call["operation"]).collect();
    assert_eq!(operations, ["read_edit", "read_task", "read_edit"]);
    assert!(
        read.iter().all(|call| call["outcome"] == "answered" && call["settled_usd"] == 0.006),
        "{read:?}"
    );
    // An answer that cannot be used is not kept: the model is asked again, and once more to repair it.
    let app = reading(&settings(&[
        ("providers.analyst", "chat"),
        ("providers.allow_http", "true"),
        ("providers.private_hosts", "127.0.0.1"),
        ("providers.chat.base_url", &chat.base_url),
        ("providers.chat.key_variable", ""),
    ]));
    for asked in [2, 4] {
        let (cpu, scene) = (CpuPool::new(1).unwrap(), scene_id.parse().unwrap());
        let about = Reading::about(&app, server.store(), cpu, &DEFAULT_TENANT, &scene).await.unwrap();
        let unusable = app.read_edit("say nothing".into(), Arc::new([]), &about).await.unwrap_err();
        assert_eq!(unusable.code, "provider_bad_answer", "{unusable:?}");
        assert_eq!(paid(), 3 + asked);
    }
    // The account of the edit says which words ask for what.
    let job = server.job_ends(edit.json()["job"]["id"].as_str().unwrap(), Duration::from_secs(300)).await;
    assert_eq!(job["state"], "succeeded", "{job}");
    let edited = server.get(&format!("/scenes/{}", edit.json()["id"].as_str().unwrap())).await.json();
    assert_eq!(edited["summary"]["edit"]["operations"][0]["words"], "the cutlery has to go", "{edited}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_scene_is_made_with_an_analyst_behind_a_chat_endpoint() {
    let made = Made::default();
    let chat = ChatServer::start(good_model(made.clone())).await;
    // Trouble on the way changes nothing but the bill.
    chat.script([Fault::Status(503), Fault::Fenced]);
    let resolved = settings(&[
        ("worker.cpu_threads", "0"),
        ("providers.analyst", "chat, embedded"),
        ("providers.allow_http", "true"),
        ("providers.private_hosts", "127.0.0.1"),
        ("providers.chat.base_url", &chat.base_url),
        ("providers.chat.key_variable", ""),
        ("providers.chat.pause_base_ms", "2"),
        ("appraise.ratings", "true"),
        ("appraise.tasks", "2"),
    ]);
    let build = pipeline::build_pipeline(&resolved).unwrap();
    let server = Server::building(build, &resolved).await;
    let text = "an apple on a plate and a fork beside it";
    let (scene_id, job_id) = server.submit(text).await;
    made.set((server.store().clone(), scene_id.parse().unwrap())).ok().unwrap();
    let job = server.job_ends(&job_id, Duration::from_secs(300)).await;
    assert_eq!(job["state"], "succeeded", "{job}");

    let scene = server.get(&format!("/scenes/{scene_id}")).await.json();
    assert_eq!((&scene["state"], &scene["verdict"]), (&json!("ready"), &json!("pass")), "{scene}");
    let calls = scene["spending"]["calls"].as_array().unwrap();
    let written: Vec<(&str, &str, &str)> = calls
        .iter()
        .map(|call| {
            let word = |name: &str| call[name].as_str().unwrap();
            (word("stage"), word("operation"), word("outcome"))
        })
        .collect();
    assert_eq!(
        written,
        [
            ("reference", "describe", "provider_server_error"),
            ("reference", "describe", "answered"),
            ("recognize", "recognize", "answered"),
            ("recognize", "measure", "answered"),
            ("recognize", "stacking", "answered"),
            ("canonicalize", "upright", "answered"),
            ("canonicalize", "upright", "answered"),
            ("canonicalize", "upright", "answered"),
            ("certify", "judge_text", "answered"),
            ("certify", "propose_tasks", "answered"),
        ]
    );
    assert_eq!(scene["spending"]["spent_usd"], 0.006 * chat.bill().len() as f64);

    let truth: Truth = serde_json::from_slice(&artifact(&made, "reference/truth.json").await).unwrap();
    let archive = server.get(&format!("/scenes/{scene_id}/bundle")).await.body;
    let mut archive = zip::ZipArchive::new(Cursor::new(archive)).unwrap();
    let names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    let name = names.iter().find(|name| name.ends_with("scene.json")).expect("is in the bundle");
    let built: Scene = serde_json::from_reader(archive.by_name(name).unwrap()).unwrap();
    let name = names.iter().find(|name| name.ends_with("report.json")).expect("is in the bundle");
    let report: Value = serde_json::from_reader(archive.by_name(name).unwrap()).unwrap();
    assert_eq!(report["appraisal"]["ratings"]["prompt"], "judge_text 1");
    assert_eq!(report["appraisal"]["ratings"]["said"][2]["score"], 7);
    assert_eq!(report["appraisal"]["tasks"]["said"][1]["objects"], json!(["apple_1", "fork_1"]));
    assert!(report["appraisal"].get("missing").is_none(), "{report}");
    assert_eq!(built.instances.len(), 3);
    for instance in &built.instances {
        let rendered = truth.instances.iter().find(|rendered| rendered.name == instance.name).unwrap();
        let off_m = (rendered.translation_m - instance.world_from_object.translation_m).length();
        assert!(off_m < 0.02, "{} is {off_m} m from where it was painted", instance.name);
    }
    instructions_are_read_by_the_model_and_paid_once(&server, &chat, &scene_id).await;
    // The model still holds the store, so its lock stays for as long as that.
    server.service.stop().await.unwrap();
}
