//! `judge`: whether a task is done in poses that another simulator reports.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::bundle_input::BundleInput;
use super::execute::TASK_ADVICE;
use super::{Exit, Failure, input_file, scene_summary, terminal};
use crate::pipeline::task_scene;
use tasks::goal::formula;
use tasks::scene_state::{SceneState, TaskVerdict};
use tasks::{PredicateOutcome, Task};

/// Arguments of `judge`.
#[derive(Debug, Args)]
#[command(
    after_help = "The state is {\"objects\": {\"mug_1\": {\"translation_m\": [x, y, z], \"rotation_xyzw\": \
                        [x, y, z, w]}}}, in the frame of scene.json. The exit code is 0 for a task that is done, \
                        and 6 for one that is not."
)]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, visible_alias = "scene", value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// A task as `tasks --out` and `execute --out` write it
    #[arg(long, value_name = "FILE")]
    task: PathBuf,
    /// File with the poses of the objects now, and with their contacts
    #[arg(long, value_name = "FILE")]
    state: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

const STATE_ADVICE: &str =
    "give {\"objects\": {\"mug_1\": {\"translation_m\": [x, y, z], \"rotation_xyzw\": [x, y, z, w]}}}";

/// Decides the task and prints the verdict. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(judge(&arguments), is_json)
}

fn judge(arguments: &Arguments) -> Result<Exit, Failure> {
    let task: Task = input_file::json(&arguments.task, "the task", TASK_ADVICE)?;
    let state: SceneState = input_file::json(&arguments.state, "the state", STATE_ADVICE)?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let bundle = task_scene::of_archive(&archive).map_err(|error| Failure::usage(error.message))?;
    let verdict = bundle.tasks.judge(&task, &state).map_err(|error| Failure::usage(error.to_string()))?;
    match arguments.json {
        true => terminal::print(&format!("{:#}\n", json!(verdict))),
        false => terminal::print(&text_of(&task, &verdict)),
    }
    Ok(if verdict.reached { Exit::Success } else { Exit::TaskFailed })
}

fn text_of(task: &Task, verdict: &TaskVerdict) -> String {
    let word = |outcome: &PredicateOutcome| if outcome.holds { "holds" } else { "does not hold" };
    let mut lines = vec![task.instruction.clone()];
    lines.extend(
        verdict
            .predicates
            .iter()
            .map(|outcome| format!("  {} {}", formula(&outcome.predicate), word(outcome))),
    );
    let moved = verdict.disturbed.iter();
    lines.extend(moved.map(|d| format!("  moved besides: {} by {:.0} mm", d.object, 1e3 * d.displacement_m)));
    lines.push(if verdict.reached { "  done" } else { "  not done" }.to_owned());
    lines.join("\n") + "\n"
}
