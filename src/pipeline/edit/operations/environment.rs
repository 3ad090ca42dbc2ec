//! Light and camera.

use std::sync::Arc;

use super::Done;
use crate::pipeline::edit::draft::Draft;
use scene::edit::CameraMove;
use scene::{CameraKnowledge, Light};

/// The camera stays this far above the table top and below the zenith, radians.
const ELEVATION_RAD: (f64, f64) = (0.1, 1.5);

pub(super) fn relight(draft: &mut Draft, light: Light) -> Done {
    draft.composition.light = Some(light);
    let (azimuth, elevation) = (light.azimuth_rad.to_degrees(), light.elevation_rad.to_degrees());
    let words = format!(
        "moved the light to azimuth {azimuth:.0}° and elevation {elevation:.0}°, {:.0} % as bright as usual",
        100.0 * light.intensity
    );
    Ok((Vec::new(), words))
}

pub(super) fn move_camera(draft: &mut Draft, change: &CameraMove) -> Done {
    let recognition = Arc::make_mut(&mut draft.composition.recognition);
    let before = recognition.camera;
    let elevation_rad = before.elevation_rad();
    let raised_rad = elevation_rad + change.raise_rad.unwrap_or(0.0);
    let raise_rad = raised_rad.clamp(ELEVATION_RAD.0, ELEVATION_RAD.1.max(elevation_rad)) - elevation_rad;
    let mut camera = before.orbited(change.turn_rad.unwrap_or(0.0), raise_rad);
    camera.world_from_camera.translation_m *= change.distance_factor.unwrap_or(1.0);
    let focal = change.focal_factor.unwrap_or(1.0);
    (camera.fx, camera.fy) = (camera.fx * focal, camera.fy * focal);
    recognition.camera = camera;
    recognition.camera_is = CameraKnowledge::Known;
    let words = format!(
        "moved the camera by {:.0}° around the table and {:.0}° up",
        change.turn_rad.unwrap_or(0.0).to_degrees(),
        raise_rad.to_degrees()
    );
    Ok((Vec::new(), words))
}
