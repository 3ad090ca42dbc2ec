//! A bundle that a command reads: its folder or its archive, every file compared with the manifest.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::{Component, Path, PathBuf};

use zip::ZipArchive;

use super::{Exit, Failure, input_file};
use export::manifest::{self, ManifestEntry};
use export::{BundleFile, zip_bundle};
use scene::Scene;

/// A bundle, and what its manifest lists.
pub struct BundleInput {
    path: PathBuf,
    /// The archive; `None` for a folder.
    archive: Option<Vec<u8>>,
    manifest_bytes: Vec<u8>,
    entries: BTreeMap<String, ManifestEntry>,
}

impl BundleInput {
    /// Opens the bundle at a path and reads its manifest.
    ///
    /// # Errors
    ///
    /// A [`Failure`] of kind usage where there is no bundle.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        const ADVICE: &str = "give the folder of a bundle, which has a manifest.json, or its .zip";
        let no_bundle =
            |why: String| Failure::usage(format!("{} is no bundle: {why}; {ADVICE}", path.display()));
        let unreadable = |error: std::io::Error| input_file::unreadable(path, "the bundle", &error, ADVICE);
        let about = std::fs::metadata(path).map_err(unreadable)?;
        let archive = match about.is_dir() {
            true => None,
            false => Some(std::fs::read(path).map_err(unreadable)?),
        };
        let manifest_bytes = match &archive {
            Some(archive) => entry(archive, manifest::PATH)
                .map_err(|_| no_bundle("the file is no zip archive, or a damaged one".to_owned()))?,
            None => match std::fs::read(path.join(manifest::PATH)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(unreadable(error)),
                read => read.ok(),
            },
        };
        let Some(manifest_bytes) = manifest_bytes else {
            return Err(no_bundle(format!("it has no {}", manifest::PATH)));
        };
        let entries = manifest::read(&manifest_bytes).map_err(|error| no_bundle(error.to_string()))?;
        Ok(Self { path: path.to_owned(), archive, manifest_bytes, entries })
    }

    /// The manifest's entry of a file.
    pub fn entry(&self, name: &str) -> Option<&ManifestEntry> {
        self.entries.get(name)
    }

    /// The bytes of a file.
    ///
    /// # Errors
    ///
    /// A [`Failure`] of kind usage where the file is missing, or is not the one of the manifest.
    pub fn file(&self, name: &str) -> Result<Vec<u8>, Failure> {
        let wrong = |what: &str| {
            let place = self.path.display();
            Failure::usage(format!("{name} of the bundle {place} {what}; use the bundle as it was written"))
        };
        let expected = self.entry(name).ok_or_else(|| wrong("is not in its manifest"))?;
        let bytes = match &self.archive {
            Some(archive) => entry(archive, name).map_err(|_| wrong("cannot be unpacked"))?,
            None => std::fs::read(inside(&self.path, name)?).ok(),
        };
        let bytes = bytes.ok_or_else(|| wrong("is missing"))?;
        if manifest::entry_of(&bytes, &expected.media_type) == *expected {
            Ok(bytes)
        } else {
            Err(wrong("was changed: it does not match its manifest"))
        }
    }

    /// The scene that the bundle describes.
    ///
    /// # Errors
    ///
    /// As [`Self::file`], and where this version does not read the scene.
    pub fn scene(&self) -> Result<Scene, Failure> {
        serde_json::from_slice(&self.file("scene.json")?).map_err(|error| {
            Failure::usage(format!(
                "scene.json of the bundle {} cannot be read: {error}",
                self.path.display()
            ))
        })
    }

    /// The archive of the whole bundle.
    ///
    /// # Errors
    ///
    /// As [`Self::file`], for the first of all files.
    pub fn into_archive(self) -> Result<Vec<u8>, Failure> {
        let mut files = Vec::with_capacity(self.entries.len() + 1);
        for (name, listed) in &self.entries {
            files.push(BundleFile::new(name, self.file(name)?, "", &listed.media_type));
        }
        if let Some(archive) = self.archive {
            return Ok(archive);
        }
        files.push(BundleFile::new(manifest::PATH, self.manifest_bytes, "", "application/json"));
        zip_bundle(&files).map_err(|error| {
            let message = format!("cannot pack the bundle {}: {error}", self.path.display());
            Failure::new(Exit::Error, message)
        })
    }
}

/// An entry of an archive by its path below the one folder; `None` if there is none.
fn entry(archive: &[u8], path: &str) -> Result<Option<Vec<u8>>, zip::result::ZipError> {
    let mut archive = ZipArchive::new(Cursor::new(archive))?;
    let is_wanted = |name: &str| name.split_once('/').is_some_and(|(_, below)| below == path);
    let name = archive.file_names().filter_map(|name| name.ok()).find(|name| is_wanted(name));
    let Some(name) = name.map(|name| name.into_owned()) else { return Ok(None) };
    let mut bytes = Vec::new();
    archive.by_name(&name)?.read_to_end(&mut bytes)?;
    Ok(Some(bytes))
}

/// `name` below `folder`; a name that leads anywhere else is an error.
fn inside(folder: &Path, name: &str) -> Result<PathBuf, Failure> {
    if Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) {
        Ok(folder.join(name))
    } else {
        Err(Failure::usage(format!(
            "the manifest of {} lists {name:?}, which lies outside",
            folder.display()
        )))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Writes a bundle of `scene.json` and one more file; its folder.
    fn folder(home: &Path) -> PathBuf {
        let files = [("scene.json", "{\"id\": \"0a1b\"}"), ("glb/mug_1.glb", "mesh")];
        let listed = files.map(|(path, text)| {
            let ManifestEntry { sha256, size, .. } = manifest::entry_of(text.as_bytes(), "text/plain");
            json!({ "path": path, "sha256": sha256, "size": size, "media_type": "text/plain" })
        });
        let folder = home.join("bundle");
        std::fs::create_dir_all(folder.join("glb")).expect("makes it");
        for (path, text) in files {
            std::fs::write(folder.join(path), text).expect("writes");
        }
        std::fs::write(folder.join("manifest.json"), json!({ "files": listed }).to_string()).expect("writes");
        folder
    }

    #[test]
    fn a_folder_and_its_archive_have_the_same_files() {
        let home = tempfile::tempdir().expect("temporary directory");
        let folder = folder(home.path());
        let archive = BundleInput::open(&folder).expect("opens").into_archive().expect("packs");
        let packed = home.path().join("bundle.zip");
        std::fs::write(&packed, &archive).expect("writes");
        for path in [&folder, &packed] {
            let bundle = BundleInput::open(path).expect("opens");
            assert_eq!(bundle.file("glb/mug_1.glb").expect("reads"), b"mesh");
            assert_eq!(bundle.entry("glb/mug_1.glb").map(|entry| entry.size), Some(4));
            assert_eq!(bundle.into_archive().expect("packs"), archive);
        }
    }

    #[test]
    fn a_changed_or_missing_file_is_named() {
        let home = tempfile::tempdir().expect("temporary directory");
        let folder = folder(home.path());
        let refusal =
            || BundleInput::open(&folder).and_then(BundleInput::into_archive).expect_err("is refused");
        std::fs::write(folder.join("glb/mug_1.glb"), "mash").expect("writes");
        let changed = refusal();
        assert_eq!(changed.exit, Exit::Usage);
        assert!(
            changed.message.contains("glb/mug_1.glb") && changed.message.contains("was changed"),
            "{changed}"
        );
        std::fs::remove_file(folder.join("glb/mug_1.glb")).expect("removes");
        assert!(refusal().message.contains("glb/mug_1.glb of the bundle"), "{}", refusal());
        std::fs::remove_file(folder.join("manifest.json")).expect("removes");
        assert!(refusal().message.contains("is no bundle: it has no manifest.json"), "{}", refusal());
    }

    #[test]
    fn no_name_leads_outside() {
        let home = tempfile::tempdir().expect("temporary directory");
        let folder = folder(home.path());
        std::fs::write(home.path().join("secret"), "mesh").expect("writes");
        let manifest = std::fs::read_to_string(folder.join("manifest.json")).expect("reads");
        let manifest = manifest.replace("glb/mug_1.glb", "../secret");
        std::fs::write(folder.join("manifest.json"), manifest).expect("writes");
        let refusal = BundleInput::open(&folder).and_then(BundleInput::into_archive).expect_err("is refused");
        assert!(refusal.message.contains("lies outside"), "{refusal}");
    }
}
