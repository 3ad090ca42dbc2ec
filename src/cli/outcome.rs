//! What came of a scene: its bundle on disk, and the document that `--json` prints.

use serde::Serialize;
use serde_json::{Value, json};

use super::folder::Folder;
use super::progress::StageTime;
use super::{Exit, Failure};
use crate::scene::Certificate;
use crate::store::artifacts::FileRow;
use crate::store::scenes::SceneRow;
use crate::store::{Store, StoreError};

/// Where the bundle goes.
pub struct Target {
    pub folder: Folder,
    /// The folder itself was asked for; else a folder named after the scene inside it.
    pub named: bool,
    pub force: bool,
    pub artifacts: bool,
}

/// A scene that was made.
pub struct Outcome {
    /// The bundle's own id.
    pub scene_id: String,
    pub seed: u64,
    pub passed: bool,
    /// `None` when the report is not one this version writes.
    pub certificate: Option<Certificate>,
    pub metrics: Value,
    pub summary: Value,
    pub stages: Vec<StageTime>,
    pub paths: Paths,
}

/// What was written, as paths.
#[derive(Clone, Debug, Serialize)]
pub struct Paths {
    pub bundle: String,
    pub scene: String,
    pub report: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub artifacts: Option<String>,
}

impl Outcome {
    /// Unpacks the bundle of a finished scene.
    pub async fn write(
        store: &Store,
        scene: &SceneRow,
        seed: u64,
        stages: Vec<StageTime>,
        target: Target,
    ) -> Result<Self, Failure> {
        let stored = |error: StoreError| Failure::new(Exit::Error, error.chain());
        let files = store.bundle_files(&scene.id).await.map_err(stored)?;
        let scene_id = match files.iter().find(|file| file.name == "scene.json") {
            Some(file) => id_of(&bytes(store, file).await?)?,
            None => return Err(Failure::new(Exit::Error, "the finished bundle has no scene.json; a bug")),
        };
        let Target { mut folder, named, force, artifacts } = target;
        if !named {
            let short: String = scene_id.chars().take(12).collect();
            folder = folder.inside(&short, force)?;
        }
        folder.clear()?;
        // The manifest goes first: a folder that was left half way is recognized as a bundle.
        let manifest_first = |file: &&FileRow| file.name != "manifest.json";
        let mut ordered: Vec<&FileRow> = files.iter().collect();
        ordered.sort_by_key(manifest_first);
        let mut certificate = None;
        for file in ordered {
            let bytes = bytes(store, file).await?;
            if file.name == "report.json" {
                certificate = serde_json::from_slice(&bytes).ok();
            }
            folder.write(&file.name, &bytes)?;
        }
        if artifacts {
            for row in store.artifacts(&scene.id).await.map_err(stored)? {
                folder.write(&format!("artifacts/{}", row.file.name), &bytes(store, &row.file).await?)?;
            }
        }
        let path = |name: &str| folder.path().join(name).display().to_string();
        let paths = Paths {
            bundle: folder.path().display().to_string(),
            scene: path("scene.json"),
            report: path("report.json"),
            artifacts: artifacts.then(|| path("artifacts")),
        };
        Ok(Self {
            scene_id,
            seed,
            passed: scene.verdict.as_deref() == Some("pass"),
            certificate,
            metrics: scene.metrics.clone().unwrap_or_default(),
            summary: scene.summary.clone().unwrap_or_default(),
            stages,
            paths,
        })
    }

    /// The JSON document.
    pub fn document(&self, total_ms: u128) -> String {
        let reasons = self.certificate.as_ref().map_or(&[][..], |certificate| &certificate.reasons);
        let document = json!({
            "scene_id": self.scene_id,
            "seed": self.seed,
            "verdict": if self.passed { "pass" } else { "quarantine" },
            "metrics": self.metrics,
            "reasons": reasons,
            "summary": self.summary,
            "stages": self.stages,
            "total_ms": u64::try_from(total_ms).unwrap_or(u64::MAX),
            "paths": self.paths,
            "failure": null,
        });
        format!("{document:#}\n")
    }
}

/// The JSON document of a scene that was not made.
pub fn failure_document(failure: &Failure) -> String {
    let kind = match failure.exit {
        Exit::Success | Exit::Quarantined | Exit::Error => "error",
        Exit::Usage => "usage",
        Exit::JobFailed => "job_failed",
        Exit::Interrupted => "interrupted",
    };
    let document = json!({
        "verdict": null,
        "failure": { "kind": kind, "message": failure.message, "exit_code": failure.exit as u8 },
    });
    format!("{document:#}\n")
}

async fn bytes(store: &Store, file: &FileRow) -> Result<bytes::Bytes, Failure> {
    let gone =
        || Failure::new(Exit::Error, format!("the stored bytes of {} are gone; run it again", file.name));
    let found = store.blobs().get(&file.digest).await;
    found.map_err(|error| Failure::new(Exit::Error, error.chain()))?.ok_or_else(gone)
}

fn id_of(scene: &[u8]) -> Result<String, Failure> {
    #[derive(serde::Deserialize)]
    struct Scene {
        id: String,
    }
    let scene: Result<Scene, _> = serde_json::from_slice(scene);
    let valid = |id: &String| !id.is_empty() && id.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-');
    let id = scene.ok().map(|scene| scene.id).filter(valid);
    id.ok_or_else(|| Failure::new(Exit::Error, "the finished scene.json has no usable id; a bug"))
}
