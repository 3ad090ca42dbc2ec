//! `execute`: a simulated robot does a task in the scene of a bundle.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::bundle_input::BundleInput;
use super::generate::refused;
use super::options::ConfigOptions;
use super::{Exit, Failure, scene_summary, terminal};
use crate::api::executions::BasePlace;
use crate::app::executions::{TaskSource, files, run as execute_task};
use crate::pipeline::task_scene;
use export::BundleFile;
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
    /// Where the base of the robot stands: x, y and z in meters in the frame of the scene, whose z is 0 on the top of
    /// the table, and the direction in which it faces in radians from x to y; chosen if absent
    #[arg(long, value_name = "X,Y,Z,YAW", value_parser = base_place, allow_hyphen_values = true)]
    base: Option<BasePlace>,
    /// Same scene, task and seed: same motion, to the byte
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Write verdict, task, motion, and the robot in the scene as MJCF, URDF and USD into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Also write a video of the motion, `video.mp4`, into the folder of --out; takes some seconds
    #[arg(long, requires = "out")]
    video: bool,
    /// Print one JSON document, without the motion
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
    let source = source(&arguments.task)?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let bundle = task_scene::of_archive(&archive).map_err(|error| Failure::usage(error.message))?;
    let refusal = |problem| refused(problem, "--task");
    let executed = execute_task(&bundle, source, &arguments.robot, arguments.base, arguments.seed, &resolved)
        .map_err(refusal)?;
    if let Some(folder) = &arguments.out {
        write(folder, &files::all_files(&archive, &executed, arguments.video).map_err(refusal)?)?;
    }
    match arguments.json {
        true => terminal::print(&format!("{:#}\n", files::verdict(&executed))),
        false => terminal::print(&verdict_text(&executed.task, &executed.execution)),
    }
    Ok(if executed.execution.succeeded { Exit::Success } else { Exit::TaskFailed })
}

/// Four numbers.
fn base_place(given: &str) -> Result<BasePlace, String> {
    let numbers: Option<Vec<f64>> = given.split(',').map(|number| number.trim().parse().ok()).collect();
    let Some([x_m, y_m, z_m, yaw_rad]) = numbers.as_deref().and_then(|n| <[f64; 4]>::try_from(n).ok()) else {
        return Err("give four numbers with commas between, such as -0.5,0,0.02,0".to_owned());
    };
    let place = BasePlace { x_m, y_m, z_m, yaw_rad };
    place.check().map(|()| place).map_err(|(name, why)| format!("{name} {why}"))
}

/// A file of a task, or the text itself.
pub(super) fn source(given: &str) -> Result<TaskSource, Failure> {
    if !given.ends_with(".json") {
        return Ok(TaskSource::Text(given.to_owned()));
    }
    let text = std::fs::read_to_string(given)
        .map_err(|error| Failure::usage(format!("cannot read the task {given}: {error}")))?;
    serde_json::from_str(&text)
        .map(TaskSource::Task)
        .map_err(|error| Failure::usage(format!("{given} is no task: {error}")))
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

/// Writes files below a folder.
fn write(folder: &Path, files: &[BundleFile]) -> Result<(), Failure> {
    for file in files {
        let path = folder.join(&file.path);
        let written = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        written
            .and_then(|()| std::fs::write(&path, &file.bytes))
            .map_err(|error| Failure::usage(format!("cannot write {}: {error}", path.display())))?;
    }
    Ok(())
}
