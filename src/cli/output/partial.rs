//! A folder that is being written: beside its place, until it is whole.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use tempfile::TempDir;

use super::{Output, unwritable};
use crate::cli::{Exit, Failure};
use episodes::sync_tree;

/// An unfinished folder; removed unless [`Partial::publish`] is called.
pub struct Partial {
    output: Output,
    folder: TempDir,
}

impl Partial {
    pub(super) fn begin(output: Output) -> Result<Self, Failure> {
        let beside = output.partials.clone().or_else(|| output.path.parent().map(Path::to_owned));
        let beside = beside.unwrap_or_else(|| PathBuf::from("/"));
        let name = output.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let made = std::fs::create_dir_all(&beside)
            .and_then(|()| folder_in(&beside, &format!("{name}.partial-")))
            .or_else(|error| match output.path.is_dir() {
                // The place of a mounted volume: its own folder can be written, the one around it cannot.
                true => folder_in(&output.path, ".partial-"),
                false => Err(error),
            });
        match made {
            Ok(folder) => Ok(Self { output, folder }),
            Err(error) => Err(unwritable(&output.shown, &error)),
        }
    }

    /// Writes one file below the folder.
    ///
    /// # Errors
    ///
    /// A [`Failure`] of the disk, and for a name that leads anywhere else.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        if !Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) {
            return Err(Failure::new(Exit::Error, format!("{name:?} is no name of a file inside a folder")));
        }
        let path = self.folder.path().join(name);
        let parent = path.parent().unwrap_or(self.folder.path());
        let written = std::fs::create_dir_all(parent)
            .and_then(|()| File::create(&path))
            .and_then(|mut file| file.write_all(bytes));
        written.map_err(|error| unwritable(&self.output.shown, &error))
    }

    /// A path inside, for what makes its folder itself; [`Self::publish_inside`] gives that its place.
    pub fn inside(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Gives the folder its place. An earlier output that may be replaced is removed after that.
    ///
    /// # Errors
    ///
    /// A [`Failure`] of the disk, or if the place was taken meanwhile. The new files stay then, and the message says
    /// where.
    pub fn publish(self) -> Result<(), Failure> {
        let Self { output, folder } = self;
        sync_tree(folder.path()).map_err(|error| unwritable(&output.shown, &error))?;
        // From here on it stays: at its place, or where the message says.
        output.publish(&folder.keep())
    }

    /// Gives the place to a folder inside that is complete and has reached the disk.
    ///
    /// # Errors
    ///
    /// Those of [`Self::publish`].
    pub fn publish_inside(self, name: &str) -> Result<(), Failure> {
        let around = self.folder.keep();
        self.output.publish(&around.join(name))?;
        // It is empty, or went with what it held.
        let _ = std::fs::remove_dir(around);
        Ok(())
    }
}

impl Output {
    /// Gives the place to a folder that is complete and has reached the disk, which is that of the place. An earlier
    /// output that may be replaced is removed after that.
    ///
    /// # Errors
    ///
    /// Those of [`Partial::publish`].
    pub fn publish(&self, folder: &Path) -> Result<(), Failure> {
        if let Some(refusal) = self.refusal() {
            return Err(kept(folder, &format!("{refusal}; the place was taken meanwhile")));
        }
        let failed = |error: io::Error| kept(folder, &unwritable(&self.shown, &error).message);
        if folder.starts_with(&self.path) {
            return move_up(folder, &self.path).map_err(failed);
        }
        let replaced = set_aside(self, folder).map_err(failed)?;
        if let Err(error) = std::fs::rename(folder, &self.path) {
            if let Some(replaced) = &replaced {
                // If even that fails, the message still names the folder beside.
                let _ = std::fs::rename(replaced, &self.path);
            }
            return Err(failed(error));
        }
        let parent = self.path.parent().unwrap_or(Path::new("/"));
        sync(parent).map_err(|error| unwritable(&self.shown, &error))?;
        match replaced {
            Some(replaced) => std::fs::remove_dir_all(&replaced).map_err(|error| {
                let (old, new) = (replaced.display(), self.shown.display());
                let message =
                    format!("{new} is written, but the output before, {old}, cannot be removed: {error}");
                Failure::new(Exit::Error, message)
            }),
            None => Ok(()),
        }
    }
}

/// Moves the output before to a new folder beside `folder`; `None` if there is none.
fn set_aside(output: &Output, folder: &Path) -> io::Result<Option<PathBuf>> {
    let is_there = std::fs::read_dir(&output.path).is_ok_and(|mut entries| entries.next().is_some());
    if !is_there {
        // An empty folder gives way to a renamed one.
        return Ok(None);
    }
    let replaced = folder_in(folder.parent().unwrap_or(Path::new("/")), ".replaced-")?.keep();
    std::fs::rename(&output.path, &replaced).inspect_err(|_| {
        // It is empty.
        let _ = std::fs::remove_dir(&replaced);
    })?;
    Ok(Some(replaced))
}

/// Moves the content of a folder up to `place` around it, which is empty otherwise.
fn move_up(folder: &Path, place: &Path) -> io::Result<()> {
    std::fs::read_dir(folder)?.try_for_each(|entry| {
        let entry = entry?;
        std::fs::rename(entry.path(), place.join(entry.file_name()))
    })?;
    // What is around the content is empty now.
    for around in folder.ancestors().take_while(|around| *around != place) {
        std::fs::remove_dir(around)?;
    }
    sync(place)
}

fn kept(folder: &Path, message: &str) -> Failure {
    Failure::new(Exit::Error, format!("{message}; what was written is in {}", folder.display()))
}

/// A new folder with the permissions of ordinary ones.
fn folder_in(parent: &Path, prefix: &str) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    builder.tempdir_in(parent)
}

fn sync(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}
