//! A file with one JSON value a line.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use serde_json::Value;

use crate::EpisodeError;

/// A file that grows line by line.
pub(crate) struct JsonLines {
    path: PathBuf,
    file: BufWriter<File>,
}

impl JsonLines {
    pub fn create(path: PathBuf) -> Result<Self, EpisodeError> {
        let file = File::create(&path).map_err(|source| EpisodeError::write(&path, source))?;
        Ok(Self { path, file: BufWriter::new(file) })
    }

    pub fn add(&mut self, value: &Value) -> Result<(), EpisodeError> {
        writeln!(self.file, "{value}").map_err(|source| EpisodeError::write(&self.path, source))
    }

    pub fn finish(mut self) -> Result<(), EpisodeError> {
        self.file.flush().map_err(|source| EpisodeError::write(&self.path, source))
    }
}
