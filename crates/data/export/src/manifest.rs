//! `manifest.json`: every file with its digest, size and role; licence and provenance of every asset.
//!
//! The manifest describes the full bundle; an archive of one format carries it unchanged.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use runtime::digest::hex;
use scene::{Provenance, Scene, StandIn};

use super::{Assets, BundleFile, ExportError, ExportSettings};

/// Path of the manifest in the bundle.
pub const PATH: &str = "manifest.json";

#[derive(Serialize)]
struct Manifest<'a> {
    format: &'static str,
    scene: &'a str,
    licence: &'a str,
    generator: Generator,
    assets: Vec<Asset<'a>>,
    files: Vec<File<'a>>,
}

#[derive(Serialize)]
struct Generator {
    name: &'static str,
    version: &'static str,
}

#[derive(Serialize)]
struct Asset<'a> {
    name: &'a str,
    label: &'a str,
    category: &'a str,
    #[serde(flatten, with = "scene::stand_in::fields")]
    stand_in: Option<StandIn>,
    licence: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    provenance: Option<&'a Provenance>,
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<&'a str>,
    mesh: &'a str,
}

#[derive(Serialize)]
struct File<'a> {
    path: &'a str,
    sha256: String,
    size: usize,
    role: &'a str,
    media_type: &'a str,
}

/// The manifest of `files`, which must not contain the manifest.
pub fn write(
    scene: &Scene,
    assets: &Assets,
    files: &[BundleFile],
    settings: &ExportSettings,
) -> Result<BundleFile, ExportError> {
    let table = Asset {
        name: &scene.table.name,
        label: &scene.table.label,
        category: &assets.table.category,
        stand_in: None,
        licence: &settings.licence,
        provenance: None,
        model: Some(&scene.table.model),
        mesh: &scene.table.mesh,
    };
    let instances = scene.instances.iter().map(|instance| Asset {
        name: instance.name.as_str(),
        label: &instance.label,
        category: &instance.category,
        stand_in: instance.stand_in.clone(),
        licence: &instance.provenance.licence,
        provenance: Some(&instance.provenance),
        model: None,
        mesh: &instance.mesh,
    });
    let manifest = Manifest {
        format: "tabletopgen-manifest/1",
        scene: &scene.id,
        licence: &settings.licence,
        generator: Generator { name: "tabletopgen", version: env!("CARGO_PKG_VERSION") },
        assets: std::iter::once(table).chain(instances).collect(),
        files: files
            .par_iter()
            .map(|file| File {
                path: &file.path,
                sha256: hex(&Sha256::digest(&file.bytes)),
                size: file.bytes.len(),
                role: &file.role,
                media_type: &file.media_type,
            })
            .collect(),
    };
    BundleFile::json(PATH, &manifest, "manifest")
}

/// A file's entry in the manifest.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct ManifestEntry {
    /// 64 lower-case hexadecimal digits.
    pub sha256: String,
    pub size: u64,
    pub media_type: String,
}

/// The manifest entry of a file with these bytes.
pub fn entry_of(bytes: &[u8], media_type: &str) -> ManifestEntry {
    ManifestEntry {
        sha256: hex(&Sha256::digest(bytes)),
        size: bytes.len() as u64,
        media_type: media_type.to_owned(),
    }
}

/// Parses a manifest: its entries by path.
pub fn read(bytes: &[u8]) -> Result<BTreeMap<String, ManifestEntry>, ExportError> {
    #[derive(Deserialize)]
    struct Document {
        files: Vec<Entry>,
    }
    #[derive(Deserialize)]
    struct Entry {
        path: String,
        #[serde(flatten)]
        file: ManifestEntry,
    }
    let document: Document = serde_json::from_slice(bytes)?;
    Ok(document.files.into_iter().map(|entry| (entry.path, entry.file)).collect())
}
