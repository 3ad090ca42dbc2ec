//! Images and masks: pixels, colors, textures, filters, and one codec with one set of limits.
//!
//! The crate knows pixels and nothing of meshes, cameras or scenes. It reads no file and no clock.

pub mod animated_webp;
pub mod codec;
pub mod distance_transform;
pub mod image;
pub mod mask;
pub mod rounding;
pub mod sobel;
pub mod srgb;
pub mod texture;

pub use self::image::Image;
pub use self::mask::{Mask, RunLengths};
pub use self::texture::Texture;
