//! What a reader says a picture shows, in the terms that are compared.

use glam::DVec2;

use imaging::Mask;
use vision::PictureReading;

/// A table as read; lengths in a unit of the reader's own, one for the whole picture; frame of the table as
/// everywhere (origin at the middle of the top).
#[derive(Clone, Debug, PartialEq)]
pub struct TableRead {
    pub elevation_rad: f64,
    pub azimuth_rad: f64,
    /// Edge of the top in the picture, pixels.
    pub outline_px: Vec<DVec2>,
    /// What the picture shows of the top's outline, counter-clockwise, units.
    pub top: Vec<DVec2>,
    pub things: Vec<ThingRead>,
}

/// One thing as read.
#[derive(Clone, Debug, PartialEq)]
pub struct ThingRead {
    /// Pixels where it shows, as large as the picture.
    pub mask: Mask,
    /// What it covers seen from above, units.
    pub footprint: Vec<DVec2>,
    /// From its support up, units.
    pub height: f64,
    /// Category it is given, and the one it would be given if the catalog had none of its own.
    pub label: Option<&'static str>,
    pub label_as_foreign: Option<&'static str>,
}

impl From<&PictureReading> for TableRead {
    /// Things on things are moved up the rays to where they stand, as the pipeline does with them.
    fn from(reading: &PictureReading) -> Self {
        let eye = reading.camera.world_from_camera.translation_m;
        let things = reading
            .objects
            .iter()
            .map(|object| {
                let nearer = 1.0 - (lifted(reading, object.stands_on) / eye.z).clamp(0.0, 0.8);
                let toward_eye = |p: DVec2| eye.truncate() + nearer * (p - eye.truncate());
                ThingRead {
                    mask: object.mask.clone(),
                    footprint: object.solid.footprint().into_iter().map(toward_eye).collect(),
                    height: nearer * object.solid.size.z,
                    label: None,
                    label_as_foreign: None,
                }
            })
            .collect();
        Self {
            elevation_rad: reading.camera.elevation_rad(),
            azimuth_rad: reading.camera.azimuth_rad(),
            outline_px: reading.table.outline_px.clone(),
            top: reading.table.outline.clone(),
            things,
        }
    }
}

/// Height of everything below a thing, units.
fn lifted(reading: &PictureReading, support: Option<usize>) -> f64 {
    let (mut at, mut height) = (support, 0.0);
    for _ in 0..reading.objects.len() {
        let Some(below) = at.map(|k| &reading.objects[k]) else { break };
        height += below.solid.size.z;
        at = below.stands_on;
    }
    height
}
