//! `migrate`: bring a data directory up to date and leave it.

use std::path::PathBuf;

use clap::Args;

use super::options::ConfigOptions;
use super::{Exit, Failure, runtime, terminal};
use crate::app;

/// Arguments of `migrate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The data directory
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Opens the directory, which migrates it.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    runtime()?.block_on(app::open(&arguments.data_dir, &resolved.config))?;
    terminal::print(&format!("{} is up to date\n", arguments.data_dir.display()));
    Ok(Exit::Success)
}
