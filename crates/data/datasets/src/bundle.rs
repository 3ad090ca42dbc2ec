//! One bundle: a folder or a ZIP archive, read file by file against its manifest.
//!
//! Every file that is returned has the size and the SHA-256 that `manifest.json` states. Files that the manifest does
//! not list are ignored in a folder (`artifacts/`) and refused in an archive.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Cursor, Read, Seek};
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;
use sha2::{Digest, Sha256};
use zip::ZipArchive;

use export::BundleFile;
use export::manifest::{self, ManifestEntry};
use runtime::digest::hex;

use crate::error::DatasetError;

/// Largest `manifest.json` that is read, bytes.
const MAX_MANIFEST_BYTES: u64 = 64 << 20;

/// An open bundle. Only the manifest is in memory.
pub struct Bundle {
    /// Path of the folder or the archive, for messages.
    place: PathBuf,
    content: Content,
    manifest: Vec<u8>,
    entries: BTreeMap<String, ManifestEntry>,
    licence: String,
}

enum Content {
    Folder,
    Archive { archive: ZipArchive<Box<dyn ReadSeek>>, indices: BTreeMap<String, usize> },
}

trait ReadSeek: Read + Seek {}

impl<R: Read + Seek> ReadSeek for R {}

/// SHA-256 of the bytes, as hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

impl Bundle {
    /// Opens a folder with `manifest.json`, or a ZIP archive of one.
    ///
    /// # Errors
    ///
    /// [`DatasetError::File`] if it cannot be read, [`DatasetError::Bundle`] if it is no complete bundle.
    pub fn open(place: &Path) -> Result<Self, DatasetError> {
        if place.is_dir() {
            let path = place.join(manifest::PATH);
            let file = File::open(&path).map_err(DatasetError::file("open", &path))?;
            let manifest =
                read_at_most(file, MAX_MANIFEST_BYTES).map_err(DatasetError::file("read", &path))?;
            return Self::new(place, Content::Folder, manifest);
        }
        let file = File::open(place).map_err(DatasetError::file("open", place))?;
        Self::of_reader(place, Box::new(BufReader::new(file)))
    }

    /// The bundle in the bytes of a ZIP archive; `place` is where they come from, for messages.
    ///
    /// # Errors
    ///
    /// As [`Self::open`].
    pub fn of_archive(place: &Path, archive: Vec<u8>) -> Result<Self, DatasetError> {
        Self::of_reader(place, Box::new(Cursor::new(archive)))
    }

    fn of_reader(place: &Path, reader: Box<dyn ReadSeek>) -> Result<Self, DatasetError> {
        let refuse = |reason: String| DatasetError::bundle(place, reason);
        let mut archive = ZipArchive::new(reader).map_err(|_| {
            refuse(
                "it is no ZIP archive, or a damaged one; give a folder of a bundle, or its .zip".to_owned(),
            )
        })?;
        let mut indices = BTreeMap::new();
        for index in 0..archive.len() {
            let entry = archive.by_index_raw(index).map_err(|error| refuse(error.to_string()))?;
            let name = entry.name().map_err(|error| refuse(error.to_string()))?.into_owned();
            if entry.is_dir() {
                continue;
            }
            let path = name.split_once('/').map_or(name.as_str(), |(_, path)| path);
            if indices.insert(path.to_owned(), index).is_some() {
                return Err(refuse(format!("the archive holds {path} twice")));
            }
        }
        let Some(&index) = indices.get(manifest::PATH) else {
            return Err(refuse("the archive has no manifest.json; give a whole bundle".to_owned()));
        };
        let entry = archive.by_index(index).map_err(|error| refuse(error.to_string()))?;
        let manifest = read_at_most(entry, MAX_MANIFEST_BYTES).map_err(DatasetError::file("read", place))?;
        let bundle = Self::new(place, Content::Archive { archive, indices }, manifest)?;
        let Content::Archive { indices, .. } = &bundle.content else { return Ok(bundle) };
        let listed = |path: &String| path == manifest::PATH || bundle.entries.contains_key(path);
        let odd = indices.keys().find(|path| !listed(path));
        let odd = odd.or_else(|| bundle.entries.keys().find(|path| !indices.contains_key(*path)));
        match odd {
            Some(path) => Err(refuse(format!("{path} is in the archive or its manifest, but not in both"))),
            None => Ok(bundle),
        }
    }

    fn new(place: &Path, content: Content, manifest: Vec<u8>) -> Result<Self, DatasetError> {
        #[derive(Deserialize)]
        struct Document {
            format: String,
            licence: String,
        }
        let refuse = |reason: String| DatasetError::bundle(place, reason);
        let document: Document =
            serde_json::from_slice(&manifest).map_err(|error| refuse(format!("manifest.json: {error}")))?;
        if document.format != "tabletopgen-manifest/1" {
            return Err(refuse(format!("manifest.json has the unknown format {:?}", document.format)));
        }
        let entries = manifest::read(&manifest).map_err(|error| refuse(format!("manifest.json: {error}")))?;
        if let Some(path) = entries.keys().find(|path| !is_inside(path)) {
            return Err(refuse(format!("manifest.json lists {path:?}, which is no path inside a bundle")));
        }
        Ok(Self { place: place.to_owned(), content, manifest, entries, licence: document.licence })
    }

    pub fn place(&self) -> &Path {
        &self.place
    }

    /// SHA-256 of `manifest.json`, which fixes the bytes of all other files.
    pub fn manifest_sha256(&self) -> String {
        sha256(&self.manifest)
    }

    /// The bundle's own license, which is that of the table's mesh.
    pub fn licence(&self) -> &str {
        &self.licence
    }

    /// Manifest entries of all files except `manifest.json`, by path.
    pub fn entries(&self) -> &BTreeMap<String, ManifestEntry> {
        &self.entries
    }

    /// The bytes of a file that the manifest lists.
    ///
    /// # Errors
    ///
    /// [`DatasetError::Bundle`] if the file is missing or differs from its entry in the manifest.
    pub fn read(&mut self, path: &str) -> Result<Vec<u8>, DatasetError> {
        let place = &self.place;
        let refuse = |reason: String| DatasetError::bundle(place, reason);
        let entry = self.entries.get(path).ok_or_else(|| refuse(format!("it has no {path}")))?;
        let unreadable = |error: std::io::Error| refuse(format!("{path} cannot be read: {error}"));
        let bytes = match &mut self.content {
            Content::Folder => {
                let file = File::open(place.join(path)).map_err(unreadable)?;
                read_at_most(file, entry.size).map_err(unreadable)?
            }
            Content::Archive { archive, indices } => {
                let index = indices.get(path).copied().unwrap_or(usize::MAX);
                let packed = archive.by_index(index).map_err(|error| refuse(format!("{path}: {error}")))?;
                read_at_most(packed, entry.size).map_err(unreadable)?
            }
        };
        if bytes.len() as u64 != entry.size || sha256(&bytes) != entry.sha256 {
            return Err(refuse(format!("{path} is not the file that manifest.json states; make it again")));
        }
        Ok(bytes)
    }

    /// Reads every file once.
    ///
    /// # Errors
    ///
    /// As [`Self::read`], for the first file.
    pub fn check(&mut self) -> Result<(), DatasetError> {
        let paths: Vec<String> = self.entries.keys().cloned().collect();
        paths.iter().try_for_each(|path| self.read(path).map(drop))
    }

    /// The ZIP archive of the bundle, all of it checked: the bytes of the source if that is an archive, else packed as
    /// the server packs it.
    ///
    /// # Errors
    ///
    /// As [`Self::read`], and [`DatasetError::Packing`].
    pub fn archive(&mut self) -> Result<Vec<u8>, DatasetError> {
        if matches!(self.content, Content::Archive { .. }) {
            let bytes = std::fs::read(&self.place).map_err(DatasetError::file("read", &self.place))?;
            // The bytes that are returned are those that are checked.
            let mut packed = Self::of_archive(&self.place, bytes.clone())?;
            packed.check()?;
            if packed.manifest != self.manifest {
                return Err(DatasetError::bundle(&self.place, "it changed while it was read; freeze again"));
            }
            return Ok(bytes);
        }
        let mut files = vec![BundleFile::new(manifest::PATH, self.manifest.clone(), "", "application/json")];
        let listed: Vec<(String, String)> =
            self.entries.iter().map(|(path, entry)| (path.clone(), entry.media_type.clone())).collect();
        for (path, media_type) in listed {
            let bytes = self.read(&path)?;
            files.push(BundleFile::new(path, bytes, "", &media_type));
        }
        let place = self.place.clone();
        export::zip_bundle(&files).map_err(|source| DatasetError::Packing { place, source })
    }
}

/// Reads up to one byte more than `limit`, so that a longer file is noticed and never held.
fn read_at_most(reader: impl Read, limit: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(std::io::Error::other(format!("it has more than {limit} bytes")));
    }
    Ok(bytes)
}

/// Whether the path stays inside its folder on every system.
pub(crate) fn is_inside(path: &str) -> bool {
    !path.is_empty()
        && !path.contains(['\\', '\0', ':'])
        && Path::new(path).components().all(|component| matches!(component, Component::Normal(_)))
}
