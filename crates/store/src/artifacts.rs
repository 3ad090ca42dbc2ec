//! What a scene consists of: artifacts of its stages, the files of its bundle, its archives by format.

use serde_json::{Value, json};
use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};

use super::{Digest, Store, StoreError, events};

/// Bytes with a name inside a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileRow {
    /// `reference/known.json` for an artifact, `mjcf/scene.xml` for a file of the bundle.
    pub name: String,
    pub digest: Digest,
    pub media_type: String,
    /// Bytes.
    pub size: u64,
}

/// An archive of the bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArchiveRow {
    pub digest: Digest,
    /// Bytes.
    pub size: u64,
}

/// An artifact with the stage that put it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArtifactRow {
    pub file: FileRow,
    pub stage: String,
    pub job_id: String,
}

/// What a finished pipeline leaves in the scene's rows.
#[derive(Clone, Debug)]
pub struct BuiltRows {
    /// Every file of the bundle.
    pub files: Vec<FileRow>,
    /// The archive with all of them.
    pub archive: ArchiveRow,
    /// `true` = certified `pass`; `false` = `quarantine`.
    pub passed: bool,
    /// Why it is quarantined, for the client.
    pub reasons: Vec<String>,
    pub summary: Value,
    pub metrics: Value,
}

impl Store {
    /// Artifacts of a scene by name.
    pub async fn artifacts(&self, scene_id: &str) -> Result<Vec<ArtifactRow>, StoreError> {
        let rows = sqlx::query("SELECT * FROM artifacts WHERE scene_id = ? ORDER BY name")
            .bind(scene_id)
            .fetch_all(&self.readers)
            .await?;
        rows.iter().map(artifact_of).collect()
    }

    /// One artifact.
    pub async fn artifact(&self, scene_id: &str, name: &str) -> Result<Option<ArtifactRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM artifacts WHERE scene_id = ? AND name = ?")
            .bind(scene_id)
            .bind(name)
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(artifact_of).transpose()
    }

    /// Files of a scene's bundle by path.
    pub async fn bundle_files(&self, scene_id: &str) -> Result<Vec<FileRow>, StoreError> {
        let rows = sqlx::query(
            "SELECT path AS name, digest, media_type, size FROM bundle_files WHERE scene_id = ? ORDER BY path",
        )
        .bind(scene_id)
        .fetch_all(&self.readers)
        .await?;
        rows.iter().map(file_of).collect()
    }

    /// The archive of a format, if it was made already.
    pub async fn archive(&self, scene_id: &str, format: &str) -> Result<Option<ArchiveRow>, StoreError> {
        let row = sqlx::query("SELECT digest, size FROM bundle_archives WHERE scene_id = ? AND format = ?")
            .bind(scene_id)
            .bind(format)
            .fetch_optional(&self.readers)
            .await?;
        row.map(|row| {
            let digest: String = row.try_get("digest")?;
            Ok(ArchiveRow { digest: Digest::parse(&digest)?, size: row.try_get::<i64, _>("size")? as u64 })
        })
        .transpose()
    }

    /// Remembers an archive (its blob is put already).
    pub async fn record_archive(
        &self,
        scene_id: &str,
        format: &str,
        archive: ArchiveRow,
    ) -> Result<(), StoreError> {
        let (scene_id, format) = (scene_id.to_owned(), format.to_owned());
        self.writer
            .write("record an archive", move |connection| {
                Box::pin(async move { insert_archive(connection, &scene_id, &format, &archive).await })
            })
            .await
    }
}

/// The commit of a finished job: its scene's rows, verdict, state and last event.
pub(super) async fn record_built(
    connection: &mut SqliteConnection,
    job_id: &str,
    built: &BuiltRows,
    now_ms: i64,
) -> Result<(), StoreError> {
    let scene_id: String = sqlx::query_scalar("SELECT scene_id FROM jobs WHERE id = ?")
        .bind(job_id)
        .fetch_one(&mut *connection)
        .await?;
    sqlx::query("DELETE FROM bundle_files WHERE scene_id = ?")
        .bind(&scene_id)
        .execute(&mut *connection)
        .await?;
    sqlx::query("DELETE FROM bundle_archives WHERE scene_id = ?")
        .bind(&scene_id)
        .execute(&mut *connection)
        .await?;
    for file in &built.files {
        sqlx::query(
            "INSERT INTO bundle_files (scene_id, path, digest, media_type, size) VALUES (?, ?, ?, ?, ?)",
        )
        .bind(&scene_id)
        .bind(&file.name)
        .bind(file.digest.as_str())
        .bind(&file.media_type)
        .bind(file.size as i64)
        .execute(&mut *connection)
        .await?;
    }
    insert_archive(connection, &scene_id, "all", &built.archive).await?;
    let (state, verdict, code) =
        if built.passed { ("ready", "pass", None) } else { ("failed", "quarantine", Some("quarantined")) };
    let message = (!built.passed).then(|| {
        format!(
            "the certificate says quarantine: {}; fetch the bundle only to inspect it",
            built.reasons.join("; ")
        )
    });
    sqlx::query(
        "UPDATE scenes SET state = CASE state WHEN 'deleted' THEN state ELSE ? END, verdict = ?,
                           failure_code = ?, failure_message = ?, summary = ?, metrics = ?, updated_at = ?
         WHERE id = ?",
    )
    .bind(state)
    .bind(verdict)
    .bind(code)
    .bind(message)
    .bind(built.summary.to_string())
    .bind(built.metrics.to_string())
    .bind(now_ms)
    .bind(&scene_id)
    .execute(&mut *connection)
    .await?;
    let data = json!({ "verdict": verdict, "metrics": built.metrics });
    events::append(connection, job_id, now_ms, "job_succeeded", &data).await
}

async fn insert_archive(
    connection: &mut SqliteConnection,
    scene_id: &str,
    format: &str,
    archive: &ArchiveRow,
) -> Result<(), StoreError> {
    sqlx::query(
        "INSERT INTO bundle_archives (scene_id, format, digest, size) VALUES (?, ?, ?, ?)
         ON CONFLICT DO UPDATE SET digest = excluded.digest, size = excluded.size",
    )
    .bind(scene_id)
    .bind(format)
    .bind(archive.digest.as_str())
    .bind(archive.size as i64)
    .execute(connection)
    .await?;
    Ok(())
}

fn artifact_of(row: &SqliteRow) -> Result<ArtifactRow, StoreError> {
    Ok(ArtifactRow { file: file_of(row)?, stage: row.try_get("stage")?, job_id: row.try_get("job_id")? })
}

fn file_of(row: &SqliteRow) -> Result<FileRow, StoreError> {
    let digest: String = row.try_get("digest")?;
    Ok(FileRow {
        name: row.try_get("name")?,
        digest: Digest::parse(&digest)?,
        media_type: row.try_get("media_type")?,
        size: row.try_get::<i64, _>("size")? as u64,
    })
}
