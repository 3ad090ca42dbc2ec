//! Checkpoints: rows of finished stages, keyed by all inputs that influence the stage's result.
//!
//! A finished stage is written once and reused by every later job of the tenant with the same key. Each job also has
//! its own stage rows (state, reuse, duration) and events. All rows of one stage are written in one transaction under
//! the job's lease.

use serde_json::json;
use sqlx::{AnyConnection, Row};

use super::artifacts::FileRow;
use super::queue::{guard, note_progress};
use super::stage_claims::StageStart;
use super::{Digest, Lease, Store, StoreError, database, events, stage_claims};
use crate::boxed;
use scene::TenantId;

/// Identity of a stage result; an empty instance means the whole scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StageKey {
    pub tenant_id: TenantId,
    pub stage: String,
    pub version: u32,
    pub instance: String,
    pub key: Digest,
}

/// A finished stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    /// Blob with the stage's output.
    pub output: Digest,
    /// Artifacts of the stage.
    pub artifacts: Vec<FileRow>,
    /// Duration of the computation, milliseconds.
    pub elapsed_ms: i64,
}

impl Store {
    /// The checkpoint of a key. An unreadable row counts as missing.
    #[boxed]
    pub async fn checkpoint(&self, stage: &StageKey) -> Result<Option<Checkpoint>, StoreError> {
        let row = sqlx::query(
            "SELECT output, artifacts, elapsed_ms FROM checkpoints WHERE tenant_id = $1 AND key = $2",
        )
        .bind(stage.tenant_id.as_str())
        .bind(stage.key.as_str())
        .fetch_optional(&self.readers)
        .await?;
        let Some(row) = row else { return Ok(None) };
        let output: String = row.try_get("output")?;
        let artifacts: String = row.try_get("artifacts")?;
        match (Digest::parse(&output), read_artifacts(&artifacts)) {
            (Ok(output), Some(artifacts)) => {
                Ok(Some(Checkpoint { output, artifacts, elapsed_ms: row.try_get("elapsed_ms")? }))
            }
            _ => {
                tracing::warn!(stage = stage.stage, key = %stage.key, "a checkpoint row is unreadable");
                Ok(None)
            }
        }
    }

    /// Claims the key of a stage, and records that the job starts to compute it. Nothing is recorded while another job
    /// computes it.
    #[boxed]
    pub async fn stage_started(&self, lease: &Lease, stage: &StageKey) -> Result<StageStart, StoreError> {
        let (lease, stage) = (lease.clone(), stage.clone());
        let start = self
            .writer
            .write("start a stage", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    let now = database::now_ms(connection).await?;
                    let start = stage_claims::claim(connection, &lease, &stage, now).await?;
                    if start != StageStart::Granted {
                        return Ok(start);
                    }
                    sqlx::query(
                        "INSERT INTO stages (job_id, stage, instance, key, state, epoch, runs, started_at)
                         VALUES ($1, $2, $3, $4, 'running', $5, 1, $6)
                         ON CONFLICT (job_id, stage, instance) DO UPDATE SET key = excluded.key, state = 'running', cached = 0,
                             epoch = excluded.epoch, runs = stages.runs + 1, elapsed_ms = NULL,
                             started_at = excluded.started_at",
                    )
                    .bind(lease.job_id.as_str())
                    .bind(&stage.stage)
                    .bind(&stage.instance)
                    .bind(stage.key.as_str())
                    .bind(lease.epoch)
                    .bind(now)
                    .execute(&mut *connection)
                    .await?;
                    let data = about(&stage, json!({}));
                    events::append(connection, &lease.job_id, now, "stage_started", &data).await?;
                    Ok(start)
                })
            })
            .await?;
        if start == StageStart::Granted {
            self.announce();
        }
        Ok(start)
    }

    /// Commits a stage: the checkpoint (if new), the job's stage row, the scene's artifacts and the event. A new
    /// checkpoint resets the attempt counter.
    #[boxed]
    pub async fn stage_finished(
        &self,
        lease: &Lease,
        stage: &StageKey,
        checkpoint: &Checkpoint,
        cached: bool,
    ) -> Result<(), StoreError> {
        let (lease, stage, checkpoint) = (lease.clone(), stage.clone(), checkpoint.clone());
        self.writer
            .write("commit a stage", move |connection| {
                Box::pin(async move { commit(connection, &lease, &stage, &checkpoint, cached).await })
            })
            .await?;
        self.announce();
        Ok(())
    }

    /// Deletes a checkpoint with missing blobs, so that the stage is computed again.
    #[boxed]
    pub async fn forget_checkpoint(&self, stage: &StageKey) -> Result<(), StoreError> {
        let stage = stage.clone();
        self.writer
            .write("forget a checkpoint", move |connection| {
                Box::pin(async move {
                    sqlx::query("DELETE FROM checkpoints WHERE tenant_id = $1 AND key = $2")
                        .bind(stage.tenant_id.as_str())
                        .bind(stage.key.as_str())
                        .execute(connection)
                        .await?;
                    Ok(())
                })
            })
            .await
    }

    /// Appends a progress event of the running stage.
    #[boxed]
    pub async fn note(&self, lease: &Lease, stage: &str, message: String) -> Result<(), StoreError> {
        let (lease, data) = (lease.clone(), json!({ "stage": stage, "message": message }));
        self.writer
            .write("note progress", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    let now = database::now_ms(connection).await?;
                    events::append(connection, &lease.job_id, now, "stage_progress", &data).await
                })
            })
            .await?;
        self.announce();
        Ok(())
    }
}

async fn commit(
    connection: &mut AnyConnection,
    lease: &Lease,
    stage: &StageKey,
    checkpoint: &Checkpoint,
    cached: bool,
) -> Result<(), StoreError> {
    guard(connection, lease).await?;
    let now = database::now_ms(connection).await?;
    if !cached {
        sqlx::query(
            "INSERT INTO checkpoints (tenant_id, key, stage, version, instance, output, artifacts, elapsed_ms,
                                      created_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)
             ON CONFLICT (tenant_id, key) DO UPDATE SET output = excluded.output, artifacts = excluded.artifacts,
                 elapsed_ms = excluded.elapsed_ms, created_at = excluded.created_at",
        )
        .bind(stage.tenant_id.as_str())
        .bind(stage.key.as_str())
        .bind(&stage.stage)
        .bind(i64::from(stage.version))
        .bind(&stage.instance)
        .bind(checkpoint.output.as_str())
        .bind(write_artifacts(&checkpoint.artifacts))
        .bind(checkpoint.elapsed_ms)
        .bind(now)
        .execute(&mut *connection)
        .await?;
        note_progress(connection, &lease.job_id).await?;
    } else {
        // A sweep may have removed it since it was read. The update locks the row until the stage's row is there, and
        // keeps off sweeps that found no stage of it.
        let kept = sqlx::query("UPDATE checkpoints SET created_at = $1 WHERE tenant_id = $2 AND key = $3")
            .bind(now)
            .bind(stage.tenant_id.as_str())
            .bind(stage.key.as_str())
            .execute(&mut *connection)
            .await?;
        if kept.rows_affected() == 0 {
            return Err(StoreError::CheckpointGone);
        }
    }
    stage_claims::release(connection, &stage.tenant_id, stage.key.as_str(), &lease.job_id).await?;
    // A stage that this job computed before a restart keeps its duration; it is "cached" now.
    sqlx::query(
        "INSERT INTO stages (job_id, stage, instance, key, state, cached, epoch, elapsed_ms, started_at)
         VALUES ($1, $2, $3, $4, 'finished', $5, $6, $7, $8)
         ON CONFLICT (job_id, stage, instance) DO UPDATE SET key = excluded.key, state = 'finished', cached = excluded.cached,
             epoch = excluded.epoch, elapsed_ms = excluded.elapsed_ms",
    )
    .bind(lease.job_id.as_str())
    .bind(&stage.stage)
    .bind(&stage.instance)
    .bind(stage.key.as_str())
    .bind(i64::from(cached))
    .bind(lease.epoch)
    .bind(checkpoint.elapsed_ms)
    .bind(now)
    .execute(&mut *connection)
    .await?;
    let scene_id: String = sqlx::query_scalar("SELECT scene_id FROM jobs WHERE id = $1")
        .bind(lease.job_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    for artifact in &checkpoint.artifacts {
        sqlx::query(
            "INSERT INTO artifacts (scene_id, name, stage, job_id, digest, media_type, size, created_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8)
             ON CONFLICT (scene_id, name) DO UPDATE SET stage = excluded.stage, job_id = excluded.job_id,
                 digest = excluded.digest, media_type = excluded.media_type, size = excluded.size,
                 created_at = excluded.created_at",
        )
        .bind(&scene_id)
        .bind(&artifact.name)
        .bind(&stage.stage)
        .bind(lease.job_id.as_str())
        .bind(artifact.digest.as_str())
        .bind(&artifact.media_type)
        .bind(artifact.size as i64)
        .bind(now)
        .execute(&mut *connection)
        .await?;
    }
    let artifacts: Vec<&str> = checkpoint.artifacts.iter().map(|artifact| artifact.name.as_str()).collect();
    let more = json!({ "elapsed_ms": checkpoint.elapsed_ms, "cached": cached, "artifacts": artifacts });
    events::append(connection, &lease.job_id, now, "stage_finished", &about(stage, more)).await
}

/// Event data with the stage, and the instance if there is one.
fn about(stage: &StageKey, more: serde_json::Value) -> serde_json::Value {
    let mut data = json!({ "stage": stage.stage });
    if !stage.instance.is_empty() {
        data["instance"] = json!(stage.instance);
    }
    if let (Some(data), serde_json::Value::Object(more)) = (data.as_object_mut(), more) {
        data.extend(more);
    }
    data
}

fn write_artifacts(artifacts: &[FileRow]) -> String {
    let list: Vec<_> =
        artifacts.iter().map(|a| json!([a.name, a.digest.as_str(), a.media_type, a.size])).collect();
    json!(list).to_string()
}

pub(super) fn read_artifacts(text: &str) -> Option<Vec<FileRow>> {
    let list: Vec<(String, Digest, String, u64)> = serde_json::from_str(text).ok()?;
    let file = |(name, digest, media_type, size)| FileRow { name, digest, media_type, size };
    Some(list.into_iter().map(file).collect())
}
