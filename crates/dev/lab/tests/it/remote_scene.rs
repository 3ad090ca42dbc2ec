//! Whole scenes whose every question goes over the network to the mock vendors. They match the scenes of the
//! embedded adapters for the same text or image, and a recording replays to the same scene, byte for byte.

use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use lab::app::mock_vendors;
use scene::Scene;
use serde_json::{Value, json};
use tabletopgen::app::pipeline;
use tabletopgen::config::{Resolved, Sources, layers};

use crate::harness::server::{Server, settings};

/// Seed of every request and of the mock server.
const SEED: u64 = 7;

/// A finished scene with the service's responses.
struct Made {
    /// `GET /scenes/{id}`.
    shown: Value,
    scene: Scene,
    bundle: Bytes,
}

impl Made {
    async fn of(resolved: &Resolved, request: &Value) -> Self {
        let server = Server::building(pipeline::build_pipeline(resolved).unwrap(), resolved).await;
        let reply = server.post("/scenes", request.clone()).await;
        assert_eq!(reply.status, 202, "{reply:?}");
        let (scene_id, job_id) = {
            let scene = reply.json();
            (scene["id"].as_str().unwrap().to_owned(), scene["job"]["id"].as_str().unwrap().to_owned())
        };
        let job = server.job_ends(&job_id, Duration::from_secs(600)).await;
        assert_eq!(job["state"], "succeeded", "{job}");
        let shown = server.get(&format!("/scenes/{scene_id}")).await.json();
        assert_eq!((&shown["state"], &shown["verdict"]), (&json!("ready"), &json!("pass")), "{shown}");
        let bundle = server.get(&format!("/scenes/{scene_id}/bundle")).await.body;
        let scene = serde_json::from_value(json_in(&bundle, "scene.json")).unwrap();
        server.stop().await;
        Self { shown, scene, bundle }
    }

    fn report(&self) -> Value {
        json_in(&self.bundle, "report.json")
    }

    /// Number of calls of this operation.
    fn count(&self, operation: &str) -> usize {
        let calls = self.shown["spending"]["calls"].as_array().unwrap();
        calls.iter().filter(|call| call["operation"] == operation).count()
    }

    /// `stage operation` of every call, each once, in the order of the first.
    fn operations(&self) -> Vec<String> {
        let mut operations: Vec<String> = Vec::new();
        for call in self.shown["spending"]["calls"].as_array().unwrap() {
            let operation =
                format!("{} {}", call["stage"].as_str().unwrap(), call["operation"].as_str().unwrap());
            if !operations.contains(&operation) {
                operations.push(operation);
            }
        }
        operations
    }
}

/// A file of a bundle.
fn json_in(bundle: &Bytes, file: &str) -> Value {
    let mut archive = zip::ZipArchive::new(Cursor::new(bundle.clone())).unwrap();
    let names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    let name = names.iter().find(|name| name.ends_with(file)).expect("is in the bundle");
    serde_json::from_reader(archive.by_name(name).unwrap()).unwrap()
}

/// The embedded adapters alone.
fn embedded() -> Resolved {
    settings(&[("worker.cpu_threads", "0")])
}

/// Settings in which every port's first provider is at this address.
fn remote(address: &str, more: &[(&str, &str)]) -> Resolved {
    let (v1, root) = (format!("http://{address}/v1"), format!("http://{address}"));
    let mut set = vec![
        ("worker.cpu_threads", "0"),
        ("providers.analyst", "chat, embedded"),
        ("providers.image_generator", "openai_images, embedded"),
        ("providers.segmenter", "sidecar"),
        ("providers.mesh_generator", "replicate, embedded"),
        ("providers.allow_http", "true"),
        ("providers.private_hosts", "127.0.0.1"),
        ("providers.chat.base_url", &v1),
        ("providers.openai_images.base_url", &v1),
        ("providers.openai_images.calls_per_minute", "1000000"),
        ("providers.segmenter_sidecar.base_url", &root),
        ("providers.replicate.base_url", &v1),
        ("providers.replicate.poll_interval_ms", "20"),
        ("providers.hunyuan3d.base_url", &root),
        ("providers.hunyuan3d.poll_interval_ms", "20"),
        ("appraise.ratings", "true"),
        ("appraise.tasks", "3"),
    ];
    set.extend(more);
    settings(&set)
}

/// Settings that replay the recording of the repository.
fn breakfast() -> Resolved {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/fixtures/cassettes");
    let archive = folder.join("breakfast.zip").display().to_string();
    let arguments = [
        ("server.listen", "127.0.0.1:0"),
        ("store.fsync", "false"),
        ("providers.mode", "replay"),
        ("providers.cassette", &archive),
    ];
    let arguments = arguments.map(|(key, value)| (key.to_owned(), value.to_owned(), "--set")).into();
    let file = Some(folder.join("breakfast.toml"));
    layers::load(Sources { file, arguments, ..Sources::default() }).unwrap()
}

async fn mock_server() -> mock_vendors::Running {
    let resolved = embedded();
    let providers = mock_vendors::providers(&resolved, SEED, Duration::ZERO).unwrap();
    mock_vendors::start(&resolved, "127.0.0.1:0", providers).await.unwrap()
}

/// Largest differences between two scenes: position, meters; relative size; yaw, degrees, modulo the symmetry and
/// modulo 1/`turns` of a full turn, or a quarter turn if an object is nearly square and `turns` > 1, because a fit
/// to one view cannot distinguish these.
fn apart(a: &Scene, b: &Scene, turns: f64) -> (f64, f64, f64) {
    let names = |scene: &Scene| {
        let mut names: Vec<String> =
            scene.instances.iter().map(|instance| instance.name.to_string()).collect();
        names.sort();
        names
    };
    assert_eq!(names(a), names(b));
    let mut worst = (0.0_f64, 0.0_f64, 0.0_f64);
    for one in &a.instances {
        let other = b.instances.iter().find(|other| other.name == one.name).unwrap();
        let (p, q) = (one.world_from_object, other.world_from_object);
        worst.0 = worst.0.max((p.translation_m - q.translation_m).length());
        worst.1 = worst.1.max((one.size_m / other.size_m - 1.0).abs().max_element());
        if let (Some(yaw), Some(same), true) = (one.yaw_rad, other.yaw_rad, one.symmetry_order > 0) {
            let is_nearly_square =
                one.size_m.truncate().max_element() < 1.2 * one.size_m.truncate().min_element();
            let turns = if turns > 1.0 && is_nearly_square { 4.0 } else { turns };
            let period = std::f64::consts::TAU / f64::from(one.symmetry_order).max(turns);
            let off = (yaw - same).rem_euclid(period);
            worst.2 = worst.2.max(off.min(period - off).to_degrees());
        }
    }
    worst
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn text_scene_over_network_matches_embedded_and_replays() {
    let request = json!({ "text": "an apple on a plate and a fork beside it", "seed": SEED });
    let there = mock_server().await;
    let address = there.address.to_string();
    let recording = tempfile::tempdir().unwrap();
    let place = recording.path().to_str().unwrap();
    let recorded = remote(&address, &[("providers.mode", "record"), ("providers.cassette", place)]);
    there.providers.invalid_top_views.store(1, Ordering::Relaxed);
    let over_network = Made::of(&recorded, &request).await;
    assert_eq!(over_network.count("top_view"), 2, "the first drawing was refused");
    assert_eq!(over_network.count("check_top"), 2);
    assert_eq!(
        over_network.operations(),
        [
            "reference describe",
            "reference paint",
            "recognize recognize",
            "recognize measure",
            "recognize stacking",
            "segment segment",
            "complete redraw",
            "reconstruct reconstruct",
            "canonicalize upright",
            "place top_view",
            "place check_top",
            "place segment",
            "certify judge_text",
            "certify propose_tasks",
        ]
    );
    let billed = there.providers.bill.lines().len();
    assert!(over_network.shown["spending"]["spent_usd"].as_f64().unwrap() > 0.0);
    let appraisal = over_network.report()["appraisal"].clone();
    let scores = appraisal["ratings"]["said"].as_array().unwrap();
    assert!(
        scores.len() == 4 && scores.iter().all(|rating| rating["score"].as_u64().unwrap() > 3),
        "{appraisal}"
    );
    assert_eq!(appraisal["tasks"]["said"].as_array().unwrap().len(), 3, "{appraisal}");
    there.stop().await;

    // The address has no listener any more.
    let played = remote(&address, &[("providers.mode", "replay"), ("providers.cassette", place)]);
    let again = Made::of(&played, &request).await;
    assert!(again.bundle == over_network.bundle, "the bundle is another");
    assert_eq!(again.shown["spending"]["spent_usd"], 0.0);
    assert_eq!(again.shown["spending"]["calls"].as_array().unwrap().len(), billed);

    let alone = Made::of(&embedded(), &request).await;
    let (place_m, size, yaw_deg) = apart(&alone.scene, &over_network.scene, 1.0);
    eprintln!("text: {place_m} m, {size}, {yaw_deg} degrees");
    assert!(place_m < 0.02 && size < 0.05 && yaw_deg < 10.0, "{place_m} m, {size}, {yaw_deg} degrees");
}

/// On "not recorded": `python -m tabletopgen_checks.service.cassette` records it again.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn bundled_recording_replays() {
    let request = json!({ "text": "an apple on a plate and a fork beside it", "seed": SEED });
    let made = Made::of(&breakfast(), &request).await;
    let names: BTreeSet<&str> = made.scene.instances.iter().map(|instance| instance.name.as_str()).collect();
    assert_eq!(names, ["apple_1", "fork_1", "plate_1"].into());
    assert_eq!(made.shown["spending"]["spent_usd"], 0.0);
    for operation in
        ["canonicalize upright", "place check_top", "certify judge_text", "certify propose_tasks"]
    {
        assert!(made.operations().contains(&operation.to_owned()), "{operation}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn image_scene_over_network_matches_embedded() {
    let image = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../docs/demo_table.png")).unwrap();
    let request = json!({ "image": { "base64": STANDARD.encode(image) }, "seed": SEED });
    let there = mock_server().await;
    let address = there.address.to_string();
    let ark = format!("http://{address}/api/v3");
    // Ark generates the top view, and objects on a uniform background.
    let others = [
        ("providers.mesh_generator", "hunyuan3d, embedded"),
        ("providers.image_generator", "ark, embedded"),
        ("providers.ark.base_url", &ark),
    ];
    let over_network = Made::of(&remote(&address, &others), &request).await;
    let providers: BTreeSet<&str> = over_network.shown["spending"]["calls"]
        .as_array()
        .unwrap()
        .iter()
        .map(|call| call["provider"].as_str().unwrap())
        .collect();
    assert!(over_network.operations().contains(&"certify judge_picture".to_owned()));
    let asked = ["ark/seedream", "hunyuan3d/server", "openai/chat", "sidecar/segmenter"];
    assert_eq!(providers, asked.into());
    there.stop().await;
    let alone = Made::of(&embedded(), &request).await;
    // A solid fitted to one view is symmetric front to back.
    let (place_m, size, yaw_deg) = apart(&alone.scene, &over_network.scene, 2.0);
    eprintln!("picture: {place_m} m, {size}, {yaw_deg} degrees");
    assert!(place_m < 0.03 && size < 0.1 && yaw_deg < 10.0, "{place_m} m, {size}, {yaw_deg} degrees");
}
