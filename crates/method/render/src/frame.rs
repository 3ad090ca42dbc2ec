//! Output images of the renderer.

use imaging::{Image, Mask};

/// Color, depth, normals and ids of one image; all buffers row-major from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub color: Image,
    /// Meters along the optical axis at the pixel's center; infinite where there is background.
    pub depth_m: Vec<f32>,
    /// Unit normals, world frame, facing the eye; zero for background. `None` if they were not requested.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Id of the object in front at the pixel's center; 0 = background.
    pub ids: Vec<u32>,
}

impl Frame {
    pub fn width_px(&self) -> u32 {
        self.color.width_px()
    }

    pub fn height_px(&self) -> u32 {
        self.color.height_px()
    }

    /// Pixels in which the object of that id is in front.
    pub fn mask(&self, id: u32) -> Mask {
        mask_of(&self.ids, self.width_px(), self.height_px(), id)
    }
}

/// Depth and ids of one image; buffers as in [`Frame`].
#[derive(Clone, Debug, PartialEq)]
pub struct GeometryFrame {
    pub width_px: u32,
    pub height_px: u32,
    /// Meters along the optical axis at the pixel's center; infinite where there is background.
    pub depth_m: Vec<f32>,
    /// Id of the object in front at the pixel's center; 0 = background.
    pub ids: Vec<u32>,
}

impl GeometryFrame {
    /// Pixels in which the object of that id is in front.
    pub fn mask(&self, id: u32) -> Mask {
        mask_of(&self.ids, self.width_px, self.height_px, id)
    }
}

fn mask_of(ids: &[u32], width_px: u32, height_px: u32, id: u32) -> Mask {
    Mask::from_bits(width_px, height_px, ids.iter().map(|shown| *shown == id).collect())
}
