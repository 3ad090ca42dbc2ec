//! Lines, boxes and coordinate axes, with smooth edges.

use glam::{DVec2, DVec3};

use super::blend;
use geometry::{Camera, Pose};
use imaging::Image;

/// A straight line between two pixel positions.
pub fn draw_line(image: &mut Image, from: DVec2, to: DVec2, color: [u8; 4], width_px: f64) {
    let limit = 4.0 * f64::from(image.width_px().max(image.height_px()));
    if !from.is_finite() || !to.is_finite() || from.abs().max_element().max(to.abs().max_element()) > limit {
        return;
    }
    let half = 0.5 * width_px;
    let low = (from.min(to) - half - 1.0).max(DVec2::ZERO).floor();
    let high = (from.max(to) + half + 1.0)
        .min(DVec2::new(f64::from(image.width_px()), f64::from(image.height_px())))
        .ceil();
    let along = to - from;
    let length_squared = along.length_squared().max(1e-12);
    for y in low.y as i64..high.y as i64 {
        for x in low.x as i64..high.x as i64 {
            let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let t = ((p - from).dot(along) / length_squared).clamp(0.0, 1.0);
            let covered = (half + 0.5 - (p - from - t * along).length()).clamp(0.0, 1.0);
            if covered > 0.0 {
                blend(image, x, y, color, covered);
            }
        }
    }
}

/// Lines from point to point; `closed` joins the last to the first.
pub fn draw_polyline(image: &mut Image, points: &[DVec2], closed: bool, color: [u8; 4], width_px: f64) {
    for pair in points.windows(2) {
        draw_line(image, pair[0], pair[1], color, width_px);
    }
    if let (true, Some(&first), Some(&last)) = (closed && points.len() > 2, points.first(), points.last()) {
        draw_line(image, last, first, color, width_px);
    }
}

/// The box `[x0, y0, x1, y1]` (x1, y1 exclusive), its line just inside.
pub fn draw_box(image: &mut Image, bbox_px: [u32; 4], color: [u8; 4], width_px: u32) {
    let [x0, y0, x1, y1] = bbox_px.map(i64::from);
    let width = i64::from(width_px);
    for y in y0..y1 {
        for x in x0..x1 {
            if x < x0 + width || x >= x1 - width || y < y0 + width || y >= y1 - width {
                blend(image, x, y, color, 1.0);
            }
        }
    }
}

/// The axes of a frame as the camera sees them: x red, y green, z blue.
pub fn draw_axes(image: &mut Image, camera: &Camera, world_from_frame: &Pose, length_m: f64, width_px: f64) {
    let Some((origin, _)) = camera.project(world_from_frame.translation_m) else { return };
    let axes =
        [(DVec3::X, [214, 39, 40, 255]), (DVec3::Y, [34, 139, 34, 255]), (DVec3::Z, [31, 90, 220, 255])];
    for (axis, color) in axes {
        if let Some((tip, _)) = camera.project(world_from_frame.transform_point(length_m * axis)) {
            draw_line(image, origin, tip, color, width_px);
        }
    }
}
