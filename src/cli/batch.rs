//! `batch`: many scenes from one file, without a server.
//!
//! The requests go through the queue of a data directory and an ordinary worker, so the directory knows what is done:
//! after Ctrl-C or a crash the same command goes on, nothing is lost and no finished stage is computed again. Requests
//! are submitted a few at a time, so that memory does not grow with their number.
//!
//! 1. [`source`] reads the file twice, one request at a time.
//! 2. [`survey`] takes stock: what is invalid, a duplicate, finished in an earlier run, or to be done.
//! 3. [`engine`] submits, follows and writes down what is to be done.
//!
//! `DIR/output.jsonl` and `DIR/errors.jsonl` are written anew from the data directory at every start ([`records`]), so
//! that a line that a crash cut off does no harm.

mod source;
mod checker;
mod survey;
mod engine;
mod money;
mod bundles;
mod records;
mod report;

use std::path::{Path, PathBuf};

use clap::Args;
use tokio_util::sync::CancellationToken;

use super::options::ConfigOptions;
use super::output::{Kind, Output};
use super::scene_summary;
use super::{Exit, Failure, block_on, number, signals, terminal};
use crate::app::config::{Origin, Resolved, is_open_to_requests};
use crate::app::{self, logging};
use crate::worker::BuildScene;
use bundles::Bundles;
use checker::Checker;
use engine::{Ending, Engine};
use records::Records;
use report::Report;
use source::Source;
use store::Intent;

/// Requests that are submitted ahead, for each one that is worked on.
const AHEAD: usize = 4;

/// Name of the default data directory in the folder of the batch.
const DATA_DIR: &str = ".tabletopgen";

/// Arguments of `batch`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Requests, one JSON object per line (.jsonl), or a recipe (.json)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Folder for output.jsonl, errors.jsonl and one bundle per request; the same folder again goes on
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Scenes worked on at the same time [default: worker.concurrency, 2]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<usize>(1..=u64::MAX))]
    workers: Option<usize>,
    /// Keep finished stages in this data directory [default: DIR/.tabletopgen]
    #[arg(long, value_name = "DIR")]
    data_dir: Option<PathBuf>,
    /// The most that the remote calls of all requests may cost together, US dollars [default: no limit but that of
    /// each request]
    #[arg(long, value_name = "USD", allow_negative_numbers = true, value_parser = number::us_dollars)]
    budget: Option<f64>,
    /// Begin requests again that failed or were cancelled in an earlier run
    #[arg(long)]
    retry_failed: bool,
    /// Take the first N requests of the file only
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<usize>(1..=u64::MAX))]
    limit: Option<usize>,
    /// Replace bundles of requests that have the same name and were changed since
    #[arg(long)]
    force: bool,
    /// Write bundles as DIR/CUSTOM_ID.zip instead of folders
    #[arg(long)]
    zip: bool,
    /// Print one JSON document at the end, and no progress
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Makes the scenes. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(batch(arguments), is_json)
}

fn batch(mut arguments: Arguments) -> Result<Exit, Failure> {
    // Settings that shape scenes become those of every request, so that the bundles state them.
    let (own, process) = std::mem::take(&mut arguments.options.set)
        .into_iter()
        .partition::<Vec<_>, _>(|(key, value)| is_open_to_requests(key, value));
    arguments.options.set = process;
    let workers = arguments.workers.map(|n| ("worker.concurrency".to_owned(), n.to_string(), "--workers"));
    let mut resolved = arguments.options.load(workers.into_iter().collect())?;
    if *resolved.origin("log.filter") == Origin::Default {
        resolved.config.log.filter = "error".to_owned();
    }
    logging::start(&resolved.config.log);
    let budget = arguments.budget.map(money::checked).transpose()?;
    let source = Source::open(&arguments.file, arguments.limit, own.into_iter().collect())?;
    // The folder is empty, missing, or that of an earlier run.
    Output::check(&arguments.out, Kind::Batch, false, &[&arguments.file])?;
    let build = app::pipeline::build_pipeline(&resolved)?;
    std::fs::create_dir_all(&arguments.out).map_err(|error| {
        Failure::new(Exit::Error, format!("cannot make the folder {}: {error}", arguments.out.display()))
    })?;
    let data_dir = arguments.data_dir.clone().unwrap_or_else(|| arguments.out.join(DATA_DIR));
    block_on(async {
        let stop = signals::stop_on_signal(
            "stopping: running stages finish, and the next run goes on after them; again to stop at once",
        )?;
        work(&arguments, &resolved, &source, build, budget, &data_dir, stop).await
    })
}

async fn work(
    arguments: &Arguments,
    resolved: &Resolved,
    source: &Source,
    build: BuildScene,
    budget: Option<scene::MicroUsd>,
    data_dir: &Path,
    stop: CancellationToken,
) -> Result<Exit, Failure> {
    let config = &resolved.config;
    let store = app::open(data_dir, config, Intent::Create).await?;
    let checker = Checker::new(resolved, source.folder());
    let bundles = Bundles::new(&arguments.out, arguments.zip, arguments.force)?;
    let mut records = Records::begin(&arguments.out)?;
    let mut money = money::Money::new(config, budget);
    let report = Report::new(arguments.json);
    let survey = survey::Survey {
        store: &store,
        checker: &checker,
        bundles: &bundles,
        retries_failed: arguments.retry_failed,
        report: &report,
    };
    let stock = survey.take(source, &mut records, &mut money, &stop).await?;
    records.publish()?;
    let mut engine = Engine {
        store: &store,
        checker: &checker,
        bundles: &bundles,
        stock,
        records,
        money,
        report,
        retries_failed: arguments.retry_failed,
        window: AHEAD * config.worker.concurrency,
        active: Default::default(),
        deferred: None,
        finished: 0,
        started: std::time::Instant::now(),
    };
    let ending =
        engine.run(source, app::worker(&store, config, &app::cpu_pool(config)?, build), &stop).await?;
    engine.report.close();
    let counts = &engine.stock.counts;
    let summary = engine.summary(&arguments.out);
    match ending {
        Ending::Complete if arguments.json => terminal::print(&summary.document()),
        Ending::Complete => terminal::print(&summary.text()),
        Ending::Stopped => {
            let message = format!(
                "interrupted with {} of {} requests done; the same command goes on there",
                counts.finished(),
                counts.computed()
            );
            return Err(Failure::new(Exit::Interrupted, message));
        }
        Ending::Storage(why) => {
            let what = match why {
                store::Outage::Full => "the disk is full; free space there",
                store::Outage::Other => "it cannot be written; see the log above",
            };
            let message = format!("{}: {what}, and give the same command again", data_dir.display());
            return Err(Failure::new(Exit::Error, message));
        }
    }
    Ok(if counts.all_succeeded() { Exit::Success } else { Exit::BatchIncomplete })
}
