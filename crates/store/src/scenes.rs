//! Scenes: what users keep. Submitting writes the scene, its job, its first event and the
//! idempotency row in one transaction.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};
use uuid::Uuid;

use super::{Store, StoreError, database, events, queue};
use scene::job::{JobEvent, JobState, SceneState};

/// How long an idempotency key is remembered.
const IDEMPOTENCY_MS: i64 = 24 * 3600 * 1000;

/// A scene to make.
#[derive(Clone, Debug)]
pub struct NewScene {
    pub tenant_id: String,
    /// The versioned request, as JSON.
    pub request: Value,
    pub labels: BTreeMap<String, String>,
    /// The most that calls of remote models may cost together, millionths of a US dollar.
    pub budget_micro_usd: i64,
    /// The client's key, and a digest of what it sent with it.
    pub idempotency: Option<(String, String)>,
}

/// What came of submitting a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Submitted {
    Created {
        scene_id: String,
        job_id: String,
    },
    /// The same key came with the same body before; this is what it made then.
    Replayed {
        scene_id: String,
        job_id: String,
    },
    /// The same key came with another body before; nothing was enqueued.
    KeyReused,
}

/// A scene's row.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneRow {
    pub id: String,
    pub parent_id: Option<String>,
    pub state: SceneState,
    /// `pass` or `quarantine`, once certified.
    pub verdict: Option<String>,
    pub failure_code: Option<String>,
    pub failure_message: Option<String>,
    pub request: Value,
    pub labels: BTreeMap<String, String>,
    pub summary: Option<Value>,
    pub metrics: Option<Value>,
    pub created_at_ms: i64,
    pub updated_at_ms: i64,
}

/// Which scenes to list, newest first.
#[derive(Clone, Debug, Default)]
pub struct SceneFilter {
    /// Deleted scenes are listed only when asked for.
    pub state: Option<SceneState>,
    pub label: Option<(String, String)>,
    pub parent: Option<String>,
    pub created_after_ms: Option<i64>,
    /// Only scenes older than this id (the last one of the page before).
    pub before_id: Option<String>,
    pub limit: u32,
}

/// What came of deleting a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deleted {
    /// It is deleted now, or was already.
    Done,
    NotFound,
}

impl Store {
    /// Stores a scene and enqueues its job, once per idempotency key.
    pub async fn submit(&self, new: NewScene) -> Result<Submitted, StoreError> {
        let submitted =
            self.writer.write("enqueue a scene", move |connection| Box::pin(submit(connection, new))).await?;
        self.announce();
        Ok(submitted)
    }

    /// A scene of the tenant, deleted ones included.
    pub async fn scene(&self, tenant_id: &str, id: &str) -> Result<Option<SceneRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM scenes WHERE id = ? AND tenant_id = ?")
            .bind(id)
            .bind(tenant_id)
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(scene_of).transpose()
    }

    /// Scenes of the tenant, newest first.
    pub async fn scenes(&self, tenant_id: &str, filter: SceneFilter) -> Result<Vec<SceneRow>, StoreError> {
        let (label_key, label_value) = filter.label.unzip();
        let rows = sqlx::query(
            "SELECT * FROM scenes
             WHERE tenant_id = ?1
               AND (state = ?2 OR (?2 IS NULL AND state != 'deleted'))
               AND (?3 IS NULL OR EXISTS (SELECT 1 FROM json_each(labels) AS l WHERE l.key = ?3 AND l.value = ?4))
               AND (?5 IS NULL OR parent_id = ?5)
               AND (?6 IS NULL OR created_at > ?6)
               AND (?7 IS NULL OR id < ?7)
             ORDER BY id DESC LIMIT ?8",
        )
        .bind(tenant_id)
        .bind(filter.state.map(SceneState::as_str))
        .bind(label_key)
        .bind(label_value)
        .bind(filter.parent)
        .bind(filter.created_after_ms)
        .bind(filter.before_id)
        .bind(filter.limit)
        .fetch_all(&self.readers)
        .await?;
        rows.iter().map(scene_of).collect()
    }

    /// Marks a scene deleted and cancels what is being done to it.
    pub async fn delete_scene(&self, tenant_id: &str, id: &str) -> Result<Deleted, StoreError> {
        let (tenant_id, id) = (tenant_id.to_owned(), id.to_owned());
        let deleted = self
            .writer
            .write("delete a scene", move |connection| Box::pin(delete(connection, tenant_id, id)))
            .await?;
        self.announce();
        self.cancelled.send_modify(|tick| *tick += 1);
        Ok(deleted)
    }
}

async fn submit(connection: &mut SqliteConnection, new: NewScene) -> Result<Submitted, StoreError> {
    let now = database::now_ms(connection).await?;
    if let Some((key, body_digest)) = &new.idempotency {
        sqlx::query("DELETE FROM idempotency WHERE expires_at <= ?")
            .bind(now)
            .execute(&mut *connection)
            .await?;
        let earlier = sqlx::query(
            "SELECT body_digest, scene_id, job_id FROM idempotency WHERE tenant_id = ? AND key = ?",
        )
        .bind(&new.tenant_id)
        .bind(key)
        .fetch_optional(&mut *connection)
        .await?;
        if let Some(earlier) = earlier {
            return Ok(if earlier.try_get::<String, _>("body_digest")? == *body_digest {
                Submitted::Replayed {
                    scene_id: earlier.try_get("scene_id")?,
                    job_id: earlier.try_get("job_id")?,
                }
            } else {
                Submitted::KeyReused
            });
        }
    }
    let scene_id = Uuid::now_v7().to_string();
    sqlx::query(
        "INSERT INTO scenes (id, tenant_id, state, request, labels, budget_micro_usd, created_at, updated_at)
         VALUES (?, ?, 'pending', ?, ?, ?, ?, ?)",
    )
    .bind(&scene_id)
    .bind(&new.tenant_id)
    .bind(new.request.to_string())
    .bind(json!(new.labels).to_string())
    .bind(new.budget_micro_usd)
    .bind(now)
    .bind(now)
    .execute(&mut *connection)
    .await?;
    let job_id = insert_job(connection, &new.tenant_id, &scene_id, None, None, now).await?;
    if let Some((key, body_digest)) = new.idempotency {
        sqlx::query(
            "INSERT INTO idempotency (tenant_id, key, body_digest, scene_id, job_id, expires_at)
             VALUES (?, ?, ?, ?, ?, ?)",
        )
        .bind(&new.tenant_id)
        .bind(key)
        .bind(body_digest)
        .bind(&scene_id)
        .bind(&job_id)
        .bind(now + IDEMPOTENCY_MS)
        .execute(connection)
        .await?;
    }
    Ok(Submitted::Created { scene_id, job_id })
}

/// A queued job on a scene, with its first event.
pub(super) async fn insert_job(
    connection: &mut SqliteConnection,
    tenant_id: &str,
    scene_id: &str,
    retry_of: Option<&str>,
    salt_from: Option<(&str, &str)>,
    now_ms: i64,
) -> Result<String, StoreError> {
    let job_id = Uuid::now_v7().to_string();
    let kind = if retry_of.is_some() { "retry" } else { "generate" };
    // A retry from a stage salts keys with its own id, so that its own restarts find its own work.
    let (from_stage, salt) = match salt_from {
        Some((stage, "")) => (Some(stage), Some(job_id.as_str())),
        Some((stage, salt)) => (Some(stage), Some(salt)),
        None => (None, None),
    };
    sqlx::query(
        "INSERT INTO jobs (id, tenant_id, kind, scene_id, retry_of, from_stage, salt, state, created_at)
         VALUES (?, ?, ?, ?, ?, ?, ?, 'queued', ?)",
    )
    .bind(&job_id)
    .bind(tenant_id)
    .bind(kind)
    .bind(scene_id)
    .bind(retry_of)
    .bind(from_stage)
    .bind(salt)
    .bind(now_ms)
    .execute(&mut *connection)
    .await?;
    events::append(connection, &job_id, now_ms, "job_queued", &json!({ "scene_id": scene_id })).await?;
    Ok(job_id)
}

async fn delete(
    connection: &mut SqliteConnection,
    tenant_id: String,
    id: String,
) -> Result<Deleted, StoreError> {
    let now = database::now_ms(connection).await?;
    let changed =
        sqlx::query("UPDATE scenes SET state = 'deleted', updated_at = ? WHERE id = ? AND tenant_id = ?")
            .bind(now)
            .bind(&id)
            .bind(&tenant_id)
            .execute(&mut *connection)
            .await?;
    if changed.rows_affected() == 0 {
        return Ok(Deleted::NotFound);
    }
    let jobs = sqlx::query("SELECT id, state FROM jobs WHERE scene_id = ?")
        .bind(&id)
        .fetch_all(&mut *connection)
        .await?;
    for job in jobs {
        let state: String = job.try_get("state")?;
        let active = JobState::parse(&state).is_some_and(|state| !state.is_final());
        if active {
            queue::move_job(connection, &job.try_get::<String, _>("id")?, JobEvent::CancelRequested, now)
                .await?;
        }
    }
    Ok(Deleted::Done)
}

fn scene_of(row: &SqliteRow) -> Result<SceneRow, StoreError> {
    let state: String = row.try_get("state")?;
    let json = |column: &'static str| -> Result<Option<Value>, StoreError> {
        let text: Option<String> = row.try_get(column)?;
        text.map(|text| serde_json::from_str(&text))
            .transpose()
            .map_err(|error| corrupt(format!("{column}: {error}")))
    };
    let labels = json("labels")?.unwrap_or_else(|| json!({}));
    Ok(SceneRow {
        id: row.try_get("id")?,
        parent_id: row.try_get("parent_id")?,
        state: SceneState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?,
        verdict: row.try_get("verdict")?,
        failure_code: row.try_get("failure_code")?,
        failure_message: row.try_get("failure_message")?,
        request: json("request")?.unwrap_or_default(),
        labels: serde_json::from_value(labels).map_err(|error| corrupt(format!("labels: {error}")))?,
        summary: json("summary")?,
        metrics: json("metrics")?,
        created_at_ms: row.try_get("created_at")?,
        updated_at_ms: row.try_get("updated_at")?,
    })
}

fn corrupt(reason: String) -> StoreError {
    StoreError::Corrupt { table: "scenes", reason }
}
