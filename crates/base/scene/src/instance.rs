//! One object of the finished scene.

use std::f64::consts::PI;

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Friction, InstanceId, MassProperties, StandIn};
use crate::description::RelationKind;
use crate::grasps::GraspFile;
use crate::stand_in::Fields as StandInFields;
use geometry::Pose;
use geometry::json_numbers::{Fraction, Positive};

/// An instance of `scene.json`. The object frame is the frame of the canonical mesh: +z up, +y toward its back, origin
/// at the center of the bottom face of its axis-aligned box, meters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(
    description = "One movable object. Its frame: z up as it stands, y its back, origin at the center of the bottom face of its axis-aligned box."
)]
pub struct Instance {
    pub name: InstanceId,
    /// The user's words.
    pub label: String,
    pub category: String,
    /// The requested object that this instance replaces, where the catalog does not have it.
    #[serde(flatten, with = "crate::stand_in::fields")]
    #[schemars(with = "StandInFields")]
    pub stand_in: Option<StandIn>,
    pub image: ImageRegion,
    /// `world_from_object` (`translation_m`, `rotation_xyzw`).
    #[serde(flatten)]
    pub world_from_object: Pose,
    /// Rotation about world z (twist); `null` within 10 degrees of the singularity.
    #[schemars(range(min = -PI, max = PI))]
    pub yaw_rad: Option<f64>,
    /// Order of rotational symmetry about +z: 1 = none, n = every 360/n degrees, 0 = any angle.
    pub symmetry_order: u32,
    /// Factors from the unit mesh to meters. They are provenance: the mesh is already scaled.
    #[schemars(with = "[Positive; 3]")]
    pub scale: DVec3,
    /// Extents of the canonical mesh's axis-aligned box.
    #[schemars(with = "[Positive; 3]")]
    pub size_m: DVec3,
    #[serde(flatten)]
    pub mass: MassProperties,
    pub friction: Friction,
    #[schemars(with = "Fraction")]
    pub restitution: f64,
    pub support: Support,
    /// Number of convex collision hulls.
    #[schemars(range(min = 1))]
    pub hulls: u32,
    /// Path of the visual mesh (GLB) in the bundle.
    #[schemars(regex(pattern = r"^glb/[a-z0-9_]+\.glb$"))]
    pub mesh: String,
    /// Grasps of the request's robot that were stable, the best first. Absent where no robot was tried, or the object
    /// is not for grippers. `grasps/<name>.yaml` has the same as isaac_grasp, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grasps: Option<GraspFile>,
    pub provenance: Provenance,
}

/// Position of the instance in the reference image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ImageRegion {
    /// Box of its visible mask: x0, y0 inclusive; x1, y1 exclusive.
    pub bbox_px: [u32; 4],
}

/// Support of an instance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub struct Support {
    /// `table`, or the name of the supporting instance.
    #[schemars(with = "InstanceId")]
    pub parent: String,
    /// `on` or `in`.
    pub relation: SupportRelation,
}

/// Kind of support: on top of the supporter, or inside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SupportRelation {
    On,
    In,
}

impl From<SupportRelation> for RelationKind {
    fn from(relation: SupportRelation) -> Self {
        match relation {
            SupportRelation::On => Self::On,
            SupportRelation::In => Self::In,
        }
    }
}

/// Reconstruction method of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(description = "Method by which the shape of a mesh was found.")]
pub enum ReconstructionMethod {
    /// A parametric model of a catalog category.
    Category,
    /// A solid of revolution about a vertical axis.
    Turned,
    Box,
    /// A horizontal outline extruded upward.
    Slab,
    /// A vertical outline extruded in depth.
    Extrusion,
    /// An inflated outline, vertical or horizontal: thickness grows with width.
    Inflation,
    /// Generated from an image by a model.
    Generated,
}

/// Origin of the parts of an instance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// Port adapter and model that made the mesh (`embedded/catalog`).
    pub mesh_by: String,
    pub licence: String,
    /// Notes of the stages about completion, rescaling and movement.
    pub notes: Vec<String>,
}
