//! A reader's estimate in the terms of the comparison.

use glam::DVec2;

use imaging::Mask;
use vision::ImageReading;

/// Estimated table. Lengths are in an arbitrary unit, one per image; table frame (origin at the center of the top).
#[derive(Clone, Debug, PartialEq)]
pub struct TableEstimate {
    /// The reader's scale.
    pub meters_per_unit: f64,
    pub elevation_rad: f64,
    pub azimuth_rad: f64,
    /// Edge of the top in the image, pixels.
    pub outline_px: Vec<DVec2>,
    /// Visible part of the top's outline, counter-clockwise, units.
    pub top: Vec<DVec2>,
    pub objects: Vec<ObjectEstimate>,
}

/// Estimated object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectEstimate {
    /// Visible pixels, in image size.
    pub mask: Mask,
    /// Footprint seen from above, units.
    pub footprint: Vec<DVec2>,
    /// Height above its support, units.
    pub height: f64,
    /// Assigned category, and the category assigned if the catalog lacks the object's own.
    pub label: Option<&'static str>,
    pub label_as_foreign: Option<&'static str>,
    /// Category assigned beside a text that names what is in the image, and whether it is one of the text.
    pub label_with_text: Option<&'static str>,
    pub named_by_text: bool,
}

impl From<&ImageReading> for TableEstimate {
    /// Objects on other objects are moved along their rays to where they rest, as in the pipeline.
    fn from(reading: &ImageReading) -> Self {
        let eye = reading.camera.world_from_camera.translation_m;
        let objects = reading
            .objects
            .iter()
            .map(|object| {
                let nearer = 1.0 - (support_height(reading, object.stands_on) / eye.z).clamp(0.0, 0.8);
                let toward_eye = |p: DVec2| eye.truncate() + nearer * (p - eye.truncate());
                ObjectEstimate {
                    mask: object.mask.clone(),
                    footprint: object.solid.footprint().into_iter().map(toward_eye).collect(),
                    height: nearer * object.solid.size.z,
                    label: None,
                    label_as_foreign: None,
                    label_with_text: None,
                    named_by_text: false,
                }
            })
            .collect();
        Self {
            meters_per_unit: 1.0,
            elevation_rad: reading.camera.elevation_rad(),
            azimuth_rad: reading.camera.azimuth_rad(),
            outline_px: reading.table.outline_px.clone(),
            top: reading.table.outline.clone(),
            objects,
        }
    }
}

/// Total height of the supports below an object, units.
fn support_height(reading: &ImageReading, support: Option<usize>) -> f64 {
    let (mut at, mut height) = (support, 0.0);
    for _ in 0..reading.objects.len() {
        let Some(below) = at.map(|k| &reading.objects[k]) else { break };
        height += below.solid.size.z;
        at = below.stands_on;
    }
    height
}
