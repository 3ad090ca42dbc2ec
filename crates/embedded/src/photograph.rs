//! What the embedded adapters answer for a picture nobody here painted.
//!
//! All of it rests on the reading of the picture by [`PictureReader`], which keeps the last ones. Things that look enough like a
//! category of the catalog get its name, and its mesh where that fits their outline; the others are `object` and become the
//! simplest solid. Sizes are what the outline says at the scale of a table of usual height. A picture that cannot be read is
//! refused with a stable code.

mod reader;
mod recent;
mod recognize;
mod segment;
mod complete;
mod neighboring_texture;
mod top_view;
mod body;
mod reconstruct;
mod category_mesh;
mod texture;

pub use complete::complete;
pub use reader::{LoadNetworkError, PictureReader, ReaderIdentity, ReadingNetwork};
pub use recognize::{at_usual_scale, recognize};
pub use reconstruct::{as_seen, reconstruct};
pub use segment::segment;
pub use top_view::top_view;

use serde::{Deserialize, Serialize};

use vision::VisionSettings;
use vision::category_fit::CategoryFitSettings;

/// Everything that decides how a photograph is answered for.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct PhotographSettings {
    pub vision: VisionSettings,
    pub sizes: SizeSettings,
    pub naming: CategoryFitSettings,
}

/// Section `[photograph]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SizeSettings {
    /// Height every table is taken to have, meters, 0.4..1.0; it sets the scene's scale where the feet show
    /// and nothing else is known. Usual: 0.74.
    pub table_height_m: f64,
    /// Longer side of the rectified top view, pixels, 256..2048; more keeps finer texture. Usual: 768.
    pub top_view_px: u32,
    /// Longer side of a texture cut from the picture, pixels, 64..2048. Usual: 512.
    pub texture_px: u32,
}

#[cfg(test)]
mod tests;
