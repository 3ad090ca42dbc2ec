//! The bundles of a dataset's scenes, copied from the blobs, and a record of each scene.
//!
//! The record is a line of `records.jsonl`, in the form of a batch's output, so that labels select scenes and the
//! yield counts those without a bundle.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use futures::TryStreamExt;
use serde_json::{Value, json};

use super::request::DatasetSource;
use super::{FreezeError, Steps};
use datasets::bundle::Bundle;
use scene::{BatchId, SceneId, TenantId};
use store::batches::OutputKind;
use store::lifecycle::SceneState;
use store::scenes::{SceneFilter, SceneRow};
use store::{Digest, Store};

/// Rows that are read at once.
const PAGE: u32 = 500;
/// The records in the work folder.
pub(super) const RECORDS: &str = "records.jsonl";

/// A scene that is to be read, or why it has no bundle.
struct Member {
    custom_id: String,
    /// As the output of a batch has it.
    state: String,
    labels: BTreeMap<String, String>,
    scene_id: Option<SceneId>,
}

/// Copies the bundles below `folder`; the path of the records.
pub(super) async fn gather(
    store: &Store,
    tenant_id: &TenantId,
    source: &DatasetSource,
    folder: &Path,
    steps: &Steps,
) -> Result<PathBuf, FreezeError> {
    let members = match source {
        DatasetSource::Batch(id) => of_batch(store, tenant_id, id).await?,
        DatasetSource::Scenes(ids) => of_ids(store, tenant_id, ids).await?,
        DatasetSource::Label { key, value } => of_label(store, tenant_id, key, value).await?,
    };
    if members.is_empty() {
        return Err(FreezeError::Request(
            "no scene is in the source; check the batch, the ids or the label".into(),
        ));
    }
    std::fs::create_dir_all(folder).map_err(FreezeError::file("create", folder))?;
    let mut lines = String::new();
    for (index, member) in members.iter().enumerate() {
        let mut record = json!({
            "custom_id": member.custom_id, "state": member.state, "labels": member.labels,
        });
        if let Some(scene_id) = &member.scene_id
            && let Some(name) = copy(store, tenant_id, scene_id, folder).await?
        {
            record["scene_id"] = json!(id_in(&folder.join(&name))?);
            record["bundle"] = json!(name);
        }
        lines += &format!("{record}\n");
        steps.set(index + 1, members.len());
    }
    let records = folder.join(RECORDS);
    std::fs::write(&records, lines).map_err(FreezeError::file("write", &records))?;
    Ok(records)
}

async fn of_batch(store: &Store, tenant_id: &TenantId, id: &BatchId) -> Result<Vec<Member>, FreezeError> {
    let mut members = Vec::new();
    for kind in [OutputKind::Output, OutputKind::Errors] {
        let mut after_place = 0;
        loop {
            let rows = store.batch_output(id, kind, after_place, PAGE).await?;
            let is_last = rows.len() < PAGE as usize;
            for row in rows {
                after_place = row.place;
                let scene_id = row.line.scene_id.and_then(|id| id.parse().ok());
                members.push(Member {
                    custom_id: row.line.custom_id.unwrap_or_else(|| format!("line {}", row.place)),
                    state: row.line.state.as_str().to_owned(),
                    labels: BTreeMap::new(),
                    scene_id,
                });
            }
            if is_last {
                break;
            }
        }
    }
    // A sweep may have removed requests since, if it was deleted.
    if store.batch(tenant_id, id).await?.is_none_or(|batch| batch.is_deleted) {
        return Err(FreezeError::Request(format!("the batch {id} was deleted; name its scenes instead")));
    }
    for member in &mut members {
        if let Some(scene_id) = &member.scene_id
            && let Some(scene) = store.scene(tenant_id, scene_id).await?
        {
            member.labels = scene.labels;
        }
    }
    Ok(members)
}

async fn of_ids(store: &Store, tenant_id: &TenantId, ids: &[SceneId]) -> Result<Vec<Member>, FreezeError> {
    let mut members = Vec::with_capacity(ids.len());
    for id in ids {
        let scene = store.scene(tenant_id, id).await?;
        let scene = scene.filter(|scene| scene.state != SceneState::Deleted);
        let scene =
            scene.ok_or_else(|| FreezeError::Request(format!("the scene {id} was deleted; leave it out")))?;
        members.push(member(scene));
    }
    Ok(members)
}

async fn of_label(
    store: &Store,
    tenant_id: &TenantId,
    key: &str,
    value: &str,
) -> Result<Vec<Member>, FreezeError> {
    let mut members = Vec::new();
    let mut before_id = None;
    loop {
        let label = Some((key.to_owned(), value.to_owned()));
        let filter = SceneFilter { label, before_id, limit: PAGE, ..SceneFilter::default() };
        let page = store.scenes(tenant_id, filter).await?;
        let is_last = page.len() < PAGE as usize;
        before_id = page.last().map(|(scene, _)| scene.id.clone());
        members.extend(page.into_iter().map(|(scene, _)| member(scene)));
        if is_last {
            members.reverse();
            return Ok(members);
        }
    }
}

fn member(scene: SceneRow) -> Member {
    let state = match (scene.state, scene.failure_code.as_deref()) {
        (SceneState::Ready, _) => "succeeded",
        (SceneState::Failed, Some("quarantined")) => "quarantined",
        (SceneState::Failed, Some("cancelled")) => "cancelled",
        (SceneState::Failed, _) => "failed",
        (SceneState::Pending | SceneState::Deleted, _) => "pending",
    };
    Member {
        // Names of requests are unique in their batch only.
        custom_id: scene.id.to_string(),
        state: state.to_owned(),
        labels: scene.labels,
        scene_id: Some(scene.id),
    }
}

/// Copies the bundle of a scene unless it is there already; its name in the folder, or `None` without a bundle.
async fn copy(
    store: &Store,
    tenant_id: &TenantId,
    scene_id: &SceneId,
    folder: &Path,
) -> Result<Option<String>, FreezeError> {
    let Some(archive) = store.archive(tenant_id, scene_id, "all").await? else { return Ok(None) };
    let name = format!("{scene_id}.zip");
    let target = folder.join(&name);
    // A copy has its name only when it is whole.
    if std::fs::metadata(&target).is_ok_and(|about| about.len() == archive.size) {
        return Ok(Some(name));
    }
    if !copy_blob(store, &archive.digest, &target).await? {
        return Err(FreezeError::Request(format!(
            "the bundle of the scene {scene_id} is lost or damaged; download it once, which makes it again, and \
             freeze then"
        )));
    }
    Ok(Some(name))
}

/// Copies a blob into a file that appears whole; `false` if it is missing or damaged.
pub(super) async fn copy_blob(store: &Store, digest: &Digest, target: &Path) -> Result<bool, FreezeError> {
    let Some(mut chunks) = store.blobs().stream(digest, None).await? else { return Ok(false) };
    let partial = target.with_extension("partial");
    let mut file = File::create(&partial).map_err(FreezeError::file("write", &partial))?;
    loop {
        match chunks.try_next().await {
            Ok(Some(bytes)) => file.write_all(&bytes).map_err(FreezeError::file("write", &partial))?,
            Ok(None) => break,
            Err(store::StoreError::BlobDamaged { .. }) => return Ok(false),
            Err(error) => return Err(error.into()),
        }
    }
    std::fs::rename(&partial, target).map_err(FreezeError::file("rename to", target))?;
    Ok(true)
}

/// The id that the bundle gives its scene: it names the scene in the dataset.
fn id_in(place: &Path) -> Result<Value, FreezeError> {
    let scene = Bundle::open(place)?.read("scene.json")?;
    let scene: Value = serde_json::from_slice(&scene).unwrap_or_default();
    Ok(scene["id"].clone())
}
