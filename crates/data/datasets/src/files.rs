//! Files that appear whole or not at all, with their digests.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use runtime::digest::hex;

use crate::dataset_manifest::FileEntry;
use crate::error::DatasetError;

/// A file under construction. It lies beside its place until [`Self::finish`] renames it.
pub struct AtomicFile {
    partial: PathBuf,
    target: PathBuf,
    file: BufWriter<File>,
    digest: Sha256,
    size: u64,
}

impl AtomicFile {
    /// Begins a file that will replace `target`; `partial` is on the same file system.
    ///
    /// # Errors
    ///
    /// [`DatasetError::File`] if the folder cannot be made or written.
    pub fn create(partial: PathBuf, target: PathBuf) -> Result<Self, DatasetError> {
        for path in [&partial, &target] {
            let folder = path.parent().unwrap_or(Path::new(""));
            fs::create_dir_all(folder).map_err(DatasetError::file("create", folder))?;
        }
        let file = File::create(&partial).map_err(DatasetError::file("create", &partial))?;
        Ok(Self { partial, target, file: BufWriter::new(file), digest: Sha256::new(), size: 0 })
    }

    pub fn size(&self) -> u64 {
        self.size
    }

    /// Syncs the file and gives it its name. Returns size and digest.
    ///
    /// # Errors
    ///
    /// [`DatasetError::File`] if the disk fails or is full.
    pub fn finish(self) -> Result<(u64, String), DatasetError> {
        let file = self.file.into_inner().map_err(io::IntoInnerError::into_error);
        file.and_then(|file| file.sync_all()).map_err(DatasetError::file("write", &self.partial))?;
        fs::rename(&self.partial, &self.target).map_err(DatasetError::file("rename to", &self.target))?;
        Ok((self.size, hex(&self.digest.finalize())))
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.digest.update(&bytes[..written]);
        self.size += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Writes a whole file, and returns its entry.
///
/// # Errors
///
/// [`DatasetError::File`].
pub fn write(folder: &Path, path: &str, bytes: &[u8]) -> Result<FileEntry, DatasetError> {
    write_beside(folder, path, &format!("{path}.partial"), bytes)
}

/// As [`write()`], with the relative path of the unfinished file.
///
/// # Errors
///
/// [`DatasetError::File`].
pub fn write_beside(
    folder: &Path,
    path: &str,
    partial: &str,
    bytes: &[u8],
) -> Result<FileEntry, DatasetError> {
    let target = folder.join(path);
    let mut file = AtomicFile::create(folder.join(partial), target.clone())?;
    file.write_all(bytes).map_err(DatasetError::file("write", &target))?;
    let (size, sha256) = file.finish()?;
    Ok(FileEntry { path: path.to_owned(), size, sha256 })
}

/// Size and digest of a file, read in pieces.
///
/// # Errors
///
/// [`DatasetError::File`].
pub fn measure(path: &Path) -> Result<(u64, String), DatasetError> {
    let mut file = File::open(path).map_err(DatasetError::file("open", path))?;
    let (mut digest, mut size, mut piece) = (Sha256::new(), 0, vec![0; 1 << 18]);
    loop {
        let count = file.read(&mut piece).map_err(DatasetError::file("read", path))?;
        if count == 0 {
            return Ok((size, hex(&digest.finalize())));
        }
        digest.update(&piece[..count]);
        size += count as u64;
    }
}

/// Paths of all files below a folder, relative to it and sorted, and of everything that is neither file nor folder.
///
/// # Errors
///
/// [`DatasetError::File`] if a folder cannot be listed.
pub fn list(folder: &Path) -> Result<Vec<String>, DatasetError> {
    let (mut paths, mut open) = (Vec::new(), vec![String::new()]);
    while let Some(inner) = open.pop() {
        let at = folder.join(&inner);
        for entry in fs::read_dir(&at).map_err(DatasetError::file("list", &at))? {
            let entry = entry.map_err(DatasetError::file("list", &at))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = if inner.is_empty() { name } else { format!("{inner}/{name}") };
            let kind = entry.file_type().map_err(DatasetError::file("read", &at))?;
            if kind.is_dir() { open.push(path) } else { paths.push(path) }
        }
    }
    paths.sort();
    Ok(paths)
}
