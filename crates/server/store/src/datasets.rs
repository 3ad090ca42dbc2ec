//! Datasets: sets of finished scenes that are frozen in the background.
//!
//! A row is one freeze with its request, which the store does not interpret. Freezing and verifying are jobs (see
//! [`crate::queue`]): their worker records files and the result under the job's lease, and the state of the dataset
//! follows that of its job. Freezes of one name follow each other.

mod deletion;
mod files;
mod requests;
mod result;

use serde_json::Value;
use sqlx::Row;
use sqlx::any::AnyRow;

use super::list_query::ListQuery;
use super::{Store, StoreError, database};
use crate::boxed;
use scene::{DatasetId, JobId, TenantId};

pub use files::DatasetFile;
pub(super) use requests::retry;
pub use requests::{NewDataset, SubmitDatasetOutcome, VerifyOutcome};
pub use result::FrozenVersion;
pub(super) use result::{begun, fail, follow, record_verification, record_version};

/// State of a freeze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DatasetState {
    /// Waits for a process.
    Queued,
    Running,
    /// The version is there, and never changes.
    Finished,
    /// There is no version.
    Failed,
}

impl DatasetState {
    pub const ALL: [Self; 4] = [Self::Queued, Self::Running, Self::Finished, Self::Failed];

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Finished => "finished",
            Self::Failed => "failed",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.as_str() == text)
    }
}

/// A dataset's row.
#[derive(Clone, Debug, PartialEq)]
pub struct DatasetRow {
    pub id: DatasetId,
    pub tenant_id: TenantId,
    pub name: String,
    /// Once frozen.
    pub version: Option<i64>,
    pub state: DatasetState,
    /// The newest job: the freeze, or the last verification. `None` for versions that were frozen by earlier releases.
    pub job_id: Option<JobId>,
    /// Request of the dataset, as JSON.
    pub request: Value,
    /// Digest of the manifest, as the manifest states it.
    pub digest: Option<String>,
    /// Summary of the version by the freeze.
    pub summary: Option<Value>,
    pub failure_code: Option<String>,
    pub failure_message: Option<String>,
    /// `queued`, `running` or `finished`; `None` if none was asked for.
    pub verify_state: Option<String>,
    /// Findings of the last verification.
    pub verification: Option<Value>,
    /// Steps of the work in progress that are done, and all.
    pub steps: (i64, i64),
    pub is_deleted: bool,
    /// Milliseconds since 1970.
    pub created_at_ms: i64,
    pub finished_at_ms: Option<i64>,
}

/// Filter of a list of datasets.
#[derive(Clone, Debug, Default)]
pub struct DatasetFilter {
    pub name: Option<String>,
    pub state: Option<DatasetState>,
    /// Only datasets older than this id, the last id of the previous page.
    pub before_id: Option<DatasetId>,
    pub limit: u32,
}

impl Store {
    /// A dataset of the tenant, including deleted datasets.
    #[boxed]
    pub async fn dataset(
        &self,
        tenant_id: &TenantId,
        id: &DatasetId,
    ) -> Result<Option<DatasetRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM datasets WHERE id = $1 AND tenant_id = $2")
            .bind(id.as_str())
            .bind(tenant_id.as_str())
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(dataset_of).transpose()
    }

    /// Datasets of the tenant, newest first.
    #[boxed]
    pub async fn datasets(
        &self,
        tenant_id: &TenantId,
        filter: DatasetFilter,
    ) -> Result<Vec<DatasetRow>, StoreError> {
        let list = ListQuery::of(tenant_id)
            .fixed("deleted_at IS NULL")
            .word("state", filter.state.map(DatasetState::as_str))
            .text("name =", filter.name)
            .text("id <", filter.before_id);
        let rows = list.select("datasets", filter.limit).rows(&self.readers).await?;
        rows.iter().map(dataset_of).collect()
    }

    /// The newest version of a name that is not deleted.
    #[boxed]
    pub async fn latest_version(
        &self,
        tenant_id: &TenantId,
        name: &str,
    ) -> Result<Option<DatasetRow>, StoreError> {
        let row = sqlx::query(
            "SELECT * FROM datasets WHERE tenant_id = $1 AND name = $2 AND state = 'finished' AND deleted_at IS NULL
             ORDER BY version DESC, id LIMIT 1",
        )
        .bind(tenant_id.as_str())
        .bind(name)
        .fetch_optional(&self.readers)
        .await?;
        row.as_ref().map(dataset_of).transpose()
    }

    /// The highest number that a version of a name has, or had while others of the name stay; 0 without one. Deleted
    /// versions count, so that no number stands for two versions.
    #[boxed]
    pub async fn highest_version(&self, tenant_id: &TenantId, name: &str) -> Result<i64, StoreError> {
        let highest: Option<i64> = sqlx::query_scalar(
            "SELECT version FROM datasets WHERE tenant_id = $1 AND name = $2 AND version IS NOT NULL
             ORDER BY version DESC LIMIT 1",
        )
        .bind(tenant_id.as_str())
        .bind(name)
        .fetch_optional(&self.readers)
        .await?;
        Ok(highest.unwrap_or(0))
    }
}

fn dataset_of(row: &AnyRow) -> Result<DatasetRow, StoreError> {
    let corrupt = |reason: String| StoreError::Corrupt { table: "datasets", reason };
    let json = |column: &str| -> Result<Option<Value>, StoreError> {
        let text: Option<String> = row.try_get(column)?;
        text.map(|text| serde_json::from_str(&text))
            .transpose()
            .map_err(|error| corrupt(format!("{column}: {error}")))
    };
    let state: String = row.try_get("state")?;
    Ok(DatasetRow {
        id: database::id(row, "datasets", "id")?,
        tenant_id: database::id(row, "datasets", "tenant_id")?,
        name: row.try_get("name")?,
        version: row.try_get("version")?,
        state: DatasetState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?,
        job_id: database::optional_id(row, "datasets", "job_id")?,
        request: json("request")?.unwrap_or_default(),
        digest: row.try_get("digest")?,
        summary: json("summary")?,
        failure_code: row.try_get("failure_code")?,
        failure_message: row.try_get("failure_message")?,
        verify_state: row.try_get("verify_state")?,
        verification: json("verification")?,
        steps: (row.try_get("steps_done")?, row.try_get("steps_all")?),
        is_deleted: row.try_get::<Option<i64>, _>("deleted_at")?.is_some(),
        created_at_ms: row.try_get("created_at")?,
        finished_at_ms: row.try_get("finished_at")?,
    })
}
