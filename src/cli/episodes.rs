//! `episodes`: demonstrations of tasks in the scene of a bundle, as a dataset that policies are trained on.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use serde_json::json;

use super::bundle_input::BundleInput;
use super::counting::Counting;
use super::execute::source;
use super::foreground::computed;
use super::generate::refused;
use super::options::ConfigOptions;
use super::output::{Kind, Output};
use super::{Exit, Failure, input_file, instructions, number, runtime, scene_summary, signals, terminal};
use crate::app::episodes::order::{MAX_COUNT, MAX_FPS, MAX_POINTS, makeable_format};
use crate::app::episodes::recorder::{Amount, RecordError, Recorded, Tally, record};
use crate::app::episodes::{Cameras, EpisodesOrder, card, setup};
use demonstrations::randomization::AXES;
use demonstrations::{CameraSpec, Randomization};
use episodes::format::Format;

/// Arguments of `episodes`.
#[derive(Debug, Args)]
#[command(
    after_help = "Finished episodes are kept in DIR.units until the dataset is complete: after Ctrl-C or a crash \
                        the same command goes on.\nThe exit code is 6 if too few attempts succeed."
)]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, visible_alias = "scene", value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// An instruction in words, or the file of a task as `tasks --out` writes it; several take turns
    #[arg(long, value_name = "TEXT_OR_FILE", allow_hyphen_values = true, required = true)]
    task: Vec<String>,
    /// The robot
    #[arg(long, value_name = "NAME", default_value = "panda")]
    robot: String,
    /// Number of episodes that succeed
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<u64>(1..=MAX_COUNT))]
    count: u64,
    /// Same scene, tasks and options: same dataset, to the byte
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true,
        value_parser = number::seed
    )]
    seed: u64,
    /// Folder for the dataset
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace the dataset that an earlier run left in the folder of --out; a folder with other files is refused
    #[arg(long)]
    force: bool,
    /// lerobot-v3.0, lerobot-v3.0-images, lerobot-v2.1, lerobot-v2.1-images, robomimic, parquet-png
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_value = "lerobot-v3.0", value_parser = makeable_format)]
    format: Vec<Format>,
    /// Usual cameras (side, front, wrist), none, or a file with a list of own ones
    #[arg(long, value_name = "NAME,...|none|FILE", default_value = "side,front,wrist")]
    cameras: String,
    /// Side of the images of usual cameras, pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 224, allow_negative_numbers = true, value_parser = number::whole::<u32>(1..=8192))]
    size: u32,
    /// Frames per second
    #[arg(long, value_name = "HZ", default_value_t = 15, allow_negative_numbers = true, value_parser = number::whole::<u32>(1..=u64::from(MAX_FPS)))]
    fps: u32,
    /// Also record depth; one of the formats must be robomimic or parquet-png
    #[arg(long)]
    depth: bool,
    /// Also record which object is at each pixel; one of the formats must be robomimic or parquet-png
    #[arg(long)]
    instance_ids: bool,
    /// Also record a cloud of N points of what all cameras see; one of the formats must be robomimic or parquet-png
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<u32>(1..=u64::from(MAX_POINTS)))]
    point_cloud: Option<u32>,
    /// Randomization between episodes: usual, wide (other objects and materials, too), none, or a file with amplitudes
    #[arg(long, value_name = "usual|wide|none|FILE", default_value = "usual")]
    randomize: String,
    /// Change one amplitude of --randomize, such as position_m=0.1 (repeatable)
    #[arg(long, value_name = "AXIS=X", value_parser = amplitude)]
    amplitude: Vec<(String, f64)>,
    /// Attempts until the command gives up [default: 4 for each episode, and 20]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<u64>(1..=u64::MAX))]
    max_attempts: Option<u64>,
    /// Record attempts that fail as episodes, too, beside those that succeed
    #[arg(long)]
    keep_failures: bool,
    /// Attempts at a time [default: one per core]; the dataset does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<usize>(1..=u64::MAX))]
    workers: Option<usize>,
    /// Print one JSON document, and no progress
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Reason why an argument is no amplitude of an axis.
#[derive(Debug, thiserror::Error)]
enum AmplitudeError {
    #[error("must be AXIS=X")]
    NoAssignment,
    #[error("there is no axis {name}; there are {}", AXES.iter().map(|axis| axis.name).collect::<Vec<_>>().join(", "))]
    UnknownAxis { name: String },
    #[error("{value} is no number")]
    NoNumber { value: String },
}

fn amplitude(text: &str) -> Result<(String, f64), AmplitudeError> {
    let (name, value) = text.split_once('=').ok_or(AmplitudeError::NoAssignment)?;
    if !AXES.iter().any(|axis| axis.name == name) {
        return Err(AmplitudeError::UnknownAxis { name: name.to_owned() });
    }
    let value = value.parse().map_err(|_| AmplitudeError::NoNumber { value: value.to_owned() })?;
    Ok((name.to_owned(), value))
}

/// Records the dataset and prints what it holds. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(record_episodes(&arguments), is_json)
}

fn record_episodes(arguments: &Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    let output = Output::check(&arguments.out, Kind::Episodes, arguments.force, &[&arguments.bundle])?;
    let mut order = order(arguments)?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let refusal = |problem| refused(problem, "--task");
    instructions::read_tasks(&resolved, &archive, &mut order.tasks, &arguments.robot, refusal)?;
    let (of_setup, config) = (order.clone(), resolved.clone());
    let setup =
        computed(arguments.json, move |watch| setup(&archive, &of_setup, &config, watch).map_err(refusal))?;
    let amount = Amount {
        count: order.count,
        max_attempts: order.max_attempts,
        keeps_failures: order.keeps_failures,
        workers: arguments.workers.unwrap_or_else(cores),
    };
    let card = card(title(&output), &resolved, &setup);
    let waiting = runtime()?;
    let stop = stop_flag(&waiting)?;
    let counting = Counting::new("episodes", arguments.json);
    let see = |tally: Tally| {
        let share = || {
            let percent = 100.0 * tally.successes as f64 / tally.attempts.max(1) as f64;
            format!(", {percent:.0} % of attempts succeed")
        };
        counting.see_with(tally.successes, order.count, share);
    };
    let recorded = record(&setup, output.path(), amount, card, &stop, &see).map_err(failure)?;
    output.publish(&recorded.dataset())?;
    let report = match arguments.json {
        true => format!("{:#}\n", document(arguments, &order, &recorded)),
        false => summary(arguments, &order, &recorded),
    };
    recorded.forget_attempts().map_err(failure)?;
    terminal::print(&report);
    Ok(Exit::Success)
}

fn order(arguments: &Arguments) -> Result<EpisodesOrder, Failure> {
    let tasks = arguments.task.iter().map(|given| source(given)).collect::<Result<_, _>>()?;
    let mut formats = arguments.format.clone();
    formats.sort_by_key(|format| Format::ALL.iter().position(|known| known == format));
    formats.dedup();
    Ok(EpisodesOrder {
        title: None,
        tasks,
        robot: arguments.robot.clone(),
        count: arguments.count,
        seed: arguments.seed,
        randomization: randomization(arguments)?,
        cameras: cameras(arguments)?,
        fps: arguments.fps,
        depth: arguments.depth,
        instance_ids: arguments.instance_ids,
        points: arguments.point_cloud,
        formats,
        keeps_failures: arguments.keep_failures,
        max_attempts: arguments
            .max_attempts
            .unwrap_or_else(|| EpisodesOrder::usual_max_attempts(arguments.count)),
    })
}

fn randomization(arguments: &Arguments) -> Result<Randomization, Failure> {
    let base = match Randomization::named(&arguments.randomize) {
        Some(named) => named,
        None => read_json(&arguments.randomize, "the amplitudes of --randomize")?,
    };
    let mut value = json!(base);
    for (name, amplitude) in &arguments.amplitude {
        value[name] = json!(amplitude);
    }
    serde_json::from_value(value).map_err(|error| Failure::usage(format!("--amplitude: {error}")))
}

fn cameras(arguments: &Arguments) -> Result<Cameras, Failure> {
    if arguments.cameras.ends_with(".json") {
        let own: Vec<CameraSpec> = read_json(&arguments.cameras, "the list of cameras")?;
        return Ok(Cameras::Own(own));
    }
    let names = match arguments.cameras.as_str() {
        "none" => Vec::new(),
        names => names.split(',').map(str::to_owned).collect(),
    };
    Ok(Cameras::Usual { names, side_px: arguments.size })
}

fn read_json<T: serde::de::DeserializeOwned>(file: &str, what: &str) -> Result<T, Failure> {
    input_file::json(Path::new(file), what, "docs/episodes.md shows one")
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

fn title(output: &Output) -> String {
    output.path().file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Set by the first Ctrl-C.
fn stop_flag(runtime: &tokio::runtime::Runtime) -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    runtime.block_on(async {
        let token = signals::stop_on_signal("stopping; attempts that have begun are finished first")?;
        tokio::spawn(async move {
            token.cancelled().await;
            flag.store(true, Ordering::Relaxed);
        });
        Ok::<(), Failure>(())
    })?;
    Ok(stop)
}

fn failure(error: RecordError) -> Failure {
    let exit = match error {
        RecordError::Stopped { .. } => Exit::Interrupted,
        RecordError::TooFew { .. } => Exit::TaskFailed,
        RecordError::Folder(_) | RecordError::Episode(_) => Exit::Error,
    };
    Failure::new(exit, error.to_string())
}

fn document(arguments: &Arguments, order: &EpisodesOrder, recorded: &Recorded) -> serde_json::Value {
    json!({
        "dataset": arguments.out,
        "episodes": recorded.summary.episodes,
        "frames": recorded.summary.frames,
        "fps": order.fps,
        "formats": order.formats.iter().map(|format| format.folder()).collect::<Vec<_>>(),
        "attempts": recorded.attempts,
    })
}

fn summary(arguments: &Arguments, order: &EpisodesOrder, recorded: &Recorded) -> String {
    let folders: Vec<&str> = order.formats.iter().map(|format| format.folder()).collect();
    let seconds = recorded.summary.frames as f64 / f64::from(order.fps);
    let mut text = format!(
        "{} episodes, {:.1} s, in {}: {}\n",
        recorded.summary.episodes,
        seconds,
        shown(&arguments.out),
        folders.join(", ")
    );
    for (outcome, times) in &recorded.attempts {
        text.push_str(&format!("  {times} {outcome}\n"));
    }
    text
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}
