//! `restore`: a backup becomes a data directory, or is checked; so is a data directory that other tools restored.

use std::path::PathBuf;

use clap::Args;

use super::backup::{as_document, failed, outcome};
use super::counting::Counting;
use super::options::ConfigOptions;
use super::{Exit, Failure, runtime, terminal};
use crate::app;
use store::{Intent, backup};

/// Arguments of `restore`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The backup; without one, --verify checks the data directory (or the database and bucket of the settings)
    #[arg(value_name = "DIR", required_unless_present = "verify")]
    backup: Option<PathBuf>,
    /// Only check that every blob is there and matches its digest; nothing is restored
    #[arg(long)]
    verify: bool,
    /// The data directory; `restore` wants one without a database
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Restores or checks.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    let settings = &resolved.config.store;
    let data_dir = &arguments.data_dir;
    let runtime = runtime()?;
    let counting = Counting::new("blobs", false);
    let mut see = move |done, all| counting.see(done, all);
    let (place, report) = match (&arguments.backup, arguments.verify) {
        (Some(backup), false) => (
            data_dir,
            runtime.block_on(backup::restore(backup, data_dir, settings, &mut see)).map_err(failed)?,
        ),
        (Some(backup), true) => {
            (backup, runtime.block_on(backup::verify(backup, settings, &mut see)).map_err(failed)?)
        }
        (None, _) => {
            let report = runtime.block_on(async {
                let store = app::open(data_dir, &resolved.config, Intent::Existing).await?;
                store.verify(&mut see).await.map_err(failed)
            })?;
            (data_dir, report)
        }
    };
    terminal::print(&match arguments.json {
        true => as_document(place, &report),
        false => format!(
            "{}: {} blobs match their digests ({} bytes)\n",
            place.display(),
            report.intact.blobs,
            report.intact.bytes
        ),
    });
    outcome(&report)
}
