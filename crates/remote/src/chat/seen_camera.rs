//! The camera of a picture, from what a model judges: its angles, and the box around the table's top.
//!
//! Method: the camera stands on a sphere about a point of the table's plane. Its distance is scaled until the outline of
//! a top of the given size, as it would be seen, is as wide as the box; the point is moved until the two have the same
//! middle; both together, a few dozen times (each step is exact for a small picture of the table). Inputs: angles in
//! radians, box in shares of the picture, size in meters; the world's origin is the middle of the top.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use geometry::Camera;
use scene::TableShape;

/// Rounds of fitting; six suffice at 60 degrees, low cameras with wide views take more.
const ROUNDS: usize = 60;

/// Distances that are believed, meters.
const DISTANCE_M: [f64; 2] = [0.1, 50.0];

/// What a model judges.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SeenCamera {
    /// Above the horizon.
    pub elevation_rad: f64,
    /// 0 = looking along the table's depth, positive = from the right.
    pub azimuth_rad: f64,
    pub fov_x_rad: f64,
    /// Of the table's top: x0, y0, x1, y1, shares of the picture's width and height.
    pub table_box: [f64; 4],
}

/// The camera that sees the top in its box; `None` where there is none.
pub(super) fn placed(
    seen: &SeenCamera,
    width_px: u32,
    height_px: u32,
    table_m: DVec3,
    shape: TableShape,
) -> Option<Camera> {
    let outline = outline(table_m, shape);
    let (width, height) = (f64::from(width_px), f64::from(height_px));
    let [x0, y0, x1, y1] = seen.table_box;
    let wanted_width = (x1 - x0) * width;
    let wanted_middle = DVec2::new(0.5 * (x0 + x1) * width, 0.5 * (y0 + y1) * height);
    // Straight down, the picture's up would be undefined.
    let elevation_rad = seen.elevation_rad.min(1.55);
    let at = |target: DVec2, distance_m: f64| {
        let (fov, azimuth) = (seen.fov_x_rad, seen.azimuth_rad);
        Camera::orbit(width_px, height_px, fov, target.extend(0.0), azimuth, elevation_rad, distance_m)
    };
    let mut target = DVec2::ZERO;
    let mut distance_m = 2.0 * table_m.x.max(table_m.y) / (0.5 * seen.fov_x_rad).tan();
    for _ in 0..ROUNDS {
        let camera = at(target, distance_m);
        let Some([low, high]) = bounds(&camera, &outline) else {
            // Part of the table lies behind the camera.
            distance_m *= 1.5;
            continue;
        };
        distance_m *= ((high.x - low.x) / wanted_width).clamp(0.5, 2.0);
        let off = 0.5 * (low + high) - wanted_middle;
        let middle = DVec2::new(0.5 * width, 0.5 * height);
        if let Some(met) = camera.meet_plane(middle + off.clamp_length_max(0.25 * width), 0.0) {
            target = met.truncate();
        }
    }
    let camera = at(target, distance_m);
    let [low, high] = bounds(&camera, &outline)?;
    let close = (high.x - low.x - wanted_width).abs() < 0.02 * width
        && (0.5 * (low + high) - wanted_middle).abs().max_element() < 0.02 * width;
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
    fn a_known_camera_is_found_again_from_its_angles_and_the_box() {
        let size = DVec3::new(1.2, 0.8, 0.75);
        for (elevation, azimuth, fov, aim, distance, shape) in [
            (0.8, 0.2, 0.61, DVec2::ZERO, 2.2, TableShape::Rectangular),
            (0.45, -0.4, 0.9, DVec2::new(0.1, -0.15), 1.6, TableShape::Rectangular),
            (1.2, 0.0, 0.5, DVec2::new(-0.1, 0.1), 2.5, TableShape::Oval),
            (1.5, 0.3, 1.1, DVec2::new(0.05, 0.0), 1.4, TableShape::Rectangular),
        ] {
            let camera = Camera::orbit(960, 720, fov, aim.extend(0.0), azimuth, elevation, distance);
            let [low, high] = bounds(&camera, &outline(size, shape)).expect("is before the camera");
            let seen = SeenCamera {
                elevation_rad: elevation,
                azimuth_rad: azimuth,
                fov_x_rad: fov,
                table_box: [low.x / 960.0, low.y / 720.0, high.x / 960.0, high.y / 720.0],
            };
            let found = placed(&seen, 960, 720, size, shape).expect("there is one");
            let off =
                (found.world_from_camera.translation_m - camera.world_from_camera.translation_m).length();
            assert!(off < 0.01 * distance, "{elevation} {fov}: {off}");
        }
    }

    #[test]
    fn nonsense_is_no_camera() {
        let seen = SeenCamera {
            elevation_rad: 0.1,
            azimuth_rad: 0.0,
            fov_x_rad: 1.9,
            table_box: [0.0, 0.0, 1e-9, 1.0],
        };
        assert_eq!(placed(&seen, 960, 720, DVec3::new(1.0, 1.0, 0.7), TableShape::Round), None);
    }
}
