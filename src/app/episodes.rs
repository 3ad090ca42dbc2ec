//! Demonstrations of tasks in the scene of a bundle, recorded as a dataset that policies are trained on.

mod card;
mod distractors;
pub mod draft;
pub mod order;
mod reading;
pub mod recorder;
pub mod regenerate;
mod unit_folder;

use std::collections::BTreeSet;

use serde_json::Value;

use super::App;
use super::activity::{Watch, staged, unwatched};
use super::executions::meshes::scene_meshes;
use super::executions::{bundle_of, task_of, task_scene};
use super::grasps::known_grasps;
use super::tasks::robot_named;
use crate::config::Resolved;
use crate::pipeline::task_scene::BundleScene;
use crate::problem::{FieldError, Problem, ProblemType};
use crate::recorder::Preparation;
use demonstrations::camera::usual;
use demonstrations::setup::{SceneParts, Wanted, prepare};
use demonstrations::{CameraSpec, Setup, SetupError, Work};
use episodes::EpisodeError;
use robot::model::Robot;
use store::Digest;

pub use card::card;
use distractors::distractors;
pub use order::{Cameras, EpisodesOrder};
pub use reading::ordered;

/// The stage in which the grasps of a task are tried, and the base of the robot is placed.
const PREPARE: &str = "prepare";

impl App {
    /// Prepares attempts of a stored order in the scene of an archive. It computes for seconds, so it blocks.
    ///
    /// # Errors
    ///
    /// As [`setup`], and for an order of another version.
    pub fn prepare_recording(&self, archive: &[u8], order: &Value) -> Result<Preparation, Problem> {
        let order = EpisodesOrder::of_stored(order)?;
        let setup = setup(archive, &order, self.resolved(), &unwatched)?;
        let card = card(order.title(), self.resolved(), &setup);
        Ok(Preparation { setup, card, keeps_failures: order.keeps_failures })
    }
}

/// Prepares the data that all demonstrations of an order share. Takes seconds: grasps are tried in simulation, and
/// distractors made.
///
/// # Errors
///
/// A [`Problem`] with the code of the refusal: for an order that will not do, a scene that is broken, and a task that
/// the robot cannot do.
pub fn setup(
    archive: &[u8],
    order: &EpisodesOrder,
    resolved: &Resolved,
    watch: Watch,
) -> Result<Setup, Problem> {
    order.check()?;
    let bundle = bundle_of(archive)?;
    let robot = robot_named(&order.robot)?;
    let mut parts = parts_of(archive, &bundle)?;
    let works = works(&bundle, &parts.scene, &robot, order, resolved, watch)?;
    let cameras = cameras(order, &works[0], &parts.scene);
    parts.distractors = distractors(&bundle, &order.randomization, order.seed, resolved);
    let wanted = Wanted {
        cameras,
        fps: order.fps,
        depth: order.depth,
        instance_ids: order.instance_ids,
        points: order.points,
        randomization: order.randomization,
        seed: order.seed,
        formats: order.formats.clone(),
        place: None,
    };
    Setup::new(parts, robot, works, wanted, &resolved.config.execution).map_err(|error| refused(&error))
}

fn parts_of(archive: &[u8], bundle: &BundleScene) -> Result<SceneParts, Problem> {
    let scene = task_scene(bundle)?;
    let names: Vec<&str> =
        std::iter::once("table").chain(scene.objects.iter().map(|object| object.name.as_str())).collect();
    let meshes = scene_meshes(archive, &names)?;
    let supporters = bundle.stored.composition.supports.supporters().to_vec();
    let digest = Digest::of(archive).to_string();
    Ok(SceneParts { scene, supporters, meshes, distractors: Vec::new(), digest })
}

fn works(
    bundle: &BundleScene,
    scene: &manipulation::execution::TaskScene,
    robot: &Robot,
    order: &EpisodesOrder,
    resolved: &Resolved,
    watch: Watch,
) -> Result<Vec<Work>, Problem> {
    let mut instructions = BTreeSet::new();
    let config = &resolved.config;
    let mut known = known_grasps(bundle, scene, robot, &config.grasps, order.seed);
    let works = order.tasks.iter().enumerate().map(|(index, source)| {
        let wrong =
            |detail: String| Problem::invalid(vec![FieldError::new(format!("/tasks/{index}"), detail)]);
        let task = task_of(source.clone(), bundle, &mut known, resolved, watch)?;
        if task.robot != order.robot {
            return Err(wrong(format!("is for the robot {}, not {}", task.robot, order.robot)));
        }
        if !instructions.insert(task.instruction.clone()) {
            return Err(wrong(format!("\"{}\" is in the list twice", task.instruction)));
        }
        let instruction = task.instruction.clone();
        let prepare = || prepare(robot, task, &mut known, &config.execution);
        staged(watch, PREPARE, Some(&instruction), prepare).map_err(|error| refused(&error))
    });
    works.collect()
}

fn cameras(
    order: &EpisodesOrder,
    work: &Work,
    scene: &manipulation::execution::TaskScene,
) -> Vec<CameraSpec> {
    let (work_m, base_m) = (work.center_m(scene), work.world_from_base.translation_m);
    match &order.cameras {
        Cameras::Usual { names, side_px } => {
            names.iter().filter_map(|name| usual(name, work_m, base_m, *side_px)).collect()
        }
        Cameras::Own(cameras) => cameras.clone(),
    }
}

fn refused(error: &SetupError) -> Problem {
    let (kind, code) = match error {
        SetupError::Place { .. } => (ProblemType::InvalidRequest, "broken_record"),
        SetupError::NoTask => (ProblemType::InvalidRequest, "no_task"),
        SetupError::Camera { .. } => (ProblemType::InvalidRequest, "camera"),
        SetupError::NotFeasible { .. } => (ProblemType::InvalidRequest, "not_feasible"),
        SetupError::Description(EpisodeError::Description { .. }) => {
            (ProblemType::InvalidRequest, "description")
        }
        SetupError::Description(_)
        | SetupError::Parts { .. }
        | SetupError::BrokenHull { .. }
        | SetupError::Scene(_)
        | SetupError::World(_) => (ProblemType::Conflict, "broken_scene"),
    };
    Problem::new(kind, code, error.to_string())
}
