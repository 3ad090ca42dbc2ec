//! `migrate`: bring the database up to date and leave it.

use std::path::PathBuf;

use clap::Args;

use super::options::ConfigOptions;
use super::{Exit, Failure, runtime, terminal};
use crate::app;
use store::DatabaseAddress;

/// Arguments of `migrate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The data directory
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Opens the store, which migrates its database.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    runtime()?.block_on(app::open(&arguments.data_dir, &resolved.config))?;
    let place = match &resolved.config.store.database {
        DatabaseAddress::Sqlite => arguments.data_dir.display().to_string(),
        DatabaseAddress::Postgres(address) => address.clone(),
    };
    terminal::print(&format!("{place} is up to date\n"));
    Ok(Exit::Success)
}
