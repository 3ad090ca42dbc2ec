//! `/scenes/{scene_id}/files`: the files of a bundle, one by one. Their bytes lie in its archive; the store has their
//! names, sizes and digests.

use std::io::{Cursor, Read};

use axum::Json;
use axum::http::{HeaderMap, HeaderValue, Method, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use zip::ZipArchive;
use zip::result::ZipResult;

use super::bundle::{bundle_removed, check_state, unreadable};
use super::download::{Content, Download, has_tag, respond};
use super::extract::{PathId, PathName, TenantApi};
use super::query::Parameters;
use super::rebuild::missing_bytes;
use super::scenes::find;
use crate::problem::Problem;
use crate::schemas::values::{Link, MAX_INTEGER, Sha256};
use scene::SceneId;
use store::Digest;
use store::artifacts::FileRow;

/// Policy of the report in a frame of the page: it shows its own images in its own style.
const REPORT_POLICY: &str =
    "sandbox; default-src 'none'; img-src data:; style-src 'unsafe-inline'; frame-ancestors 'self'";

/// Parameters of the files of a bundle.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FileParameters {
    /// Also those of a scene whose certificate says quarantine.
    quarantined: bool,
}

/// The files of a bundle by name.
#[derive(Serialize, JsonSchema)]
pub(super) struct BundleFileList {
    files: Vec<BundleFileView>,
}

/// A file of a bundle.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "BundleFile")]
pub(super) struct BundleFileView {
    /// Path below the folder of the bundle.
    name: String,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    size_bytes: u64,
    #[schemars(with = "Sha256")]
    sha256: String,
    media_type: String,
    #[schemars(with = "Link")]
    link: String,
}

/// `GET /scenes/{scene_id}/files`.
pub async fn list(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    Parameters(parameters): Parameters<FileParameters>,
) -> Result<Response, Problem> {
    let files = files_of(&api, &scene_id, parameters.quarantined).await?;
    let suffix = if parameters.quarantined { "?quarantined=true" } else { "" };
    let view = |file: FileRow| BundleFileView {
        link: format!("/scenes/{scene_id}/files/{}{suffix}", file.name),
        name: file.name,
        size_bytes: file.size,
        sha256: file.digest.to_string(),
        media_type: file.media_type,
    };
    Ok(Json(BundleFileList { files: files.into_iter().map(view).collect() }).into_response())
}

/// `GET /scenes/{scene_id}/files/{*name}`.
pub async fn download(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    PathName(name): PathName,
    Parameters(parameters): Parameters<FileParameters>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let files = files_of(&api, &scene_id, parameters.quarantined).await?;
    let file = files.into_iter().find(|file| file.name == name);
    let file = file.ok_or_else(|| Problem::not_found("file of the bundle", &name))?;
    // A client that has it already needs no bytes.
    let is_known = has_tag(&headers, header::IF_NONE_MATCH, &format!("\"{}\"", file.digest));
    let bytes = if is_known { Bytes::new() } else { bytes_of(&api, &scene_id, &file).await? };
    let what = Download {
        digest: &file.digest,
        size: file.size,
        media_type: &file.media_type,
        file_name: None,
        content: Content::Memory(bytes),
    };
    let response = respond(&api, &method, &headers, what).await?;
    let Some(mut response) = response else { return Err(missing_bytes(&api, &scene_id).await) };
    if file.name == "report.html" {
        let policy = HeaderValue::from_static(REPORT_POLICY);
        response.headers_mut().insert(header::CONTENT_SECURITY_POLICY, policy);
    }
    Ok(response)
}

/// The files of a finished scene.
async fn files_of(api: &TenantApi, scene_id: &SceneId, quarantined: bool) -> Result<Vec<FileRow>, Problem> {
    check_state(&find(api, scene_id).await?, quarantined)?;
    let files = api.store.bundle_files(&api.tenant_id, scene_id).await?;
    if files.is_empty() { Err(bundle_removed()) } else { Ok(files) }
}

/// The bytes of a file of a bundle.
pub(super) async fn bytes_of(api: &TenantApi, scene_id: &SceneId, file: &FileRow) -> Result<Bytes, Problem> {
    // An archive is in memory while a file of it is read.
    let _turn = api.archive_reads.acquire().await;
    let all = api.store.archive(&api.tenant_id, scene_id, "all").await?.ok_or_else(bundle_removed)?;
    let Some(archive) = api.store.blobs().get(&all.digest).await? else {
        return Err(missing_bytes(api, scene_id).await);
    };
    let (name, digest) = (file.name.clone(), file.digest.clone());
    let read = tokio::task::spawn_blocking(move || member(&archive, &name, &digest)).await;
    read.ok().and_then(Result::ok).flatten().ok_or_else(unreadable)
}

/// The member of a bundle's archive with a path below the bundle's folder, if it has this digest.
fn member(archive: &[u8], path: &str, digest: &Digest) -> ZipResult<Option<Bytes>> {
    let mut archive = ZipArchive::new(Cursor::new(archive))?;
    for index in 0..archive.len() {
        // Names are in the directory of the archive; no other member is unpacked.
        let is_it =
            archive.by_index_raw(index)?.name()?.split_once('/').is_some_and(|(_, below)| below == path);
        if is_it {
            let mut entry = archive.by_index(index)?;
            let mut bytes =
                Vec::with_capacity(usize::try_from(entry.size()).unwrap_or_default().min(64 << 20));
            entry.read_to_end(&mut bytes)?;
            return Ok(Some(Bytes::from(bytes)).filter(|bytes| Digest::of(bytes) == *digest));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    #[test]
    fn a_member_is_found_by_its_path_and_only_with_its_digest() {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for path in ["scene.json", "mjcf/scene.xml", "mjcf/scene.json"] {
            archive.start_file(format!("scene-12ab/{path}"), SimpleFileOptions::default()).expect("starts");
            archive.write_all(path.as_bytes()).expect("writes");
        }
        let archive = archive.finish().expect("finishes").into_inner();
        let found = |path: &str, text: &[u8]| member(&archive, path, &Digest::of(text)).expect("reads");
        assert_eq!(found("scene.json", b"scene.json").as_deref(), Some(&b"scene.json"[..]));
        assert_eq!(found("mjcf/scene.xml", b"mjcf/scene.xml").as_deref(), Some(&b"mjcf/scene.xml"[..]));
        assert_eq!(found("scene.xml", b"mjcf/scene.xml"), None);
        assert_eq!(found("scene.json", b"another"), None);
    }
}
