//! The CPU forward renderer: projection, rasterization, shadow maps, sky light and shading.
//!
//! [`scene_buffers`] holds the placed geometry, [`prepare`] projects and bins it, [`raster`] fills the z-buffer of one
//! band of rows, [`shade`] and [`shade_band`] turn surfaces into light, [`tone_map`] turns light into sRGB, and
//! [`bands`] runs these steps on rayon. [`backdrop`], [`floor_pattern`], [`room_light`] and [`environment_map`] are
//! what a room adds. [`object_colors`] shades few pixels of a mesh in several sets of colors.
//! [`reference`] is the slow version that the tests compare with.

pub mod backdrop;
pub mod bands;
pub mod environment;
pub mod environment_map;
pub mod floor_light;
pub mod floor_pattern;
pub mod light_map;
pub mod noise;
pub mod object_colors;
pub mod one_sided;
pub mod partly_open;
pub mod prepare;
pub mod projection;
pub mod raster;
pub mod reference;
pub mod relief;
pub mod room_light;
pub mod scene_buffers;
pub mod shade;
pub mod shade_band;
pub mod shading_materials;
pub mod sky;
pub mod sky_group;
pub mod still_layer;
pub mod surface_colors;
pub mod texture_map;
mod tone_curve;
pub mod tone_map;
