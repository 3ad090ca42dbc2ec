//! The directional light of MJCF and SDF files.

use crate::number::spaced;
use scene::Scene;

/// Attributes of the light, as the formats write them.
pub(crate) struct Sun {
    /// Position at which a viewer draws the light, meters.
    pub position_m: String,
    /// The way the light travels.
    pub direction: String,
    /// Of each channel.
    pub brightness: String,
}

/// Distance from the center of the table top at which the light is drawn, meters.
const DISTANCE_M: f64 = 2.75;

impl Sun {
    /// The light of a scene; `usual_brightness` is that of the studio in this format.
    pub fn of(scene: &Scene, usual_brightness: f64) -> Self {
        let gray = |brightness: f64| spaced(&[brightness; 3]);
        match &scene.light {
            None => Self {
                position_m: "-0.6 -1 2.5".to_owned(),
                direction: "0.2 0.35 -1".to_owned(),
                brightness: gray(usual_brightness),
            },
            Some(light) => {
                let toward = light.toward_light();
                Self {
                    position_m: spaced(&(DISTANCE_M * toward).to_array()),
                    direction: spaced(&(-toward).to_array()),
                    brightness: gray((usual_brightness * light.intensity).min(1.0)),
                }
            }
        }
    }
}
