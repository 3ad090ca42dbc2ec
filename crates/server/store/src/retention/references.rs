//! Every row that refers to a blob.
//!
//! Rows of `bundle_files` have digests too, but no blobs: their bytes lie in the archive.

use sqlx::Row;

use super::super::checkpoints::read_artifacts;
use super::super::readers::Readers;
use super::{Digest, StoreError};

/// Rows of one query.
const PAGE_ROWS: i64 = 1000;

/// Purpose of a blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ReferenceKind {
    /// The output of a stage; computed again if it is missing.
    Checkpoint,
    /// An artifact; computed again if it is missing.
    Artifact,
    /// An archive of a bundle; computed again if it is missing.
    Bundle,
    /// The answer of a remote model to a job that may still need it.
    Answer,
    /// An attempt of a recording that is not ended; made again if it is missing.
    Episode,
    /// A file of a dataset or of a recording, or the answer of an execution; nothing can make it again.
    Dataset,
    /// The image of a request; nothing can make it again.
    Input,
}

/// About how many references there are.
pub(super) async fn estimate(readers: &Readers) -> Result<u64, StoreError> {
    let count: i64 = sqlx::query_scalar(
        "SELECT CAST((SELECT COUNT(*) FROM artifacts) + 4 * (SELECT COUNT(*) FROM checkpoints)
                   + (SELECT COUNT(*) FROM bundle_archives) + (SELECT COUNT(*) FROM dataset_files)
                   + (SELECT COUNT(*) FROM recording_attempts) + 4 * (SELECT COUNT(*) FROM recording_archives) AS BIGINT)",
    )
    .fetch_one(readers)
    .await?;
    Ok(count.max(0) as u64)
}

/// Visits every reference; several rows may refer to the same blob. A row that is added meanwhile may be passed over:
/// its blob was put a moment ago, or another row refers to it.
pub(crate) async fn for_each_reference(
    readers: &Readers,
    mut visit: impl FnMut(ReferenceKind, Digest) + Send,
) -> Result<(), StoreError> {
    let (mut tenant, mut key) = (String::new(), String::new());
    loop {
        let rows = sqlx::query(
            "SELECT tenant_id, key, output, artifacts FROM checkpoints
             WHERE (tenant_id, key) > ($1, $2) ORDER BY tenant_id, key LIMIT $3",
        )
        .bind(&tenant)
        .bind(&key)
        .bind(PAGE_ROWS)
        .fetch_all(readers)
        .await?;
        let Some(last) = rows.last() else { break };
        (tenant, key) = (last.try_get("tenant_id")?, last.try_get("key")?);
        for row in &rows {
            // An unreadable row counts as missing, so its blobs may go.
            if let Ok(output) = Digest::parse(&row.try_get::<String, _>("output")?) {
                visit(ReferenceKind::Checkpoint, output);
            }
            let artifacts: String = row.try_get("artifacts")?;
            for artifact in read_artifacts(&artifacts).unwrap_or_default() {
                visit(ReferenceKind::Artifact, artifact.digest);
            }
        }
    }
    for (kind, table, owner, name) in [
        (ReferenceKind::Artifact, "artifacts", "scene_id", "name"),
        (ReferenceKind::Bundle, "bundle_archives", "scene_id", "format"),
        (ReferenceKind::Dataset, "dataset_files", "dataset_id", "path"),
    ] {
        let sql = format!(
            "SELECT {owner} AS owner, {name} AS name, digest FROM {table}
             WHERE ({owner}, {name}) > ($1, $2) ORDER BY {owner}, {name} LIMIT $3"
        );
        let (mut owner, mut name) = (String::new(), String::new());
        loop {
            let rows = sqlx::query(sqlx::AssertSqlSafe(sql.as_str()))
                .bind(&owner)
                .bind(&name)
                .bind(PAGE_ROWS)
                .fetch_all(readers)
                .await?;
            let Some(last) = rows.last() else { break };
            (owner, name) = (last.try_get("owner")?, last.try_get("name")?);
            for row in &rows {
                visit(kind, Digest::parse(&row.try_get::<String, _>("digest")?)?);
            }
        }
    }
    recordings(readers, &mut visit).await?;
    executions(readers, &mut visit).await?;
    let mut call: i64 = 0;
    loop {
        let rows = sqlx::query(
            "SELECT id, answer_file, task_file FROM calls
             WHERE id > $1 AND (answer_file IS NOT NULL OR task_file IS NOT NULL) ORDER BY id LIMIT $2",
        )
        .bind(call)
        .bind(PAGE_ROWS)
        .fetch_all(readers)
        .await?;
        let Some(last) = rows.last() else { break };
        call = last.try_get("id")?;
        for row in &rows {
            for column in ["answer_file", "task_file"] {
                if let Some(digest) = row.try_get::<Option<String>, _>(column)? {
                    visit(ReferenceKind::Answer, Digest::parse(&digest)?);
                }
            }
        }
    }
    let mut scene = String::new();
    loop {
        let rows = sqlx::query(
            "SELECT id, request FROM scenes
             WHERE id > $1 AND state <> 'deleted' AND request LIKE '%sha256%' ORDER BY id LIMIT $2",
        )
        .bind(&scene)
        .bind(PAGE_ROWS)
        .fetch_all(readers)
        .await?;
        let Some(last) = rows.last() else { break };
        scene = last.try_get("id")?;
        for row in &rows {
            digests_in(&row.try_get::<String, _>("request")?)
                .for_each(|digest| visit(ReferenceKind::Input, digest));
        }
    }
    Ok(())
}

/// References of recordings: the bundle of one that is not ended, its episodes, and the parts of its dataset.
async fn recordings(
    readers: &Readers,
    visit: &mut (impl FnMut(ReferenceKind, Digest) + Send),
) -> Result<(), StoreError> {
    let bundles: Vec<String> =
        sqlx::query_scalar("SELECT bundle FROM recordings WHERE state IN ('queued', 'running')")
            .fetch_all(readers)
            .await?;
    for bundle in bundles {
        visit(ReferenceKind::Bundle, Digest::parse(&bundle)?);
    }
    let (mut recording, mut number) = (String::new(), -1);
    loop {
        let rows = sqlx::query(
            "SELECT recording_id, number, unit FROM recording_attempts
             WHERE (recording_id, number) > ($1, $2) AND unit IS NOT NULL
             ORDER BY recording_id, number LIMIT $3",
        )
        .bind(&recording)
        .bind(number)
        .bind(PAGE_ROWS)
        .fetch_all(readers)
        .await?;
        let Some(last) = rows.last() else { break };
        (recording, number) = (last.try_get("recording_id")?, last.try_get::<i64, _>("number")?);
        for row in &rows {
            visit(ReferenceKind::Episode, Digest::parse(&row.try_get::<String, _>("unit")?)?);
        }
    }
    let (mut recording, mut format) = (String::new(), String::new());
    loop {
        let rows = sqlx::query(
            "SELECT recording_id, format, parts FROM recording_archives
             WHERE (recording_id, format) > ($1, $2) ORDER BY recording_id, format LIMIT $3",
        )
        .bind(&recording)
        .bind(&format)
        .bind(PAGE_ROWS)
        .fetch_all(readers)
        .await?;
        let Some(last) = rows.last() else { break };
        (recording, format) = (last.try_get("recording_id")?, last.try_get("format")?);
        for row in &rows {
            digests_in(&row.try_get::<String, _>("parts")?)
                .for_each(|digest| visit(ReferenceKind::Dataset, digest));
        }
    }
    Ok(())
}

/// References of executions: the bundle while there is no answer, and the answer.
async fn executions(
    readers: &Readers,
    visit: &mut (impl FnMut(ReferenceKind, Digest) + Send),
) -> Result<(), StoreError> {
    let mut id = String::new();
    loop {
        let rows = sqlx::query(
            "SELECT job_id, bundle, answer FROM executions WHERE job_id > $1 ORDER BY job_id LIMIT $2",
        )
        .bind(&id)
        .bind(PAGE_ROWS)
        .fetch_all(readers)
        .await?;
        let Some(last) = rows.last() else { return Ok(()) };
        id = last.try_get("job_id")?;
        for row in &rows {
            match row.try_get::<Option<String>, _>("answer")? {
                Some(answer) => visit(ReferenceKind::Dataset, Digest::parse(&answer)?),
                None => visit(ReferenceKind::Bundle, Digest::parse(&row.try_get::<String, _>("bundle")?)?),
            }
        }
    }
}

/// Every word of a text that is a digest. The store does not know the form of requests.
fn digests_in(text: &str) -> impl Iterator<Item = Digest> {
    text.split(|c: char| !c.is_ascii_alphanumeric()).filter_map(|word| Digest::parse(word).ok())
}
