//! Stage `bundle`: what is in the certified archive, checked against its manifest, becomes the scene that is
//! served.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Context;
use super::certify;
use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use certificate::Verdict;
use export::ExportError;
use export::archive::{manifest_entries, manifest_itself};
use scene::Metrics;
use store::Digest;
use store::artifacts::{ArchiveRow, BuiltScene, FileRow};

pub const STAGE: Stage = Stage { name: "bundle", version: 2 };

#[derive(Serialize)]
pub struct Inputs {
    pub certified: certify::Output,
}

/// The archive, and what is in it.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub archive: ArtifactRef,
    files: Vec<File>,
    verdict: Verdict,
    reasons: Vec<String>,
    metrics: Metrics,
    summary: serde_json::Value,
}

/// A file of the archive; its bytes lie there.
#[derive(Clone, Serialize, Deserialize)]
struct File {
    path: String,
    digest: Digest,
    media_type: String,
    size: u64,
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let archive = context.get(&inputs.certified.archive).await?;
    let listed = context
        .cpu(move || {
            let mut listed = manifest_entries(&archive)?;
            listed.extend([manifest_itself(&archive)?]);
            Ok(listed)
        })
        .await?;
    let unusable =
        |why: String| StageError::permanent("bundle_failed", format!("listing the bundle's files: {why}"));
    let listed = listed.map_err(|error: ExportError| unusable(error.to_string()))?;
    let files = listed
        .into_iter()
        .map(|(path, message)| {
            let digest = Digest::parse(&message.sha256).map_err(|error| unusable(error.to_string()))?;
            Ok(File { path, digest, media_type: message.media_type, size: message.size })
        })
        .collect::<Result<_, StageError>>()?;
    let certified = &inputs.certified;
    Ok(Output {
        archive: certified.archive.clone(),
        files,
        verdict: certified.verdict,
        reasons: certified.reasons.clone(),
        metrics: certified.metrics,
        summary: certified.summary.clone(),
    })
}

impl Output {
    /// As the store keeps it with the scene.
    pub fn into_rows(self) -> BuiltScene {
        let file =
            |f: File| FileRow { name: f.path, digest: f.digest, media_type: f.media_type, size: f.size };
        BuiltScene {
            files: self.files.into_iter().map(file).collect(),
            archive: ArchiveRow { digest: self.archive.digest, size: self.archive.size },
            passed: self.verdict == Verdict::Pass,
            reasons: self.reasons,
            summary: self.summary,
            metrics: serde_json::json!(self.metrics),
        }
    }
}
