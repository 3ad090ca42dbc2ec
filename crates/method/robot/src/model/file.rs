//! The format of a robot's file, `config/robots/<name>.toml`, before it is checked; `docs/robots.md` explains it.
//!
//! Unknown keys are errors. Positions are in meters, `rpy_deg` turns about the fixed axes x, y and z in this order, in
//! degrees, as URDF does in radians. Positions of joints are in radians, or meters where a joint slides.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::model::limits::JointLimits;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotFile {
    pub name: String,
    /// The name that the manufacturer gives it.
    pub title: String,
    /// Sources of the numbers, and changes made to them.
    pub sources: Vec<String>,
    /// Colors in sRGB, each channel in 0..=1.
    pub materials: BTreeMap<String, [f64; 3]>,
    /// Maximum distance by which the computed spheres may stick out of the shapes, meters, where a link states nothing
    /// else.
    pub sphere_tolerance_m: f64,
    /// The base first; each other link after its parent.
    pub links: Vec<LinkFile>,
    pub gripper: GripperFile,
    pub tool: ToolFile,
    pub home: HomeFile,
    #[serde(default)]
    pub ignored_pairs: Vec<IgnoredPairFile>,
    #[serde(default)]
    pub variants: BTreeMap<String, VariantFile>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LinkFile {
    pub name: String,
    /// The joint that carries the link; the base has none.
    pub joint: Option<JointFile>,
    pub inertia: Option<InertiaFile>,
    #[serde(default)]
    pub shapes: Vec<ShapeFile>,
    pub sphere_tolerance_m: Option<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum JointKindFile {
    Fixed,
    Revolute,
    Prismatic,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointFile {
    pub name: String,
    pub kind: JointKindFile,
    pub parent: String,
    pub origin: OriginFile,
    pub axis: Option<[f64; 3]>,
    pub limits: Option<LimitsFile>,
    pub mimic: Option<MimicFile>,
    pub drive: Option<DriveFile>,
}

/// Frame of a joint in the frame of its parent link, at position zero.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum OriginFile {
    Pose(PoseFile),
    /// Craig's parameters: turn about x by alpha, move along x by a, turn about z by theta, move along z by d.
    ModifiedDh(ModifiedDhFile),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseFile {
    pub xyz_m: [f64; 3],
    #[serde(default)]
    pub rpy_deg: [f64; 3],
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModifiedDhFile {
    pub alpha_deg: f64,
    pub a_m: f64,
    pub theta_deg: f64,
    pub d_m: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitsFile {
    pub position: [f64; 2],
    pub velocity: f64,
    pub acceleration: f64,
    pub jerk: f64,
    pub effort: f64,
}

impl From<LimitsFile> for JointLimits {
    fn from(file: LimitsFile) -> Self {
        Self {
            min_position: file.position[0],
            max_position: file.position[1],
            max_velocity: file.velocity,
            max_acceleration: file.acceleration,
            max_jerk: file.jerk,
            max_effort: file.effort,
        }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MimicFile {
    pub joint: String,
    pub multiplier: f64,
    #[serde(default)]
    pub offset: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DriveFile {
    /// Of the position servo: newton meters per radian, or newtons per meter.
    pub stiffness: f64,
    /// Of the position servo: newton meter seconds per radian, or newton seconds per meter.
    pub damping: f64,
    /// Of the joint itself, in the same unit.
    pub joint_damping: f64,
    /// Dry friction: newton meters, or newtons.
    pub joint_friction: f64,
    /// Inertia of the rotor behind the gear: kilogram square meters, or kilograms.
    pub armature: f64,
}

/// Without `center_m` and `moments_kg_m2`, both are those of the link's shapes as solids of one density.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InertiaFile {
    pub mass_kg: f64,
    pub center_m: Option<[f64; 3]>,
    /// About the center of mass along the axes of the link: xx, xy, xz, yy, yz, zz.
    pub moments_kg_m2: Option<[f64; 6]>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum RoleFile {
    #[default]
    Both,
    Visual,
    Collision,
}

/// One of the four primitives, with its material.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShapeFile {
    pub material: String,
    #[serde(default)]
    pub role: RoleFile,
    /// Whether it is where a finger touches what it holds.
    #[serde(default)]
    pub pad: bool,
    #[serde(rename = "box")]
    pub cuboid: Option<BoxFile>,
    pub cylinder: Option<RoundFile>,
    pub capsule: Option<RoundFile>,
    pub sphere: Option<SphereFile>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxFile {
    pub center_m: [f64; 3],
    pub size_m: [f64; 3],
    #[serde(default)]
    pub rpy_deg: [f64; 3],
}

/// The axis of a cylinder, or the line between the centers of a capsule's ends.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RoundFile {
    pub from_m: [f64; 3],
    pub to_m: [f64; 3],
    pub radius_m: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereFile {
    pub center_m: [f64; 3],
    pub radius_m: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GripperFile {
    pub joint: String,
    pub opening_per_position: f64,
    pub grip_force_n: f64,
    pub max_force_n: f64,
    pub pad_friction: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ToolFile {
    pub name: String,
    pub link: String,
    pub xyz_m: [f64; 3],
    #[serde(default)]
    pub rpy_deg: [f64; 3],
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HomeFile {
    pub positions: Vec<f64>,
    pub opening_m: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IgnoredPairFile {
    pub links: [String; 2],
    pub reason: String,
}

/// Changes of a variant to the joints that it names.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VariantFile {
    pub reason: String,
    pub joints: BTreeMap<String, JointChangeFile>,
    pub home: Option<HomeFile>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointChangeFile {
    pub origin: Option<OriginFile>,
    pub limits: Option<LimitsFile>,
}
