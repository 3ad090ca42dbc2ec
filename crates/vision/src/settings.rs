//! Knobs of [`read_picture`](super::read_picture).

use serde::{Deserialize, Serialize};

/// Sizes, thresholds and refusals of the classical reading of a picture. The values named as usual were
/// chosen on pictures of our own painter.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct VisionSettings {
    /// Longer side of the copy that is looked at, pixels, 256..1536; more finds thinner things and costs
    /// in proportion to the area. Usual: 768.
    pub work_px: u32,
    /// Horizontal field of view every picture is taken to have, radians, 0.2..1.6; a single frontal
    /// rectangle cannot tell it from the pitch. Usual: 0.6109 (35 degrees).
    pub fov_x_rad: f64,
    /// Share of the border that one smooth color must explain, 0..1; less accepts busier rooms and finds
    /// tables in them that are none. Usual: 0.6.
    pub backdrop_share: f64,
    /// CIELAB distance from the backdrop above which a pixel belongs to something, 2..30; less sees pale
    /// things and soft shadows alike. Usual: 6.
    pub backdrop_distance: f64,
    /// Standard deviations of the top's own color within which a pixel is taken for bare top, 2..6; more
    /// tolerates grain and eats things of the top's color. Usual: 3.2.
    pub surface_sigmas: f64,
    /// Least share of the picture the table top must fill, 0..1. Usual: 0.06.
    pub min_table_share: f64,
    /// Least overlap (intersection over union) of the bare top's hull with the rectangle or ellipse it is
    /// read as, 0..1; less reads other shapes as one of these. Usual: 0.9.
    pub min_outline_fit: f64,
    /// Largest distance of the outline from that of a level rectangle or circle under the camera found, as
    /// a share of the picture's longer side; more believes odder outlines. Usual: 0.02.
    pub max_outline_residual: f64,
    /// Brightness of a shadow relative to the bare top below which it is taken for a dark thing, 0..1.
    /// Usual: 0.22.
    pub shadow_darkest: f64,
    /// How far a shadow's color may stray from the top's, natural logarithm per channel; more eats things
    /// of the top's hue, less leaves shadows as things. Usual: 0.13.
    pub shadow_hue: f64,
    /// Least share of the picture an object must fill, 0..1. Usual: 0.0004.
    pub min_object_share: f64,
    /// Largest share of the table top one object may fill before the reading is refused, 0..1. Usual: 0.5.
    pub max_object_share: f64,
    /// Most objects that are believed, 1..64. Usual: 48.
    pub max_objects: u32,
}
