//! Tasks for a robot in the scene of a bundle: proposed by rules, read from an instruction, or the scene's own.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::App;
use super::activity::{Activity, Watch, staged, unwatched};
use super::executions::{TaskSource, bundle_of, task_scene as simulated_scene};
use super::grasps::{known_grasps, limits, note, note_wide};
use super::instructions::refused;
use super::submission::check_text;
use crate::config::Resolved;
use crate::pipeline::task_scene::BundleScene;
use crate::problem::{FieldError, Problem, ProblemType};
use crate::schemas::values::MAX_INTEGER;
use manipulation::execution::{KnownGrasps, Rehearsal};
use robot::model::{Robot, library};
use scene::request::MAX_SEED;
use tasks::proposals::{ProposedTask, propose, propose_if};
use tasks::text::own_task;
use tasks::{Refusal, Task, validate};

/// Proposed tasks of a robot in a scene.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SceneTasks {
    pub robot: String,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
    /// The task of the scene's own text, where it was an instruction.
    pub own: Option<Task>,
    /// Task of the given instruction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instructed: Option<Task>,
    /// Empty where an instruction was given.
    pub proposed: Vec<ProposedTask>,
}

/// Most tasks of one answer.
pub const MAX_TASKS: usize = 50;
/// Most of those that are rehearsed.
const MAX_REHEARSED: usize = 10;

/// Request for the tasks of a scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TasksRequest {
    /// The robot that has to do them; its gripper and strength decide what it can move.
    pub robot: String,
    /// Number of proposals.
    #[schemars(range(min = 1, max = 50))]
    pub count: usize,
    /// The same scene, seed and robot give the same proposals.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
    /// An instruction to read in place of proposals.
    #[schemars(length(min = 1, max = 4000))]
    pub text: Option<String>,
    /// Whether only tasks are proposed whose grasps hold in simulation and whose motions the arm can make. Takes
    /// seconds for each object; at most ten at a time, and one request at a time in a process. `false` proposes by
    /// shapes and weights alone, at once.
    pub rehearsed: bool,
}

impl Default for TasksRequest {
    fn default() -> Self {
        Self { robot: "panda".to_owned(), count: 5, seed: 0, text: None, rehearsed: true }
    }
}

impl TasksRequest {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    ///
    /// The first value that is not.
    pub fn check(&self, max_text_chars: usize) -> Result<(), FieldError> {
        let wrong = |name: &str, why: String| Err(FieldError::new(format!("/{name}"), why));
        if !(1..=MAX_TASKS).contains(&self.count) {
            return wrong("count", format!("must be a whole number from 1 to {MAX_TASKS}"));
        }
        if self.is_rehearsed() && self.count > MAX_REHEARSED {
            let why = format!(
                "must be at most {MAX_REHEARSED} where tasks are rehearsed; more are proposed with rehearsed=false \
                 (--no-rehearse)"
            );
            return wrong("count", why);
        }
        if self.seed > MAX_SEED {
            return wrong("seed", format!("must be at most {MAX_SEED}"));
        }
        match &self.text {
            Some(text) => {
                check_text(text, max_text_chars).map_or_else(|why| wrong("text", why.to_string()), |_| Ok(()))
            }
            None => Ok(()),
        }
    }

    /// Whether proposals are asked for that are rehearsed.
    pub fn is_rehearsed(&self) -> bool {
        self.rehearsed && self.text.is_none()
    }
}

impl App {
    /// Proposes tasks in the scene of an archive, or checks the one that an instruction asks for. It computes, so it
    /// blocks.
    ///
    /// # Errors
    ///
    /// As [`tasks_of`], and for an archive that cannot be read.
    pub fn propose_tasks(
        &self,
        archive: &[u8],
        request: &TasksRequest,
        instructed: Option<TaskSource>,
    ) -> Result<SceneTasks, Problem> {
        // An unknown robot is found before the bundle is unpacked.
        let robot = robot_named(&request.robot)?;
        tasks_of(&bundle_of(archive)?, request, instructed, &robot, self.resolved(), &unwatched)
    }
}

/// The tasks of a scene that was read, for the robot of the request.
///
/// # Errors
///
/// A [`Problem`] with the code of the refusal, for an instruction that is no feasible task.
pub fn tasks_of(
    bundle: &BundleScene,
    request: &TasksRequest,
    instructed: Option<TaskSource>,
    robot: &Robot,
    resolved: &Resolved,
    watch: Watch,
) -> Result<SceneTasks, Problem> {
    let (scene, config) = (simulated_scene(bundle)?, &resolved.config);
    let mut known = known_grasps(bundle, &scene, robot, &config.grasps, request.seed);
    let (instructed, proposed) = match instructed {
        Some(source) => (Some(instructed_task(source, bundle, &mut known, resolved, watch)?), Vec::new()),
        None if request.rehearsed => (None, rehearsed(bundle, request, &mut known, resolved, watch)?),
        None => {
            let limits = limits(&mut known, bundle, config)?;
            (None, propose(&bundle.tasks, request.count, request.seed, &limits))
        }
    };
    let own = own_task(&bundle.scene, robot.name());
    Ok(SceneTasks { robot: robot.name().to_owned(), seed: request.seed, own, instructed, proposed })
}

/// Proposals whose grasps hold and whose motions the arm can make. Each is rehearsed when it is its turn, until there
/// are as many as were asked for.
fn rehearsed(
    bundle: &BundleScene,
    request: &TasksRequest,
    known: &mut KnownGrasps,
    resolved: &Resolved,
    watch: Watch,
) -> Result<Vec<ProposedTask>, Problem> {
    let config = &resolved.config;
    let mut limits = limits(known, bundle, config)?;
    note_wide(&mut limits, bundle, known, watch)?;
    let rehearsal = Rehearsal::new(known.scene(), known.robot(), &config.execution);
    let rehearsal =
        rehearsal.map_err(|error| Problem::new(ProblemType::Conflict, "broken_scene", error.to_string()))?;
    let mut found = 0;
    let mut can_be_done = |task: &Task| {
        // What cannot be simulated has no grasp.
        let rehearse = || known.book(&task.goal).is_ok_and(|grasps| rehearsal.can_be_done(task, &grasps));
        let is_possible = staged(watch, REHEARSE, Some(&task.instruction), rehearse);
        if is_possible {
            found += 1;
            let message = format!("{found} of {}: {}", request.count, task.instruction);
            watch(Activity::Found { stage: REHEARSE, message });
        }
        is_possible
    };
    Ok(propose_if(&bundle.tasks, request.count, request.seed, &limits, &mut can_be_done))
}

/// The stage in which proposals are rehearsed.
const REHEARSE: &str = "rehearse";

/// The task of an instruction, which the robot can do as far as shapes and weights say.
///
/// # Errors
///
/// As [`tasks_of`].
pub fn instructed_task(
    source: TaskSource,
    bundle: &BundleScene,
    known: &mut KnownGrasps,
    resolved: &Resolved,
    watch: Watch,
) -> Result<Task, Problem> {
    let task = match source {
        TaskSource::Text(text) => tasks::text::task(&text, &bundle.tasks, known.robot().name())
            .map_err(|refusal| refused(&refusal))?,
        TaskSource::Task(task) => *task,
    };
    let mut limits = limits(known, bundle, &resolved.config)?;
    loop {
        match validate(&task, &bundle.tasks, std::slice::from_ref(&limits)) {
            Ok(()) => return Ok(task),
            // A grasp that holds decides, not the width.
            Err(Refusal::ObjectTooWide { object, .. }) if !limits.held.contains_key(&object) => {
                staged(watch, "grasps", Some(object.as_str()), || note(&mut limits, &object, known))?;
            }
            Err(refusal) => return Err(refused(&refusal)),
        }
    }
}

/// A built-in robot.
///
/// # Errors
///
/// A [`Problem`] with the code `unknown_robot`.
pub fn robot_named(name: &str) -> Result<Robot, Problem> {
    let known = || library::names().map(str::to_owned).collect();
    let unknown = |_| refused(&Refusal::UnknownRobot { robot: name.to_owned(), known: known() });
    Robot::built_in(name, None).map_err(unknown)
}
