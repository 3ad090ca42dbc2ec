//! A folder that is being written: beside its place, until it is whole.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use rayon::prelude::*;
use tempfile::TempDir;

use super::{Output, unwritable};
use crate::cli::{Exit, Failure};

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

    /// Gives the folder its place. An earlier output that may be replaced is removed after that.
    ///
    /// # Errors
    ///
    /// A [`Failure`] of the disk, or if the place was taken meanwhile. The new files stay then, and the message says
    /// where.
    pub fn publish(self) -> Result<(), Failure> {
        let Self { output, folder } = self;
        sync_all(folder.path()).map_err(|error| unwritable(&output.shown, &error))?;
        if let Some(refusal) = output.refusal() {
            return Err(kept(folder, &format!("{refusal}; the place was taken meanwhile")));
        }
        if folder.path().parent() == Some(&*output.path) {
            return move_up(folder, &output);
        }
        let replaced = match set_aside(&output, folder.path()) {
            Ok(replaced) => replaced,
            Err(error) => return Err(kept(folder, &unwritable(&output.shown, &error).message)),
        };
        if let Err(error) = std::fs::rename(folder.path(), &output.path) {
            if let Some(replaced) = &replaced {
                // If even that fails, the message still names the folder beside.
                let _ = std::fs::rename(replaced, &output.path);
            }
            return Err(kept(folder, &unwritable(&output.shown, &error).message));
        }
        // It has another name now.
        let _ = folder.keep();
        let parent = output.path.parent().unwrap_or(Path::new("/"));
        sync(parent).map_err(|error| unwritable(&output.shown, &error))?;
        match replaced {
            Some(replaced) => std::fs::remove_dir_all(&replaced).map_err(|error| {
                let (old, new) = (replaced.display(), output.shown.display());
                let message =
                    format!("{new} is written, but the output before, {old}, cannot be removed: {error}");
                Failure::new(Exit::Error, message)
            }),
            None => Ok(()),
        }
    }
}

/// Moves the output before to a name beside it; `None` if there is none.
fn set_aside(output: &Output, partial: &Path) -> io::Result<Option<PathBuf>> {
    let is_there = std::fs::read_dir(&output.path).is_ok_and(|mut entries| entries.next().is_some());
    if !is_there {
        // An empty folder gives way to a renamed one.
        return Ok(None);
    }
    let mut name = partial.file_name().unwrap_or_default().to_owned();
    name.push(".replaced");
    let replaced = partial.with_file_name(name);
    std::fs::rename(&output.path, &replaced)?;
    Ok(Some(replaced))
}

/// Moves the content of a folder to the folder around it, which is empty otherwise.
fn move_up(folder: TempDir, output: &Output) -> Result<(), Failure> {
    let moved = std::fs::read_dir(folder.path()).and_then(|mut entries| {
        entries.try_for_each(|entry| {
            let entry = entry?;
            std::fs::rename(entry.path(), output.path.join(entry.file_name()))
        })
    });
    match moved.and_then(|()| sync(&output.path)) {
        Ok(()) => Ok(()),
        Err(error) => Err(kept(folder, &unwritable(&output.shown, &error).message)),
    }
}

fn kept(folder: TempDir, message: &str) -> Failure {
    let folder = folder.keep();
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

/// Syncs every file and folder below `folder`, and itself.
fn sync_all(folder: &Path) -> io::Result<()> {
    let mut paths = vec![folder.to_owned()];
    let mut next = 0;
    while next < paths.len() {
        if paths[next].is_dir() {
            for entry in std::fs::read_dir(&paths[next])? {
                paths.push(entry?.path());
            }
        }
        next += 1;
    }
    paths.par_iter().try_for_each(|path| sync(path))
}

fn sync(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}
