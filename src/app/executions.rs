//! A task in the scene of a bundle, executed by a simulated robot.

pub mod files;
pub mod meshes;
pub mod parquet_table;
pub mod video;

use std::sync::Arc;

use super::activity::{Watch, staged, unwatched};
use super::grasps::{broken, known_grasps};
use super::tasks::{instructed_task, robot_named};
use crate::api::error::{FieldError, Problem, ProblemType};
use crate::api::executions::{BasePlace, CheckExecution, ExecutionFormat, ExecutionRequest, RequestedTask};
use crate::config::Resolved;
use crate::executor::{self, Answer, Execute};
use crate::pipeline::task_scene::{BundleScene, of_archive, simulated};
use export::archive::zip_files;
use geometry::{DVec3, Pose};
use manipulation::execution::{Execution, KnownGrasps, Refusal, RobotStart, TaskScene, check_base, execute};
use manipulation::frames::to_isometry;
use robot::model::Robot;
use runtime::seed::child_rng;
use serde::Deserialize;
use serde_json::Value;
use tasks::Task;

/// Source of the task.
#[derive(Clone, Debug)]
pub enum TaskSource {
    /// An instruction in words.
    Text(String),
    Task(Box<Task>),
}

impl TaskSource {
    /// The robot that does it: the one that a task names, else the given one.
    fn robot<'a>(&'a self, given: &'a str) -> &'a str {
        match self {
            Self::Text(_) => given,
            Self::Task(task) => &task.robot,
        }
    }
}

/// A task that was executed.
#[derive(Clone, Debug)]
pub struct Executed {
    pub task: Task,
    pub robot: Robot,
    pub seed: u64,
    pub execution: Execution,
}

/// Checks requests before they are enqueued, for the interface.
pub fn check() -> CheckExecution {
    Arc::new(|request| {
        let (source, robot) = source_of(&request.task)?;
        robot_named(source.robot(&robot)).map(drop)
    })
}

/// Executes stored requests, for the executor.
pub fn execute_stored(resolved: &Resolved) -> Execute {
    let resolved = resolved.clone();
    Arc::new(move |archive: &[u8], request: &Value| {
        let request = ExecutionRequest::of_stored(request).map_err(|error| executor::Refusal {
            code: "another_version",
            message: format!(
                "the stored request belongs to another version ({error}); execute the task again"
            ),
            is_of_request: true,
        })?;
        answer(archive, &request, &resolved).map_err(|problem| executor::Refusal {
            code: problem.own_code(),
            is_of_request: problem.kind == ProblemType::InvalidRequest,
            message: problem.message(),
        })
    })
}

fn answer(archive: &[u8], request: &ExecutionRequest, resolved: &Resolved) -> Result<Answer, Problem> {
    let (source, robot) = source_of(&request.task)?;
    let bundle = of_archive(archive)
        .map_err(|error| Problem::new(ProblemType::Conflict, error.code, error.message))?;
    let executed = run(&bundle, source, &robot, request.base, request.seed, resolved, &unwatched)?;
    if request.format == ExecutionFormat::Json {
        let document = files::document(&executed).to_string();
        return Ok(Answer { bytes: document.into(), media_type: "application/json" });
    }
    let written = files::all_files(archive, &executed, request.video)?;
    let zipped = zip_files(&written, "execution/").map_err(|error| {
        Problem::new(ProblemType::Internal, "archive_failed", format!("packing the execution: {error}"))
    })?;
    Ok(Answer { bytes: zipped.into(), media_type: "application/zip" })
}

/// The task of a request, and the robot of an instruction in words.
fn source_of(task: &RequestedTask) -> Result<(TaskSource, String), Problem> {
    match task {
        RequestedTask::Text { text, robot } => Ok((TaskSource::Text(text.clone()), robot.clone())),
        RequestedTask::Task(task) => {
            let task = Task::deserialize(task).map_err(|error| {
                Problem::invalid(vec![FieldError::new("/task", format!("is no task: {error}"))])
            })?;
            Ok((TaskSource::Task(Box::new(task)), String::new()))
        }
    }
}

/// Executes a task, with the base of the robot at a given place or where it is best. Takes seconds: grasps are tried in
/// simulation first, unless the bundle states them.
///
/// # Errors
///
/// A [`Problem`] with the code of the refusal, where the task is not attempted. A task that fails is an [`Execution`].
pub fn run(
    bundle: &BundleScene,
    source: TaskSource,
    robot_name: &str,
    base: Option<BasePlace>,
    seed: u64,
    resolved: &Resolved,
    watch: Watch,
) -> Result<Executed, Problem> {
    let robot = robot_named(source.robot(robot_name))?;
    let (scene, config) = (task_scene(bundle)?, &resolved.config);
    let mut known = known_grasps(bundle, &scene, &robot, &config.grasps, seed);
    let task = task_of(source, bundle, &mut known, resolved, watch)?;
    let start =
        RobotStart { world_from_base: base.map(|base| to_isometry(&pose_of(base))), joint_positions: None };
    if let Some(base) = &start.world_from_base {
        check_base(&scene, &robot, base).map_err(|refusal| refused(&refusal))?;
    }
    for object in task.goal.moved_objects() {
        staged(watch, "grasps", Some(object.as_str()), || known.of(object.as_str()).map(|_| ()))
            .map_err(broken)?;
    }
    let grasps = known.book(&task.goal).map_err(broken)?;
    let mut rng = child_rng(seed, "execution");
    let done = staged(watch, "motion", None, || {
        execute(&scene, &robot, &task, &grasps, &start, &config.execution, &mut rng)
    });
    let execution = done.map_err(|refusal| refused(&refusal))?;
    Ok(Executed { task, robot, seed, execution })
}

fn pose_of(base: BasePlace) -> Pose {
    Pose::upright(DVec3::new(base.x_m, base.y_m, base.z_m), base.yaw_rad)
}

/// The task itself, or that of the instruction.
///
/// # Errors
///
/// A [`Problem`] with the code of the refusal, for an instruction that is no feasible task.
pub fn task_of(
    source: TaskSource,
    bundle: &BundleScene,
    known: &mut KnownGrasps,
    resolved: &Resolved,
    watch: Watch,
) -> Result<Task, Problem> {
    match source {
        TaskSource::Text(text) => instructed_task(&text, bundle, known, resolved, watch),
        TaskSource::Task(task) => Ok(*task),
    }
}

/// Table and objects as the simulation of the robot has them.
///
/// # Errors
///
/// A [`Problem`] for a bundle without a table.
pub fn task_scene(bundle: &BundleScene) -> Result<TaskScene, Problem> {
    let no_table = || Problem::new(ProblemType::Conflict, "broken_scene", "the scene has no table");
    simulated(&bundle.stored.composition, bundle.stored.hulls.iter()).ok_or_else(no_table)
}

fn refused(refusal: &Refusal) -> Problem {
    Problem::new(ProblemType::InvalidRequest, refusal.code(), refusal.to_string())
}
