//! Freezing a version in the work folder, and its files as blobs.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use super::request::DatasetRequest;
use super::{FreezeError, Freezer, Steps, sources};
use crate::schemas::datasets::OpenDocument;
use datasets::dataset_manifest::{self, Changes, Counts, Layout};
use datasets::freeze::{self, FreezeRequest, FrozenDataset, Progress};
use datasets::selection::Selection;
use datasets::{licences, statistics};
use store::datasets::{DatasetFile, DatasetRow, FrozenVersion};
use store::{Lease, StoreError};

/// From the manifest of the version.
#[derive(Serialize, JsonSchema)]
pub struct DatasetSummary<'a> {
    #[schemars(with = "OpenDocument")]
    counts: &'a Counts,
    #[schemars(with = "OpenDocument")]
    selection: &'a Selection,
    #[schemars(with = "Option<OpenDocument>")]
    changes: Option<&'a Changes>,
    /// The version existed already.
    unchanged: bool,
}

impl Freezer {
    /// Freezes a dataset and records the files of its version.
    pub(super) async fn freeze(
        &self,
        lease: &Lease,
        dataset: &DatasetRow,
        folder: &Path,
        steps: &Steps,
    ) -> Result<FrozenVersion, FreezeError> {
        let request: DatasetRequest = serde_json::from_value(dataset.request.clone()).map_err(|error| {
            FreezeError::Request(format!(
                "the stored request belongs to another version ({error}); freeze again"
            ))
        })?;
        let tenant_id = &dataset.tenant_id;
        let records =
            sources::gather(&self.store, tenant_id, &request.source, &folder.join("sources"), steps).await?;
        let out = folder.join("out");
        // First, as a version that is deleted in between still counts.
        let highest = self.store.highest_version(tenant_id, &dataset.name).await?;
        let earlier = self.store.latest_version(tenant_id, &dataset.name).await?;
        if let Some(earlier) = &earlier {
            self.place_earlier(earlier, &out).await?;
        }
        let last_removed = u32::try_from(highest).unwrap_or(u32::MAX - 1);
        let frozen = self.frozen(dataset, request, records, (out, last_removed), steps.clone()).await?;
        let manifest = &frozen.manifest;
        let paths = match &earlier {
            Some(earlier) if frozen.existed => {
                self.store.share_dataset_files(lease, earlier).await?;
                let files = self.store.dataset_files(&dataset.id).await?;
                files.into_iter().map(|file| file.path).collect()
            }
            _ => self.put_files(lease, &frozen, steps).await?,
        };
        let summary = DatasetSummary {
            counts: &manifest.counts,
            selection: &manifest.selection,
            changes: manifest.changes.as_ref(),
            unchanged: frozen.existed,
        };
        Ok(FrozenVersion {
            version: i64::from(manifest.version),
            digest: manifest.digest.clone(),
            summary: json!(summary),
            paths,
        })
    }

    /// Puts the manifest of the version before in its place in the work folder.
    async fn place_earlier(&self, earlier: &DatasetRow, out: &Path) -> Result<(), FreezeError> {
        let Some(manifest) = self.store.dataset_file(&earlier.id, dataset_manifest::PATH).await? else {
            return Err(self.without_manifest(earlier).await?);
        };
        let folder = out.join(&earlier.name).join(format!("v{}", earlier.version.unwrap_or(0)));
        std::fs::create_dir_all(&folder).map_err(FreezeError::file("create", &folder))?;
        let target = folder.join(dataset_manifest::PATH);
        match sources::copy_blob(&self.store, &manifest.digest, &target).await? {
            true => Ok(()),
            false => Err(self.without_manifest(earlier).await?),
        }
    }

    /// Reason why the manifest of an earlier version is not there.
    async fn without_manifest(&self, earlier: &DatasetRow) -> Result<FreezeError, FreezeError> {
        let present = self.store.dataset(&earlier.tenant_id, &earlier.id).await?;
        if present.is_none_or(|dataset| dataset.is_deleted) {
            return Ok(StoreError::VersionGone.into());
        }
        let message = format!("the manifest of version {:?} of {} is lost", earlier.version, earlier.name);
        Ok(FreezeError::Request(format!("{message}; restore it from a backup, or freeze under another name")))
    }

    /// Stores the files of a version as blobs, each with its row; their paths.
    async fn put_files(
        &self,
        lease: &Lease,
        frozen: &FrozenDataset,
        steps: &Steps,
    ) -> Result<Vec<String>, FreezeError> {
        let listed = frozen.manifest.files.iter().map(|file| file.path.clone());
        let paths: Vec<String> = listed.chain([dataset_manifest::PATH.to_owned()]).collect();
        for (index, path) in paths.iter().enumerate() {
            let place = frozen.folder.join(path);
            // A shard is in memory at once; its size is bounded.
            let bytes = tokio::fs::read(&place).await.map_err(FreezeError::file("read", &place))?;
            let size = bytes.len() as u64;
            let digest = self.store.blobs().put(bytes).await?;
            let media_type = media_type(path).to_owned();
            let file = DatasetFile { path: path.clone(), digest, size, media_type };
            self.store.record_dataset_file(lease, file).await?;
            steps.set(index + 1, paths.len());
        }
        Ok(paths)
    }

    async fn frozen(
        &self,
        dataset: &DatasetRow,
        request: DatasetRequest,
        records: PathBuf,
        (out, last_removed): (PathBuf, u32),
        steps: Steps,
    ) -> Result<FrozenDataset, FreezeError> {
        let request = FreezeRequest {
            name: dataset.name.clone(),
            version: None,
            last_removed,
            sources: Vec::new(),
            batch_output: Some(records),
            filter: request.filter,
            plan: request.splits,
            leakage_rules: request.disjoint,
            layout: Layout::Shards { max_bytes: request.shard_bytes, max_scenes: request.shard_scenes },
            out,
        };
        let freezing = self.cpu.run(move || {
            freeze::freeze(&request, &mut |progress| {
                let (Progress::Read { done, all } | Progress::Packed { done, all }) = progress;
                steps.set(done, all);
            })
        });
        Ok(freezing.await??)
    }
}

/// The media type of a file of a version.
fn media_type(path: &str) -> &'static str {
    match path {
        dataset_manifest::PATH | statistics::JSON_PATH => "application/json",
        statistics::PAGE_PATH => "text/html; charset=utf-8",
        licences::PATH => "text/markdown; charset=utf-8",
        _ => "application/x-tar",
    }
}
