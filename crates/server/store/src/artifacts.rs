//! Files of a scene: artifacts of its stages, files of its bundle, archives by format.

use serde_json::Value;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::{Digest, Store, StoreError, database};
use crate::boxed;
use scene::{JobId, SceneId, TenantId};

/// A named file of a scene.
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

/// An artifact with its stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArtifactRow {
    pub file: FileRow,
    pub stage: String,
    pub job_id: JobId,
}

/// Result of a finished pipeline for the scene's rows.
#[derive(Clone, Debug)]
pub struct BuiltScene {
    /// Every file of the bundle.
    pub files: Vec<FileRow>,
    /// The archive with all of them.
    pub archive: ArchiveRow,
    /// `true` = certified `pass`; `false` = `quarantine`.
    pub passed: bool,
    /// Reasons for the quarantine, for the client.
    pub reasons: Vec<String>,
    pub summary: Value,
    pub metrics: Value,
}

impl BuiltScene {
    /// The verdict of the certificate.
    pub(crate) fn verdict(&self) -> &'static str {
        if self.passed { "pass" } else { "quarantine" }
    }
}

impl Store {
    /// Artifacts of a scene by name.
    #[boxed]
    pub async fn artifacts(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
    ) -> Result<Vec<ArtifactRow>, StoreError> {
        let rows = sqlx::query(
            "SELECT * FROM artifacts
             WHERE scene_id = $1 AND (SELECT tenant_id FROM scenes WHERE id = artifacts.scene_id) = $2
             ORDER BY name",
        )
        .bind(scene_id.as_str())
        .bind(tenant_id.as_str())
        .fetch_all(&self.readers)
        .await?;
        rows.iter().map(artifact_of).collect()
    }

    /// One artifact.
    #[boxed]
    pub async fn artifact(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
        name: &str,
    ) -> Result<Option<ArtifactRow>, StoreError> {
        let row = sqlx::query(
            "SELECT * FROM artifacts
             WHERE scene_id = $1 AND name = $2 AND (SELECT tenant_id FROM scenes WHERE id = artifacts.scene_id) = $3",
        )
        .bind(scene_id.as_str())
        .bind(name)
        .bind(tenant_id.as_str())
        .fetch_optional(&self.readers)
        .await?;
        row.as_ref().map(artifact_of).transpose()
    }

    /// Files of a scene's bundle by path.
    #[boxed]
    pub async fn bundle_files(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
    ) -> Result<Vec<FileRow>, StoreError> {
        let rows = sqlx::query(
            "SELECT path AS name, digest, media_type, size FROM bundle_files
             WHERE scene_id = $1 AND (SELECT tenant_id FROM scenes WHERE id = bundle_files.scene_id) = $2
             ORDER BY path",
        )
        .bind(scene_id.as_str())
        .bind(tenant_id.as_str())
        .fetch_all(&self.readers)
        .await?;
        rows.iter().map(file_of).collect()
    }

    /// The archive of a format, if it exists.
    #[boxed]
    pub async fn archive(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
        format: &str,
    ) -> Result<Option<ArchiveRow>, StoreError> {
        let row = sqlx::query(
            "SELECT digest, size FROM bundle_archives
             WHERE scene_id = $1 AND format = $2
               AND (SELECT tenant_id FROM scenes WHERE id = bundle_archives.scene_id) = $3",
        )
        .bind(scene_id.as_str())
        .bind(format)
        .bind(tenant_id.as_str())
        .fetch_optional(&self.readers)
        .await?;
        row.map(|row| {
            let digest: String = row.try_get("digest")?;
            Ok(ArchiveRow { digest: Digest::parse(&digest)?, size: row.try_get::<i64, _>("size")? as u64 })
        })
        .transpose()
    }

    /// Records an archive, whose blob must exist. A scene of another tenant does not change.
    #[boxed]
    pub async fn record_archive(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
        format: &str,
        archive: ArchiveRow,
    ) -> Result<(), StoreError> {
        let (tenant_id, scene_id, format) = (tenant_id.clone(), scene_id.clone(), format.to_owned());
        self.writer
            .write("record an archive", move |connection| {
                Box::pin(
                    async move { insert_archive(connection, &tenant_id, &scene_id, &format, &archive).await },
                )
            })
            .await
    }
}

/// Commits the result of a finished job: its scene's rows, verdict and state.
pub(super) async fn record_built(
    connection: &mut AnyConnection,
    job_id: &JobId,
    built: &BuiltScene,
    now_ms: i64,
) -> Result<(), StoreError> {
    let job = sqlx::query("SELECT tenant_id, scene_id FROM jobs WHERE id = $1")
        .bind(job_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    let tenant_id: TenantId = database::id(&job, "jobs", "tenant_id")?;
    let scene_id: SceneId = database::id(&job, "jobs", "scene_id")?;
    sqlx::query("DELETE FROM bundle_files WHERE scene_id = $1")
        .bind(scene_id.as_str())
        .execute(&mut *connection)
        .await?;
    sqlx::query("DELETE FROM bundle_archives WHERE scene_id = $1")
        .bind(scene_id.as_str())
        .execute(&mut *connection)
        .await?;
    for file in &built.files {
        sqlx::query(
            "INSERT INTO bundle_files (scene_id, path, digest, media_type, size) VALUES ($1, $2, $3, $4, $5)",
        )
        .bind(scene_id.as_str())
        .bind(&file.name)
        .bind(file.digest.as_str())
        .bind(&file.media_type)
        .bind(file.size as i64)
        .execute(&mut *connection)
        .await?;
    }
    insert_archive(connection, &tenant_id, &scene_id, "all", &built.archive).await?;
    let (state, code) = if built.passed { ("ready", None) } else { ("failed", Some("quarantined")) };
    let message = (!built.passed).then(|| {
        format!(
            "the certificate says quarantine: {}; fetch the bundle only to inspect it",
            built.reasons.join("; ")
        )
    });
    sqlx::query(
        "UPDATE scenes SET state = CASE state WHEN 'deleted' THEN state ELSE $1 END, stripped_at = NULL, verdict = $2,
                           failure_code = $3, failure_message = $4, summary = $5, metrics = $6, updated_at = $7
         WHERE id = $8",
    )
    .bind(state)
    .bind(built.verdict())
    .bind(code)
    .bind(message)
    .bind(built.summary.to_string())
    .bind(built.metrics.to_string())
    .bind(now_ms)
    .bind(scene_id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

async fn insert_archive(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    scene_id: &SceneId,
    format: &str,
    archive: &ArchiveRow,
) -> Result<(), StoreError> {
    sqlx::query(
        "INSERT INTO bundle_archives (scene_id, format, digest, size)
         SELECT id, $1, $2, $3 FROM scenes WHERE id = $4 AND tenant_id = $5
         ON CONFLICT (scene_id, format) DO UPDATE SET digest = excluded.digest, size = excluded.size",
    )
    .bind(format)
    .bind(archive.digest.as_str())
    .bind(archive.size as i64)
    .bind(scene_id.as_str())
    .bind(tenant_id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

fn artifact_of(row: &AnyRow) -> Result<ArtifactRow, StoreError> {
    Ok(ArtifactRow {
        file: file_of(row)?,
        stage: row.try_get("stage")?,
        job_id: database::id(row, "artifacts", "job_id")?,
    })
}

fn file_of(row: &AnyRow) -> Result<FileRow, StoreError> {
    let digest: String = row.try_get("digest")?;
    Ok(FileRow {
        name: row.try_get("name")?,
        digest: Digest::parse(&digest)?,
        media_type: row.try_get("media_type")?,
        size: row.try_get::<i64, _>("size")? as u64,
    })
}
