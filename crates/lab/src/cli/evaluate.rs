//! `evaluate`: runs a benchmark set and writes its tables.
//!
//! Scenes of the layout set are worked on side by side, one per core, each in a temporary data directory that is gone
//! when the scene is scored; so are pictures of the picture set ([`pictures`]), which need none. Files are written at the
//! end and whole: an interrupted run leaves none.

mod pictures;

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
use crate::evaluate::layout::{Difficulty, LayoutBench, SceneScore};
use crate::evaluate::report::{Report, Section};
use crate::evaluate::scenes::{BenchmarkScene, scenes, spread};
use ports::Call;
use runtime::Cpu;
use tabletopgen::app::config::Config;
use tabletopgen::app::{AppError, logging};
use tabletopgen::cli::options::ConfigOptions;
use tabletopgen::cli::outcome::write_artifacts;
use tabletopgen::cli::{Exit, Failure, folder, generate, runtime, signals, terminal};
use tabletopgen::pipeline::checkpoint::Interrupt;
use tabletopgen::pipeline::error::StageError;

/// Arguments of `evaluate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The benchmark set
    #[arg(long = "set", value_name = "NAME", value_enum)]
    set_name: SetName,
    /// Layout: what the stages get to see: exact knowledge, spoiled knowledge, or one after the other
    #[arg(long, value_enum, default_value_t = Difficulties::Both)]
    difficulty: Difficulties,
    /// Only so many scenes, spread over the set, or so many pictures, the first [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    scenes: Option<u32>,
    /// Pictures: whose pictures; thresholds are chosen on those of the validation split
    #[arg(long, value_enum, default_value_t = SplitName::Test)]
    split: SplitName,
    /// Pictures: read maps that say the truth in place of the network's, so that what is lost is lost by the reading of maps
    #[arg(long)]
    perfect_maps: bool,
    /// Folder for <set>.md and <set>.json, or one of these files; the other is written beside it
    #[arg(long, value_name = "PATH", default_value = "out/evaluate")]
    out: PathBuf,
    /// Layout: only scenes whose names begin so, such as office_living or office_living_07
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Layout: also write what every stage put aside, under DIR/<difficulty>/<scene>/artifacts/<stage>/. Pictures: also
    /// write each picture beside what was painted and what was read, DIR/<number>.png
    #[arg(long, value_name = "DIR")]
    artifacts: Option<PathBuf>,
    /// Threads that compute [default: one per core]; the scores do not depend on it
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the JSON document instead of the tables
    #[arg(long)]
    json: bool,
    /// TOML file laid over the default settings
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// The benchmark sets there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SetName {
    /// 78 painted scenes: yaw, position and scale of the layout against the truth
    Layout,
    /// 200 painted pictures of things, tops and backdrops of their own: what `generate --image` reads in them
    Pictures,
    /// Painted pictures: whether what is believed of the regions that things are chosen from holds; `training/belief.py` fits
    /// it to the file this writes
    Regions,
}

impl SetName {
    fn name(self) -> &'static str {
        match self {
            Self::Layout => "layout",
            Self::Pictures => "pictures",
            Self::Regions => "regions",
        }
    }
}

/// Which difficulties are run.
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

/// Everything a run needs besides its scenes.
struct Bench {
    config: Config,
    layout: LayoutBench,
    cpu: Cpu,
    interrupt: Interrupt,
    artifacts: Option<PathBuf>,
}

/// Why a scene has no score.
enum Unscored {
    /// The run was stopped, or cannot go on.
    Stop(Failure),
    /// This scene alone.
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
        SetName::Pictures => pictures::run(&arguments, &resolved)?,
        SetName::Regions => pictures::run_regions(&arguments, &resolved)?,
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

/// What a run says, and whether every scene has a score.
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
        interrupt: Interrupt::default(),
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
    let interrupt = bench.interrupt.clone();
    tokio::spawn(async move {
        stop.cancelled().await;
        interrupt.raise();
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
                terminal::note(&format!("{head}: {}", told(&score)));
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

/// One scene in a data directory of its own.
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
    bench.interrupt.check().map_err(|_| stopped())?;
    let request = LayoutBench::request(scene);
    let opened = evaluation::opened(directory.path(), &bench.config, &bench.cpu, &bench.interrupt, &request);
    let Opened { checkpoints, store, scene_id } =
        opened.await.map_err(|error: AppError| Unscored::Stop(error.into()))?;
    let call = Call::without_budget(bench.cpu.clone(), bench.interrupt.clone());
    let scored = bench.layout.score(scene, difficulty, checkpoints, &call).await;
    if let Some(artifacts) = &bench.artifacts {
        let folder = artifacts.join(difficulty.name().replace(", ", "-").replace(' ', "-")).join(&scene.name);
        let folder = folder::prepare(&folder, true).map_err(Unscored::Stop)?;
        write_artifacts(&store, &scene_id, &folder).await.map_err(Unscored::Stop)?;
    }
    scored.map_err(|error| match bench.interrupt.check() {
        Err(_) => stopped(),
        Ok(()) => Unscored::Scene(error),
    })
}

/// The scene's largest errors on one line.
fn told(score: &SceneScore) -> String {
    let most = |values: Vec<f64>| values.into_iter().fold(0.0, f64::max);
    let yaw_deg = most(score.objects.iter().filter_map(|o| o.yaw_error_deg).collect());
    let off_m = most(score.objects.iter().filter_map(|o| o.position_error_m).collect());
    let objects = score.objects.len();
    format!("{objects} objects, at worst {yaw_deg:.1} degrees and {:.1} mm off", 1e3 * off_m)
}

/// Markdown and JSON file for what `--out` says.
fn files(out: &Path, set: &str) -> (PathBuf, PathBuf) {
    let named = out.extension().is_some_and(|extension| extension == "md" || extension == "json");
    let stem = if named { out.with_extension("") } else { out.join(set) };
    (stem.with_extension("md"), stem.with_extension("json"))
}

/// Writes a file so that it is there whole or not at all.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Temporary files are their owner's alone; a result is as readable as any file (the umask still counts).
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
