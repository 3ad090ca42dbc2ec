//! Parquet files that follow each other: a new one begins before a limit of bytes would be passed.

use std::path::{Path, PathBuf};

use crate::EpisodeError;
use crate::lerobot::FILES_A_CHUNK;
use crate::parquet_table::{ParquetFile, Table};
use crate::part_folder::make_folder;

/// The number of a file: its folder and its place in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FileNumber {
    pub chunk: u64,
    pub file: u64,
}

impl FileNumber {
    /// The path below a folder.
    pub fn path(self, folder: &Path, ending: &str) -> PathBuf {
        folder.join(format!("chunk-{:03}/file-{:03}.{ending}", self.chunk, self.file))
    }

    pub fn next(self) -> Self {
        if self.file + 1 == FILES_A_CHUNK {
            Self { chunk: self.chunk + 1, file: 0 }
        } else {
            Self { file: self.file + 1, ..self }
        }
    }
}

/// Parquet files in a folder.
pub(crate) struct RollingData {
    folder: PathBuf,
    limit_bytes: u64,
    metadata: Vec<(&'static str, String)>,
    number: FileNumber,
    file: Option<ParquetFile>,
}

impl RollingData {
    /// Files that each state `metadata` as key and value.
    pub fn new(folder: PathBuf, limit_bytes: u64, metadata: Vec<(&'static str, String)>) -> Self {
        Self { folder, limit_bytes, metadata, number: FileNumber::default(), file: None }
    }

    /// File into which a table of so many bytes will go. It ends a file that would become too large.
    pub fn file_for(&mut self, bytes: u64) -> Result<FileNumber, EpisodeError> {
        let is_full = |file: &mut ParquetFile| file.bytes() + bytes > self.limit_bytes;
        if let Some(file) = self.file.take_if(is_full) {
            file.finish()?;
            self.number = self.number.next();
        }
        Ok(self.number)
    }

    /// Adds a table as a row group to the file that [`Self::file_for`] named.
    pub fn add(&mut self, table: &Table) -> Result<(), EpisodeError> {
        let file = match &mut self.file {
            Some(file) => file,
            none => {
                let path = self.number.path(&self.folder, "parquet");
                make_folder(path.parent().unwrap_or(&self.folder))?;
                none.insert(ParquetFile::create(&path, table, &self.metadata)?)
            }
        };
        file.add(table)
    }

    pub fn finish(self) -> Result<(), EpisodeError> {
        self.file.map_or(Ok(()), ParquetFile::finish)
    }
}
