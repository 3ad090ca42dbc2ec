//! Mass properties and friction of a rigid body.

use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::json_numbers::Positive;

/// Mass, center of mass and inertia in the object's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MassProperties {
    #[schemars(with = "Positive")]
    pub mass_kg: f64,
    #[schemars(with = "[f64; 3]")]
    pub center_of_mass_m: DVec3,
    /// Principal moments about the center of mass, positive and obeying the triangle inequality.
    #[schemars(with = "[Positive; 3]")]
    pub inertia_diagonal_kg_m2: DVec3,
    /// `object_from_principal`: rotates principal axes into the object's frame.
    #[schemars(with = "[f64; 4]", inner(range(min = -1.000001, max = 1.000001)))]
    pub principal_axes_xyzw: DQuat,
}

impl MassProperties {
    /// The same distribution of another mass (positive).
    pub fn with_mass(self, mass_kg: f64) -> Self {
        let inertia_diagonal_kg_m2 = self.inertia_diagonal_kg_m2 * (mass_kg / self.mass_kg);
        Self { mass_kg, inertia_diagonal_kg_m2, ..self }
    }
}

/// Coulomb friction coefficients of the surface against an equal one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename = "friction")]
#[schemars(rename = "Friction")]
pub struct Friction {
    #[serde(rename = "static")]
    #[schemars(range(min = 0.0))]
    pub static_coefficient: f64,
    #[serde(rename = "dynamic")]
    #[schemars(range(min = 0.0))]
    pub dynamic_coefficient: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_mass_scales_the_inertia_and_keeps_the_center() {
        let found = MassProperties {
            mass_kg: 0.5,
            center_of_mass_m: DVec3::new(0.0, 0.01, 0.05),
            inertia_diagonal_kg_m2: DVec3::new(1.0, 2.0, 2.5),
            principal_axes_xyzw: DQuat::from_rotation_x(0.3),
        };
        let heavier = found.with_mass(2.0);
        assert_eq!((heavier.mass_kg, heavier.inertia_diagonal_kg_m2), (2.0, DVec3::new(4.0, 8.0, 10.0)));
        assert_eq!(heavier.center_of_mass_m, found.center_of_mass_m);
        assert_eq!(heavier.principal_axes_xyzw, found.principal_axes_xyzw);
    }
}
