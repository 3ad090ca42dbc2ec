//! `execute`: a simulated robot does a task in the scene of a bundle.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::bundle_input::BundleInput;
use super::foreground::computed;
use super::generate::refused;
use super::options::ConfigOptions;
use super::output::{Kind, Output};
use super::{Exit, Failure, input_file, instructions, number, scene_summary, terminal};
use crate::app::activity::staged;
use crate::app::executions::order::{BasePlace, OutOfRange};
use crate::app::executions::{TaskSource, files, run as execute_task, video};
use crate::pipeline::task_scene;
use manipulation::execution::Execution;
use tasks::Task;

/// Arguments of `execute`.
#[derive(Debug, Args)]
#[command(after_help = "The exit code is 0 for a task that was done, and 6 for one that failed.")]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, visible_alias = "scene", value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// An instruction in words, or the file of a task as `tasks --out` writes it
    #[arg(long, value_name = "TEXT_OR_FILE", allow_hyphen_values = true)]
    task: String,
    /// The robot of an instruction in words
    #[arg(long, value_name = "NAME", default_value = "panda")]
    robot: String,
    /// Place of the robot's base: x, y and z in meters in the frame of the scene, whose z is 0 on the top of the table,
    /// and the direction in which it faces in radians from x to y; chosen if absent
    #[arg(long, value_name = "X,Y,Z,YAW", value_parser = base_place, allow_hyphen_values = true)]
    base: Option<BasePlace>,
    /// Same scene, task and seed: same motion, to the byte
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = number::seed)]
    seed: u64,
    /// Write verdict, task, motion, and the robot in the scene as MJCF, URDF and USD into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the execution that an earlier run left in the folder of --out; a folder with other files is refused
    #[arg(long, requires = "out")]
    force: bool,
    /// Also write a video of the motion, `video.mp4`, into the folder of --out; takes some seconds
    #[arg(long, requires = "out")]
    video: bool,
    /// Print one JSON document, without the motion, and no progress
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Executes the task and prints the verdict. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(execute(&arguments), is_json)
}

fn execute(arguments: &Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    if arguments.video {
        video::check().map_err(|why| Failure::usage(format!("--video: {why}")))?;
    }
    let output = output(arguments)?;
    let mut source = source(&arguments.task)?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let (tasks, refusal) = (std::slice::from_mut(&mut source), |problem| refused(problem, "--task"));
    instructions::read_tasks(&resolved, &archive, tasks, &arguments.robot, refusal)?;
    let (robot, base, seed) = (arguments.robot.clone(), arguments.base, arguments.seed);
    let (with_files, with_video) = (arguments.out.is_some(), arguments.video);
    let (executed, files) = computed(arguments.json, move |watch| {
        let bundle = task_scene::of_archive(&archive).map_err(|error| Failure::usage(error.message))?;
        let executed =
            execute_task(&bundle, source, &robot, base, seed, &resolved, watch).map_err(refusal)?;
        let files = || files::all_files(&archive, &executed, with_video).map_err(refusal);
        let files = if with_files { staged(watch, "files", None, files)? } else { Vec::new() };
        Ok((executed, files))
    })?;
    if let Some(output) = output {
        let partial = output.begin()?;
        for file in files {
            partial.write(&file.path, &file.bytes)?;
        }
        partial.publish()?;
    }
    match arguments.json {
        true => terminal::print(&format!("{:#}\n", files::verdict(&executed))),
        false => terminal::print(&verdict_text(&executed.task, &executed.execution)),
    }
    Ok(if executed.execution.succeeded { Exit::Success } else { Exit::TaskFailed })
}

/// The folder of `--out`, checked before any work.
fn output(arguments: &Arguments) -> Result<Option<Output>, Failure> {
    let task = is_file(&arguments.task).then(|| Path::new(&arguments.task));
    let inputs: Vec<&Path> = std::iter::once(&*arguments.bundle).chain(task).collect();
    let out = arguments.out.as_deref();
    out.map(|out| Output::check(out, Kind::Execution, arguments.force, &inputs)).transpose()
}

/// Reason why an argument is no place of a base.
#[derive(Debug, thiserror::Error)]
enum BasePlaceError {
    #[error("give four numbers with commas between, such as -0.5,0,0.02,0")]
    NotFourNumbers,
    #[error("{name} {0}", name = .0.name)]
    OutOfRange(#[from] OutOfRange),
}

/// Four numbers.
fn base_place(given: &str) -> Result<BasePlace, BasePlaceError> {
    let numbers: Option<Vec<f64>> = given.split(',').map(|number| number.trim().parse().ok()).collect();
    let Some([x_m, y_m, z_m, yaw_rad]) = numbers.as_deref().and_then(|n| <[f64; 4]>::try_from(n).ok()) else {
        return Err(BasePlaceError::NotFourNumbers);
    };
    let place = BasePlace { x_m, y_m, z_m, yaw_rad };
    place.check()?;
    Ok(place)
}

/// Advice where a file of a task cannot be used.
pub(super) const TASK_ADVICE: &str = "give a file that `tasks --out` or `execute --out` wrote";

/// A file of a task, or the text itself.
pub(super) fn source(given: &str) -> Result<TaskSource, Failure> {
    if !is_file(given) {
        return Ok(TaskSource::Text(given.to_owned()));
    }
    input_file::json(Path::new(given), "the task", TASK_ADVICE).map(TaskSource::Task)
}

/// Whether a task is given by the name of its file.
pub(super) fn is_file(given: &str) -> bool {
    given.ends_with(".json")
}

fn verdict_text(task: &Task, execution: &Execution) -> String {
    let mut text = format!("{}: {}\n", execution.robot, task.instruction);
    // Writing to a string does not fail.
    let verdict = match execution.failure {
        None => "done".to_owned(),
        Some(failure) => format!("failed, {}", json!(failure).as_str().unwrap_or_default()),
    };
    let _ = writeln!(text, "  {verdict} after {:.1} s", execution.duration_s);
    if let Some(detail) = &execution.detail {
        let _ = writeln!(text, "  {detail}");
    }
    for pick in &execution.picks {
        let _ = writeln!(text, "  picked {}, slip {:.1} mm", pick.object, 1e3 * pick.slip_m);
    }
    for moved in &execution.disturbed {
        let _ = writeln!(text, "  moved besides: {}", json!(moved));
    }
    text
}
