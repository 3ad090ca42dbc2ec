//! The table: requested properties, and the table of the finished scene.

use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::InstanceId;
use geometry::json_numbers::{Fraction, Positive};
use geometry::{Friction, MassProperties, Outline};

/// Shape of a table top.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(description = "Outline of the top of the table.")]
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(description = "Properties of the table; the catalog chooses those that are absent.")]
pub struct TableSpec {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<TableShape>,
    /// Width (x), depth (y) of the top and height above the floor (z), meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<TableSize>")]
    pub size_m: Option<DVec3>,
    /// Name of a table model of the catalog.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 63))]
    pub model: Option<String>,
    /// Name of a material, such as `oak`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 63))]
    pub material: Option<String>,
    /// A color name of the text.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 63))]
    pub color: Option<String>,
}

/// Width and depth of the top and its height above the floor, meters.
#[derive(JsonSchema)]
#[schemars(inline)]
#[expect(dead_code, reason = "the schema of a field")]
struct TableSize(
    #[schemars(range(min = 0.2, max = 5.0))] f64,
    #[schemars(range(min = 0.2, max = 5.0))] f64,
    #[schemars(range(min = 0.1, max = 2.0))] f64,
);

/// The table of a finished scene. Its mesh is an instance named `table` with its frame's origin at
/// the center of the top surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "The table of a finished scene; its frame is the world's.")]
pub struct Table {
    #[schemars(with = "InstanceId")]
    pub name: String,
    pub label: String,
    pub shape: TableShape,
    /// Outline of the top surface in the world's xy plane.
    #[schemars(with = "Vec<[f64; 2]>", length(min = 3))]
    pub outline_m: Outline,
    /// Top surface above the floor.
    #[schemars(with = "Positive")]
    pub height_m: f64,
    /// Catalog model of its mesh.
    pub model: String,
    /// Extents of its mesh.
    #[schemars(with = "[Positive; 3]")]
    pub size_m: DVec3,
    #[serde(flatten)]
    pub mass: MassProperties,
    pub friction: Friction,
    #[schemars(with = "Fraction")]
    pub restitution: f64,
    /// Number of convex collision hulls.
    #[schemars(range(min = 1))]
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
