//! The downloadable archive: a ZIP with sorted entries and fixed dates.

use std::io::{Cursor, Write};
use std::str::FromStr;

use serde::Deserialize;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::{BundleFile, ExportError};

/// Which formats an archive holds. `scene.json` with its schema, the report, the manifest, the README
/// and the previews are always in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formats {
    All,
    Usd,
    Urdf,
    Mjcf,
    Glb,
}

/// The word names no format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no format; use all, usd, urdf, mjcf or glb")]
pub struct UnknownFormat(String);

impl FromStr for Formats {
    type Err = UnknownFormat;
    fn from_str(word: &str) -> Result<Self, UnknownFormat> {
        match word {
            "all" => Ok(Self::All),
            "usd" => Ok(Self::Usd),
            "urdf" => Ok(Self::Urdf),
            "mjcf" => Ok(Self::Mjcf),
            "glb" => Ok(Self::Glb),
            _ => Err(UnknownFormat(word.to_owned())),
        }
    }
}

impl Formats {
    /// Whether the file belongs in the archive.
    pub fn includes(self, path: &str) -> bool {
        let chosen = match self {
            Self::All => return true,
            Self::Usd => "usd",
            Self::Urdf => "urdf",
            Self::Mjcf => "mjcf",
            Self::Glb => "glb",
        };
        let folder = path.split('/').next().unwrap_or_default();
        !["usd", "urdf", "mjcf", "glb", "sdf"].contains(&folder) || folder == chosen
    }
}

/// Files in one piece for the store: a line of JSON (path, role, media type and length of each), then
/// their bytes in that order.
pub fn shelve(files: &[BundleFile]) -> Vec<u8> {
    let index: Vec<ShelfEntry> =
        files.iter().map(|f| (f.path.clone(), f.role.clone(), f.media_type.clone(), f.bytes.len())).collect();
    let mut shelf = serde_json::json!(index).to_string().into_bytes();
    shelf.push(b'\n');
    files.iter().for_each(|file| shelf.extend_from_slice(&file.bytes));
    shelf
}

/// Path, role, media type, length in bytes.
type ShelfEntry = (String, String, String, usize);

/// The files that [`shelve`] put in one piece.
pub fn unshelve(shelf: &[u8]) -> Result<Vec<BundleFile>, ExportError> {
    let broken = || ExportError::AssetsMismatch("the stored files of the bundle are incomplete".to_owned());
    let end = shelf.iter().position(|byte| *byte == b'\n').ok_or_else(broken)?;
    let index: Vec<ShelfEntry> = serde_json::from_slice(&shelf[..end])?;
    let mut at = end + 1;
    let mut files = Vec::with_capacity(index.len());
    for (path, role, media_type, length) in index {
        let stop = at.checked_add(length).ok_or_else(broken)?;
        let bytes = shelf.get(at..stop).ok_or_else(broken)?.to_vec();
        at = stop;
        files.push(BundleFile { path, bytes, role, media_type });
    }
    Ok(files)
}

/// The archive's bytes. Entries lie under `scene-<id>/`, sorted by path; equal files give equal bytes.
pub fn zip_bundle(files: &[BundleFile], filter: Formats) -> Result<Vec<u8>, ExportError> {
    #[derive(Deserialize)]
    struct SceneId {
        id: String,
    }
    let scene = files.iter().find(|file| file.path == "scene.json");
    let scene = scene.ok_or_else(|| ExportError::AssetsMismatch("there is no scene.json".to_owned()))?;
    let SceneId { id } = serde_json::from_slice(&scene.bytes)?;
    let mut chosen: Vec<&BundleFile> = files.iter().filter(|file| filter.includes(&file.path)).collect();
    chosen.sort_by(|a, b| a.path.cmp(&b.path));
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for file in chosen {
        // PNG is compressed already.
        let method = match file.media_type.as_str() {
            "image/png" => CompressionMethod::Stored,
            _ => CompressionMethod::Deflated,
        };
        let options = SimpleFileOptions::default()
            .compression_method(method)
            .compression_level(None)
            .last_modified_time(DateTime::DEFAULT)
            .unix_permissions(0o644);
        archive.start_file(format!("scene-{id}/{}", file.path), options)?;
        archive.write_all(&file.bytes).map_err(zip::result::ZipError::from)?;
    }
    Ok(archive.finish()?.into_inner())
}
