//! Where the object stands while its yaw is tried: on its own viewing ray, on what carries it.

use glam::{DVec2, DVec3};

use super::crop::Crop;
use super::outline_mesh::OutlineMesh;
use geometry::{Camera, Pose};

/// Where an object stands before its picture is compared, and how it moves when its picture is to move.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// World position of the middle of the bottom of its box.
    pub origin: DVec3,
    /// From there to the middle of its box.
    pub middle_from_origin: DVec3,
    /// World z of the box's middle where the object stays on what it stands on; else it stays at its depth.
    level_m: Option<f64>,
}

/// Sizes are not taken to be off by more than this factor.
const LEAST_ZOOM: f64 = 0.6;

impl Standing {
    /// The object's middle lies on the ray through the middle of the mask's box: on what it stands on (at that
    /// world z) where the ray meets it within reason, else at the distance at which it looks as large as the
    /// box.
    pub fn on_viewing_ray(mesh: &OutlineMesh, camera: &Camera, seat_height_m: f64, crop: &Crop) -> Self {
        let size = mesh.bounds.1 - mesh.bounds.0;
        let middle_from_origin = DVec3::new(0.0, 0.0, 0.5 * size.z);
        let middle_z = seat_height_m + middle_from_origin.z;
        let eye = camera.world_from_camera.translation_m;
        let center = crop.center_px;
        let direction = camera.ray_direction_in_world(center);
        let box_px = (crop.high_px - crop.low_px).max_element();
        let distance_by_size = camera.fx * size.max_element() / box_px.max(1.0);
        let on_seat = camera
            .meet_plane(center, middle_z)
            .filter(|p| (0.2..5.0).contains(&((*p - eye).length() / distance_by_size.max(1e-6))));
        let middle = on_seat.unwrap_or(eye + distance_by_size * direction);
        Self { origin: middle - middle_from_origin, middle_from_origin, level_m: on_seat.map(|_| middle_z) }
    }

    /// World position of the origin, straight below the middle that is seen at that pixel, of an object `zoom` times
    /// as large as it is taken to be; `None` where it does not stand on anything the camera sees.
    pub fn seen_m(&self, camera: &Camera, middle_px: DVec2, zoom: f64) -> Option<DVec2> {
        let half_height_m = self.middle_from_origin.z;
        let middle_z = self.level_m? + (zoom.clamp(LEAST_ZOOM, 1.0 / LEAST_ZOOM) - 1.0) * half_height_m;
        camera.meet_plane(middle_px, middle_z).map(|middle| middle.truncate())
    }

    /// World position of the origin with the middle's picture moved by so many pixels; `None` where that is
    /// behind the camera.
    pub fn moved(&self, camera: &Camera, shift_px: DVec2) -> Option<DVec3> {
        let (middle_px, _) = camera.project(self.origin + self.middle_from_origin)?;
        self.under(camera, middle_px + shift_px)
    }

    /// World position of the origin with the middle seen at that pixel; `None` where that is behind the camera.
    pub fn under(&self, camera: &Camera, middle_px: DVec2) -> Option<DVec3> {
        let middle = self.origin + self.middle_from_origin;
        let (now_px, depth) = camera.project(middle)?;
        let at_its_depth = || {
            let shift_px = middle_px - now_px;
            let shift = DVec3::new(shift_px.x * depth / camera.fx, shift_px.y * depth / camera.fy, 0.0);
            middle + camera.world_from_camera.transform_vector(shift)
        };
        // Near the horizon a pixel is many meters: there it does not follow the ray.
        let eye = camera.world_from_camera.translation_m;
        let near = |p: &DVec3| (0.5..2.0).contains(&((*p - eye).length() / (middle - eye).length()));
        let on_seat = self.level_m.and_then(|z| camera.meet_plane(middle_px, z)).filter(near);
        Some(on_seat.unwrap_or_else(at_its_depth) - self.middle_from_origin)
    }
}

/// Middle of the bottom of the mesh's box, object frame: what stands at the origin and is turned about.
pub fn seat(mesh: &OutlineMesh) -> DVec3 {
    let middle = 0.5 * (mesh.bounds.0 + mesh.bounds.1);
    DVec3::new(middle.x, middle.y, mesh.bounds.0.z)
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
    let seat = seat(mesh);
    let camera_from_object = camera.world_from_camera.inverse() * Pose::upright(origin, yaw_rad);
    let matrix = glam::DMat3::from_quat(camera_from_object.rotation);
    pixels.clear();
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for &p in &mesh.positions {
        let q = matrix * (p - seat) + camera_from_object.translation_m;
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
        // Hidden on both axes: the object is at least as large as what is seen of it.
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
