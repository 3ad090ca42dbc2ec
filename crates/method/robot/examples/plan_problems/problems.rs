//! The file of problems: an arm, and for each problem a world, a start and goals.

use std::error::Error;
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use robot::collision::{Arm, ArmBody, ArmJoint, JointMotion, Obstacle, Sphere};
use robot::model::limits::JointLimits;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemFile {
    pub arm: ArmEntry,
    pub problems: Vec<ProblemEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmEntry {
    joints: Vec<JointEntry>,
    bodies: Vec<BodyEntry>,
    /// Bodies, by index, that must not touch.
    pairs: Vec<(usize, usize)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointEntry {
    translation_m: [f64; 3],
    /// Roll, pitch and yaw about the fixed axes of the parent.
    rpy_rad: [f64; 3],
    min_position: f64,
    max_position: f64,
    max_velocity: f64,
    max_acceleration: f64,
    max_jerk: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyEntry {
    frame: usize,
    /// Center and radius.
    spheres_m: Vec<[f64; 4]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemEntry {
    pub name: String,
    pub set: String,
    pub start: Vec<f64>,
    pub goals: Vec<Vec<f64>>,
    pub obstacles: Vec<ObstacleEntry>,
}

/// A solid; `axes[k]` is its axis `k` in the frame of the base.
#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ObstacleEntry {
    Cuboid { center_m: [f64; 3], axes: [[f64; 3]; 3], half_extents_m: [f64; 3] },
    Cylinder { center_m: [f64; 3], axes: [[f64; 3]; 3], radius_m: f64, half_length_m: f64 },
    Capsule { center_m: [f64; 3], axes: [[f64; 3]; 3], radius_m: f64, half_length_m: f64 },
    Sphere { center_m: [f64; 3], radius_m: f64 },
}

impl ProblemFile {
    pub fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        Ok(serde_json::from_slice(&std::fs::read(path)?)?)
    }
}

impl ArmEntry {
    pub fn build(&self) -> Result<Arm, Box<dyn Error>> {
        let joint = |entry: &JointEntry| {
            let [roll, pitch, yaw] = entry.rpy_rad;
            ArmJoint {
                parent_from_joint: Isometry3::from_parts(
                    Translation3::from(entry.translation_m),
                    UnitQuaternion::from_euler_angles(roll, pitch, yaw),
                ),
                motion: JointMotion::Turn,
                limits: JointLimits {
                    min_position: entry.min_position,
                    max_position: entry.max_position,
                    max_velocity: entry.max_velocity,
                    max_acceleration: entry.max_acceleration,
                    max_jerk: entry.max_jerk,
                    max_effort: 1.0,
                },
            }
        };
        let body = |entry: &BodyEntry| ArmBody {
            frame: entry.frame,
            spheres: entry
                .spheres_m
                .iter()
                .map(|&[x, y, z, radius_m]| Sphere { center_m: Point3::new(x, y, z), radius_m })
                .collect(),
        };
        let joints = self.joints.iter().map(joint).collect();
        Ok(Arm::new(joints, self.bodies.iter().map(body).collect(), self.pairs.clone())?)
    }
}

impl ObstacleEntry {
    pub fn build(&self) -> Result<Obstacle, Box<dyn Error>> {
        let placed = |center_m: &[f64; 3], axes: &[[f64; 3]; 3]| {
            let matrix = Matrix3::from_columns(&axes.map(Vector3::from));
            let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&matrix));
            Isometry3::from_parts(Translation3::from(*center_m), rotation)
        };
        Ok(match self {
            Self::Cuboid { center_m, axes, half_extents_m } => {
                Obstacle::cuboid(placed(center_m, axes), Vector3::from(*half_extents_m))?
            }
            Self::Cylinder { center_m, axes, radius_m, half_length_m } => {
                Obstacle::cylinder(placed(center_m, axes), *radius_m, *half_length_m)?
            }
            Self::Capsule { center_m, axes, radius_m, half_length_m } => {
                Obstacle::capsule(placed(center_m, axes), *radius_m, *half_length_m)?
            }
            Self::Sphere { center_m, radius_m } => Obstacle::sphere(Point3::from(*center_m), *radius_m)?,
        })
    }
}
