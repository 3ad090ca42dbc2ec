//! The place of a database that a command reaches beside the processes that run.

use std::path::PathBuf;

use clap::Args;

use super::Failure;
use super::options::ConfigOptions;
use crate::config::Resolved;

/// Place of the database.
#[derive(Debug, Args)]
pub struct Place {
    /// The data directory
    #[arg(long, value_name = "DIR", default_value = "data")]
    pub data_dir: PathBuf,
    #[command(flatten)]
    options: ConfigOptions,
}

impl Place {
    /// The settings, which may name a database outside of the data directory.
    ///
    /// # Errors
    ///
    /// A [`Failure`] for settings that are not valid.
    pub fn settings(&self) -> Result<Resolved, Failure> {
        self.options.load(Vec::new())
    }
}
