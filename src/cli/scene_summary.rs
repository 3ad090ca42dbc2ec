//! Result of a scene: its bundle on disk, and the document that `--json` prints.

use std::path::{Path, PathBuf};

use futures::TryStreamExt;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};

use super::output::{Kind, Output, Partial};
use super::progress::StageTime;
use super::{Exit, Failure, terminal};
use certificate::Certificate;
use scene::SceneId;
use store::scenes::SceneRow;
use store::{DEFAULT_TENANT, Digest, Store, StoreError};

/// Place of the bundle.
pub enum Place {
    /// A folder that was asked for.
    Named(Output),
    /// A folder inside this one, named after the scene.
    Within { folder: PathBuf, is_forced: bool },
}

/// Place of the bundle, and whether with artifacts.
pub struct Target {
    pub place: Place,
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

/// Paths of the written files and folders.
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
        let archive = store.archive(&DEFAULT_TENANT, &scene.id, "all").await.map_err(stored)?;
        let archive = match archive {
            // Each entry has a checksum, which unpacking compares.
            Some(row) => unverified(store, &row.digest, "the bundle").await?,
            None => return Err(Failure::new(Exit::Error, "the finished scene has no bundle; a bug")),
        };
        let files = unpacked(&archive)?;
        let scene_id = match files.iter().find(|(name, _)| name == "scene.json") {
            Some((_, bytes)) => id_of(bytes)?,
            None => return Err(Failure::new(Exit::Error, "the finished bundle has no scene.json; a bug")),
        };
        let Target { place, artifacts } = target;
        let report = files.iter().find(|(name, _)| name == "report.json");
        let certificate = report.and_then(|(_, bytes)| serde_json::from_slice(bytes).ok());
        let folder = match place {
            Place::Named(output) => FolderOfScene::New(output),
            Place::Within { folder, is_forced } => {
                folder_of_scene(&folder, &scene_id, is_forced, &files, artifacts)?
            }
        };
        if let FolderOfScene::New(output) = &folder {
            let partial = output.begin()?;
            files.par_iter().try_for_each(|(name, bytes)| partial.write(name, bytes))?;
            if artifacts {
                write_artifacts(store, &scene.id, &partial).await?;
            }
            partial.publish()?;
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
    pub fn document(&self, total_ms: u128) -> Value {
        let reasons = self.certificate.as_ref().map_or(&[][..], |certificate| &certificate.reasons);
        let reasons: Vec<&str> = reasons.iter().map(|reason| reason.sentence.as_str()).collect();
        json!({
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
        })
    }
}

/// The folder of a scene inside another one.
enum FolderOfScene {
    New(Output),
    /// A folder that holds this very bundle already.
    Present(PathBuf),
}

impl FolderOfScene {
    fn path(&self) -> &Path {
        match self {
            Self::New(output) => output.given_path(),
            Self::Present(path) => path,
        }
    }
}

/// The folder named after the scene: `0a1b...`, or with a number behind (`0a1b...-2`) where that holds something else.
fn folder_of_scene(
    within: &Path,
    scene_id: &str,
    is_forced: bool,
    files: &[(String, Vec<u8>)],
    with_artifacts: bool,
) -> Result<FolderOfScene, Failure> {
    let short: String = scene_id.chars().take(12).collect();
    let names = std::iter::once(short.clone()).chain((2_u32..).map(|number| format!("{short}-{number}")));
    for path in names.map(|name| within.join(name)) {
        let is_same = |(name, bytes): &(String, Vec<u8>)| {
            std::fs::read(path.join(name)).is_ok_and(|present| present == *bytes)
        };
        let has_artifacts = !with_artifacts || path.join("artifacts").is_dir();
        if !is_forced && has_artifacts && files.iter().all(is_same) {
            return Ok(FolderOfScene::Present(path));
        }
        match Output::check(&path, Kind::Bundle, is_forced, &[]) {
            Ok(output) => return Ok(FolderOfScene::New(output)),
            Err(refusal) if refusal.exit == Exit::Usage => {}
            Err(failure) => return Err(failure),
        }
    }
    Err(Failure::new(Exit::Error, format!("{} has no name left for scene {scene_id}", within.display())))
}

/// The result of a command; with `--json`, a failure is printed as a document.
pub fn with_failure_document(done: Result<Exit, Failure>, is_json: bool) -> Result<Exit, Failure> {
    if let (Err(failure), true) = (&done, is_json) {
        terminal::print(&failure_document(failure));
    }
    done
}

/// The JSON document of a scene that was not made.
fn failure_document(failure: &Failure) -> String {
    let kind = match failure.exit {
        Exit::Success
        | Exit::Quarantined
        | Exit::Different
        | Exit::BatchIncomplete
        | Exit::TaskFailed
        | Exit::Error => "error",
        Exit::Usage => "usage",
        Exit::JobFailed => "job_failed",
        Exit::Interrupted => "interrupted",
    };
    let mut document = json!({
        "verdict": null,
        "failure": { "kind": kind, "message": failure.message, "exit_code": failure.exit.code() },
    });
    if let Some(problem) = &failure.problem {
        document["failure"]["problem"] = problem.clone();
    }
    format!("{document:#}\n")
}

/// Writes every artifact that the scene's stages left so far below `artifacts/`.
pub async fn write_artifacts(store: &Store, scene_id: &SceneId, folder: &Partial) -> Result<(), Failure> {
    let rows = store.artifacts(&DEFAULT_TENANT, scene_id).await;
    for row in rows.map_err(|error| Failure::new(Exit::Error, error.chain()))? {
        let bytes = bytes(store, &row.file.digest, &row.file.name).await?;
        folder.write(&format!("artifacts/{}", row.file.name), &bytes)?;
    }
    Ok(())
}

async fn bytes(store: &Store, digest: &Digest, what: &str) -> Result<bytes::Bytes, Failure> {
    let found = store.blobs().get(digest).await;
    found.map_err(|error| Failure::new(Exit::Error, error.chain()))?.ok_or_else(|| gone(what))
}

/// Bytes as [`bytes()`] gives them, not compared with the digest.
async fn unverified(store: &Store, digest: &Digest, what: &str) -> Result<Vec<u8>, Failure> {
    let failed = |error: StoreError| Failure::new(Exit::Error, error.chain());
    let Some(mut parts) = store.blobs().stream(digest, None).await.map_err(failed)? else {
        return Err(gone(what));
    };
    let mut bytes = Vec::new();
    while let Some(part) = parts.try_next().await.map_err(failed)? {
        bytes.extend_from_slice(&part);
    }
    Ok(bytes)
}

fn gone(what: &str) -> Failure {
    Failure::new(Exit::Error, format!("the stored bytes of {what} are gone; run it again"))
}

/// Path below the archive's one folder, and bytes, of every file.
fn unpacked(archive: &[u8]) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let damaged = |error: &dyn std::fmt::Display| {
        Failure::new(Exit::Error, format!("the stored bundle cannot be unpacked: {error}; run it again"))
    };
    let archive = zip::ZipArchive::new(std::io::Cursor::new(archive)).map_err(|e| damaged(&e))?;
    (0..archive.len())
        .into_par_iter()
        .map_init(
            || archive.clone(),
            |archive, index| {
                let mut entry = archive.by_index(index).map_err(|e| damaged(&e))?;
                let path = entry.name().map_err(|e| damaged(&e))?.into_owned();
                let name = path.split_once('/').map_or("", |(_, name)| name).to_owned();
                let mut bytes = Vec::new();
                std::io::Read::read_to_end(&mut entry, &mut bytes).map_err(|e| damaged(&e))?;
                Ok((name, bytes))
            },
        )
        .collect()
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
