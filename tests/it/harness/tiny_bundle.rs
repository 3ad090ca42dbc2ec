//! A pipeline of one stage that packs a whole, tiny bundle: enough for what reads bundles.
//!
//! A text that contains `quarantine` fails its certificate, and one with `render` has a real image. Every text has a
//! mesh of its own.

use std::collections::BTreeMap;
use std::sync::Arc;

use export::BundleFile;
use scene::SceneRequest;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use store::artifacts::{ArchiveRow, FileRow};
use tabletopgen::pipeline::checkpoint::{ArtifactRef, Stage, StageContext};
use tabletopgen::pipeline::error::StageError;
use tabletopgen::worker::{BuildScene, BuiltScene, JobContext};

const PACK: Stage = Stage { name: "pack", version: 1 };

#[derive(Serialize)]
struct Inputs {
    request: SceneRequest,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Output {
    archive: ArtifactRef,
    files: Vec<(String, String, String, u64)>,
}

/// As the worker takes it.
pub fn build() -> BuildScene {
    Arc::new(|context| Box::pin(build_scene(context)))
}

async fn build_scene(context: JobContext) -> Result<BuiltScene, StageError> {
    let stages = context.checkpoints.for_stages(&[PACK.name], Arc::new(()));
    let passed = passes(&context.request);
    let output = stages.run(PACK, Inputs { request: context.request }, pack).await?;
    let archive = ArchiveRow { digest: output.archive.digest, size: output.archive.size };
    Ok(BuiltScene {
        archive,
        files: output.files.into_iter().map(row).collect(),
        passed,
        reasons: if passed { vec![] } else { vec!["mug_1 floats".into()] },
        summary: json!({ "objects": 1 }),
        metrics: json!({ "col_o": 0.0, "col_s": 0.0, "ss": 1.0, "dss_shipped": 1.0 }),
    })
}

async fn pack(context: StageContext<()>, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let archive = export::zip_bundle(&files(&inputs.request)).expect("packs");
    let mut listed = export::archive::manifest_entries(&archive).expect("is a bundle");
    listed.extend([export::archive::manifest_itself(&archive).expect("is a bundle")]);
    let files =
        listed.into_iter().map(|(path, entry)| (path, entry.sha256, entry.media_type, entry.size)).collect();
    Ok(Output { archive: context.put("all.zip", "application/zip", archive).await?, files })
}

fn row((name, digest, media_type, size): (String, String, String, u64)) -> FileRow {
    FileRow { name, digest: store::Digest::parse(&digest).expect("is a digest"), media_type, size }
}

/// Red on the left, blue on the right.
fn render() -> Vec<u8> {
    let mut image = imaging::Image::filled(800, 600, [255, 0, 0, 255]);
    (0..600).for_each(|y| (400..800).for_each(|x| image.set_pixel(x, y, [0, 0, 255, 255])));
    imaging::codec::encode_png(&image)
}

fn passes(request: &SceneRequest) -> bool {
    !request.input.text().unwrap_or_default().contains("quarantine")
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

fn files(request: &SceneRequest) -> Vec<BundleFile> {
    let id = sha256(json!(request).to_string().as_bytes())[..12].to_owned();
    let (verdict, reasons) = match passes(request) {
        true => ("pass", json!([])),
        false => {
            ("quarantine", json!([{ "code": "floats", "bodies": ["mug_1"], "sentence": "mug_1 floats" }]))
        }
    };
    let report =
        json!({ "format": "tabletopgen-report/1", "scene": id, "verdict": verdict, "reasons": reasons });
    let is_rendered = request.input.text().unwrap_or_default().contains("render");
    let hero = if is_rendered { render() } else { b"hero".to_vec() };
    let mut files: BTreeMap<&str, Vec<u8>> = BTreeMap::from([
        ("scene.json", scene(&id, request).to_string().into_bytes()),
        ("report.json", report.to_string().into_bytes()),
        ("preview/hero.png", hero),
        ("report.html", b"<!doctype html><title>Report</title>".to_vec()),
        ("preview/top.png", b"top".to_vec()),
        ("glb/table.glb", b"a table".to_vec()),
        ("glb/mug_1.glb", format!("a mug of {:?}", request.input.text()).into_bytes()),
    ]);
    let media_type = |path: &str| match path.rsplit('.').next() {
        Some("png") => "image/png",
        Some("html") => "text/html",
        _ => "application/json",
    };
    let entries: Vec<Value> = files
        .iter()
        .map(|(path, bytes)| {
            json!({
                "path": path, "sha256": sha256(bytes), "size": bytes.len(), "role": "r",
                "media_type": media_type(path),
            })
        })
        .collect();
    let manifest =
        json!({ "format": "tabletopgen-manifest/1", "scene": id, "licence": "CC0-1.0", "files": entries });
    files.insert("manifest.json", manifest.to_string().into_bytes());
    let file =
        |(path, bytes): (&str, Vec<u8>)| BundleFile::new(path.to_owned(), bytes, "r", media_type(path));
    files.into_iter().map(file).collect()
}

fn scene(id: &str, request: &SceneRequest) -> Value {
    let still = json!([0.0, 0.0, 0.0, 1.0]);
    let body = |name: &str, other: Value| {
        let mut body = json!({
            "name": name, "label": name, "mesh": format!("glb/{name}.glb"), "mass_kg": 1.0,
            "center_of_mass_m": [0.0, 0.0, 0.0], "inertia_diagonal_kg_m2": [1.0, 1.0, 1.0],
            "principal_axes_xyzw": still, "friction": { "static": 0.5, "dynamic": 0.4 }, "restitution": 0.1, "hulls": 1,
        });
        let fields = other.as_object().unwrap().clone();
        body.as_object_mut().unwrap().extend(fields);
        body
    };
    let table = json!({
        "shape": "square", "model": "desk", "height_m": 0.7, "size_m": [1.0, 1.0, 0.7],
        "outline_m": [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
    });
    let mug = json!({
        "category": "mug", "image": { "bbox_px": [0, 0, 1, 1] }, "translation_m": [0.0, 0.0, 0.0],
        "rotation_xyzw": still, "yaw_rad": 0.0, "symmetry_order": 1, "scale": [1.0, 1.0, 1.0],
        "size_m": [0.1, 0.1, 0.1], "support": { "parent": "table", "relation": "on" },
        "provenance": { "mesh_by": "embedded/catalog", "licence": "CC0-1.0", "notes": [] },
    });
    json!({
        "format": "tabletopgen-scene/1", "id": id, "seed": request.seed, "request": request,
        "frame": { "up": "+z", "handedness": "right", "origin": "table", "units": "m" },
        "camera": {
            "width_px": 10, "height_px": 10, "fx": 1.0, "fy": 1.0, "cx": 5.0, "cy": 5.0,
            "world_from_camera": { "translation_m": [0.0, 0.0, 1.0], "rotation_xyzw": still },
        },
        "table": body("table", table),
        "instances": [body("mug_1", mug)],
        "metrics": { "col_o": 0.0, "col_s": 0.0, "ss": 1.0, "dss_aligned": 1.0, "dss_shipped": 1.0 },
    })
}
