//! A pinhole camera with OpenCV axes (+x right, +y down, +z forward), pixel centers at +0.5.

use glam::{DMat3, DQuat, DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Pose;
use super::json_numbers::Positive;

/// Pinhole intrinsics and pose of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(
    description = "A pinhole camera with OpenCV axes (x right, y down, z forward), pixel centers at +0.5."
)]
pub struct Camera {
    #[schemars(range(min = 1))]
    pub width_px: u32,
    #[schemars(range(min = 1))]
    pub height_px: u32,
    /// Focal lengths and principal point in pixels.
    #[schemars(with = "Positive")]
    pub fx: f64,
    #[schemars(with = "Positive")]
    pub fy: f64,
    pub cx: f64,
    pub cy: f64,
    pub world_from_camera: Pose,
}

impl Camera {
    /// Camera at `eye_m` looking at `target_m`, image upright (world +z up), with square pixels and
    /// the horizontal field of view `fov_x_rad`. Straight down is allowed; then +y is up in the image.
    pub fn look_at(width_px: u32, height_px: u32, fov_x_rad: f64, eye_m: DVec3, target_m: DVec3) -> Self {
        let forward = (target_m - eye_m).normalize();
        let up = if forward.cross(DVec3::Z).length() < 1e-9 { DVec3::Y } else { DVec3::Z };
        let right = forward.cross(up).normalize();
        let down = forward.cross(right);
        let rotation = DQuat::from_mat3(&DMat3::from_cols(right, down, forward)).normalize();
        let f = 0.5 * f64::from(width_px) / (0.5 * fov_x_rad).tan();
        Self {
            width_px,
            height_px,
            fx: f,
            fy: f,
            cx: 0.5 * f64::from(width_px),
            cy: 0.5 * f64::from(height_px),
            world_from_camera: Pose { translation_m: eye_m, rotation },
        }
    }

    /// Camera on a sphere about `target_m`: azimuth 0 is at the front edge, viewing along +y, and
    /// azimuth 90 degrees at +x. Elevation 0 is horizontal, 90 degrees is straight down.
    pub fn orbit(
        width_px: u32,
        height_px: u32,
        fov_x_rad: f64,
        target_m: DVec3,
        azimuth_rad: f64,
        elevation_rad: f64,
        distance_m: f64,
    ) -> Self {
        let offset = DVec3::new(
            azimuth_rad.sin() * elevation_rad.cos(),
            -azimuth_rad.cos() * elevation_rad.cos(),
            elevation_rad.sin(),
        );
        Self::look_at(width_px, height_px, fov_x_rad, target_m + distance_m * offset, target_m)
    }

    /// The camera orbited about the world's origin: rotated about +z, which adds to its azimuth, and about its own
    /// rightward axis, which adds to its elevation. Distance and pixel of the origin do not change.
    pub fn orbited(&self, azimuth_rad: f64, elevation_rad: f64) -> Self {
        let right = self.world_from_camera.transform_vector(DVec3::X);
        // A negative rotation about the rightward axis raises the camera.
        let rotation = DQuat::from_rotation_z(azimuth_rad) * DQuat::from_axis_angle(right, -elevation_rad);
        let turn = Pose { translation_m: DVec3::ZERO, rotation };
        Self { world_from_camera: turn * self.world_from_camera, ..*self }
    }

    /// Pixel coordinates and depth along the optical axis (meters) of a world point; `None` behind the camera.
    pub fn project(&self, point_in_world: DVec3) -> Option<(DVec2, f64)> {
        let p = self.world_from_camera.inverse().transform_point(point_in_world);
        (p.z > 1e-9).then(|| (DVec2::new(self.fx * p.x / p.z + self.cx, self.fy * p.y / p.z + self.cy), p.z))
    }

    /// Unit direction, in the world, of the ray through a pixel position (centers at +0.5).
    pub fn ray_direction_in_world(&self, pixel: DVec2) -> DVec3 {
        let in_camera = DVec3::new((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy, 1.0);
        self.world_from_camera.transform_vector(in_camera.normalize())
    }

    /// Intersection of the ray through `pixel` with the horizontal plane at height `z_m`, if any.
    pub fn meet_plane(&self, pixel: DVec2, z_m: f64) -> Option<DVec3> {
        let origin = self.world_from_camera.translation_m;
        let direction = self.ray_direction_in_world(pixel);
        let t = (z_m - origin.z) / direction.z;
        (t.is_finite() && t > 0.0).then(|| origin + t * direction)
    }

    /// Elevation of the camera above the horizon, radians.
    pub fn elevation_rad(&self) -> f64 {
        (-self.world_from_camera.transform_vector(DVec3::Z).z).clamp(-1.0, 1.0).asin()
    }

    /// Azimuth, radians: 0 views along +y, pi/2 views along -x from +x. For a camera that points straight down, it
    /// follows from the image's up direction.
    pub fn azimuth_rad(&self) -> f64 {
        let forward = self.world_from_camera.transform_vector(DVec3::Z);
        let up = self.world_from_camera.transform_vector(-DVec3::Y);
        let along = if forward.truncate().length() > 1e-6 { forward } else { up };
        (-along.x).atan2(along.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn look_at_projects_the_target_to_the_center_and_reports_its_angles() {
        for (azimuth, elevation) in [(0.0, 0.6), (0.5, 1.0), (-1.2, 0.3)] {
            let camera = Camera::orbit(640, 480, 0.6, DVec3::new(0.1, 0.0, 0.0), azimuth, elevation, 1.5);
            let (pixel, depth) = camera.project(DVec3::new(0.1, 0.0, 0.0)).expect("in front");
            assert!((pixel - DVec2::new(320.0, 240.0)).length() < 1e-9 && (depth - 1.5).abs() < 1e-12);
            assert!((camera.elevation_rad() - elevation).abs() < 1e-9);
            assert!((camera.azimuth_rad() - azimuth).abs() < 1e-9);
        }
    }

    #[test]
    fn project_maps_world_right_and_up_to_image_right_and_up() {
        let camera = Camera::orbit(640, 480, 0.6, DVec3::ZERO, 0.0, 0.5, 1.5);
        let (right, _) = camera.project(DVec3::new(0.1, 0.0, 0.0)).expect("in front");
        let (above, _) = camera.project(DVec3::new(0.0, 0.0, 0.1)).expect("in front");
        assert!(right.x > 320.0 && above.y < 240.0);
        let met = camera.meet_plane(right, 0.0).expect("meets the table");
        assert!((met - DVec3::new(0.1, 0.0, 0.0)).length() < 1e-9);
    }
}
