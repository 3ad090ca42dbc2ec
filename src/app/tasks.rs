//! Tasks for a robot in the scene of a bundle: proposed by rules, read from an instruction, or the scene's own.

use std::sync::Arc;

use serde::Serialize;
use serde_json::json;

use crate::api::error::{FieldError, Problem, ProblemType};
use crate::api::tasks::{ProposeTasks, TasksRequest};
use crate::config::Resolved;
use crate::pipeline::error::StageError;
use crate::pipeline::task_scene::{self, BundleScene};
use embedded::analyst;
use manipulation::execution::{ExecutionSettings, Rehearsal};
use remote::settings::AnalystProvider;
use robot::model::{Robot, library};
use scene::request::RequestOptions;
use tasks::proposals::{ProposedTask, propose, propose_if};
use tasks::text::own_task;
use tasks::{Reading, Refusal, RobotLimits, Task, validate};

/// The tasks of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneTasks {
    pub robot: String,
    pub seed: u64,
    /// That of the scene's own text, where it was an instruction.
    pub own: Option<Task>,
    /// That of the instruction that was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instructed: Option<Task>,
    /// Where no instruction was given.
    pub proposed: Vec<ProposedTask>,
}

/// Proposes tasks for scenes, or reads them. A scene's text is read by the embedded parser.
pub fn propose_tasks(resolved: &Resolved) -> ProposeTasks {
    let resolved = resolved.clone();
    Arc::new(move |archive: &[u8], request: &TasksRequest| {
        // An unknown robot is found before the bundle is unpacked.
        let robot = limits_of(&request.robot, &resolved.config.execution)?;
        let bundle = task_scene::of_archive(archive).map_err(unreadable)?;
        tasks_of(&bundle, request, robot, &resolved).map(|found| json!(found))
    })
}

/// The tasks of a scene that was read, for the robot of the request.
///
/// # Errors
///
/// A [`Problem`] with the code of the refusal, for an instruction that is no feasible task.
pub fn tasks_of(
    bundle: &BundleScene,
    request: &TasksRequest,
    robot: RobotLimits,
    resolved: &Resolved,
) -> Result<SceneTasks, Problem> {
    let (instructed, proposed) = match &request.text {
        Some(text) => (Some(instructed_task(text, bundle, &robot, resolved)?), Vec::new()),
        None if request.rehearsed => (None, rehearsed(bundle, request, &robot, resolved)?),
        None => (None, propose(&bundle.tasks, request.count, request.seed, &robot)),
    };
    let own = own_task(&bundle.scene, &robot.name);
    Ok(SceneTasks { robot: robot.name, seed: request.seed, own, instructed, proposed })
}

/// Proposals whose grasps hold and whose motions the arm can make.
fn rehearsed(
    bundle: &BundleScene,
    request: &TasksRequest,
    limits: &RobotLimits,
    resolved: &Resolved,
) -> Result<Vec<ProposedTask>, Problem> {
    let robot = built_in(&limits.name)?;
    let (scene, config) = (super::executions::task_scene(bundle)?, &resolved.config);
    let rehearsal = Rehearsal::new(&scene, &robot, &config.grasps, &config.execution, request.seed);
    let mut rehearsal =
        rehearsal.map_err(|error| Problem::new(ProblemType::Conflict, "broken_scene", error.to_string()))?;
    let mut can_be_done = |task: &Task| rehearsal.can_be_done(task);
    Ok(propose_if(&bundle.tasks, request.count, request.seed, limits, &mut can_be_done))
}

/// The task of an instruction.
///
/// # Errors
///
/// As [`tasks_of`].
pub fn instructed_task(
    text: &str,
    bundle: &BundleScene,
    robot: &RobotLimits,
    resolved: &Resolved,
) -> Result<Task, Problem> {
    let analysts = &resolved.config.providers.analyst;
    if !analysts.iter().all(|provider| *provider == AnalystProvider::Embedded) {
        let detail = "a remote model reads texts here (providers.analyst), and it is not asked for tasks; set \
                      providers.analyst to embedded, or leave the instruction out";
        return Err(Problem::new(ProblemType::Conflict, "remote_analyst", detail));
    }
    let reading = Reading::new(text, &bundle.tasks);
    let options = RequestOptions::default();
    let description =
        analyst::describe(reading.text(), bundle.scene.seed, &options, &resolved.config.analyst)
            .map_err(|error| Problem::invalid(vec![FieldError::new("/text", error.to_string())]))?;
    let task = reading.task(&description, &robot.name).map_err(|refusal| refused(&refusal))?;
    validate(&task, &bundle.tasks, std::slice::from_ref(robot)).map_err(|refusal| refused(&refusal))?;
    Ok(task)
}

/// What a robot can take and lift, from its file.
///
/// # Errors
///
/// A [`Problem`] with the code `unknown_robot`.
pub fn limits_of(name: &str, execution: &ExecutionSettings) -> Result<RobotLimits, Problem> {
    Ok(execution.limits_of(&built_in(name)?))
}

fn built_in(name: &str) -> Result<Robot, Problem> {
    let known = || library::names().map(str::to_owned).collect();
    let unknown = |_| refused(&Refusal::UnknownRobot { robot: name.to_owned(), known: known() });
    Robot::built_in(name, None).map_err(unknown)
}

fn refused(refusal: &Refusal) -> Problem {
    Problem::new(ProblemType::InvalidRequest, refusal.code(), refusal.to_string())
}

fn unreadable(error: StageError) -> Problem {
    Problem::new(ProblemType::Conflict, error.code, error.message)
}
