//! Mass properties and friction of a rigid body.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Mass, center of mass and inertia in the object's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MassProperties {
    pub mass_kg: f64,
    pub center_of_mass_m: DVec3,
    /// Principal moments about the center of mass, positive and obeying the triangle inequality.
    pub inertia_diagonal_kg_m2: DVec3,
    /// `object_from_principal`: rotates principal axes into the object's frame.
    pub principal_axes_xyzw: DQuat,
}

/// Coulomb friction coefficients of the surface against an equal one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename = "friction")]
pub struct Friction {
    #[serde(rename = "static")]
    pub static_coefficient: f64,
    #[serde(rename = "dynamic")]
    pub dynamic_coefficient: f64,
}
