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
pub use recognize::{at_usual_scale, recognize};
pub use reconstruct::{as_seen, reconstruct};
pub use segment::segment;
pub(crate) use tabletop_texture::with_photographed_top;
pub use text_naming::{ObjectNames, name_objects};
pub use top_view::top_view;

use serde::{Deserialize, Serialize};

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
    /// Longer side of the rectified top view, pixels, 256..2048. More keeps finer texture.
    pub top_view_px: u32,
    /// Longer side of a texture cropped from the image, pixels, 64..2048.
    pub texture_px: u32,
}

impl PhotographSettings {
    /// The field of view, if it is known.
    pub fn known_field_of_view_rad(&self) -> Option<f64> {
        (self.field_of_view_rad > 0.0).then_some(self.field_of_view_rad)
    }
}

#[cfg(test)]
mod tests;
