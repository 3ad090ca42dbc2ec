//! The downloadable archive: a ZIP with sorted entries and fixed dates.

use std::collections::{BTreeMap, HashMap};
use std::io::{Cursor, Read, Write};

use rayon::prelude::*;
use serde::Deserialize;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::{BundleFile, ExportError, manifest};

/// The archive's bytes. Entries lie under `scene-<id>/`, sorted by path; equal files give equal bytes.
///
/// # Errors
///
/// [`ExportError`] if a file cannot be packed.
pub fn zip_bundle(files: &[BundleFile]) -> Result<Vec<u8>, ExportError> {
    zip_with(files, &bundle_folder(files)?, None)
}

/// As [`zip_bundle`]. What the archive of the parent scene has under the same path, to the byte, is copied as it is
/// packed there.
///
/// # Errors
///
/// [`ExportError`] if a file cannot be packed.
pub fn zip_derived_bundle(files: &[BundleFile], parent: &[u8]) -> Result<Vec<u8>, ExportError> {
    zip_with(files, &bundle_folder(files)?, EarlierArchive::read(parent).as_ref())
}

/// The folder of all entries.
fn bundle_folder(files: &[BundleFile]) -> Result<String, ExportError> {
    #[derive(Deserialize)]
    struct SceneId {
        id: String,
    }
    let scene = files.iter().find(|file| file.path == "scene.json");
    let scene = scene.ok_or_else(|| ExportError::AssetsMismatch("there is no scene.json".to_owned()))?;
    let SceneId { id } = serde_json::from_slice(&scene.bytes)?;
    Ok(format!("scene-{id}/"))
}

/// An archive of files, sorted by path, with `folder` before each path. Equal files give equal bytes.
///
/// # Errors
///
/// [`ExportError`] if a file cannot be packed.
pub fn zip_files(files: &[BundleFile], folder: &str) -> Result<Vec<u8>, ExportError> {
    zip_with(files, folder, None)
}

fn zip_with(
    files: &[BundleFile],
    folder: &str,
    earlier: Option<&EarlierArchive>,
) -> Result<Vec<u8>, ExportError> {
    let mut sorted: Vec<&BundleFile> = files.iter().collect();
    sorted.sort_by(|a, b| a.path.cmp(&b.path));
    // Formats share meshes and textures; equal contents are compressed once.
    let mut of_length: HashMap<usize, Vec<usize>> = HashMap::with_capacity(sorted.len());
    let mut different: Vec<&BundleFile> = Vec::with_capacity(sorted.len());
    let mut contents: Vec<usize> = Vec::with_capacity(sorted.len());
    for &file in &sorted {
        let as_long = of_length.entry(file.bytes.len()).or_default();
        let alike =
            |&&k: &&usize| different[k].media_type == file.media_type && different[k].bytes == file.bytes;
        let content = as_long.iter().find(alike).copied().unwrap_or(different.len());
        if content == different.len() {
            as_long.push(content);
            different.push(file);
        }
        contents.push(content);
    }
    // Each file is compressed in parallel as an archive of its own; the compressed entries are then copied.
    let pack = |file: &BundleFile| match earlier.and_then(|earlier| earlier.packed(file)) {
        Some(packed) => Ok(packed),
        None => single_entry_archive(file),
    };
    let packed: Vec<Vec<u8>> = different.into_par_iter().map(pack).collect::<Result<_, ZipError>>()?;
    let mut archive = ZipWriter::new(Cursor::new(Vec::with_capacity(packed.iter().map(Vec::len).sum())));
    for (file, content) in sorted.iter().zip(contents) {
        let mut alone = ZipArchive::new(Cursor::new(packed[content].as_slice()))?;
        archive.raw_copy_file_rename(alone.by_index_raw(0)?, format!("{folder}{}", file.path))?;
    }
    Ok(archive.finish()?.into_inner())
}

/// An archive that was written before, of another state of the scene.
struct EarlierArchive<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    folder: String,
}

impl<'a> EarlierArchive<'a> {
    /// `None` for what is no archive of one folder.
    fn read(bytes: &'a [u8]) -> Option<Self> {
        let archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
        let folder = archive.file_names().next()?.ok()?.split_once('/')?.0.to_owned();
        Some(Self { archive, folder })
    }

    /// An archive with a file as the one entry, as it is packed here; `None` if it is not here, or other bytes are.
    fn packed(&self, file: &BundleFile) -> Option<Vec<u8>> {
        // A clone shares the directory and has a place of its own to read.
        let mut archive = self.archive.clone();
        let index = archive.index_for_name(&format!("{}/{}", self.folder, file.path))?;
        let mut entry = archive.by_index(index).ok()?;
        if entry.size() != file.bytes.len() as u64 || entry.compression() != compression_of(file).0 {
            return None;
        }
        let mut bytes = Vec::with_capacity(file.bytes.len());
        entry.read_to_end(&mut bytes).ok()?;
        drop(entry);
        if bytes != file.bytes {
            return None;
        }
        let mut alone = ZipWriter::new(Cursor::new(Vec::new()));
        // An archive that another program packed has other dates.
        let packed = archive.by_index_raw(index).ok()?;
        alone.raw_copy_file_touch(packed, DateTime::DEFAULT, Some(FILE_MODE)).ok()?;
        Some(alone.finish().ok()?.into_inner())
    }
}

/// Permissions of every entry.
const FILE_MODE: u32 = 0o644;

/// Compression level. Meshes and USD text become 5 % larger than at the default level 6, in half the time.
const DEFLATE_LEVEL: i64 = 4;

/// Method and level. PNG files are already compressed.
fn compression_of(file: &BundleFile) -> (CompressionMethod, Option<i64>) {
    match file.media_type.as_str() {
        "image/png" => (CompressionMethod::Stored, None),
        _ => (CompressionMethod::Deflated, Some(DEFLATE_LEVEL)),
    }
}

/// An archive with one entry.
fn single_entry_archive(file: &BundleFile) -> Result<Vec<u8>, ZipError> {
    let (method, level) = compression_of(file);
    let options = SimpleFileOptions::default()
        .compression_method(method)
        .compression_level(level)
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(FILE_MODE);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    archive.start_file(file.path.as_str(), options)?;
    archive.write_all(&file.bytes)?;
    Ok(archive.finish()?.into_inner())
}

/// Path and manifest entry of `manifest.json` itself, which its own list cannot contain.
pub fn manifest_itself(archive: &[u8]) -> Result<(String, manifest::ManifestEntry), ExportError> {
    let mut archive = ZipArchive::new(Cursor::new(archive))?;
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index)?;
        if entry.name()?.split_once('/').is_some_and(|(_, path)| path == manifest::PATH) {
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).map_err(ZipError::from)?;
            return Ok((manifest::PATH.to_owned(), manifest::entry_of(&bytes, "application/json")));
        }
    }
    Err(ExportError::AssetsMismatch("the packed bundle has no manifest.json".to_owned()))
}

/// The manifest's entries of all files of an archive except `manifest.json`, by path.
///
/// # Errors
///
/// [`ExportError::AssetsMismatch`] if the archive and its manifest do not list the same files with the same sizes.
pub fn manifest_entries(archive: &[u8]) -> Result<BTreeMap<String, manifest::ManifestEntry>, ExportError> {
    let mismatch = |what: String| ExportError::AssetsMismatch(format!("the packed bundle {what}"));
    let mut archive = ZipArchive::new(Cursor::new(archive))?;
    let mut sizes = BTreeMap::new();
    let mut entries = None;
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index)?;
        let name = entry.name()?.into_owned();
        let path = name.split_once('/').map_or("", |(_, path)| path).to_owned();
        if path == manifest::PATH {
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).map_err(ZipError::from)?;
            entries = Some(manifest::read(&bytes)?);
        } else {
            sizes.insert(path, entry.size());
        }
    }
    let entries = entries.ok_or_else(|| mismatch("has no manifest.json".to_owned()))?;
    let expected: BTreeMap<String, u64> =
        entries.iter().map(|(path, file)| (path.clone(), file.size)).collect();
    if expected != sizes {
        let odd = expected.iter().find(|(path, size)| sizes.get(*path) != Some(size));
        let odd = odd.or_else(|| sizes.iter().find(|(path, _)| !expected.contains_key(*path)));
        return Err(mismatch(format!("is not what its manifest tells: {:?}", odd.map(|(path, _)| path))));
    }
    Ok(entries)
}

/// The files of an archive whose paths satisfy `is_wanted`, by path, each compared with the manifest.
///
/// # Errors
///
/// [`ExportError::AssetsMismatch`] if the archive is no bundle, or if a file is not the one that its manifest lists;
/// [`ExportError::Archive`] if it cannot be unpacked.
pub fn wanted_files(
    archive: &[u8],
    is_wanted: impl Fn(&str) -> bool,
) -> Result<BTreeMap<String, Vec<u8>>, ExportError> {
    let entries = manifest_entries(archive)?;
    let mut archive = ZipArchive::new(Cursor::new(archive))?;
    let mut files = BTreeMap::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index)?;
        let name = entry.name()?.into_owned();
        let Some((_, path)) = name.split_once('/') else { continue };
        let Some(listed) = entries.get(path).filter(|_| is_wanted(path)) else { continue };
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).map_err(ZipError::from)?;
        if manifest::entry_of(&bytes, &listed.media_type).sha256 != listed.sha256 {
            return Err(ExportError::AssetsMismatch(format!(
                "{path} is not the file that the manifest lists; download the bundle again"
            )));
        }
        files.insert(path.to_owned(), bytes);
    }
    Ok(files)
}
