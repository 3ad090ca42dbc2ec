//! The light of a scene that has another one than the usual studio.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::validation::{Violation, Violations};

/// A key light at infinity. The world's z axis points up, and y points to the back of the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(description = "The key light, where an edit changed it; without one, that of the usual studio.")]
pub struct Light {
    /// Direction in which the light stands: 0 = at the front edge, pi/2 = at +x; -6.3..6.3.
    #[schemars(range(min = -6.3, max = 6.3))]
    pub azimuth_rad: f64,
    /// Above the horizon, 0.2..1.5.
    #[schemars(range(min = 0.2, max = 1.5))]
    pub elevation_rad: f64,
    /// Of the usual brightness, 0.3..2.
    #[schemars(range(min = 0.3, max = 2.0))]
    pub intensity: f64,
}

impl Light {
    /// Near that of the usual studio and of its rooms for a viewer at the front edge: from the left, above.
    pub const USUAL: Self = Self { azimuth_rad: -0.7, elevation_rad: 0.9, intensity: 1.0 };

    /// Every value that is out of its range.
    pub fn violations(&self) -> Vec<Violation> {
        let mut violations = Violations::default();
        let azimuth = (-6.3..=6.3).contains(&self.azimuth_rad);
        violations.require(azimuth, "/azimuth_rad", "must be from -6.3 to 6.3 radians");
        let elevation = (0.2..=1.5).contains(&self.elevation_rad);
        violations.require(elevation, "/elevation_rad", "must be from 0.2 to 1.5 radians");
        let intensity = (0.3..=2.0).contains(&self.intensity);
        violations.require(intensity, "/intensity", "must be from 0.3 to 2");
        violations.into_vec()
    }

    /// Unit vector from the scene toward the light, in the world.
    pub fn toward_light(&self) -> DVec3 {
        let (sin, cos) = self.azimuth_rad.sin_cos();
        DVec3::new(sin * self.elevation_rad.cos(), -cos * self.elevation_rad.cos(), self.elevation_rad.sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuth_counts_from_the_front_edge_to_the_right() {
        let toward = |azimuth_rad| Light { azimuth_rad, elevation_rad: 0.5, intensity: 1.0 }.toward_light();
        assert!(toward(0.0).y < -0.8 && toward(0.0).x.abs() < 1e-12, "at the front");
        assert!(toward(std::f64::consts::FRAC_PI_2).x > 0.8, "at the right");
        assert!((toward(1.0).length() - 1.0).abs() < 1e-12 && toward(1.0).z > 0.4);
    }
}
