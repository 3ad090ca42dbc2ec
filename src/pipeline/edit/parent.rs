//! The parent scene: its bundle unpacked into artifacts.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use crate::pipeline::Context;
use crate::pipeline::checkpoint::{ArtifactRef, Stage};
use crate::pipeline::composition::{self, Composition, StoredComposition};
use crate::pipeline::error::StageError;
use export::archive::wanted_files;
use store::Digest;

pub const STAGE: Stage = Stage { name: "parent", version: 2 };

#[derive(Serialize)]
pub struct Inputs {
    /// Of the bundle's archive.
    pub bundle: Digest,
}

/// Images of a bundle that an edit takes over.
const REFERENCE: &str = "preview/reference.png";
const TOP: &str = "preview/top.png";

/// Reads the bundle's composition; its artifacts are stored anew.
pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Composition, StageError> {
    let archive = context.blob(&inputs.bundle, "the parent's bundle").await?;
    let read = context.cpu(move || unpacked(&archive)).await??;
    let Parent { stored: StoredComposition { mut composition, hulls, .. }, mut files } = read;
    composition.image = stored_image(&context, &mut files, REFERENCE, "reference.png").await?;
    composition.top_view = stored_image(&context, &mut files, TOP, "top.png").await?;
    for (index, (body, hulls)) in composition.bodies.iter_mut().zip(&hulls).enumerate() {
        let name = body.resolved.name.clone();
        let mesh = files.remove(&mesh_path(&name)).ok_or_else(|| incomplete(&mesh_path(&name)))?;
        body.mesh = context.put(&format!("{name}.glb"), "model/gltf-binary", mesh).await?;
        body.hulls = context.put_json(&format!("{name}_hulls.json"), hulls).await?;
        let thumbnail = files.keys().find(|path| is_thumbnail_of(path, &name)).cloned();
        body.thumbnail = match thumbnail.and_then(|path| files.remove(&path)) {
            Some(png) => Some(context.put(&format!("{name}.png"), "image/png", png).await?),
            None => None,
        };
        (body.resolved.mesh, body.resolved.hulls) = (body.mesh.clone(), body.hulls.clone());
        if index == 0 {
            (composition.table.mesh, composition.table.hulls) = (body.mesh.clone(), body.hulls.clone());
        }
    }
    Ok(composition)
}

/// A bundle, unpacked.
pub(super) struct Parent {
    pub stored: StoredComposition,
    pub files: BTreeMap<String, Vec<u8>>,
}

pub(super) fn mesh_path(name: &str) -> String {
    format!("glb/{name}.glb")
}

/// Of the USD asset of a body.
fn is_thumbnail_of(path: &str, name: &str) -> bool {
    path.starts_with(&format!("usd/assets/{name}/")) && path.contains("/.thumbs/")
}

/// The composition of a bundle, with the files that it names.
pub(super) fn unpacked(archive: &[u8]) -> Result<Parent, StageError> {
    let is_wanted = |path: &str| {
        path == composition::PATH
            || path == REFERENCE
            || path == TOP
            || (path.starts_with("glb/") && path != "glb/scene.glb")
            || path.contains("/.thumbs/")
    };
    let unreadable = |error: &dyn std::fmt::Display| {
        StageError::permanent("parent_unreadable", format!("reading the parent's bundle: {error}"))
    };
    let mut files = wanted_files(archive, is_wanted).map_err(|error| unreadable(&error))?;
    let bytes = files.remove(composition::PATH).ok_or_else(|| {
        unreadable(&"it has no composition.json, as bundles of earlier versions; make the scene again")
    })?;
    let stored = StoredComposition::read(&bytes).map_err(|error| unreadable(&error))?;
    Ok(Parent { stored, files })
}

async fn stored_image(
    context: &Context,
    files: &mut BTreeMap<String, Vec<u8>>,
    path: &str,
    name: &str,
) -> Result<ArtifactRef, StageError> {
    let png = files.remove(path).ok_or_else(|| incomplete(path))?;
    context.put(name, "image/png", png).await
}

fn incomplete(path: &str) -> StageError {
    StageError::permanent(
        "parent_unreadable",
        format!("reading the parent's bundle: it has no {path}; download it again, with all formats"),
    )
}
