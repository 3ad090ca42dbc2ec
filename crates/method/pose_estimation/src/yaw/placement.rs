//! Placement of the object during the yaw search: on its own viewing ray, on its supporter.

use glam::{DVec2, DVec3};

use super::crop::Crop;
use super::outline_mesh::OutlineMesh;
use geometry::{Camera, Pose};

/// Initial placement of an object, and its motion for a shift in the image.
#[derive(Clone, Copy, Debug)]
pub struct RayPlacement {
    /// World position of the center of the bottom of its box.
    pub origin: DVec3,
    /// From there to the center of its box.
    pub center_from_origin: DVec3,
    /// World z of the box's center if the object moves on its supporting plane; `None` if it moves at its depth.
    level_m: Option<f64>,
}

/// Sizes are not taken to be off by more than this factor.
const MIN_ZOOM: f64 = 0.6;

impl RayPlacement {
    /// The object's center lies on the ray through the center of the mask's box: at the support height where the ray
    /// meets it at a plausible distance, else at the distance at which its projected box is as large as the mask's.
    pub fn on_viewing_ray(mesh: &OutlineMesh, camera: &Camera, support_height_m: f64, crop: &Crop) -> Self {
        let size = mesh.bounds.1 - mesh.bounds.0;
        let center_from_origin = DVec3::new(0.0, 0.0, 0.5 * size.z);
        let center_z = support_height_m + center_from_origin.z;
        let eye = camera.world_from_camera.translation_m;
        let center = crop.center_px;
        let direction = camera.ray_direction_in_world(center);
        let box_px = (crop.high_px - crop.low_px).max_element();
        let distance_by_size = camera.fx * size.max_element() / box_px.max(1.0);
        let on_seat = camera
            .meet_plane(center, center_z)
            .filter(|p| (0.2..5.0).contains(&((*p - eye).length() / distance_by_size.max(1e-6))));
        let midpoint = on_seat.unwrap_or(eye + distance_by_size * direction);
        Self { origin: midpoint - center_from_origin, center_from_origin, level_m: on_seat.map(|_| center_z) }
    }

    /// World position of the origin, straight below the center projected to that pixel, for an object `zoom` times its
    /// nominal size; `None` without a visible supporting plane.
    pub fn seen_m(&self, camera: &Camera, center_px: DVec2, zoom: f64) -> Option<DVec2> {
        let half_height_m = self.center_from_origin.z;
        // The level is that of the nominal size; a larger object on the same plane has a higher center.
        let center_z = self.level_m? + (zoom.clamp(MIN_ZOOM, 1.0 / MIN_ZOOM) - 1.0) * half_height_m;
        camera.meet_plane(center_px, center_z).map(|midpoint| midpoint.truncate())
    }

    /// World position of the origin with the center's image moved by so many pixels; `None` where that is
    /// behind the camera.
    pub fn moved(&self, camera: &Camera, shift_px: DVec2) -> Option<DVec3> {
        let (center_px, _) = camera.project(self.origin + self.center_from_origin)?;
        self.under(camera, center_px + shift_px)
    }

    /// World position of the origin with the center seen at that pixel; `None` where that is behind the camera.
    pub fn under(&self, camera: &Camera, center_px: DVec2) -> Option<DVec3> {
        let midpoint = self.origin + self.center_from_origin;
        let (now_px, depth) = camera.project(midpoint)?;
        let at_its_depth = || {
            let shift_px = center_px - now_px;
            let shift = DVec3::new(shift_px.x * depth / camera.fx, shift_px.y * depth / camera.fy, 0.0);
            midpoint + camera.world_from_camera.transform_vector(shift)
        };
        // Near the horizon a pixel is many meters: there the depth is kept.
        let eye = camera.world_from_camera.translation_m;
        let near = |p: &DVec3| (0.5..2.0).contains(&((*p - eye).length() / (midpoint - eye).length()));
        let on_seat = self.level_m.and_then(|z| camera.meet_plane(center_px, z)).filter(near);
        Some(on_seat.unwrap_or_else(at_its_depth) - self.center_from_origin)
    }
}

/// Center of the bottom of the mesh's box, object frame: the pivot of the yaw.
pub fn bottom_center(mesh: &OutlineMesh) -> DVec3 {
    let midpoint = 0.5 * (mesh.bounds.0 + mesh.bounds.1);
    DVec3::new(midpoint.x, midpoint.y, mesh.bounds.0.z)
}

/// Pixel positions of all vertices with the object at `origin` turned by `yaw_rad`, and their box; `None`
/// if a vertex lies behind the camera.
pub fn projected(
    mesh: &OutlineMesh,
    camera: &Camera,
    origin: DVec3,
    yaw_rad: f64,
    pixels: &mut Vec<DVec2>,
) -> Option<(DVec2, DVec2)> {
    let pivot = bottom_center(mesh);
    let camera_from_object = camera.world_from_camera.inverse() * Pose::upright(origin, yaw_rad);
    let matrix = glam::DMat3::from_quat(camera_from_object.rotation);
    pixels.clear();
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for &p in &mesh.positions {
        let q = matrix * (p - pivot) + camera_from_object.translation_m;
        if q.z <= 1e-6 {
            return None;
        }
        let pixel = DVec2::new(camera.fx * q.x / q.z + camera.cx, camera.fy * q.y / q.z + camera.cy);
        (low, high) = (low.min(pixel), high.max(pixel));
        pixels.push(pixel);
    }
    Some((low, high))
}

/// Scale and offset that bring the rendered box onto the mask's box: `crop = scale * pixel + offset`.
///
/// An axis whose two sides are the object's own fixes the scale (both: the larger side, as a padded
/// tight crop does); one own side fixes the position. Where nothing is own, size and place stay as
/// rendered.
pub fn fit(crop: &Crop, low: DVec2, high: DVec2) -> (f64, DVec2) {
    let [left, top, right, bottom] = crop.own_sides;
    let (rendered, seen) = ((high - low).max(DVec2::splat(1e-6)), crop.high_px - crop.low_px);
    let ratio = seen / rendered;
    let zoom = match (left && right, top && bottom) {
        (true, true) => seen.max_element() / rendered.max_element(),
        (true, false) => ratio.x,
        (false, true) => ratio.y,
        // Hidden on both axes: the object is at least as large as its visible part.
        (false, false) => ratio.max_element().max(1.0),
    };
    let place =
        |own_low: bool, own_high: bool, seen: (f64, f64), rendered: (f64, f64)| match (own_low, own_high) {
            (true, false) => seen.0 - zoom * rendered.0,
            (false, true) => seen.1 - zoom * rendered.1,
            _ => 0.5 * (seen.0 + seen.1) - 0.5 * zoom * (rendered.0 + rendered.1),
        };
    let shift = DVec2::new(
        place(left, right, (crop.low_px.x, crop.high_px.x), (low.x, high.x)),
        place(top, bottom, (crop.low_px.y, crop.high_px.y), (low.y, high.y)),
    );
    let half = 0.5 * crop.side_px as f64;
    (crop.scale * zoom, crop.scale * (shift - crop.center_px) + half)
}
