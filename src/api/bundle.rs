//! `/scenes/{scene_id}/bundle`: the archive, whole or by format.
//!
//! The whole archive comes from the pipeline. One format's archive is cut from it entry by entry (same
//! names, same compressed bytes), once; then it is a blob like the other.

use std::borrow::Cow;
use std::io::Cursor;

use axum::http::{HeaderMap, Method};
use axum::response::Response;
use bytes::Bytes;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use zip::result::ZipResult;
use zip::{ZipArchive, ZipWriter};

use super::download::{Content, Download, respond};
use super::extract::{PathId, TenantApi};
use super::query::Parameters;
use super::rebuild::missing_bytes;
use super::scenes::find;
use crate::problem::{Problem, ProblemType};
use scene::SceneId;
use store::Digest;
use store::artifacts::ArchiveRow;
use store::lifecycle::SceneState;
use store::scenes::SceneRow;

/// Formats with a folder of their own in the bundle; everything outside these folders is in every archive.
const FORMATS: [&str; 5] = ["usd", "urdf", "mjcf", "sdf", "glb"];

/// Parameters of `GET /scenes/{scene_id}/bundle`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BundleParameters {
    /// Only this format's folder, with the files every format shares; `all` when absent.
    format: BundleFormat,
    /// Also give the bundle of a scene whose certificate says quarantine.
    quarantined: bool,
}

/// One of [`FORMATS`], or `all`.
#[derive(Deserialize)]
#[serde(try_from = "String")]
pub(super) struct BundleFormat(String);

impl BundleFormat {
    fn as_str(&self) -> &str {
        &self.0
    }
}

impl JsonSchema for BundleFormat {
    fn schema_name() -> Cow<'static, str> {
        "BundleFormat".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names: Vec<&str> = FORMATS.into_iter().chain(["all"]).collect();
        json_schema!({ "description": "Format of a scene, or all.", "type": "string", "enum": names })
    }
}

impl Default for BundleFormat {
    fn default() -> Self {
        Self("all".to_owned())
    }
}

impl TryFrom<String> for BundleFormat {
    type Error = String;

    fn try_from(name: String) -> Result<Self, Self::Error> {
        if name == "all" || FORMATS.contains(&name.as_str()) {
            Ok(Self(name))
        } else {
            Err(format!("must be {} or all", FORMATS.join(", ")))
        }
    }
}

/// `GET /scenes/{scene_id}/bundle`.
pub async fn download(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    Parameters(parameters): Parameters<BundleParameters>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let BundleParameters { format, quarantined } = parameters;
    let format = format.as_str();
    let scene = find(&api, &scene_id).await?;
    check_state(&scene, quarantined)?;
    let suffix = if format == "all" { String::new() } else { format!("-{format}") };
    // A damaged archive of one format is gone once it was found damaged; the second time it is cut again.
    for _ in 0..2 {
        let Some(Archive { row, unstored }) = archive(&api, &scene_id, format).await? else { break };
        let what = Download {
            digest: &row.digest,
            size: row.size,
            media_type: "application/zip",
            file_name: Some(format!("scene-{scene_id}{suffix}.zip")),
            content: unstored.map_or(Content::Stored, Content::Memory),
        };
        if let Some(response) = respond(&api, &method, &headers, what).await? {
            return Ok(response);
        }
    }
    Err(missing_bytes(&api, &scene_id).await)
}

/// Refuses a scene that has no bundle, or one that may not be used, unless it is asked for.
pub(super) fn check_state(scene: &SceneRow, quarantined: bool) -> Result<(), Problem> {
    let conflict = |code, detail: &str| Err(Problem::new(ProblemType::Conflict, code, detail));
    match (scene.state, scene.failure_code.as_deref()) {
        (SceneState::Ready, _) => Ok(()),
        (SceneState::Failed, Some("quarantined")) if quarantined => Ok(()),
        (SceneState::Failed, Some("quarantined")) => conflict(
            "scene_quarantined",
            "its certificate says quarantine; to inspect it anyway, ask with ?quarantined=true",
        ),
        (SceneState::Failed, _) => {
            conflict("scene_failed", "this scene has no bundle; see its failure, then retry its job")
        }
        (SceneState::Pending | SceneState::Deleted, _) => {
            conflict("scene_not_ready", "this scene is not finished; follow its job's events")
        }
    }
}

/// An archive, and its bytes where they could not be stored.
pub(super) struct Archive {
    pub row: ArchiveRow,
    pub unstored: Option<Bytes>,
}

/// The archive of a format; `None` if the bytes of the whole bundle are gone.
async fn archive(api: &TenantApi, scene_id: &SceneId, format: &str) -> Result<Option<Archive>, Problem> {
    if let Some(archive) = kept(api, scene_id, format).await? {
        return Ok(Some(archive));
    }
    let all = api.store.archive(&api.tenant_id, scene_id, "all").await?.ok_or_else(bundle_removed)?;
    if format == "all" {
        return Ok(None);
    }
    let Some(bytes) = api.store.blobs().get(&all.digest).await? else { return Ok(None) };
    let wanted = format.to_owned();
    let cut = tokio::task::spawn_blocking(move || only(&bytes, &wanted)).await;
    let part = match cut {
        Ok(Ok(part)) => part,
        _ => return Err(unreadable()),
    };
    let Some(part) = part else {
        return Err(Problem::new(
            ProblemType::NotFound,
            "format_not_in_bundle",
            format!("this bundle has no {format}; ask with format=all for what it has"),
        ));
    };
    keep(api, scene_id, format, part).await.map(Some)
}

/// The archive of a format that was made before, where its bytes are there.
pub(super) async fn kept(
    api: &TenantApi,
    scene_id: &SceneId,
    format: &str,
) -> Result<Option<Archive>, Problem> {
    let Some(row) = api.store.archive(&api.tenant_id, scene_id, format).await? else { return Ok(None) };
    let is_there = api.store.blobs().contains(&row.digest).await?;
    Ok(is_there.then_some(Archive { row, unstored: None }))
}

/// Keeps what was made out of a bundle, so that it is made once.
pub(super) async fn keep(
    api: &TenantApi,
    scene_id: &SceneId,
    format: &str,
    part: Bytes,
) -> Result<Archive, Problem> {
    let size = part.len() as u64;
    let stored = match api.store.blobs().put(part.clone()).await {
        Ok(digest) => {
            let row = ArchiveRow { digest, size };
            api.store.record_archive(&api.tenant_id, scene_id, format, row.clone()).await.map(|()| row)
        }
        Err(error) => Err(error),
    };
    match stored {
        Ok(row) => Ok(Archive { row, unstored: None }),
        // A full disk is no reason not to send what is there.
        Err(error) if error.outage().is_some() => {
            let row = ArchiveRow { digest: Digest::of(&part), size };
            Ok(Archive { row, unstored: Some(part) })
        }
        Err(error) => Err(error.into()),
    }
}

/// The bundle is gone by the rules of retention.
pub(super) fn bundle_removed() -> Problem {
    let detail = "the bundle of this quarantined scene was removed after its time; submit the scene again";
    Problem::new(ProblemType::Gone, "bundle_removed", detail)
}

/// The bundle is not what it was.
pub(super) fn unreadable() -> Problem {
    Problem::new(ProblemType::Internal, "bundle_unreadable", "the bundle cannot be read")
}

/// The entries of one format and of no format; `None` when the format has none.
fn only(archive: &[u8], format: &str) -> ZipResult<Option<Bytes>> {
    let mut all = ZipArchive::new(Cursor::new(archive))?;
    let mut part = ZipWriter::new(Cursor::new(Vec::new()));
    let mut found = false;
    for index in 0..all.len() {
        let entry = all.by_index_raw(index)?;
        // `scene-<id>/mjcf/scene.xml`: the folder below the bundle's own decides.
        let name = entry.name()?;
        let folder = name.split('/').find(|folder| !folder.starts_with("scene-"));
        let folder = folder.unwrap_or_default().to_owned();
        if folder == format {
            found = true;
        } else if FORMATS.contains(&folder.as_str()) {
            continue;
        }
        part.raw_copy_file(entry)?;
    }
    let bytes = part.finish()?.into_inner();
    Ok(found.then(|| Bytes::from(bytes)))
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};

    use super::*;
    use zip::write::SimpleFileOptions;

    #[test]
    fn one_format_and_what_belongs_to_all() {
        let mut all = ZipWriter::new(Cursor::new(Vec::new()));
        for path in ["scene.json", "mjcf/scene.xml", "usd/scene.usda", "preview/hero.png"] {
            all.start_file(format!("scene-12ab/{path}"), SimpleFileOptions::default()).expect("starts");
            all.write_all(path.as_bytes()).expect("writes");
        }
        let all = all.finish().expect("finishes").into_inner();
        let part = only(&all, "mjcf").expect("reads").expect("has it");
        assert_eq!(part, only(&all, "mjcf").expect("reads").expect("has it"));
        let mut part = ZipArchive::new(Cursor::new(&part[..])).expect("is an archive");
        let names: Vec<String> = part.file_names().map(|name| name.expect("UTF-8").into_owned()).collect();
        assert_eq!(
            names,
            ["scene.json", "mjcf/scene.xml", "preview/hero.png"].map(|p| format!("scene-12ab/{p}"))
        );
        let mut text = String::new();
        part.by_name("scene-12ab/mjcf/scene.xml")
            .expect("is there")
            .read_to_string(&mut text)
            .expect("reads");
        assert_eq!(text, "mjcf/scene.xml");
        assert!(only(&all, "sdf").expect("reads").is_none());
    }
}
