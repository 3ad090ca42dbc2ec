//! Verification of a version: its blobs become a folder again, and every byte of that is read and compared.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

use super::{FreezeError, Freezer, Steps, sources};
use crate::schemas::values::MAX_INTEGER;
use datasets::verify;
use store::datasets::DatasetRow;

/// Faults that are listed; the number of all is stated.
const MAX_FAULTS: usize = 100;

/// Findings of the last verification.
#[derive(Serialize, JsonSchema)]
pub struct VerificationResult {
    intact: bool,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    scenes: usize,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    bytes: u64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    fault_count: usize,
    /// The first hundred.
    faults: Vec<verify::Fault>,
}

impl Freezer {
    /// Verifies a version; what was found, as JSON.
    pub(super) async fn verify(
        &self,
        dataset: &DatasetRow,
        folder: &Path,
        steps: &Steps,
    ) -> Result<Value, FreezeError> {
        let version = folder.join("version");
        for file in self.store.dataset_files(&dataset.id).await? {
            let target = version.join(&file.path);
            let parent = target.parent().unwrap_or(&version);
            std::fs::create_dir_all(parent).map_err(FreezeError::file("create", parent))?;
            let is_there = std::fs::metadata(&target).is_ok_and(|about| about.len() == file.size);
            // A blob that is missing or damaged leaves a file out, which is a fault of the version.
            if !is_there && !sources::copy_blob(&self.store, &file.digest, &target).await? {
                tracing::warn!(dataset_id = %dataset.id, path = file.path, "a file of a dataset is lost");
            }
        }
        let steps = steps.clone();
        let verified = self.cpu.run(move || {
            verify::verify(&version, &mut |done, all| steps.set(done, all)).map_err(|error| error.to_string())
        });
        let result = match verified.await? {
            Ok(verification) => VerificationResult {
                intact: verification.faults.is_empty(),
                scenes: verification.facts.len(),
                bytes: verification.bytes,
                fault_count: verification.faults.len(),
                faults: verification.faults.into_iter().take(MAX_FAULTS).collect(),
            },
            // Without a manifest there is nothing to compare with.
            Err(reason) => VerificationResult {
                intact: false,
                scenes: 0,
                bytes: 0,
                fault_count: 1,
                faults: vec![verify::Fault { path: datasets::dataset_manifest::PATH.to_owned(), reason }],
            },
        };
        Ok(json!(result))
    }
}
