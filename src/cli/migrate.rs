//! `migrate`: bring the database up to date and leave it.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::options::ConfigOptions;
use super::{Exit, Failure, runtime, terminal};
use crate::app;
use store::{DatabaseAddress, Intent};

/// Arguments of `migrate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The data directory
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    /// Make the database if there is none in the data directory. The tables of a PostgreSQL database, which must exist,
    /// are made without this
    #[arg(long)]
    create: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Opens the store, which migrates its database.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    let database = &resolved.config.store.database;
    // The address of a PostgreSQL database cannot be a new place by mistake: it names a database that exists.
    let creates = arguments.create || matches!(database, DatabaseAddress::Postgres(_));
    let intent = if creates { Intent::Create } else { Intent::Existing };
    runtime()?.block_on(app::open(&arguments.data_dir, &resolved.config, intent))?;
    let place = match database {
        DatabaseAddress::Sqlite => arguments.data_dir.display().to_string(),
        DatabaseAddress::Postgres(address) => address.clone(),
    };
    terminal::print(&match arguments.json {
        true => format!("{:#}\n", json!({ "place": place, "is_up_to_date": true })),
        false => format!("{place} is up to date\n"),
    });
    Ok(Exit::Success)
}
