//! Ground truth of a synthetic image.

use glam::{DVec2, DVec3};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde::{Deserialize, Serialize};

use super::viewpoint::Framing;
use super::{Split, TableShape};
use geometry::{Camera, Pose};
use imaging::Mask;

/// Ground truth of an image except its pixel labels. Lengths are meters in the world (table) frame; pixel centers
/// are at +0.5.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageTruth {
    pub split: Split,
    pub number: u64,
    pub width_px: u32,
    pub height_px: u32,
    pub camera: Camera,
    pub elevation_rad: f64,
    pub azimuth_rad: f64,
    /// Horizontal field of view of the whole image.
    pub fov_x_rad: f64,
    pub framing: Framing,
    /// Names of the random choices that determined the image.
    pub backdrop: String,
    pub is_cartoon: bool,
    pub table: TableTruth,
    /// In label order.
    pub objects: Vec<ObjectTruth>,
}

/// Ground truth of the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableTruth {
    pub shape: TableShape,
    /// Name of the top's finish.
    pub finish: String,
    /// Counter-clockwise edge of the flat part of the top.
    pub outline_m: Vec<DVec2>,
    /// The projected edge, hidden parts included; corners behind the camera are dropped.
    pub outline_px: Vec<DVec2>,
    /// Height above the floor.
    pub height_m: f64,
    /// Whether the whole outline lies within the image.
    pub is_whole: bool,
}

/// Ground truth of one object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectTruth {
    /// Catalog category, or the composite kind.
    pub name: String,
    pub is_composite: bool,
    pub world_from_object: Pose,
    /// Extents in the object frame.
    pub size_m: DVec3,
    /// Index of the supporting object; `None` = the table.
    pub stands_on: Option<usize>,
    /// Whether the object stands in a hollow of its support.
    pub is_inside: bool,
    /// Counter-clockwise hull of the contact patch, and its height in the world frame.
    pub contact_m: Vec<DVec2>,
    pub contact_z_m: f64,
    /// The projected contact patch.
    pub contact_px: Vec<DVec2>,
    /// Counter-clockwise hull of the vertical projection.
    pub footprint_m: Vec<DVec2>,
    /// Bounding box of the complete silhouette, hidden parts and parts beyond the frame included: x0, y0, x1, y1.
    pub box_px: [f64; 4],
    /// Number of visible pixels, and their share of the complete silhouette within the frame.
    pub visible_px: usize,
    pub visible_share: f64,
}

/// Front-most surface at each pixel center, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    pub width_px: u32,
    pub height_px: u32,
    /// [`Labels::BACKDROP`], [`Labels::FRAME`], [`Labels::TOP`], or [`Labels::FIRST_OBJECT`] and an object's index.
    pub values: Vec<u8>,
}

impl Labels {
    pub const BACKDROP: u8 = 0;
    /// The table without its top surface: edge and legs.
    pub const FRAME: u8 = 1;
    /// The bare top surface.
    pub const TOP: u8 = 2;
    pub const FIRST_OBJECT: u8 = 3;

    /// Mask of the pixels with that value.
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

    /// Mask of the visible pixels of the object with that index.
    pub fn object(&self, index: usize) -> Mask {
        self.mask(Self::FIRST_OBJECT + index as u8)
    }
}
