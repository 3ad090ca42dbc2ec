//! A folder that appears complete or not at all.
//!
//! Files are written below `NAME.part`, which also holds a note that it is incomplete. At the end every file reaches
//! the disk, the note goes, and the folder gets its name.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use crate::EpisodeError;

/// Files that are on their way to the disk at a time.
const SYNCED_AT_ONCE: usize = 16;
/// The note in a folder that is not complete.
const NOTE: &str = "INCOMPLETE.txt";
const NOTE_TEXT: &str = "This dataset is being written, or its writer was stopped. Do not use it.\n";

/// A folder that is being written.
pub struct PartFolder {
    part: PathBuf,
    complete: PathBuf,
}

impl PartFolder {
    /// Begins a folder. What an earlier writer left under the name of the part is removed.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Folder`] where the folder exists, or where the part is something else;
    /// [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the disk.
    pub fn create(folder: &Path) -> Result<Self, EpisodeError> {
        let refused = |what: &str, correction| {
            Err(EpisodeError::Folder { folder: folder.to_owned(), what: what.to_owned(), correction })
        };
        let Some(name) = folder.file_name() else {
            return refused("the folder has no name", "name a folder");
        };
        if folder.exists() {
            return refused("the folder exists", "remove it or choose another");
        }
        let mut part_name = name.to_owned();
        part_name.push(".part");
        let part = folder.with_file_name(part_name);
        if part.exists() {
            if !part.join(NOTE).is_file() {
                return refused(
                    "the folder with the ending .part beside it is none of an earlier writer",
                    "move that folder away or choose another",
                );
            }
            fs::remove_dir_all(&part).map_err(|source| EpisodeError::write(&part, source))?;
        }
        let created = Self { part, complete: folder.to_owned() };
        created.folder("")?;
        created.write(NOTE, NOTE_TEXT.as_bytes())?;
        Ok(created)
    }

    /// A path inside the folder while it is written.
    pub fn path(&self, inside: &str) -> PathBuf {
        self.part.join(inside)
    }

    /// Makes a folder inside, with those around it, and returns its path.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the disk.
    pub fn folder(&self, inside: &str) -> Result<PathBuf, EpisodeError> {
        let path = self.path(inside);
        make_folder(&path)?;
        Ok(path)
    }

    /// Writes a file inside.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the disk.
    pub fn write(&self, inside: &str, bytes: &[u8]) -> Result<(), EpisodeError> {
        write_file(&self.path(inside), bytes)
    }

    /// Gives the folder its name, after everything in it has reached the disk.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the disk.
    pub fn complete(self) -> Result<(), EpisodeError> {
        sync_tree(&self.part).map_err(|source| EpisodeError::write(&self.part, source))?;
        let note = self.part.join(NOTE);
        fs::remove_file(&note).map_err(|source| EpisodeError::write(&note, source))?;
        sync(&self.part)?;
        fs::rename(&self.part, &self.complete)
            .map_err(|source| EpisodeError::write(&self.complete, source))?;
        match self.complete.parent() {
            Some(parent) if parent != Path::new("") => sync(parent),
            _ => sync(Path::new(".")),
        }
    }
}

/// Makes a folder with those around it.
pub(crate) fn make_folder(path: &Path) -> Result<(), EpisodeError> {
    fs::create_dir_all(path).map_err(|source| EpisodeError::write(path, source))
}

/// Writes a file.
pub(crate) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), EpisodeError> {
    fs::write(path, bytes).map_err(|source| EpisodeError::write(path, source))
}

/// Has every file and folder below `folder`, and itself, reach the disk. Each waits for the disk, which takes many in
/// the time of one: 340 files take 2.3 s one after the other, and 0.14 s so.
///
/// # Errors
///
/// The first error of the system.
pub fn sync_tree(folder: &Path) -> io::Result<()> {
    let mut paths = vec![folder.to_owned()];
    let mut next = 0;
    while next < paths.len() {
        if paths[next].is_dir() {
            for entry in fs::read_dir(&paths[next])? {
                paths.push(entry?.path());
            }
        }
        next += 1;
    }
    let (place, failure) = (AtomicUsize::new(0), Mutex::new(None));
    let work = || {
        while let Some(path) = paths.get(place.fetch_add(1, Ordering::Relaxed)) {
            if let Err(error) = File::open(path).and_then(|file| file.sync_all()) {
                failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                return;
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..SYNCED_AT_ONCE.min(paths.len()) {
            scope.spawn(work);
        }
    });
    failure.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
}

fn sync(path: &Path) -> Result<(), EpisodeError> {
    File::open(path).and_then(|file| file.sync_all()).map_err(|source| EpisodeError::write(path, source))
}
