//! `evaluate`: runs a benchmark set and writes its tables.
//!
//! Scenes of the layout set run in parallel, one per core, each in a temporary data directory that is removed after
//! scoring. Images of the image set ([`images`]) run in parallel without one. Files are written completely at the
//! end: an interrupted run writes none.

mod images;

use std::fs::Permissions;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use futures::{StreamExt, stream};

use super::split::SplitName;
use crate::app::evaluation;
use crate::app::evaluation::Opened;
use crate::benchmark::images::BesideImage;
use crate::benchmark::layout::{Difficulty, LayoutBench, SceneScore};
use crate::benchmark::report::{Report, Section};
use crate::benchmark::scenes::{BenchmarkScene, scenes, spread};
use ports::Call;
use runtime::CpuPool;
use tabletopgen::app::config::Config;
use tabletopgen::app::{AppError, logging};
use tabletopgen::cli::options::ConfigOptions;
use tabletopgen::cli::output::{Kind, Output};
use tabletopgen::cli::scene_summary::write_artifacts;
use tabletopgen::cli::{Exit, Failure, generate, runtime, signals, terminal};
use tabletopgen::pipeline::checkpoint::CancelFlag;
use tabletopgen::pipeline::error::StageError;

/// Arguments of `evaluate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The benchmark set
    #[arg(long = "set", value_name = "NAME", value_enum)]
    set_name: SetName,
    /// Layout: exact or noisy stage inputs, or both in turn
    #[arg(long, value_enum, default_value_t = Difficulties::Both)]
    difficulty: Difficulties,
    /// Number of scenes, spread over the set, or of images, from the first [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    scenes: Option<u32>,
    /// Images: split; thresholds are chosen on the validation split
    #[arg(long, value_enum, default_value_t = SplitName::Test)]
    split: SplitName,
    /// Images: use ground-truth maps in place of the network's, to measure the decoding of maps alone
    #[arg(long)]
    perfect_maps: bool,
    /// Images: also give each image a text that lists its objects, and count the labels with and without it
    #[arg(long)]
    with_text: bool,
    /// Images: also give the reader the intrinsics of each image's camera
    #[arg(long)]
    with_intrinsics: bool,
    /// Images: also give the reader intrinsics and depths, exact ones or as a sensor measures them
    #[arg(long, value_enum, value_name = "QUALITY", conflicts_with = "with_intrinsics")]
    with_depth: Option<DepthQuality>,
    /// Folder for SET.md and SET.json, or one of these files; the other is written beside it
    #[arg(long, value_name = "PATH", default_value = "out/evaluate")]
    out: PathBuf,
    /// Layout: only scenes whose names start with this, such as office_living or office_living_07
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Layout: also write the artifacts of every stage, under DIR/DIFFICULTY/SCENE/artifacts/STAGE/. Images:
    /// also write ground truth and estimate side by side, DIR/NUMBER.png
    #[arg(long, value_name = "DIR")]
    artifacts: Option<PathBuf>,
    /// Compute threads [default: one per core]; the scores do not depend on it
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the JSON document instead of the tables
    #[arg(long)]
    json: bool,
    /// TOML file laid over the default settings
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// Quality of the depths beside images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DepthQuality {
    /// Whole millimeters
    Exact,
    /// With the noise, the holes and the edges of a structured-light camera
    Sensor,
}

impl Arguments {
    fn beside(&self) -> BesideImage {
        match (self.with_depth, self.with_intrinsics) {
            (Some(DepthQuality::Exact), _) => BesideImage::Depth,
            (Some(DepthQuality::Sensor), _) => BesideImage::SensorDepth,
            (None, true) => BesideImage::Intrinsics,
            (None, false) => BesideImage::Nothing,
        }
    }
}

/// The benchmark sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SetName {
    /// 78 synthetic scenes: yaw, position and scale of the layout against the ground truth
    Layout,
    /// 200 synthetic images with their own objects, tops and backdrops: the estimates of `generate --image`
    Images,
    /// Synthetic images: calibration of the region score; `training/region_score.py` fits it to the written file
    Regions,
}

impl SetName {
    fn name(self) -> &'static str {
        match self {
            Self::Layout => "layout",
            Self::Images => "images",
            Self::Regions => "regions",
        }
    }
}

/// The difficulties of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Difficulties {
    Clean,
    Noisy,
    /// The noisy set with an exact camera
    NoisyExactCamera,
    /// clean, then noisy
    Both,
}

impl Difficulties {
    fn list(self) -> &'static [Difficulty] {
        match self {
            Self::Clean => &[Difficulty::Clean],
            Self::Noisy => &[Difficulty::Noisy],
            Self::NoisyExactCamera => &[Difficulty::NoisyExactCamera],
            Self::Both => &[Difficulty::Clean, Difficulty::Noisy],
        }
    }
}

/// State of a run.
struct Bench {
    config: Config,
    layout: LayoutBench,
    cpu: CpuPool,
    cancel: CancelFlag,
    artifacts: Option<PathBuf>,
}

/// Reason of a missing score.
enum Unscored {
    /// The run was stopped or cannot continue.
    Stop(Failure),
    /// Only this scene failed.
    Scene(StageError),
}

/// Runs the set, prints its tables, writes its files.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let threads = arguments.threads.map(|n| ("worker.cpu_threads".to_owned(), n.to_string(), "--threads"));
    let options = ConfigOptions { config: arguments.config.clone(), set: Vec::new() };
    let mut resolved = options.load(threads.into_iter().collect())?;
    generate::adapt(&mut resolved, false);
    logging::start(&resolved.config.log);
    let (markdown, json) = files(&arguments.out, arguments.set_name.name());
    if let Some(folder) = markdown.parent() {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    }
    let started = Instant::now();
    let Finished { table, document, complete } = match arguments.set_name {
        SetName::Layout => layout(&arguments, resolved.config)?,
        SetName::Images => images::run(&arguments, &resolved)?,
        SetName::Regions => images::run_regions(&arguments, &resolved)?,
    };
    write_whole(&markdown, table.as_bytes())?;
    write_whole(&json, document.as_bytes())?;
    terminal::print(&if arguments.json { document + "\n" } else { table });
    terminal::note(&format!(
        "{:.0} s; written to {} and {}",
        started.elapsed().as_secs_f64(),
        markdown.display(),
        json.display()
    ));
    Ok(if complete { Exit::Success } else { Exit::JobFailed })
}

/// Output of a run, and whether every scene has a score.
struct Finished {
    table: String,
    document: String,
    complete: bool,
}

fn layout(arguments: &Arguments, config: Config) -> Result<Finished, Failure> {
    let bench = Bench {
        layout: evaluation::layout_bench(&config),
        cpu: evaluation::cpu(&config)?,
        config,
        cancel: CancelFlag::default(),
        artifacts: arguments.artifacts.clone(),
    };
    let mut all = scenes();
    let set_size = all.len();
    if let Some(start) = &arguments.scene {
        all.retain(|scene| scene.name.starts_with(start.as_str()));
        if all.is_empty() {
            let message = format!("--scene {start}: no scene of the set is named so; try office_living");
            return Err(Failure::usage(message));
        }
    }
    let chosen = match arguments.scenes {
        Some(count) => spread(all, count as usize),
        None => all,
    };
    let sections = runtime()?.block_on(sections(&bench, arguments.difficulty.list(), &chosen))?;
    let report = Report { set: "layout", version: env!("CARGO_PKG_VERSION"), set_size, sections };
    let complete = report.sections.iter().all(|section| section.failed.is_empty());
    Ok(Finished { table: report.markdown(), document: json_of(&report)?, complete })
}

fn json_of(report: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(report)
        .map_err(|error| Failure::new(Exit::Error, format!("the report has no JSON form: {error}; a bug")))
}

async fn sections(
    bench: &Bench,
    difficulties: &[Difficulty],
    chosen: &[BenchmarkScene],
) -> Result<Vec<Section>, Failure> {
    let stop = signals::stop_on_signal("stopping; again to stop at once")?;
    let cancel = bench.cancel.clone();
    tokio::spawn(async move {
        stop.cancelled().await;
        cancel.cancel();
    });
    let mut sections = Vec::new();
    for &difficulty in difficulties {
        sections.push(section(bench, difficulty, chosen).await?);
    }
    Ok(sections)
}

async fn section(
    bench: &Bench,
    difficulty: Difficulty,
    chosen: &[BenchmarkScene],
) -> Result<Section, Failure> {
    let at_once = match bench.config.worker.cpu_threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    let turns: Vec<_> = chosen
        .iter()
        .enumerate()
        .map(|(index, scene)| async move {
            let started = Instant::now();
            let scored = score(bench, difficulty, scene).await;
            (index, scene, scored, started.elapsed().as_secs_f64())
        })
        .collect();
    let mut running = stream::iter(turns).buffer_unordered(at_once);
    let (mut scored, mut failed) = (Vec::new(), Vec::new());
    while let Some((index, scene, result, seconds)) = running.next().await {
        let done = scored.len() + failed.len() + 1;
        let head = format!("{} {done}/{} {} {seconds:.1} s", difficulty.name(), chosen.len(), scene.name);
        match result {
            Ok(score) => {
                terminal::note(&format!("{head}: {}", message(&score)));
                scored.push((index, score));
            }
            Err(Unscored::Stop(failure)) => return Err(failure),
            Err(Unscored::Scene(error)) => {
                terminal::note(&format!("{head}: {error}"));
                failed.push((index, (scene.name.clone(), error.to_string())));
            }
        }
    }
    scored.sort_by_key(|(index, _)| *index);
    failed.sort_by_key(|(index, _)| *index);
    let scored = scored.into_iter().map(|(_, score)| score).collect();
    Ok(Section::new(difficulty, scored, failed.into_iter().map(|(_, failure)| failure).collect()))
}

/// Scores one scene in its own data directory.
async fn score(
    bench: &Bench,
    difficulty: Difficulty,
    scene: &BenchmarkScene,
) -> Result<SceneScore, Unscored> {
    let stopped = || Unscored::Stop(Failure::new(Exit::Interrupted, "interrupted; no tables were written"));
    let directory = tempfile::Builder::new().prefix("tabletopgen-evaluate-").tempdir().map_err(|error| {
        let place = std::env::temp_dir();
        let message =
            format!("cannot make a directory in {}: {error}; set TMPDIR to another", place.display());
        Unscored::Stop(Failure::new(Exit::Error, message))
    })?;
    bench.cancel.check().map_err(|_| stopped())?;
    let request = LayoutBench::request(scene);
    let opened = evaluation::opened(directory.path(), &bench.config, &bench.cpu, &bench.cancel, &request);
    let Opened { checkpoints, store, scene_id } =
        opened.await.map_err(|error: AppError| Unscored::Stop(error.into()))?;
    let call = Call::without_budget(bench.cpu.clone(), bench.cancel.clone());
    let scored = bench.layout.score(scene, difficulty, checkpoints, &call).await;
    if let Some(artifacts) = &bench.artifacts {
        let folder = artifacts.join(difficulty.name().replace(", ", "-").replace(' ', "-")).join(&scene.name);
        let folder = Output::check(&folder, Kind::Artifacts, true, &[]).and_then(|output| output.begin());
        let folder = folder.map_err(Unscored::Stop)?;
        write_artifacts(&store, &scene_id, &folder).await.map_err(Unscored::Stop)?;
        folder.publish().map_err(Unscored::Stop)?;
    }
    scored.map_err(|error| match bench.cancel.check() {
        Err(_) => stopped(),
        Ok(()) => Unscored::Scene(error),
    })
}

/// Largest errors of a scene in one line.
fn message(score: &SceneScore) -> String {
    let highest = |values: Vec<f64>| values.into_iter().fold(0.0, f64::max);
    let yaw_deg = highest(score.objects.iter().filter_map(|o| o.yaw_error_deg).collect());
    let off_m = highest(score.objects.iter().filter_map(|o| o.position_error_m).collect());
    let objects = score.objects.len();
    format!("{objects} objects, at worst {yaw_deg:.1} degrees and {:.1} mm off", 1e3 * off_m)
}

/// Markdown and JSON path for `--out`.
fn files(out: &Path, set: &str) -> (PathBuf, PathBuf) {
    let named = out.extension().is_some_and(|extension| extension == "md" || extension == "json");
    let stem = if named { out.with_extension("") } else { out.join(set) };
    (stem.with_extension("md"), stem.with_extension("json"))
}

/// Writes a file atomically.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Temporary files are private to their owner; results use the usual mode (subject to the umask).
    let made = tempfile::Builder::new().permissions(Permissions::from_mode(0o666)).tempfile_in(folder);
    let mut file = made.map_err(|error| unwritable(path, &error))?;
    file.write_all(bytes).map_err(|error| unwritable(path, &error))?;
    file.persist(path).map_err(|error| unwritable(path, &error.error))?;
    Ok(())
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(
        Exit::Error,
        format!("cannot write {}: {error}; choose another place with --out", path.display()),
    )
}
