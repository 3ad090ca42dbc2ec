//! One attempt at a demonstration: drawn, arranged, done, and recorded.

use episodes::EpisodeEncoder;
use episodes::EpisodeError;
use episodes::EpisodeUnit;
use episodes::episode::{EpisodeHeader, Outcome};
use episodes::frame::{CameraFrame, Frame};
use episodes::point_cloud::PointCloud;
use manipulation::execution::{Execution, RobotStart, TaskScene, execute};
use manipulation::world::WorldOptions;
use physics::{Body, SettleError, SettleSettings};
use runtime::CancelFlag;
use runtime::seed::{child_rng, child_seed};

use crate::motion_window::motion_window;
use crate::point_cloud::points;
use crate::record::{self, EpisodeRecord};
use crate::sample::Sample;
use crate::setup::{Setup, Work};
use crate::stage::{CameraView, Props, Stage};
use crate::vectors::frame_vectors;

/// Objects may move so far until they rest, meters; more is no arrangement.
const MAX_SETTLING_M: f64 = 0.005;
/// Time for settling, seconds.
const SETTLE_S: f64 = 2.0;
/// Natural frequency of contacts: the highest that this simulation permits; a robot's world has stiffer ones.
const CONTACT_FREQUENCY_HZ: f64 = 500.0;

/// Result of an attempt.
#[derive(Debug)]
pub enum Attempted {
    /// The task was done.
    Succeeded(Box<EpisodeUnit>),
    /// Failure: a short stable name of the reason, details for people, and the episode, if there was a motion and it is
    /// wanted.
    Failed { reason: String, detail: String, unit: Option<Box<EpisodeUnit>> },
}

/// Makes the attempt of a number. Failures are recorded as episodes only where `keeps_failures`.
///
/// # Errors
///
/// [`EpisodeError`] if a frame does not fit the description, which is a fault of the program.
pub fn attempt(setup: &Setup, number: u64, keeps_failures: bool) -> Result<Attempted, EpisodeError> {
    let seed = child_seed(setup.seed, &format!("episode {number}"));
    let work = setup.work_of(number);
    let failed = |reason: &str, detail: String| {
        Ok(Attempted::Failed { reason: reason.to_owned(), detail, unit: None })
    };
    let Some(sample) = Sample::draw(setup, work, &setup.randomization, seed) else {
        return failed("no_arrangement", "no free places were found for the objects".to_owned());
    };
    let scene = match settled(sampled(setup, &sample)) {
        Ok(scene) => scene,
        Err(unstable) => return failed("unstable_arrangement", unstable.to_string()),
    };
    let start = RobotStart {
        world_from_base: Some(work.base()),
        joint_positions: Some(sample.joint_positions_rad.clone()),
    };
    let mut rng = child_rng(seed, "execution");
    let done = execute(&scene, &setup.robot, &work.task, &work.grasps, &start, &setup.settings, &mut rng);
    let execution = match done {
        Ok(execution) => execution,
        Err(refusal) => return failed(refusal.code(), refusal.to_string()),
    };
    let outcome = match execution.failure {
        None => Outcome::Success,
        Some(failure) => Outcome::Failure { reason: failure.code().to_owned() },
    };
    let is_recorded = outcome.is_success() || keeps_failures;
    let unit = match is_recorded {
        true => recorded(setup, work, number, seed, &sample, &scene, &execution, outcome.clone())?,
        false => None,
    };
    Ok(match (outcome, unit) {
        (Outcome::Success, Some(unit)) => Attempted::Succeeded(unit),
        (Outcome::Success, None) => Attempted::Failed {
            reason: "nothing_to_do".to_owned(),
            detail: "the task was done without a motion".to_owned(),
            unit: None,
        },
        (Outcome::Failure { reason }, unit) => {
            Attempted::Failed { reason, detail: execution.detail.unwrap_or_default(), unit }
        }
    })
}

/// The scene with what was drawn; absent objects are left out.
fn sampled(setup: &Setup, sample: &Sample) -> TaskScene {
    let present = setup.scene.objects.iter().zip(&sample.objects).filter(|(_, drawn)| drawn.present);
    let objects = present.map(|(object, drawn)| {
        let mut friction = object.friction;
        friction.static_coefficient *= drawn.friction_factor;
        friction.dynamic_coefficient *= drawn.friction_factor;
        Body {
            world_from_object: drawn.world_from_object,
            mass: object.mass.with_mass(object.mass.mass_kg * drawn.mass_factor),
            friction,
            ..object.clone()
        }
    });
    TaskScene {
        table: setup.scene.table.clone(),
        outline: setup.scene.outline.clone(),
        objects: objects.collect(),
    }
}

/// Reason why an arrangement is not stable.
#[derive(Debug, thiserror::Error)]
enum Unstable {
    #[error(transparent)]
    Settling(#[from] SettleError),
    #[error("the objects do not rest after {SETTLE_S} s")]
    NotAtRest,
    #[error("{name} moved by {:.1} mm", 1e3 * .moved_m)]
    Moved { name: String, moved_m: f64 },
}

/// The scene at rest: the certificate of an arrangement.
///
/// # Errors
///
/// [`Unstable`] if an object does not stay.
fn settled(mut scene: TaskScene) -> Result<TaskScene, Unstable> {
    let world = WorldOptions::default();
    let settings = SettleSettings {
        duration_s: SETTLE_S,
        steps_per_s: world.steps_per_s,
        solver_iterations: world.solver_iterations,
        contact_frequency_hz: CONTACT_FREQUENCY_HZ,
        length_unit_m: world.length_unit_m,
        damping_per_s: world.damping_per_s,
        rest_speed_m_s: 0.005,
        rest_time_s: 0.1,
    };
    let bodies: Vec<Body> = std::iter::once(&scene.table).chain(&scene.objects).cloned().collect();
    let settled = physics::settle(&bodies, &settings, &CancelFlag::default())?;
    if !settled.at_rest {
        return Err(Unstable::NotAtRest);
    }
    let moved = settled.displacements_m.iter().zip(&bodies).find(|(moved_m, _)| **moved_m > MAX_SETTLING_M);
    if let Some((&moved_m, body)) = moved {
        return Err(Unstable::Moved { name: body.name.clone(), moved_m });
    }
    for (object, pose) in scene.objects.iter_mut().zip(&settled.poses[1..]) {
        object.world_from_object = *pose;
    }
    Ok(scene)
}

#[expect(clippy::too_many_arguments, reason = "all that is known of an attempt")]
fn recorded(
    setup: &Setup,
    work: &Work,
    number: u64,
    seed: u64,
    sample: &Sample,
    scene: &TaskScene,
    execution: &Execution,
    outcome: Outcome,
) -> Result<Option<Box<EpisodeUnit>>, EpisodeError> {
    let recording = &execution.recording;
    let window = motion_window(&recording.frames, recording.rate_hz);
    // The action of a frame is what is asked for at the next.
    let frames = &recording.frames[window];
    if frames.len() < 2 {
        return Ok(None);
    }
    let description = &setup.description;
    let initial = scene.objects.iter().map(|object| (object.name.clone(), object.world_from_object));
    let task_index = setup.task_of(number);
    let record = EpisodeRecord {
        format: record::FORMAT.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        scene: setup.scene_digest.clone(),
        task: work.task.clone(),
        task_index,
        tasks: description.tasks().to_vec(),
        dataset_seed: setup.seed,
        number,
        fps: description.fps(),
        depth: description.cameras().iter().any(|camera| camera.depth),
        instance_ids: description.cameras().iter().any(|camera| camera.instance_ids.is_some()),
        points: description.points(),
        cameras: setup.cameras.clone(),
        randomization: setup.randomization,
        world_from_base: work.world_from_base,
        sample: sample.clone(),
        initial_poses: initial.collect(),
        instances: setup.instances(),
        begins_s: frames[0].time_s,
        picks: record::picks(&execution.picks),
    };
    let record = serde_json::to_value(record).unwrap_or_default();
    let header = EpisodeHeader { number, seed, task: task_index, record };
    let mut encoder = EpisodeEncoder::new(description, &setup.formats, header)?;
    let props = Props::new(setup, work, sample);
    let has_cameras = !setup.cameras.is_empty();
    let mut stage =
        has_cameras.then(|| Stage::new(setup, work, sample, &props, recording, &frames[..frames.len() - 1]));
    for (now, vectors) in frames.iter().zip(frame_vectors(&setup.robot, frames)) {
        let images = |stage: &mut Stage| stage.images(&props, recording, now);
        let views: Vec<CameraView> = stage.as_mut().map(images).unwrap_or_default();
        let cameras: Vec<CameraFrame> = views
            .iter()
            .zip(description.cameras())
            .map(|(view, camera)| CameraFrame {
                image: &view.image,
                depth_m: camera.depth.then_some(view.depth_m.as_slice()),
                instance_ids: camera.instance_ids.is_some().then_some(view.ids.as_slice()),
                intrinsics: view.intrinsics,
                world_from_camera: view.world_from_camera,
            })
            .collect();
        let points = description.points().map(|count| points(&views, count as usize));
        let points = points.as_ref().map(|points| PointCloud {
            positions_m: &points.positions_m,
            colors: &points.colors,
            instance_ids: &points.instance_ids,
        });
        let (state, action, servo_command) = (&vectors.state, &vectors.action, &vectors.servo_command);
        encoder.add(&Frame { state, action, servo_command, cameras: &cameras, points })?;
    }
    encoder.finish(outcome).map(|unit| Some(Box::new(unit)))
}
