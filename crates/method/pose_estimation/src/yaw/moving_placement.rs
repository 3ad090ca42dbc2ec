//! Derivative of the placement by yaw: the vertices' pixels, their box, and the crop's zoom.
//!
//! Forward mode, by the chain rule. A vertex moves about the upright axis. Each side of the box moves with the vertex
//! that sets it. Quantities that follow from the box alone (four numbers) are differentiated by central differences
//! along its motion. Where another vertex takes over a side the derivative jumps.

use glam::{DMat3, DVec2, DVec3};

use super::comparison::{Comparison, NEAR_CENTER_PX};
use super::placement::{bottom_center, fit};
use geometry::Pose;
use soft_raster::MovingPoint;
use soft_raster::color::MovingKey;

/// Half the step of the central differences, radians: far above rounding, far below the scale of curvature.
const STEP_RAD: f64 = 1e-6;

/// A vertex in the camera's image, pixels, its depth, meters, and their derivatives, per radian.
#[derive(Clone, Copy, Debug)]
pub struct MovingPixel {
    at_px: DVec2,
    slope: DVec2,
    depth_m: f64,
    depth_slope: f64,
}

impl MovingPixel {
    /// Reciprocal depth of the pixel, with its slope; the crop does not change it.
    pub fn key(&self) -> MovingKey<1> {
        let key = 1.0 / self.depth_m;
        MovingKey { key: key as f32, slopes: [(-self.depth_slope * key * key) as f32] }
    }
}

/// The vertices' box in the camera's image and its derivative.
#[derive(Clone, Copy, Debug)]
struct MovingBox {
    low_px: DVec2,
    high_px: DVec2,
    low_slope: DVec2,
    high_slope: DVec2,
}

impl MovingBox {
    const EMPTY: Self = Self {
        low_px: DVec2::INFINITY,
        high_px: DVec2::NEG_INFINITY,
        low_slope: DVec2::ZERO,
        high_slope: DVec2::ZERO,
    };

    fn hold(&mut self, pixel: MovingPixel) {
        for axis in 0..2 {
            if pixel.at_px[axis] < self.low_px[axis] {
                (self.low_px[axis], self.low_slope[axis]) = (pixel.at_px[axis], pixel.slope[axis]);
            }
            if pixel.at_px[axis] > self.high_px[axis] {
                (self.high_px[axis], self.high_slope[axis]) = (pixel.at_px[axis], pixel.slope[axis]);
            }
        }
    }

    /// The corners a little later.
    fn after(&self, step_rad: f64) -> (DVec2, DVec2) {
        (self.low_px + step_rad * self.low_slope, self.high_px + step_rad * self.high_slope)
    }
}

/// The vertices in the crop at a yaw, with their derivatives; as [`Comparison`] places them. `None` if one
/// lies behind the camera. `pixels` is room to work in.
pub fn moving_points(
    comparison: &Comparison,
    yaw_rad: f64,
    pixels: &mut Vec<MovingPixel>,
    points: &mut Vec<MovingPoint<1>>,
) -> Option<()> {
    let mut seen = project(comparison, comparison.standing.origin, DVec3::ZERO, yaw_rad, pixels)?;
    let off_center_px = |(low, high): (DVec2, DVec2)| comparison.off_center_px(low, high);
    let shift_px = off_center_px(seen.after(0.0));
    if shift_px.length() > NEAR_CENTER_PX {
        let camera = comparison.camera;
        let origin = comparison.standing.moved(camera, shift_px)?;
        let moved = |step_rad| {
            let shift_px = off_center_px(seen.after(step_rad));
            comparison.standing.moved(camera, shift_px).unwrap_or(origin)
        };
        let origin_slope = camera.world_from_camera.inverse().transform_vector(slope_at_0(moved));
        seen = project(comparison, origin, origin_slope, yaw_rad, pixels)?;
    }
    let to_crop = |step_rad: f64| {
        let (low, high) = seen.after(step_rad);
        let (zoom, offset) = fit(comparison.crop, low, high);
        offset.extend(zoom)
    };
    let (placed, placed_slope) = (to_crop(0.0), slope_at_0(to_crop));
    let ((zoom, offset), (zoom_slope, offset_slope)) =
        ((placed.z, placed.truncate()), (placed_slope.z, placed_slope.truncate()));
    points.clear();
    points.extend(pixels.iter().map(|pixel| {
        let slope = zoom_slope * pixel.at_px + zoom * pixel.slope + offset_slope;
        MovingPoint {
            at_px: (zoom * pixel.at_px + offset).as_vec2().to_array(),
            slopes: [slope.as_vec2().to_array()],
        }
    }));
    Some(())
}

/// Derivative at 0, by central difference.
fn slope_at_0<T>(f: impl Fn(f64) -> T) -> T
where
    T: std::ops::Sub<Output = T> + std::ops::Div<f64, Output = T>,
{
    (f(STEP_RAD) - f(-STEP_RAD)) / (2.0 * STEP_RAD)
}

/// The vertices in the camera's image with the object at `origin` (world frame), which moves by
/// `origin_slope_in_camera` per radian.
fn project(
    comparison: &Comparison,
    origin: DVec3,
    origin_slope_in_camera: DVec3,
    yaw_rad: f64,
    pixels: &mut Vec<MovingPixel>,
) -> Option<MovingBox> {
    let (mesh, camera) = (comparison.mesh, comparison.camera);
    let camera_from_world = camera.world_from_camera.inverse();
    let camera_from_object = camera_from_world * Pose::upright(origin, yaw_rad);
    let matrix = DMat3::from_quat(camera_from_object.rotation);
    let axis_in_camera = camera_from_world.transform_vector(DVec3::Z);
    let (bottom_center, focal_px) = (bottom_center(mesh), DVec2::new(camera.fx, camera.fy));
    pixels.clear();
    let mut seen = MovingBox::EMPTY;
    for &p in &mesh.positions {
        let turned = matrix * (p - bottom_center);
        let q = turned + camera_from_object.translation_m;
        if q.z <= 1e-6 {
            return None;
        }
        let q_slope = axis_in_camera.cross(turned) + origin_slope_in_camera;
        let pixel = MovingPixel {
            at_px: focal_px * q.truncate() / q.z + DVec2::new(camera.cx, camera.cy),
            slope: focal_px * (q_slope.truncate() - q.truncate() * (q_slope.z / q.z)) / q.z,
            depth_m: q.z,
            depth_slope: q_slope.z,
        };
        seen.hold(pixel);
        pixels.push(pixel);
    }
    Some(seen)
}
