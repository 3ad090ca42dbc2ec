//! `tasks`: what a robot could do in the scene of a bundle.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::bundle_input::BundleInput;
use super::foreground::computed;
use super::generate::refused;
use super::options::ConfigOptions;
use super::output::{Kind, Output};
use super::{Exit, Failure, instructions, number, scene_summary, terminal};
use crate::app::executions::TaskSource;
use crate::app::tasks::{MAX_TASKS, SceneTasks, TasksRequest, robot_named, tasks_of};
use crate::pipeline::task_scene::{self, BundleScene};
use crate::problem::Problem;
use tasks::proposals::Difficulty;
use tasks::{Task, bddl, goal};

/// Arguments of `tasks`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// The robot that has to do them
    #[arg(long, value_name = "NAME", default_value = "panda")]
    robot: String,
    /// Number of proposed tasks
    #[arg(long, value_name = "N", default_value_t = 5, allow_negative_numbers = true, value_parser = number::whole::<usize>(1..=MAX_TASKS as u64))]
    count: usize,
    /// The same scene, seed and robot: the same proposals
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = number::seed)]
    seed: u64,
    /// Read this instruction in place of proposing tasks
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    text: Option<String>,
    /// Propose by shapes and weights alone, at once: without it, grasps are tried in simulation and the motions of the
    /// arm are planned, which takes seconds for each object, for ten tasks at most
    #[arg(long)]
    no_rehearse: bool,
    /// Also write each task as JSON and as a BDDL problem into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the tasks that an earlier run left in the folder of --out; a folder with other files is refused
    #[arg(long, requires = "out")]
    force: bool,
    /// Print one JSON document instead of the table, and no progress
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Prints the tasks. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(tasks(arguments), is_json)
}

fn tasks(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    let Arguments { robot, count, seed, text, no_rehearse, .. } = arguments;
    let request = TasksRequest { robot, count, seed, text, rehearsed: !no_rehearse };
    let refusal = |problem| refused(problem, "--text");
    let checked = request.check(resolved.config.server.max_text_chars);
    checked.map_err(|error| refusal(Problem::invalid(vec![error])))?;
    let robot = robot_named(&request.robot).map_err(refusal)?;
    let check = |out: &PathBuf| Output::check(out, Kind::Tasks, arguments.force, &[&arguments.bundle]);
    let output = arguments.out.as_ref().map(check).transpose()?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let mut instructed: Vec<TaskSource> = request.text.clone().map(TaskSource::Text).into_iter().collect();
    instructions::read_tasks(&resolved, &archive, &mut instructed, &request.robot, refusal)?;
    let (found, bundle) = computed(arguments.json, move |watch| {
        let bundle = task_scene::of_archive(&archive).map_err(|error| Failure::usage(error.message))?;
        let found =
            tasks_of(&bundle, &request, instructed.pop(), &robot, &resolved, watch).map_err(refusal)?;
        Ok((found, bundle))
    })?;
    if let Some(output) = output {
        write(&output, &found, &bundle)?;
    }
    match arguments.json {
        true => terminal::print(&format!("{:#}\n", json!(found))),
        false => terminal::print(&table(&found)),
    }
    Ok(Exit::Success)
}

/// One paragraph a task.
fn table(found: &SceneTasks) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    if let Some(own) = &found.own {
        let _ = writeln!(text, "the scene's own: {}\n     {}", own.instruction, goal_of(own));
    }
    if let Some(instructed) = &found.instructed {
        let _ = writeln!(text, "{}\n     {}", instructed.instruction, goal_of(instructed));
        return text;
    }
    for (number, proposed) in found.proposed.iter().enumerate() {
        let Difficulty { overall, objects, steps, precision_m, .. } = proposed.difficulty;
        let _ = writeln!(
            text,
            "{:>3}. {}\n     {}\n     difficulty {overall:.2}: {objects} objects, {steps} steps, {:.0} mm precise",
            number + 1,
            proposed.task.instruction,
            goal_of(&proposed.task),
            1e3 * precision_m,
        );
    }
    if found.proposed.is_empty() {
        let _ = writeln!(
            text,
            "{} has nothing to do here: it can do none of the tasks that fit the scene",
            found.robot
        );
    }
    text
}

fn goal_of(task: &Task) -> String {
    task.goal.predicates().iter().map(goal::formula).collect::<Vec<_>>().join(", ")
}

/// `task_0001.json` and `task_0001.bddl` of each task, and the domain of all.
fn write(output: &Output, found: &SceneTasks, bundle: &BundleScene) -> Result<(), Failure> {
    let partial = output.begin()?;
    let written = |name: &str, text: String| partial.write(name, text.as_bytes());
    written("domain.bddl", bddl::domain())?;
    let proposed = found.proposed.iter().map(|proposed| &proposed.task);
    for (number, task) in found.instructed.iter().chain(proposed).enumerate() {
        let name = format!("task_{:04}", number + 1);
        written(&format!("{name}.json"), format!("{:#}\n", json!(task)))?;
        written(&format!("{name}.bddl"), bddl::problem(&name, task, &bundle.tasks))?;
    }
    partial.publish()
}
