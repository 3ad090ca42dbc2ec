//! Procedural textures and finishes: wood grain, labels, pages, metal, ceramics, cloth, stone, lettering.
//!
//! Textures depend on colors and a seeded generator. Sizes are powers of two between 64 and 512 pixels, and all
//! textures except labels, pages and screens repeat without a seam. Row 0 is the top of the image; texture
//! coordinates have v = 0 at the bottom.

mod noise;
mod drawing;
mod lettering;
mod wood;
mod metal;
mod ceramic;
mod fabric;
mod stone;
mod checker;
mod label;
mod finish;
mod mapping;
pub(crate) mod print;

pub use ceramic::ceramic_speckle;
pub use checker::{checker, stripes};
pub use drawing::{draw_texture, fill_disc, fill_rectangle, frame_rectangle};
pub use fabric::{fabric_weave, wicker};
pub use finish::{is_finish, material_finish};
pub use label::{label, wrap_label};
pub use lettering::{draw_text, text_width_px};
pub use mapping::{mapped_from_above, mapped_from_front, mapped_from_side, mapped_on_box, wrapped_around};
pub use metal::brushed_metal;
pub use noise::Noise;
pub use stone::{granite, marble};
pub use wood::{wood_grain, wood_planks};
