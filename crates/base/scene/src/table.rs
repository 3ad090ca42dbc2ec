//! The table: requested properties, and the table of the finished scene.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use geometry::{Friction, MassProperties, Outline};

/// Shape of a table top.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TableShape {
    Rectangular,
    Square,
    Round,
    Oval,
    Triangular,
    /// Any other simple polygon.
    Irregular,
}

/// Requested properties of the table, from the analyst or the client. The catalog chooses absent ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TableSpec {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<TableShape>,
    /// Width (x), depth (y) of the top and height above the floor (z), meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_m: Option<DVec3>,
    /// Name of a table model of the catalog.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Name of a material, such as `oak`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// A color name of the text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<String>,
}

/// The table of a finished scene. Its mesh is an instance named `table` with its frame's origin at
/// the center of the top surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    pub name: String,
    pub label: String,
    pub shape: TableShape,
    /// Outline of the top surface in the world's xy plane.
    pub outline_m: Outline,
    /// Top surface above the floor.
    pub height_m: f64,
    /// Catalog model of its mesh.
    pub model: String,
    /// Extents of its mesh.
    pub size_m: DVec3,
    #[serde(flatten)]
    pub mass: MassProperties,
    pub friction: Friction,
    pub restitution: f64,
    /// Number of convex collision hulls.
    pub hulls: u32,
    /// Path of the visual mesh (GLB) in the bundle.
    pub mesh: String,
}

impl Table {
    /// Corners of the outline at z = 0.
    pub fn corners_in_world(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.outline_m.corners().iter().map(|c: &DVec2| c.extend(0.0))
    }
}
