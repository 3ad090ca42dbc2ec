//! `sweep`: removes what the retention settings do not keep. A running server does so by itself.

use std::path::PathBuf;

use clap::Args;

use super::backup::failed;
use super::options::ConfigOptions;
use super::{Exit, Failure, runtime, terminal};
use crate::app;
use store::Intent;
use store::retention::{ResourceRemovals, SweepReport};

/// Arguments of `sweep`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The data directory, which no server may use meanwhile
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    /// Say what would be removed, and remove nothing
    #[arg(long)]
    dry_run: bool,
    /// Print the numbers as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Sweeps once.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    let settings = &resolved.config.store.retention;
    let report = runtime()?.block_on(async {
        let store = app::open(&arguments.data_dir, &resolved.config, Intent::Existing).await?;
        store.sweep(settings, arguments.dry_run).await.map_err(failed)
    })?;
    let Some(report) = report else {
        return Err(Failure::new(Exit::Error, "a backup is under way; sweep again when it has ended"));
    };
    if arguments.json {
        terminal::print(&format!("{:#}\n", serde_json::json!(report)));
    } else {
        terminal::print(&text(&report));
    }
    Ok(Exit::Success)
}

fn text(report: &SweepReport) -> String {
    let SweepReport { stripped_scenes, orphaned_checkpoints, quarantined_bundles, .. } = report;
    let SweepReport {
        idempotency_keys,
        executions,
        purged_scenes,
        dataset_jobs,
        deliveries,
        removed,
        kept,
        ..
    } = report;
    let verb = if report.is_dry_run { "would be removed" } else { "removed" };
    format!(
        "scenes whose artifacts and checkpoints {verb}: {stripped_scenes}\n\
         checkpoints of no job {verb}: {orphaned_checkpoints}\n\
         bundles of quarantined scenes {verb}: {quarantined_bundles}\n\
         idempotency keys {verb}: {idempotency_keys}\n\
         executions {verb}: {executions}\n\
         ended jobs of datasets {verb}: {dataset_jobs}\n\
         deliveries to webhooks {verb}: {deliveries}\n\
         deleted scenes whose last rows {verb}: {purged_scenes}\n\
         {}{}{}\
         blobs {verb}: {} ({} bytes); kept: {} ({} bytes)\n",
        of_kind("batches", "requests", &report.batches, verb),
        of_kind("datasets", "files", &report.datasets, verb),
        of_kind("recordings", "files", &report.recordings, verb),
        removed.blobs,
        removed.bytes,
        kept.blobs,
        kept.bytes
    )
}

/// The lines about resources of one kind.
fn of_kind(kind: &str, contents: &str, removals: &ResourceRemovals, verb: &str) -> String {
    let ResourceRemovals { expired, emptied, purged } = removals;
    format!(
        "{kind} whose time is over: {expired}\n\
         deleted {kind} whose {contents} {verb}: {emptied}\n\
         deleted {kind} whose last rows {verb}: {purged}\n"
    )
}
