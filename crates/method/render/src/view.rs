//! Camera of an image.

use glam::{DVec2, DVec3};

use geometry::Camera;

/// A perspective camera or the straight-down drawing of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    Perspective(Camera),
    Orthographic(TopView),
}

/// A camera looking straight down; the image's right is world +x and its up is world +y. Surfaces above `eye_z_m` are
/// invisible; depth is measured down from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TopView {
    pub width_px: u32,
    pub height_px: u32,
    pub meters_per_px: f64,
    /// World position in the center of the image.
    pub center_m: DVec2,
    /// World height of the eye.
    pub eye_z_m: f64,
}

impl TopView {
    /// Pixel position (centers at +0.5) of a world position.
    pub fn pixel_from_world(&self, xy_m: DVec2) -> DVec2 {
        let offset = (xy_m - self.center_m) / self.meters_per_px;
        DVec2::new(0.5 * f64::from(self.width_px) + offset.x, 0.5 * f64::from(self.height_px) - offset.y)
    }

    /// World position of a pixel position.
    pub fn world_from_pixel(&self, pixel: DVec2) -> DVec2 {
        let half = DVec2::new(0.5 * f64::from(self.width_px), 0.5 * f64::from(self.height_px));
        let offset = pixel - half;
        self.center_m + self.meters_per_px * DVec2::new(offset.x, -offset.y)
    }
}

impl View {
    pub fn width_px(&self) -> u32 {
        match self {
            View::Perspective(camera) => camera.width_px,
            View::Orthographic(top) => top.width_px,
        }
    }

    pub fn height_px(&self) -> u32 {
        match self {
            View::Perspective(camera) => camera.height_px,
            View::Orthographic(top) => top.height_px,
        }
    }

    /// Pixel position (centers at +0.5) of a point in the world; `None` behind the camera.
    pub fn project(&self, point_in_world: DVec3) -> Option<DVec2> {
        match self {
            View::Perspective(camera) => camera.project(point_in_world).map(|(pixel, _)| pixel),
            View::Orthographic(top) => Some(top.pixel_from_world(point_in_world.truncate())),
        }
    }

    /// The part of the image whose upper left corner is `low_px` and that is `size_px` wide and high.
    pub fn window(&self, low_px: [u32; 2], size_px: [u32; 2]) -> View {
        let [width_px, height_px] = size_px;
        let low = DVec2::from(low_px.map(f64::from));
        match self {
            View::Perspective(camera) => View::Perspective(Camera {
                width_px,
                height_px,
                cx: camera.cx - low.x,
                cy: camera.cy - low.y,
                ..*camera
            }),
            View::Orthographic(top) => View::Orthographic(TopView {
                width_px,
                height_px,
                center_m: top.world_from_pixel(low + 0.5 * DVec2::from(size_px.map(f64::from))),
                ..*top
            }),
        }
    }
}
