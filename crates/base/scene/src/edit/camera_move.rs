//! Changes of the reference camera.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ANGLE, FACTOR, is_angle, is_factor};
use crate::validation::{Violation, Violations};

/// A change of the reference camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CameraMove {
    /// About the vertical axis through the center of the table, counter-clockwise seen from above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn_rad: Option<f64>,
    /// Upward, about the center of the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raise_rad: Option<f64>,
    /// Of the distance to the center of the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_factor: Option<f64>,
    /// Of the focal length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_factor: Option<f64>,
}

impl CameraMove {
    pub(super) fn violations(&self) -> Vec<Violation> {
        let mut violations = Violations::default();
        let any = self.turn_rad.is_some()
            || self.raise_rad.is_some()
            || self.distance_factor.is_some()
            || self.focal_factor.is_some();
        let needed = "give `turn_rad`, `raise_rad`, `distance_factor`, `focal_factor`, or several";
        violations.require(any, "", needed);
        violations.require(is_angle(self.turn_rad), "/turn_rad", ANGLE);
        let raise = self.raise_rad.is_none_or(|raise_rad| (-1.0..=1.0).contains(&raise_rad));
        violations.require(raise, "/raise_rad", "must be from -1 to 1 radian");
        violations.require(is_factor(self.distance_factor), "/distance_factor", FACTOR);
        violations.require(is_factor(self.focal_factor), "/focal_factor", FACTOR);
        violations.into_vec()
    }
}
