//! The finished scene that another is made from, or in which robots do tasks.

use futures::TryStreamExt;

use super::extract::TenantApi;
use super::rebuild::missing_bytes;
use super::scenes::find;
use crate::app::edit_scene::ParentBundle;
use crate::problem::{Problem, ProblemType};
use scene::SceneId;
use store::lifecycle::SceneState;
use store::scenes::SceneRow;

/// The stored bundle of a scene, whose row is in `store::artifacts`.
///
/// # Errors
///
/// A [`Problem`] where there is no such scene, or it is not finished, is quarantined and that is not allowed, or its
/// bundle is gone.
pub(super) async fn bundle_of(
    api: &TenantApi,
    scene_id: &SceneId,
    allow_quarantined: bool,
) -> Result<ParentBundle, Problem> {
    check_finished(&find(api, scene_id).await?, allow_quarantined)?;
    let Some(archive) = api.store.archive(&api.tenant_id, scene_id, "all").await? else {
        let detail =
            "the bundle of this quarantined scene was removed after its time; submit the scene again";
        return Err(Problem::new(ProblemType::Gone, "bundle_removed", detail));
    };
    let start = 0..archive.size.min(MAX_HEADER_BYTES);
    let Some(mut parts) = api.store.blobs().stream(&archive.digest, Some(start)).await? else {
        return Err(missing_bytes(api, scene_id).await);
    };
    let mut start = Vec::new();
    while let Some(part) = parts.try_next().await? {
        start.extend_from_slice(&part);
    }
    let Some(id) = bundle_id(&start) else {
        let detail = "the bundle of this scene cannot be read; submit the scene again";
        return Err(Problem::new(ProblemType::Internal, "bundle_unreadable", detail));
    };
    Ok(ParentBundle { id, digest: archive.digest })
}

/// Computes with the archive of a bundle on the pool that all work computes on, and keeps `permit` until that is done.
///
/// # Errors
///
/// A [`Problem`] where the bytes are gone, where `work` fails, and where it panics.
pub(super) async fn compute_with<T: Send + 'static>(
    api: &TenantApi,
    scene_id: &SceneId,
    bundle: &ParentBundle,
    permit: impl Send + 'static,
    work: impl FnOnce(&[u8]) -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let Some(archive) = api.store.blobs().get(&bundle.digest).await? else {
        return Err(missing_bytes(api, scene_id).await);
    };
    let computed = api.cpu.run(move || {
        let _permit = permit;
        work(&archive)
    });
    computed.await.unwrap_or_else(|died| {
        tracing::error!(%died, %scene_id, "a computation of a request failed");
        let detail = "a bug stopped this computation; the log has the details under this request id";
        Err(Problem::new(ProblemType::Internal, "internal_error", detail))
    })
}

fn check_finished(scene: &SceneRow, allow_quarantined: bool) -> Result<(), Problem> {
    let conflict = |code, detail: &str| Err(Problem::new(ProblemType::Conflict, code, detail));
    match (scene.state, scene.failure_code.as_deref()) {
        (SceneState::Ready, _) => Ok(()),
        (SceneState::Failed, Some("quarantined")) if allow_quarantined => Ok(()),
        (SceneState::Failed, Some("quarantined")) => conflict(
            "parent_quarantined",
            "the certificate of this scene says quarantine; to edit it anyway, add \"allow_quarantined\": true",
        ),
        (SceneState::Failed, _) => {
            conflict("parent_failed", "this scene has no bundle; see its failure, then retry its job")
        }
        (SceneState::Pending | SceneState::Deleted, _) => {
            conflict("parent_not_ready", "this scene is not finished; follow its job's events, then edit it")
        }
    }
}

/// Bytes that hold the header of an archive's first entry: 30, and a name.
const MAX_HEADER_BYTES: u64 = 1024;

/// The id in the name of an archive's first entry, `scene-<id>/<path>`. `start` is the start of the archive: the local
/// file header of section 4.3.7 of PKWARE's APPNOTE.
fn bundle_id(start: &[u8]) -> Option<String> {
    let header = start.strip_prefix(b"PK\x03\x04")?;
    let length = u16::from_le_bytes([*header.get(22)?, *header.get(23)?]);
    let name = std::str::from_utf8(header.get(26..26 + usize::from(length))?).ok()?;
    let (folder, _) = name.split_once('/')?;
    let id = folder.strip_prefix("scene-")?;
    let valid = !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
    valid.then(|| id.to_owned())
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;

    fn archive_with(name: &str) -> Vec<u8> {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        archive.start_file(name, SimpleFileOptions::default()).expect("starts");
        archive.write_all(b"{}").expect("writes");
        archive.finish().expect("finishes").into_inner()
    }

    #[test]
    fn bundle_id_is_that_of_the_folder() {
        let archive = archive_with("scene-0d9cd785067890c78cc5/README.md");
        assert_eq!(bundle_id(&archive).as_deref(), Some("0d9cd785067890c78cc5"));
        assert_eq!(bundle_id(&archive[..66]).as_deref(), Some("0d9cd785067890c78cc5"));
        for (start, what) in [
            (archive[..40].to_vec(), "a cut name"),
            (archive_with("README.md"), "no folder"),
            (archive_with("scene-/README.md"), "no id"),
            (archive_with("scene-a b/README.md"), "another form"),
            (b"no archive".to_vec(), "no archive"),
            (Vec::new(), "nothing"),
        ] {
            assert_eq!(bundle_id(&start), None, "{what}");
        }
    }
}
