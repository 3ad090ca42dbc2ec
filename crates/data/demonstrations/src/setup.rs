//! Data that all demonstrations of a dataset share.

use episodes::EpisodeError;
use episodes::description::{CameraDescription, DatasetDescription, InstanceIdWidth};
use episodes::format::Format;
use geometry::collision_shape::{BrokenHull, CollisionShape};
use geometry::{DVec3, Pose, TexturedMesh};
use manipulation::execution::{ExecutionSettings, GraspBook, KnownGrasps, Rehearsal, SceneError, TaskScene};
use manipulation::frames::{to_isometry, to_pose};
use manipulation::link_meshes::link_meshes;
use manipulation::world::WorldError;
use nalgebra::Isometry3;
use robot::model::Robot;
use scene::Supporter;
use serde_json::json;
use sha2::{Digest, Sha256};
use tasks::Task;

use crate::camera::{CameraSpec, Mount};
use crate::distractors::Distractor;
use crate::finish::{is_of_one_color, is_table_of_catalog};
use crate::randomization::Randomization;
use crate::vectors::{action_layout, servo_layout, state_layout};

/// One task, with what is found once for all of its demonstrations.
pub struct Work {
    pub task: Task,
    /// Grasps of the objects that the task moves.
    pub grasps: GraspBook,
    /// Pose of the robot's base.
    pub world_from_base: Pose,
}

/// Data that all demonstrations share. [`Setup::new`] is the only way to make one.
pub struct Setup {
    pub(crate) scene: TaskScene,
    /// Supporter of each object.
    pub(crate) supporters: Vec<Supporter>,
    /// Number of the objects that belong to the scene; the distractors follow them.
    own_objects: usize,
    /// The collision shapes of the objects.
    pub(crate) shapes: Vec<CollisionShape>,
    /// The table first, then the objects.
    pub(crate) meshes: Vec<TexturedMesh>,
    /// For each object, whether it can have another material; then whether the table can.
    pub(crate) is_of_one_color: Vec<bool>,
    pub(crate) is_table_of_catalog: bool,
    pub(crate) link_meshes: Vec<TexturedMesh>,
    pub(crate) robot: Robot,
    pub(crate) works: Vec<Work>,
    /// Place of the only work among the tasks of the dataset, if that has more.
    place: Option<TaskPlace>,
    pub(crate) cameras: Vec<CameraSpec>,
    pub(crate) randomization: Randomization,
    pub(crate) settings: ExecutionSettings,
    pub(crate) seed: u64,
    /// Identifies the scene in records.
    pub(crate) scene_digest: String,
    pub(crate) formats: Vec<Format>,
    pub(crate) description: DatasetDescription,
}

/// A scene for demonstrations.
pub struct SceneParts {
    pub scene: TaskScene,
    /// Supporter of each object, in the order of the objects.
    pub supporters: Vec<Supporter>,
    /// Of the table first, then of the objects.
    pub meshes: Vec<TexturedMesh>,
    /// Other objects of which some may stand on the table. Their names are not those of objects.
    pub distractors: Vec<Distractor>,
    /// Identifies the scene in records: a digest of what it was read from.
    pub digest: String,
}

/// Options of the recording.
pub struct Wanted {
    pub cameras: Vec<CameraSpec>,
    /// Frames per second.
    pub fps: u32,
    /// Whether cameras also give depth, and the object at each pixel.
    pub depth: bool,
    pub instance_ids: bool,
    /// Points in the cloud of each frame; `None` without clouds.
    pub points: Option<u32>,
    pub randomization: Randomization,
    /// Seed of everything that is drawn.
    pub seed: u64,
    pub formats: Vec<Format>,
    /// For making an episode of a dataset again: its task is the only work then.
    pub place: Option<TaskPlace>,
}

/// The place of a task in the list of a dataset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskPlace {
    pub index: usize,
    pub instructions: Vec<String>,
}

/// Reason why there can be no demonstrations.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    #[error("no task was given")]
    NoTask,
    #[error("the task \"{instruction}\" is not the one of number {index} among those of the dataset")]
    Place { instruction: String, index: usize },
    #[error("the scene has {objects} objects, but {what} for {given}")]
    Parts { objects: usize, what: &'static str, given: usize },
    #[error("camera {camera}: {fault}")]
    Camera { camera: String, fault: String },
    #[error("the task \"{instruction}\": the arm cannot make its motions from any place of its base")]
    NotFeasible { instruction: String },
    #[error("the object {name}: {source}")]
    BrokenHull { name: String, source: BrokenHull },
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    World(#[from] WorldError),
    #[error(transparent)]
    Description(#[from] EpisodeError),
}

/// Finds the grasps of a task, and where the robot stands: what is moved is tried in simulation, which takes seconds,
/// unless its grasps are known.
///
/// # Errors
///
/// [`SetupError::NotFeasible`] if no place for the base is good; others for a broken scene.
pub fn prepare(
    robot: &Robot,
    task: Task,
    known: &mut KnownGrasps,
    settings: &ExecutionSettings,
) -> Result<Work, SetupError> {
    let grasps = known.book(&task.goal)?;
    let rehearsal = Rehearsal::new(known.scene(), robot, settings)?;
    let Some(base) = rehearsal.base_for(&task, &grasps) else {
        return Err(SetupError::NotFeasible { instruction: task.instruction });
    };
    Ok(Work { task, grasps, world_from_base: to_pose(&base) })
}

impl Work {
    pub(crate) fn base(&self) -> Isometry3<f64> {
        to_isometry(&self.world_from_base)
    }

    /// The center of what the task is about: of the objects that it names, somewhat above the table.
    pub fn center_m(&self, scene: &TaskScene) -> DVec3 {
        const HEIGHT_M: f64 = 0.06;
        let named = self.task.goal.named_objects();
        let at: Vec<DVec3> = named
            .iter()
            .filter_map(|name| scene.index(name.as_str()))
            .map(|index| scene.objects[index].world_from_object.translation_m)
            .collect();
        let sum: DVec3 = at.iter().sum();
        (sum / at.len().max(1) as f64).with_z(HEIGHT_M)
    }
}

impl Setup {
    /// Checks what was given.
    ///
    /// # Errors
    ///
    /// The first value that will not do.
    pub fn new(
        mut parts: SceneParts,
        robot: Robot,
        works: Vec<Work>,
        wanted: Wanted,
        settings: &ExecutionSettings,
    ) -> Result<Self, SetupError> {
        if works.is_empty() {
            return Err(SetupError::NoTask);
        }
        let objects = parts.scene.objects.len();
        // One mesh is that of the table.
        let meshes = parts.meshes.len().saturating_sub(1);
        for (what, given) in [("supporters", parts.supporters.len()), ("meshes", meshes)] {
            if given != objects {
                return Err(SetupError::Parts { objects, what, given });
            }
        }
        for camera in &wanted.cameras {
            if let Some(fault) = camera.fault().or_else(|| inside(camera, &parts)) {
                return Err(SetupError::Camera { camera: camera.name.clone(), fault });
            }
        }
        for Distractor { body, mesh } in parts.distractors {
            parts.scene.objects.push(body);
            parts.supporters.push(Supporter::TABLE);
            parts.meshes.push(mesh);
        }
        let shapes = parts.scene.objects.iter().map(|object| {
            let broken = |source| SetupError::BrokenHull { name: object.name.clone(), source };
            CollisionShape::new(&object.hulls).map_err(broken)
        });
        let shapes = shapes.collect::<Result<Vec<_>, _>>()?;
        let cameras = wanted.cameras.iter().map(|camera| CameraDescription {
            name: camera.name.clone(),
            width_px: camera.width_px,
            height_px: camera.height_px,
            depth: wanted.depth,
            instance_ids: wanted.instance_ids.then_some(InstanceIdWidth::U16),
        });
        let description = DatasetDescription::new(
            robot.name(),
            wanted.fps,
            state_layout(&robot)?,
            action_layout(&robot)?,
            cameras.collect(),
            instructions(&works, wanted.place.as_ref())?,
        )?
        .with_servo_commands(servo_layout(&robot)?);
        let description = match wanted.points {
            Some(points) => description.with_points(points)?,
            None => description,
        };
        let settings = ExecutionSettings { record_hz: f64::from(wanted.fps), ..settings.clone() };
        Ok(Self {
            link_meshes: link_meshes(&robot),
            scene: parts.scene,
            supporters: parts.supporters,
            own_objects: objects,
            is_of_one_color: parts.meshes[1..].iter().map(is_of_one_color).collect(),
            is_table_of_catalog: is_table_of_catalog(&parts.meshes[0]),
            meshes: parts.meshes,
            scene_digest: parts.digest,
            shapes,
            robot,
            works,
            place: wanted.place,
            cameras: wanted.cameras,
            randomization: wanted.randomization,
            settings,
            seed: wanted.seed,
            formats: wanted.formats,
            description,
        })
    }

    /// Number of objects that belong to the scene.
    pub(crate) fn own_objects(&self) -> usize {
        self.own_objects
    }

    pub fn description(&self) -> &DatasetDescription {
        &self.description
    }

    pub fn formats(&self) -> &[Format] {
        &self.formats
    }

    /// The task of an attempt, by its place in the description: they take turns.
    pub fn task_of(&self, number: u64) -> usize {
        (number % self.description.tasks().len() as u64) as usize
    }

    pub(crate) fn work_of(&self, number: u64) -> &Work {
        &self.works[if self.place.is_some() { 0 } else { self.task_of(number) }]
    }

    /// A digest of everything that attempts depend on.
    pub fn identity(&self) -> String {
        let works: Vec<_> =
            self.works.iter().map(|work| json!([work.task, work.grasps, work.world_from_base])).collect();
        let identity = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "scene": self.scene_digest,
            "robot": [self.robot.name(), self.robot.variant().unwrap_or_default()],
            "works": works,
            "cameras": self.cameras,
            "randomization": self.randomization,
            "settings": self.settings,
            "seed": self.seed,
            "formats": self.formats.iter().map(|format| format.folder()).collect::<Vec<_>>(),
        });
        Sha256::digest(identity.to_string()).iter().map(|byte| format!("{byte:02x}")).collect()
    }

    pub fn randomization(&self) -> &Randomization {
        &self.randomization
    }

    /// Names of the instances in images: the index in the list is the id; 0 is none.
    pub fn instances(&self) -> Vec<String> {
        let objects = self.scene.objects.iter().map(|object| object.name.clone());
        ["none".to_owned(), "table".to_owned()]
            .into_iter()
            .chain(objects)
            .chain(["robot".to_owned()])
            .collect()
    }
}

/// The instructions of the dataset.
fn instructions(works: &[Work], place: Option<&TaskPlace>) -> Result<Vec<String>, SetupError> {
    let own = |work: &Work| work.task.instruction.clone();
    let Some(place) = place else { return Ok(works.iter().map(own).collect()) };
    let known = place.instructions.get(place.index);
    match works {
        [work] if known == Some(&work.task.instruction) => Ok(place.instructions.clone()),
        _ => Err(SetupError::Place { instruction: own(&works[0]), index: place.index }),
    }
}

/// Message about a camera that is fixed to the world and inside the table or an object; `None` if it is outside of all.
fn inside(camera: &CameraSpec, parts: &SceneParts) -> Option<String> {
    if camera.mount != Mount::World {
        return None;
    }
    let (low, high) = parts.meshes[0].bounds();
    if camera.eye_m.cmpge(low).all() && camera.eye_m.cmple(high).all() {
        return Some("is inside the table; its top is at z = 0".to_owned());
    }
    parts.scene.objects.iter().zip(&parts.meshes[1..]).find_map(|(object, mesh)| {
        let at = object.world_from_object.inverse().transform_point(camera.eye_m);
        let (low, high) = mesh.bounds();
        (at.cmpge(low).all() && at.cmple(high).all()).then(|| format!("is inside {}", object.name))
    })
}
