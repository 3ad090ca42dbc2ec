//! An 8-bit RGBA image, rows from the top, straight (not premultiplied) alpha, sRGB-encoded color.

/// An image of `width_px` x `height_px` pixels, four bytes each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width_px: u32,
    height_px: u32,
    rgba: Vec<u8>,
}

impl Image {
    /// An image of one color.
    pub fn filled(width_px: u32, height_px: u32, rgba: [u8; 4]) -> Self {
        Self { width_px, height_px, rgba: rgba.repeat(width_px as usize * height_px as usize) }
    }

    /// Takes ownership of row-major RGBA bytes; `None` unless there are exactly width x height x 4.
    pub fn from_rgba(width_px: u32, height_px: u32, rgba: Vec<u8>) -> Option<Self> {
        (rgba.len() == width_px as usize * height_px as usize * 4).then_some(Self {
            width_px,
            height_px,
            rgba,
        })
    }

    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// Row-major RGBA bytes.
    pub fn as_rgba(&self) -> &[u8] {
        &self.rgba
    }

    /// Row-major RGBA bytes, for kernels that write whole rows.
    pub fn as_rgba_mut(&mut self) -> &mut [u8] {
        &mut self.rgba
    }

    /// The pixel in column `x`, row `y`; both must be inside.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let at = (y as usize * self.width_px as usize + x as usize) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }

    /// The image with its rows in reverse order.
    pub fn upside_down(&self) -> Self {
        let row = (self.width_px as usize * 4).max(1);
        let mut rgba = Vec::with_capacity(self.rgba.len());
        self.rgba.chunks_exact(row).rev().for_each(|row| rgba.extend_from_slice(row));
        Self { width_px: self.width_px, height_px: self.height_px, rgba }
    }

    /// Writes the pixel in column `x`, row `y`; both must be inside.
    pub fn set_pixel(&mut self, x: u32, y: u32, rgba: [u8; 4]) {
        let at = (y as usize * self.width_px as usize + x as usize) * 4;
        self.rgba[at..at + 4].copy_from_slice(&rgba);
    }
}
