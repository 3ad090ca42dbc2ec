//! Images and masks: pixels, colors, textures, filters, a dot font, and one bounded codec.
//!
//! The crate must not depend on any other crate of the workspace. It knows no meshes, cameras or scenes, and reads no
//! file and no clock.
//!
//! ```
//! use imaging::Image;
//! use imaging::codec::{decode_png, encode_png};
//!
//! let mut image = Image::filled(4, 3, [10, 20, 30, 255]);
//! image.set_pixel(1, 2, [255, 0, 0, 255]);
//! assert_eq!(decode_png(&encode_png(&image))?, image);
//! # Ok::<(), imaging::codec::CodecError>(())
//! ```

pub mod codec;
pub mod depth;
pub mod distance_transform;
pub mod image;
pub mod mask;
pub mod normal_map;
pub mod rounding;
pub mod sobel;
pub mod srgb;
pub mod text;
pub mod texture;

pub use self::depth::DepthImage;
pub use self::image::Image;
pub use self::mask::{Mask, RunLengths};
pub use self::normal_map::{GreenAxis, normal_map};
pub use self::texture::Texture;
