//! A job of the command line: one scene, here and now, by the server's code path, into a folder.
//!
//! Everything that can be refused is refused before the work: arguments, settings, the input, the folder. Settings
//! given with `--set` that shape scenes become the request's own, so the bundle states them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use tokio_util::sync::CancellationToken;

use super::options::ConfigOptions;
use super::output::{self, Kind, Output};
use super::progress::Progress;
use super::scene_summary::{Outcome, Place, Target};
use super::{Exit, Failure, number, runtime, signals, terminal};
use crate::app::config::{Config, Origin, Resolved, is_open_to_requests};
use crate::app::local;
use crate::app::local::Ended;
use crate::app::submission::Submission;
use crate::app::{self, logging};
use crate::worker::BuildScene;
use store::lifecycle::JobState;
use store::{BlobPlace, Intent, Outage, Store};

/// Arguments of the commands that make one scene.
#[derive(Debug, Args)]
pub struct JobOptions {
    /// Same input and seed: same scene, to the byte [default: random, and reported]
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        value_parser = number::seed
    )]
    pub seed: Option<u64>,
    /// Folder for the bundle [default: out/SHORT_ID]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Try this robot in the finished scene, panda or piper: its grasps of each object, what it can pick up, and tasks;
    /// takes seconds for each object
    #[arg(long, value_name = "NAME")]
    pub robot: Option<String>,
    /// Replace the bundle that an earlier run left in the folder of --out; a folder with other files is refused
    #[arg(long)]
    pub force: bool,
    /// Also write what every stage put aside, under DIR/artifacts/STAGE/
    #[arg(long)]
    pub artifacts: bool,
    /// Keep and reuse finished stages in this data directory instead of a temporary one
    #[arg(long, value_name = "DIR")]
    pub data_dir: Option<PathBuf>,
    /// Threads that compute [default: one per core]; the scene does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<usize>(1..=u64::MAX))]
    pub threads: Option<usize>,
    /// Print one JSON document instead of the table, and no progress
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub options: ConfigOptions,
}

/// The configuration of a job.
pub struct JobConfig {
    pub resolved: Resolved,
    /// The settings that shape the scene: `options.set` of its request.
    pub own: BTreeMap<String, String>,
}

/// A scene that was made, and how long that took.
pub struct FinishedJob {
    pub outcome: Outcome,
    pub total_ms: u128,
}

impl FinishedJob {
    pub fn exit(&self) -> Exit {
        if self.outcome.passed { Exit::Success } else { Exit::Quarantined }
    }
}

impl JobOptions {
    /// Reads the configuration and starts the log.
    ///
    /// # Errors
    ///
    /// A [`Failure`] with every setting that is wrong.
    pub fn configure(&mut self) -> Result<JobConfig, Failure> {
        let (own, process) = std::mem::take(&mut self.options.set)
            .into_iter()
            .partition::<Vec<_>, _>(|(key, value)| is_open_to_requests(key, value));
        self.options.set = process;
        let threads = self.threads.map(|n| ("worker.cpu_threads".to_owned(), n.to_string(), "--threads"));
        let mut resolved = self.options.load(threads.into_iter().collect())?;
        adapt(&mut resolved, self.data_dir.is_some());
        logging::start(&resolved.config.log);
        Ok(JobConfig { resolved, own: own.into_iter().collect() })
    }

    /// Place of the bundle, checked before any work. `inputs` are the files and folders that the command reads.
    ///
    /// # Errors
    ///
    /// A [`Failure`] where the folder must not or cannot be written.
    pub fn place(&self, inputs: &[&Path]) -> Result<Place, Failure> {
        if let Some(out) = &self.out {
            return Ok(Place::Named(Output::check(out, Kind::Bundle, self.force, inputs)?));
        }
        // The usual folder holds one folder per bundle, so it may hold anything itself.
        let folder = PathBuf::from("out");
        output::check_parent(&folder)?;
        Ok(Place::Within { folder, is_forced: self.force })
    }

    /// Makes the scene of a submission, and writes its bundle.
    ///
    /// # Errors
    ///
    /// A [`Failure`] where the bundle cannot be written, or the job does not succeed.
    pub fn run(
        &self,
        resolved: &Resolved,
        submission: Submission,
        place: Place,
    ) -> Result<FinishedJob, Failure> {
        let build = app::pipeline::build_pipeline(resolved)?;
        runtime()?.block_on(self.make(&resolved.config, build, submission, place))
    }

    async fn make(
        &self,
        config: &Config,
        build: BuildScene,
        submission: Submission,
        bundle_place: Place,
    ) -> Result<FinishedJob, Failure> {
        let started = std::time::Instant::now();
        let stop = signals::stop_on_signal("stopping; again to stop at once")?;
        let temporary = match &self.data_dir {
            Some(_) => None,
            None => Some(tempfile::Builder::new().prefix("tabletopgen-").tempdir().map_err(|error| {
                let place = std::env::temp_dir();
                let advice = "set TMPDIR or --data-dir to a directory that can be written";
                Failure::new(
                    Exit::Error,
                    format!("cannot make a directory in {}: {error}; {advice}", place.display()),
                )
            })?),
        };
        let data_dir = match (&temporary, &self.data_dir) {
            (Some(temporary), _) => temporary.path(),
            (None, given) => given.as_deref().unwrap_or(Path::new("data")),
        };
        let store = app::open(data_dir, config, Intent::Create).await?;
        let seed = submission.request.seed;
        let mut progress = Progress::new(self.json);
        if !self.json {
            terminal::note(&format!("seed {seed}"));
        }
        let ended = follow(&store, config, build, submission, stop.clone(), &mut progress).await;
        let place = progress.place().to_owned();
        let kept = match temporary {
            None => {
                format!(
                    "; finished stages are kept in {}: the same command goes on there",
                    data_dir.display()
                )
            }
            Some(_) => String::new(),
        };
        let outcome = match ended? {
            Ended::Storage(why) => return Err(storage_failure(why, data_dir)),
            Ended::Job { job, .. } if job.state == JobState::Cancelled => {
                let message = format!("interrupted {place}; no bundle was written (seed {seed}){kept}");
                return Err(Failure::new(Exit::Interrupted, message));
            }
            Ended::Job { job, scene } if job.state == JobState::Succeeded => {
                let target = Target { place: bundle_place, artifacts: self.artifacts };
                Outcome::write(&store, &scene, seed, progress.into_times(), target).await?
            }
            Ended::Job { job, .. } => {
                let message = job.failure_message.unwrap_or_default();
                let code = job.failure_code.unwrap_or_default();
                let message = format!("{message} ({code}, {place}, seed {seed})");
                return Err(Failure::new(Exit::JobFailed, message));
            }
        };
        Ok(FinishedJob { outcome, total_ms: started.elapsed().as_millis() })
    }
}

/// Defaults that differ without a server: nothing temporary is worth waiting for the disk, or writing to it
/// what is read once, and the log keeps to what is wrong.
pub fn adapt(resolved: &mut Resolved, keeps_data: bool) {
    if !keeps_data && *resolved.origin("store.fsync") == Origin::Default {
        resolved.config.store.fsync = false;
    }
    if !keeps_data && *resolved.origin("store.blobs") == Origin::Default {
        resolved.config.store.blobs = BlobPlace::Memory;
    }
    if *resolved.origin("log.filter") == Origin::Default {
        resolved.config.log.filter = "error".to_owned();
    }
}

async fn follow(
    store: &Store,
    config: &Config,
    build: BuildScene,
    submission: Submission,
    stop: CancellationToken,
    progress: &mut Progress,
) -> Result<Ended, Failure> {
    Ok(local::run(store, config, build, submission, stop, |event| progress.see(event)).await?)
}

fn storage_failure(why: Outage, data_dir: &Path) -> Failure {
    let message = match why {
        Outage::Full => format!(
            "the disk of {} is full; free space there, or choose another with --data-dir or TMPDIR",
            data_dir.display()
        ),
        Outage::Other => format!("{} cannot be written; see the log above", data_dir.display()),
    };
    Failure::new(Exit::Error, message)
}
