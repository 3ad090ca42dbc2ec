//! After `resolve`, where the request names a robot, for each object that is for grippers: grasps that hold it.
//!
//! The object stands alone on a plane, turned as it rests in the scene. Its place and its yaw decide no grasp, and its
//! tilt is rounded to a milliradian, so that equal objects share their grasps: within a scene they are tried once, and
//! variants and edits find those of their parent. For the same reason the random numbers come from the digest of the
//! hulls and not from the seed of the request. What is near the object in the scene is for the stage `rehearse`.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Checkpoints, Stage};
use super::composition::{BodyParts, Composition};
use super::error::StageError;
use super::resources::StageResources;
use super::task_scene::is_graspable;
use super::{Context, artifact_io};
use geometry::{Friction, MassProperties, Pose};
use manipulation::grasp::{Grasp, GraspSettings, Verdict, grasps};
use physics::Body;
use robot::model::Robot;
use runtime::seed::child_rng;
use scene::InstanceId;
use store::Digest;

/// The version counts changes of the robots' files and of the simulation, too.
pub const STAGE: Stage = Stage { name: "grasp", version: 1 };

/// Most grasps of an object that are kept.
const MAX_KEPT: usize = 10;

/// The components of the direction of up are rounded to one part in this many.
const UP_STEPS: f64 = 1000.0;

#[derive(Serialize)]
pub struct Inputs {
    decisive: Decisive,
    /// Hulls whose digest is in `decisive`.
    #[serde(skip)]
    hulls: ArtifactRef,
}

/// Everything that decides the grasps of an object.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Decisive {
    robot: String,
    hulls: Digest,
    mass: MassProperties,
    friction: Friction,
    restitution: f64,
    rolling_friction_m: f64,
    /// The direction of up in the object's frame, rounded: how the object stands but for its yaw.
    up_in_object: DVec3,
    grasps: GraspSettings,
}

/// Stable grasps of one object in the frame of its hulls, the best first.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub grasps: Vec<Grasp>,
}

/// A built-in robot.
///
/// # Errors
///
/// `unknown_robot`.
pub(super) fn robot_named(name: &str) -> Result<Robot, StageError> {
    Robot::built_in(name, None).map_err(|error| {
        StageError::permanent("unknown_robot", format!("trying the robot of the request: {error}"))
    })
}

/// The stable grasps of each object of a composition; `None` of those that are not for grippers. Equal objects are
/// tried once, under the name of the first.
///
/// # Errors
///
/// The error of the first object that fails.
pub(super) async fn of_objects(
    stages: &Checkpoints<StageResources>,
    robot: &str,
    composition: &Composition,
    settings: &GraspSettings,
) -> Result<Vec<Option<Vec<Grasp>>>, StageError> {
    let mut different: Vec<(InstanceId, Inputs)> = Vec::new();
    let mut uses: Vec<Option<usize>> = Vec::with_capacity(composition.recognition.objects.len());
    for (recognized, body) in composition.recognition.objects.iter().zip(&composition.bodies[1..]) {
        if !is_graspable(&recognized.category) {
            uses.push(None);
            continue;
        }
        let inputs = Inputs::new(robot, body, settings);
        let known = different.iter().position(|(_, other)| other.decisive == inputs.decisive);
        uses.push(Some(known.unwrap_or(different.len())));
        if known.is_none() {
            let name = InstanceId::new(&body.resolved.name)
                .map_err(|error| StageError::permanent("invalid_name", error.to_string()))?;
            different.push((name, inputs));
        }
    }
    let found = stages.run_each(STAGE, different, run).await?;
    Ok(uses.into_iter().map(|index| Some(found[index?].grasps.clone())).collect())
}

impl Inputs {
    fn new(robot: &str, body: &BodyParts, settings: &GraspSettings) -> Self {
        let BodyParts { resolved, hulls, .. } = body;
        let physical = &resolved.physical;
        let up = resolved.settled.rotation.inverse() * DVec3::Z;
        Self {
            decisive: Decisive {
                robot: robot.to_owned(),
                hulls: hulls.digest.clone(),
                mass: physical.mass,
                friction: physical.friction,
                restitution: physical.restitution,
                rolling_friction_m: physical.rolling_friction_m,
                // Adding zero makes a negative zero positive.
                up_in_object: (up * UP_STEPS).round() / UP_STEPS + DVec3::ZERO,
                grasps: settings.clone(),
            },
            hulls: hulls.clone(),
        }
    }
}

impl Decisive {
    /// The pose of the object alone.
    fn standing(&self) -> Pose {
        let rotation = DQuat::from_rotation_arc(self.up_in_object.normalize(), DVec3::Z);
        Pose { translation_m: DVec3::ZERO, rotation }
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let hulls = artifact_io::hulls(&context, &inputs.hulls).await?;
    let robot = robot_named(&inputs.decisive.robot)?;
    let name = context.instance().map_or_else(String::new, ToString::to_string);
    let (object_name, given) = (name.clone(), inputs.clone());
    let found = context
        .cpu(move || {
            let decisive = &given.decisive;
            let object = Body {
                name: object_name,
                hulls,
                world_from_object: decisive.standing(),
                mass: decisive.mass,
                friction: decisive.friction,
                restitution: decisive.restitution,
                rolling_friction_m: decisive.rolling_friction_m,
                fixed: false,
            };
            let mut rng = child_rng(0, &format!("grasps of {}", decisive.hulls));
            grasps(&object, &robot, &decisive.grasps, &mut rng)
        })
        .await?;
    let mut grasps = found.map_err(|error| {
        StageError::permanent("no_grasp_trials", format!("trying grasps of {name}: {error}"))
    })?;
    grasps.retain(|grasp| grasp.verdict == Verdict::Stable);
    grasps.truncate(MAX_KEPT);
    let output = Output { grasps };
    context.put_json("grasps.json", &output).await?;
    Ok(output)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::certify::tests::body;
    use geometry::shapes::block;

    fn decisive(world_from_object: Pose) -> Decisive {
        let (parts, _) = body("cube_1", block(DVec3::splat(0.05)), world_from_object);
        let defaults: toml::Table = include_str!("../../config/default.toml").parse().expect("our own file");
        let settings: GraspSettings = defaults["grasps"].clone().try_into().expect("our own section");
        Inputs::new("panda", &parts, &settings).decisive
    }

    #[test]
    fn place_and_yaw_decide_no_grasp_and_tilt_does() {
        let tilted = |tilt_rad: f64, yaw_rad: f64, x_m: f64| {
            let rotation = DQuat::from_rotation_z(yaw_rad) * DQuat::from_rotation_x(tilt_rad);
            decisive(Pose { translation_m: DVec3::new(x_m, 0.1, 0.2), rotation })
        };
        let upright = tilted(0.0, 0.0, 0.0);
        assert_eq!(upright, tilted(1e-5, 2.0, 0.3));
        assert_eq!(upright.standing().rotation, DQuat::IDENTITY);
        assert_ne!(upright, tilted(0.2, 0.0, 0.0));
        assert_eq!(tilted(0.2, 0.0, 0.0), tilted(0.2, -1.3, 0.1));
        for tilt_rad in [0.2, 1.5, std::f64::consts::PI] {
            let standing = tilted(tilt_rad, 0.7, 0.0).standing();
            let up = DQuat::from_rotation_x(tilt_rad).inverse() * DVec3::Z;
            assert!((standing.rotation * up).angle_between(DVec3::Z) < 2e-3, "{tilt_rad}");
        }
    }
}
