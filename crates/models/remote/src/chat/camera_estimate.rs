//! The camera of an image from a model's estimates: its angles and the box of the table top.
//!
//! Method: the camera lies on a sphere about a target point of the table plane. Alternately, its distance is scaled
//! until the projected outline of the table top is as wide as the box, and the target is moved until the centers
//! coincide. Each step is exact in the limit of a small projection of the table. Inputs: angles in radians, box in
//! shares of the image size, table size in meters; the world origin is the center of the top.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use geometry::Camera;
use scene::TableShape;

/// Fitting iterations; six suffice at 60 degrees, low cameras with wide views need more.
const ROUNDS: usize = 60;

/// Range of plausible distances, meters.
const DISTANCE_M: [f64; 2] = [0.1, 50.0];

/// The estimates of a model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CameraEstimate {
    /// Above the horizon.
    pub elevation_rad: f64,
    /// 0 = looking along the table's depth, positive = from the right.
    pub azimuth_rad: f64,
    pub fov_x_rad: f64,
    /// Box of the table top: x0, y0, x1, y1, shares of the width and height of the image.
    pub table_box: [f64; 4],
}

/// The camera whose view of the top fills its box; `None` where the fit does not converge.
pub(super) fn fit_camera(
    estimate: &CameraEstimate,
    width_px: u32,
    height_px: u32,
    table_m: DVec3,
    shape: TableShape,
) -> Option<Camera> {
    let outline = outline(table_m, shape);
    let (width, height) = (f64::from(width_px), f64::from(height_px));
    let [x0, y0, x1, y1] = estimate.table_box;
    let wanted_width = (x1 - x0) * width;
    let wanted_center = DVec2::new(0.5 * (x0 + x1) * width, 0.5 * (y0 + y1) * height);
    // Straight down, the up direction of the image is undefined.
    let elevation_rad = estimate.elevation_rad.min(1.55);
    let at = |target: DVec2, distance_m: f64| {
        let (fov, azimuth) = (estimate.fov_x_rad, estimate.azimuth_rad);
        Camera::orbit(width_px, height_px, fov, target.extend(0.0), azimuth, elevation_rad, distance_m)
    };
    let mut target = DVec2::ZERO;
    let mut distance_m = 2.0 * table_m.x.max(table_m.y) / (0.5 * estimate.fov_x_rad).tan();
    for _ in 0..ROUNDS {
        let camera = at(target, distance_m);
        let Some([low, high]) = bounds(&camera, &outline) else {
            // Part of the table lies behind the camera.
            distance_m *= 1.5;
            continue;
        };
        distance_m *= ((high.x - low.x) / wanted_width).clamp(0.5, 2.0);
        let off = 0.5 * (low + high) - wanted_center;
        let center = DVec2::new(0.5 * width, 0.5 * height);
        if let Some(met) = camera.meet_plane(center + off.clamp_length_max(0.25 * width), 0.0) {
            target = met.truncate();
        }
    }
    let camera = at(target, distance_m);
    let [low, high] = bounds(&camera, &outline)?;
    let close = (high.x - low.x - wanted_width).abs() < 0.02 * width
        && (0.5 * (low + high) - wanted_center).abs().max_element() < 0.02 * width;
    (close && (DISTANCE_M[0]..=DISTANCE_M[1]).contains(&distance_m)).then_some(camera)
}

/// Points along the edge of the top.
fn outline(table_m: DVec3, shape: TableShape) -> Vec<DVec3> {
    let half = 0.5 * table_m.truncate();
    match shape {
        TableShape::Round | TableShape::Oval => (0..32)
            .map(|k| DVec2::from_angle(TAU * f64::from(k) / 32.0) * half)
            .map(|point| point.extend(0.0))
            .collect(),
        _ => [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| (DVec2::new(x, y) * half).extend(0.0))
            .into(),
    }
}

fn bounds(camera: &Camera, outline: &[DVec3]) -> Option<[DVec2; 2]> {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for point in outline {
        let (pixel, _) = camera.project(*point)?;
        (low, high) = (low.min(pixel), high.max(pixel));
    }
    Some([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fit_camera_recovers_a_known_camera() {
        let size = DVec3::new(1.2, 0.8, 0.75);
        for (elevation, azimuth, fov, aim, distance, shape) in [
            (0.8, 0.2, 0.61, DVec2::ZERO, 2.2, TableShape::Rectangular),
            (0.45, -0.4, 0.9, DVec2::new(0.1, -0.15), 1.6, TableShape::Rectangular),
            (1.2, 0.0, 0.5, DVec2::new(-0.1, 0.1), 2.5, TableShape::Oval),
            (1.5, 0.3, 1.1, DVec2::new(0.05, 0.0), 1.4, TableShape::Rectangular),
        ] {
            let camera = Camera::orbit(960, 720, fov, aim.extend(0.0), azimuth, elevation, distance);
            let [low, high] = bounds(&camera, &outline(size, shape)).expect("is before the camera");
            let estimate = CameraEstimate {
                elevation_rad: elevation,
                azimuth_rad: azimuth,
                fov_x_rad: fov,
                table_box: [low.x / 960.0, low.y / 720.0, high.x / 960.0, high.y / 720.0],
            };
            let found = fit_camera(&estimate, 960, 720, size, shape).expect("there is one");
            let off =
                (found.world_from_camera.translation_m - camera.world_from_camera.translation_m).length();
            assert!(off < 0.01 * distance, "{elevation} {fov}: {off}");
        }
    }

    #[test]
    fn fit_camera_rejects_an_impossible_box() {
        let estimate = CameraEstimate {
            elevation_rad: 0.1,
            azimuth_rad: 0.0,
            fov_x_rad: 1.9,
            table_box: [0.0, 0.0, 1e-9, 1.0],
        };
        assert_eq!(fit_camera(&estimate, 960, 720, DVec3::new(1.0, 1.0, 0.7), TableShape::Round), None);
    }
}
