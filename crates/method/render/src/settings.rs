//! Quality settings of the renderer.

use serde::{Deserialize, Serialize};

/// Quality of [`render`](super::render); none of these moves a depth or an id.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RenderSettings {
    /// Color samples along each side of a pixel, 1..4. 2 smooths edges at about three times the cost.
    pub supersampling: u32,
    /// Side of the key light's shadow map, texels, 128..4096; more gives crisper contact shadows, 0 = no
    /// shadows.
    pub shadow_map_px: u32,
    /// Occlusion-tested directions of the sky, 0..64; more gives smoother contact darkening, 0 = none.
    pub sky_directions: u32,
    /// Side of each sky direction's occlusion map, texels, 32..1024; more gives tighter darkening.
    pub sky_map_px: u32,
}

impl RenderSettings {
    /// For the many images of a motion: smooth edges, and no shadows of the sky, which cost most.
    pub const MOTION: Self = Self { supersampling: 2, shadow_map_px: 512, sky_directions: 0, sky_map_px: 32 };
}
