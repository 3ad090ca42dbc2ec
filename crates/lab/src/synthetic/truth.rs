//! What is true of a painted picture.

use glam::{DVec2, DVec3};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde::{Deserialize, Serialize};

use super::viewpoint::Framing;
use super::{Split, TableShape};
use geometry::{Camera, Pose};
use imaging::Mask;

/// Everything known of a picture but its pixels' labels. Lengths are meters in the world (table) frame, pixel positions
/// have centers at +0.5.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureTruth {
    pub split: Split,
    pub number: u64,
    pub width_px: u32,
    pub height_px: u32,
    pub camera: Camera,
    pub elevation_rad: f64,
    pub azimuth_rad: f64,
    /// Horizontal, of the whole picture.
    pub fov_x_rad: f64,
    pub framing: Framing,
    /// Names of the draws that made the picture.
    pub backdrop: String,
    pub is_cartoon: bool,
    pub table: TableTruth,
    /// In the order of their labels.
    pub objects: Vec<ObjectTruth>,
}

/// The table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableTruth {
    pub shape: TableShape,
    /// Kind of top.
    pub finish: String,
    /// Counter-clockwise edge of the flat part of the top.
    pub outline_m: Vec<DVec2>,
    /// The same in the picture, whatever hides it; corners behind the camera are cut off.
    pub outline_px: Vec<DVec2>,
    /// Above the floor.
    pub height_m: f64,
    /// Whether the whole outline lies within the picture.
    pub is_whole: bool,
}

/// One object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectTruth {
    /// Catalog category, or the kind of composite.
    pub name: String,
    pub is_composite: bool,
    pub world_from_object: Pose,
    /// Extents in its own frame.
    pub size_m: DVec3,
    /// Index of what carries it; `None` = the table.
    pub stands_on: Option<usize>,
    /// Whether it stands in its carrier's hollow.
    pub is_inside: bool,
    /// Counter-clockwise hull of what touches its support, and the world height of that.
    pub contact_m: Vec<DVec2>,
    pub contact_z_m: f64,
    /// The same in the picture.
    pub contact_px: Vec<DVec2>,
    /// Counter-clockwise hull of all of it seen from above.
    pub footprint_m: Vec<DVec2>,
    /// Box of its whole silhouette, hidden parts and parts beyond the frame included: x0, y0, x1, y1.
    pub box_px: [f64; 4],
    /// Pixels that show it, and their share of its whole silhouette within the frame.
    pub visible_px: usize,
    pub visible_share: f64,
}

/// What is in front at each pixel's center, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    pub width_px: u32,
    pub height_px: u32,
    /// [`Labels::BACKDROP`], [`Labels::FRAME`], [`Labels::TOP`], or [`Labels::FIRST_OBJECT`] and an object's index.
    pub values: Vec<u8>,
}

impl Labels {
    pub const BACKDROP: u8 = 0;
    /// The table but for its top surface: edge, legs.
    pub const FRAME: u8 = 1;
    /// The bare top surface.
    pub const TOP: u8 = 2;
    pub const FIRST_OBJECT: u8 = 3;

    /// Pixels of that value.
    pub fn mask(&self, value: u8) -> Mask {
        let bits = self.values.iter().map(|v| *v == value).collect();
        Mask::from_bits(self.width_px, self.height_px, bits)
    }

    /// The values as a lossless 8-bit gray PNG.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Up)
            .write_image(&self.values, self.width_px, self.height_px, ExtendedColorType::L8)
            .expect("the buffer matches the size and memory accepts every write");
        bytes
    }

    /// Pixels that show the object of that index.
    pub fn object(&self, index: usize) -> Mask {
        self.mask(Self::FIRST_OBJECT + index as u8)
    }
}
