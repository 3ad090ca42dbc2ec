//! `backup`: a copy of a data directory, also while a server uses it.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::counting::Counting;
use super::options::ConfigOptions;
use super::output::{Kind, Output};
use super::{Exit, Failure, runtime, terminal};
use store::backup::BackupReport;
use store::{StoreError, backup};

/// Arguments of `backup`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for the copy; a folder with an earlier backup gets what is new
    #[arg(value_name = "DIR")]
    target: PathBuf,
    /// The data directory
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Copies the database, then the blobs it refers to.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    let Arguments { target, data_dir, .. } = &arguments;
    Output::check(target, Kind::Backup, false, &[data_dir])?;
    let counting = Counting::new("blobs", false);
    let mut see = move |done, all| counting.see(done, all);
    let copying = backup::backup(data_dir, target, &resolved.config.store, &mut see);
    let report = runtime()?.block_on(copying).map_err(failed)?;
    terminal::print(&match arguments.json {
        true => as_document(target, &report),
        false => format!(
            "{}: {} blobs, {} of them new ({} bytes)\n",
            target.display(),
            report.intact.blobs,
            report.copied.blobs,
            report.copied.bytes
        ),
    });
    outcome(&report)
}

/// The report, JSON.
pub(super) fn as_document(place: &Path, report: &BackupReport) -> String {
    format!("{:#}\n", json!({ "place": place.display().to_string(), "report": report }))
}

/// Lists what is lost; the exit code says whether anything is.
pub(super) fn outcome(report: &BackupReport) -> Result<Exit, Failure> {
    const SHOWN: usize = 20;
    for blob in report.lost.iter().take(SHOWN) {
        let what = if blob.is_damaged { "does not match its digest" } else { "is missing" };
        terminal::note(&format!("{} ({:?}) {what}", blob.digest, blob.kind));
    }
    match report.lost.len() {
        0 => Ok(Exit::Success),
        count => Err(Failure::new(
            Exit::Error,
            format!(
                "{count} blobs are lost. Checkpoints, artifacts and bundles are computed again when they are wanted; \
                 the image of a request and the answer of a remote model are not"
            ),
        )),
    }
}

pub(super) fn failed(error: StoreError) -> Failure {
    Failure::new(Exit::Error, error.chain())
}
