//! The folder a bundle is unpacked into: checked before the work, written after it.
//!
//! A folder that holds a bundle already is written over (its listed files go first, so that nothing
//! stale stays); any other folder with something in it is refused unless forced. Files of other programs
//! are never removed.

use std::path::{Component, Path, PathBuf};

use serde::Deserialize;

use super::{Exit, Failure};

/// A folder that may be written.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// The topmost directory that was made for it, to be removed again if nothing comes of it.
    made: Option<PathBuf>,
}

/// Checks that `path` may become a bundle, making it where it is missing.
pub fn prepare(path: &Path, force: bool) -> Result<Folder, Failure> {
    if path.exists() && !path.is_dir() {
        return Err(Failure::usage(format!("--out {} is a file; name a folder", path.display())));
    }
    if !force && !is_empty(path)? && listed_files(path).is_none() {
        return Err(Failure::usage(format!(
            "--out {} is not empty and holds no bundle; name another folder, or add --force to write into it",
            path.display()
        )));
    }
    let made =
        path.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists()).last();
    let made = made.map(Path::to_owned);
    let unwritable = |error: std::io::Error| {
        let advice = "name another folder with --out";
        Failure::new(Exit::Error, format!("cannot write into {}: {error}; {advice}", path.display()))
    };
    std::fs::create_dir_all(path).map_err(unwritable)?;
    let folder = Folder { path: path.to_owned(), made };
    match tempfile::NamedTempFile::new_in(path) {
        Ok(_) => Ok(folder),
        Err(error) => {
            folder.abandon();
            Err(unwritable(error))
        }
    }
}

impl Folder {
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder `name` in here.
    pub fn inside(self, name: &str, force: bool) -> Result<Self, Failure> {
        let inner = prepare(&self.path.join(name), force)?;
        Ok(Self { made: self.made.or(inner.made), path: inner.path })
    }

    /// Removes what was made for nothing: empty directories only.
    pub fn abandon(self) {
        let Some(top) = self.made else { return };
        for folder in self.path.ancestors() {
            // A directory with something in it stays, and so do those around it.
            if std::fs::remove_dir(folder).is_err() || folder == top {
                return;
            }
        }
    }

    /// Removes what an earlier bundle left here.
    pub fn clear(&self) -> Result<(), Failure> {
        for file in listed_files(&self.path).unwrap_or_default() {
            let path = inside(&self.path, &file)?;
            match std::fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(unremovable(&path, &error));
                }
                _ => {}
            }
        }
        let artifacts = self.path.join("artifacts");
        if listed_files(&self.path).is_some() && artifacts.is_dir() {
            std::fs::remove_dir_all(&artifacts).map_err(|error| unremovable(&artifacts, &error))?;
        }
        Ok(())
    }

    /// Writes one file below the folder.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = inside(&self.path, name)?;
        let parent = path.parent().unwrap_or(&self.path);
        let written = std::fs::create_dir_all(parent).and_then(|()| std::fs::write(&path, bytes));
        written.map_err(|error| {
            let advice = match error.kind() {
                std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
                    "; free space there, or name another folder with --out"
                }
                _ => "",
            };
            Failure::new(Exit::Error, format!("cannot write {}: {error}{advice}", path.display()))
        })
    }
}

fn unremovable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Error, format!("cannot remove {} of the bundle before: {error}", path.display()))
}

/// `name` below `folder`; a name that leads anywhere else is an error.
fn inside(folder: &Path, name: &str) -> Result<PathBuf, Failure> {
    let name = Path::new(name);
    if name.components().all(|part| matches!(part, Component::Normal(_))) {
        return Ok(folder.join(name));
    }
    Err(Failure::new(Exit::Error, format!("{} is no name of a file inside a bundle", name.display())))
}

fn is_empty(path: &Path) -> Result<bool, Failure> {
    match std::fs::read_dir(path) {
        Ok(mut entries) => Ok(entries.next().is_none()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(true),
        Err(error) => Err(Failure::new(Exit::Error, format!("cannot look into {}: {error}", path.display()))),
    }
}

/// The files a bundle's manifest lists, itself included; `None` where there is no bundle.
fn listed_files(folder: &Path) -> Option<Vec<String>> {
    #[derive(Deserialize)]
    struct Manifest {
        format: String,
        files: Vec<File>,
    }
    #[derive(Deserialize)]
    struct File {
        path: String,
    }
    let bytes = std::fs::read(folder.join("manifest.json")).ok()?;
    let manifest: Manifest = serde_json::from_slice(&bytes).ok()?;
    manifest.format.starts_with("tabletopgen-manifest/").then(|| {
        let files = manifest.files.into_iter().map(|file| file.path);
        files.filter(|path| path != "manifest.json").collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MANIFEST: &[u8] =
        br#"{ "format": "tabletopgen-manifest/1", "files": [{ "path": "mjcf/old.xml" }, { "path": "../up" }] }"#;

    #[test]
    fn only_bundles_and_empty_folders_are_written_over() {
        let home = tempfile::tempdir().expect("temporary directory");
        let path = home.path().join("a/b");
        prepare(&path, false).expect("makes it").abandon();
        assert!(!home.path().join("a").exists(), "what was made for nothing is gone");

        let folder = prepare(&path, false).expect("makes it");
        folder.write("notes.txt", b"mine").expect("writes");
        assert_eq!(prepare(&path, false).expect_err("is refused").exit, Exit::Usage);
        prepare(&path, true).expect("forced").abandon();
        assert!(path.join("notes.txt").exists());

        let honest = String::from_utf8_lossy(MANIFEST).replace(r#", { "path": "../up" }"#, "");
        folder.write("manifest.json", honest.as_bytes()).expect("writes");
        folder.write("mjcf/old.xml", b"old").expect("writes");
        prepare(&path, false).expect("holds a bundle").clear().expect("clears");
        assert!(!path.join("mjcf/old.xml").exists() && path.join("notes.txt").exists());
        assert!(prepare(&path.join("notes.txt"), false).is_err(), "a file is no folder");
    }

    #[test]
    fn nothing_leads_outside() {
        let home = tempfile::tempdir().expect("temporary directory");
        let folder = prepare(&home.path().join("in"), false).expect("makes it");
        for name in ["../out", "/etc/x", "a/../../b"] {
            assert!(folder.write(name, b"").is_err(), "{name}");
        }
        folder.write("manifest.json", MANIFEST).expect("writes");
        std::fs::write(home.path().join("up"), b"not ours").expect("writes");
        assert!(folder.clear().is_err());
        assert!(home.path().join("up").exists());
    }
}
