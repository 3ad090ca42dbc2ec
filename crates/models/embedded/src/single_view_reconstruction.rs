//! Single-view reconstruction: the embedded adapters' results for images from clients.
//!
//! All results derive from the reading of the image by [`ImageReader`], which caches the last ones. Objects that
//! match a catalog category well get its name, and its mesh if its outline fits. The others have the category
//! `object` and become a fitted primitive. Sizes follow from the outline and a table of standard height. An
//! unreadable image is rejected with a stable code.

mod reader;
mod reading_cache;
mod recognize;
mod text_naming;
mod segment;
mod complete;
mod neighboring_texture;
mod top_view;
mod tabletop_texture;
mod primitive_mesh;
mod reconstruct;
mod category_mesh;
mod texture;

pub use complete::complete;
pub use reader::{ImageReader, LoadNetworkError, ReaderIdentity, ReadingNetwork};
pub use recognize::{at_usual_scale, recognize, scale_correction};
pub use reconstruct::{as_seen, reconstruct};
pub use segment::segment;
pub(crate) use tabletop_texture::with_photographed_top;
pub use text_naming::{ObjectNames, name_objects};
pub use top_view::top_view;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use imaging::depth::MAX_ASPECT_DIFFERENCE;
use vision::Intrinsics;
use vision::category_fit::CategoryFitSettings;

/// Settings of the single-view reconstruction.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct SingleViewSettings {
    pub sizes: PhotographSettings,
    pub naming: CategoryFitSettings,
}

/// Section `[photograph]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PhotographSettings {
    /// Assumed height of a table, meters, 0.4..1.0. It sets the scale if the feet are visible and no other scale
    /// is known.
    pub table_height_m: f64,
    /// Horizontal field of view of the camera, radians, 0..2.6; 0 = not known.
    pub field_of_view_rad: f64,
    /// Intrinsics of the camera: focal lengths and principal point, right and down, then width and height of the
    /// image that they belong to; pixels. All 0 = not known. Left out of keys then, which are older.
    #[serde(skip_serializing_if = "is_unknown")]
    pub intrinsics_px: [f64; 6],
    /// Longer side of the rectified top view, pixels, 256..2048. More keeps finer texture.
    pub top_view_px: u32,
    /// Longer side of a texture cropped from the image, pixels, 64..2048.
    pub texture_px: u32,
}

impl PhotographSettings {
    /// Whether the settings state a field of view or all intrinsics of the camera.
    pub fn has_intrinsics(&self) -> bool {
        self.field_of_view_rad > 0.0 || self.states_intrinsics()
    }

    /// Whether the settings state all intrinsics of the camera.
    pub fn states_intrinsics(&self) -> bool {
        !is_unknown(&self.intrinsics_px)
    }

    /// Reason why the stated intrinsics cannot be those of an image of that size.
    pub fn aspect_fault(&self, width_px: u32, height_px: u32) -> Option<String> {
        let [.., width, height] = self.intrinsics_px;
        let aspect = f64::from(width_px) / f64::from(height_px.max(1));
        let differs = || (width / height / aspect - 1.0).abs() > MAX_ASPECT_DIFFERENCE;
        (self.states_intrinsics() && differs()).then(|| {
            format!(
                "belongs to an image of {width} x {height} pixels, and the upright image is {width_px} x {height_px}; \
                 state the intrinsics of the image as it is sent"
            )
        })
    }

    /// The intrinsics of the camera of an image of that size, if they are known.
    pub fn intrinsics(&self, width_px: u32, height_px: u32) -> Option<Intrinsics> {
        if !self.states_intrinsics() {
            let is_known = self.field_of_view_rad > 0.0;
            return is_known.then(|| Intrinsics::of_field_of_view(self.field_of_view_rad, width_px));
        }
        let [fx, fy, cx, cy, of_width, of_height] = self.intrinsics_px;
        let scale = DVec2::new(f64::from(width_px) / of_width, f64::from(height_px) / of_height);
        Some(Intrinsics { focal_px: scale * DVec2::new(fx, fy), center_px: Some(scale * DVec2::new(cx, cy)) })
    }

    /// Reason why the stated intrinsics are those of no camera.
    pub fn intrinsics_fault(&self) -> Option<String> {
        if !self.states_intrinsics() {
            return None;
        }
        let [fx, fy, cx, cy, width, height] = self.intrinsics_px;
        if self.field_of_view_rad > 0.0 {
            return Some("comes beside photograph.field_of_view_rad; state one of the two".to_owned());
        }
        let is_inside = (0.0..=width).contains(&cx) && (0.0..=height).contains(&cy);
        let is_lens = width >= 1.0 && height >= 1.0 && fx >= 0.1 * width && (0.5..=2.0).contains(&(fy / fx));
        (!is_inside || !is_lens).then(|| {
            "must be fx, fy, cx, cy, width, height in pixels: a principal point inside the image, and similar focal \
             lengths of at least a tenth of its width"
                .to_owned()
        })
    }
}

fn is_unknown(intrinsics_px: &[f64; 6]) -> bool {
    intrinsics_px.iter().all(|number| *number == 0.0)
}

#[cfg(test)]
mod tests;
