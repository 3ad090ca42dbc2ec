//! A task in the scene of a bundle, executed by a simulated robot.

pub mod files;
pub mod meshes;
pub mod order;
pub mod parquet_table;
pub mod video;

use super::App;
use super::activity::{Watch, staged, unwatched};
use super::grasps::{broken, known_grasps};
use super::tasks::{instructed_task, robot_named};
use crate::config::Resolved;
use crate::executor::Answer;
use crate::pipeline::task_scene::{BundleScene, of_archive, simulated};
use crate::problem::{Problem, ProblemType};
use export::archive::zip_files;
use geometry::{DVec3, Pose};
use manipulation::execution::{Execution, KnownGrasps, Refusal, RobotStart, TaskScene, check_base, execute};
use manipulation::frames::to_isometry;
use robot::model::Robot;
use runtime::seed::child_rng;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tasks::Task;

use order::{BasePlace, ExecutionFormat, ExecutionOrder};

/// Source of the task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskSource {
    /// An instruction in words.
    Text(String),
    Task(Box<Task>),
}

impl TaskSource {
    /// The instruction in words.
    pub fn instruction(&self) -> &str {
        match self {
            Self::Text(text) => text.trim(),
            Self::Task(task) => &task.instruction,
        }
    }

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

impl App {
    /// Executes the stored order of an execution in the scene of an archive. It computes for seconds, so it blocks.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with the code of the refusal, where the task is not attempted.
    pub fn execute_stored(&self, archive: &[u8], order: &Value) -> Result<Answer, Problem> {
        let order = ExecutionOrder::of_stored(order).map_err(|error| {
            let detail =
                format!("the stored request belongs to another version ({error}); execute the task again");
            Problem::new(ProblemType::InvalidRequest, "another_version", detail)
        })?;
        let ExecutionOrder { task, robot, seed, base, video, format } = order;
        let bundle = bundle_of(archive)?;
        let executed = run(&bundle, task, &robot, base, seed, self.resolved(), &unwatched)?;
        if format == ExecutionFormat::Json {
            let document = files::document(&executed).to_string();
            return Ok(Answer { bytes: document.into(), media_type: "application/json" });
        }
        let written = files::all_files(archive, &executed, video)?;
        let zipped = zip_files(&written, "execution/").map_err(|error| {
            Problem::new(ProblemType::Internal, "archive_failed", format!("packing the execution: {error}"))
        })?;
        Ok(Answer { bytes: zipped.into(), media_type: "application/zip" })
    }
}

/// The scene of an archive, as tasks are done in it.
///
/// # Errors
///
/// A [`Problem`] for an archive that cannot be read.
pub fn bundle_of(archive: &[u8]) -> Result<BundleScene, Problem> {
    of_archive(archive).map_err(|error| Problem::new(ProblemType::Conflict, error.code, error.message))
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
        text @ TaskSource::Text(_) => instructed_task(text, bundle, known, resolved, watch),
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
