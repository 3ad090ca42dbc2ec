//! One object of the finished scene.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{Friction, InstanceId, MassProperties};
use geometry::Pose;

/// An instance as `scene.json` tells it. The object's frame is the canonical mesh's: +z up as it
/// stands, +y its back, origin at the center of the bottom face of its axis-aligned box, meters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instance {
    pub name: InstanceId,
    pub label: String,
    pub category: String,
    pub picture: Picture,
    /// `world_from_object` (`translation_m`, `rotation_xyzw`).
    #[serde(flatten)]
    pub world_from_object: Pose,
    /// Twist of the rotation about world z; `null` within 10 degrees of singular.
    pub yaw_rad: Option<f64>,
    /// Order of rotational symmetry about +z: 1 = none, n = every 360/n degrees, 0 = any angle.
    pub symmetry_order: u32,
    /// Factors that took the unit mesh to meters; provenance, never applied again.
    pub scale: DVec3,
    /// Extents of the canonical mesh's axis-aligned box.
    pub size_m: DVec3,
    #[serde(flatten)]
    pub mass: MassProperties,
    pub friction: Friction,
    pub restitution: f64,
    pub support: Support,
    /// Number of convex collision hulls.
    pub hulls: u32,
    /// Path of the visual mesh (GLB) in the bundle.
    pub mesh: String,
    pub provenance: Provenance,
}

/// Where the instance appears in the reference picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Box of its visible mask: x0, y0 inclusive; x1, y1 exclusive.
    pub bbox_px: [u32; 4],
}

/// What carries an instance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub struct Support {
    /// `table`, or the name of the instance it stands on or in.
    pub parent: String,
    /// `on` or `in`.
    pub relation: SupportRelation,
}

/// How a supporter carries an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SupportRelation {
    On,
    In,
}

/// How the shape of a mesh was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReconstructionMethod {
    /// A parametric category of the catalog.
    Category,
    /// A profile turned about an upright axis.
    Turned,
    Box,
    /// An outline on the table, raised.
    Slab,
    /// An upright outline with depth.
    Extrusion,
    /// An outline, upright or on the table, blown up: the wider, the thicker.
    Inflation,
    /// A model made it from a picture.
    Generated,
}

/// Who made the parts of an instance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Port adapter and model that made the mesh (`embedded/catalog`).
    pub mesh_by: String,
    pub licence: String,
    /// Free notes of the stages: what was completed, rescaled, moved.
    pub notes: Vec<String>,
}
