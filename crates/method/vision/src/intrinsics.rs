//! Known intrinsics of the camera of an image.

use glam::DVec2;

/// Pinhole intrinsics, in pixels of the whole image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    pub focal_px: DVec2,
    /// Principal point; `None` = the center of the image.
    pub center_px: Option<DVec2>,
}

impl Intrinsics {
    /// Square pixels and a centered principal point, with a horizontal field of view in an image of that width.
    pub fn of_field_of_view(fov_x_rad: f64, width_px: u32) -> Self {
        Self { focal_px: DVec2::splat(0.5 * f64::from(width_px) / (0.5 * fov_x_rad).tan()), center_px: None }
    }

    /// The same camera in an image reduced or enlarged by that factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { focal_px: factor * self.focal_px, center_px: self.center_px.map(|center| factor * center) }
    }

    /// The principal point in an image of that size.
    pub fn center_in(&self, width_px: f64, height_px: f64) -> DVec2 {
        self.center_px.unwrap_or(0.5 * DVec2::new(width_px, height_px))
    }
}
