//! Stage 12: the certified files become one archive.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Context;
use super::certify;
use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use crate::export::archive::unshelve;
use crate::export::{Formats, zip_bundle};
use crate::scene::certificate::{Metrics, Verdict};
use crate::store::Digest;
use crate::store::artifacts::{ArchiveRow, BuiltRows, FileRow};

pub const STAGE: Stage = Stage { name: "bundle", version: 1 };

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
    let shelf = context.get(&inputs.certified.files).await?;
    let packed = context
        .cpu(move || {
            let files = unshelve(&shelf)?;
            let listed: Vec<File> = files
                .iter()
                .map(|file| File {
                    path: file.path.clone(),
                    digest: Digest::of(&file.bytes),
                    media_type: file.media_type.clone(),
                    size: file.bytes.len() as u64,
                })
                .collect();
            Ok((zip_bundle(&files, Formats::All)?, listed))
        })
        .await?;
    let (archive, files) = packed.map_err(|error: crate::export::ExportError| {
        StageError::permanent("bundle_failed", format!("packing the bundle: {error}"))
    })?;
    let certified = &inputs.certified;
    Ok(Output {
        archive: context.put("scene.zip", "application/zip", archive).await?,
        files,
        verdict: certified.verdict,
        reasons: certified.reasons.clone(),
        metrics: certified.metrics,
        summary: certified.summary.clone(),
    })
}

impl Output {
    /// As the store keeps it with the scene.
    pub fn into_rows(self) -> BuiltRows {
        let file =
            |f: File| FileRow { name: f.path, digest: f.digest, media_type: f.media_type, size: f.size };
        BuiltRows {
            files: self.files.into_iter().map(file).collect(),
            archive: ArchiveRow { digest: self.archive.digest, size: self.archive.size },
            passed: self.verdict == Verdict::Pass,
            reasons: self.reasons,
            summary: self.summary,
            metrics: serde_json::json!(self.metrics),
        }
    }
}
