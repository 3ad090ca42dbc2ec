//! `generate`: one scene, here and now, by the server's code path.
//!
//! Everything that can be refused is refused before the work: arguments, settings, the input, the
//! folder. Settings given with `--set` that shape scenes become the request's own, so the bundle tells
//! them.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use tokio_util::sync::CancellationToken;

use super::options::{ConfigOptions, TextOptions};
use super::output_dir::{self, Folder};
use super::progress::Progress;
use super::scene_summary::{self, Outcome};
use super::{Exit, Failure, certificate, runtime, signals, terminal};
use crate::api::submission::{self, SceneBody, Submission};
use crate::app::config::{Config, Origin, Resolved, is_open_to_requests};
use crate::app::local;
use crate::app::local::Ended;
use crate::app::{self, logging};
use crate::worker::BuildScene;
use scene::job::JobState;
use scene::request::{MAX_SEED, RequestOptions};
use store::{BlobPlace, Outage, Store};

/// Arguments of `generate`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("input").required(true).multiple(true).args(["text", "image"])))]
pub struct Arguments {
    /// What stands on the table, in words; beside an image, what is in it
    #[arg(long, value_name = "TEXT")]
    text: Option<String>,
    /// An image of a table: PNG, JPEG or WebP
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// Same input and seed: same scene, to the byte [default: random, and reported]
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        value_parser = clap::value_parser!(u64).range(..=MAX_SEED)
    )]
    seed: Option<u64>,
    /// Folder for the bundle [default: out/SHORT_ID]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write into a folder that holds other objects
    #[arg(long)]
    force: bool,
    /// Also write what every stage put aside, under DIR/artifacts/STAGE/
    #[arg(long)]
    artifacts: bool,
    #[command(flatten)]
    reading: TextOptions,
    /// Keep and reuse finished stages in this data directory instead of a temporary one
    #[arg(long, value_name = "DIR")]
    data_dir: Option<PathBuf>,
    /// Threads that compute [default: one per core]; the scene does not depend on it
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print one JSON document instead of the table, and no progress
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Makes the scene, writes its bundle, prints its certificate. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(generate(arguments), is_json)
}

fn generate(mut arguments: Arguments) -> Result<Exit, Failure> {
    let (own, process) = std::mem::take(&mut arguments.options.set)
        .into_iter()
        .partition::<Vec<_>, _>(|(key, value)| is_open_to_requests(key, value));
    arguments.options.set = process;
    let threads = arguments.threads.map(|n| ("worker.cpu_threads".to_owned(), n.to_string(), "--threads"));
    let mut resolved = arguments.options.load(threads.into_iter().collect())?;
    adapt(&mut resolved, arguments.data_dir.is_some());
    logging::start(&resolved.config.log);

    let image = arguments.image.as_deref().map(|path| read_image(path, &resolved.config)).transpose()?;
    let body = SceneBody {
        text: arguments.text.clone(),
        seed: arguments.seed,
        options: RequestOptions { set: own.into_iter().collect(), ..arguments.reading.request_options() },
        ..SceneBody::default()
    };
    let settings = &resolved.config.server;
    let submission = submission::validate(body, image, settings, &app::pipeline::validate(&resolved))
        .map_err(|problem| refused(problem, "--text"))?;
    let build = app::pipeline::build_pipeline(&resolved)?;
    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from("out"));
    // The default folder holds one folder per bundle, so it may hold anything itself.
    let folder = output_dir::prepare(&out, arguments.force || arguments.out.is_none())?;
    runtime()?.block_on(make(&arguments, &resolved.config, build, submission, folder))
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

async fn make(
    arguments: &Arguments,
    config: &Config,
    build: BuildScene,
    submission: Submission,
    folder: Folder,
) -> Result<Exit, Failure> {
    let started = std::time::Instant::now();
    let stop = signals::stop_on_signal("stopping; again to stop at once")?;
    let temporary = match &arguments.data_dir {
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
    let data_dir = match (&temporary, &arguments.data_dir) {
        (Some(temporary), _) => temporary.path(),
        (None, given) => given.as_deref().unwrap_or(Path::new("data")),
    };
    let store = match app::open(data_dir, config).await {
        Ok(store) => store,
        Err(error) => {
            folder.abandon();
            return Err(error.into());
        }
    };
    let seed = submission.request.seed;
    let mut progress = Progress::new(arguments.json);
    if !arguments.json {
        terminal::note(&format!("seed {seed}"));
    }
    let ended = follow(&store, config, build, submission, stop.clone(), &mut progress).await;
    let place = progress.place().to_owned();
    let kept = match temporary {
        None => {
            format!("; finished stages are kept in {}: the same command goes on there", data_dir.display())
        }
        Some(_) => String::new(),
    };
    let outcome = match ended? {
        Ended::Storage(why) => {
            folder.abandon();
            return Err(storage_failure(why, data_dir));
        }
        Ended::Job { job, .. } if job.state == JobState::Cancelled => {
            folder.abandon();
            let message = format!("interrupted {place}; no bundle was written (seed {seed}){kept}");
            return Err(Failure::new(Exit::Interrupted, message));
        }
        Ended::Job { job, scene } if job.state == JobState::Succeeded => {
            Outcome::write(&store, &scene, seed, progress.into_times(), arguments.target(folder)).await?
        }
        Ended::Job { job, .. } => {
            folder.abandon();
            let message = job.failure_message.unwrap_or_default();
            let code = job.failure_code.unwrap_or_default();
            return Err(Failure::new(Exit::JobFailed, format!("{message} ({code}, {place}, seed {seed})")));
        }
    };
    let total_ms = started.elapsed().as_millis();
    match arguments.json {
        true => terminal::print(&outcome.document(total_ms)),
        false => terminal::print(&certificate::table(&outcome, total_ms)),
    }
    Ok(if outcome.passed { Exit::Success } else { Exit::Quarantined })
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

impl Arguments {
    fn target(&self, folder: Folder) -> scene_summary::Target {
        scene_summary::Target {
            folder,
            named: self.out.is_some(),
            force: self.force,
            artifacts: self.artifacts,
        }
    }
}

fn read_image(path: &Path, config: &Config) -> Result<bytes::Bytes, Failure> {
    let unreadable =
        |error: std::io::Error| Failure::usage(format!("cannot read the image {}: {error}", path.display()));
    let about = std::fs::metadata(path).map_err(unreadable)?;
    let limit = config.server.max_image_bytes;
    if !about.is_file() {
        return Err(Failure::usage(format!("the image {} is not a file", path.display())));
    }
    if about.len() > limit as u64 {
        return Err(Failure::usage(format!(
            "the image {} has {} bytes; give one of at most {limit}",
            path.display(),
            about.len()
        )));
    }
    Ok(std::fs::read(path).map_err(unreadable)?.into())
}

/// A refusal in the words of the command line, with the document that the server would answer. `text` is the name of
/// the argument that holds the text.
pub(super) fn refused(problem: crate::api::Problem, text: &str) -> Failure {
    let mut document = problem.document("");
    if let Some(members) = document.as_object_mut() {
        members.remove("request_id");
    }
    Failure { problem: Some(document), ..Failure::usage(refusal_message(problem, text)) }
}

fn refusal_message(problem: crate::api::Problem, text: &str) -> String {
    if problem.errors.is_empty() {
        return problem.detail;
    }
    let lines = problem.errors.iter().map(|error| {
        let option = match error.pointer.as_str() {
            "/text" => text.to_owned(),
            "/options/max_objects" => "--max-objects".to_owned(),
            "" => "input".to_owned(),
            pointer => match pointer.strip_prefix("/options/set/") {
                Some(key) => format!("--set {}", key.replace("~1", "/").replace("~0", "~")),
                None => pointer.replacen('/', "--", 1),
            },
        };
        let gap = if error.detail.starts_with(|c: char| c.is_lowercase()) { " " } else { ": " };
        format!("{option}{gap}{}", error.detail)
    });
    lines.collect::<Vec<_>>().join("\n")
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
