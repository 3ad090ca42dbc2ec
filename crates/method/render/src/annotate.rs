//! Drawing onto finished images: boxes, outlines, curves, labels and contact sheets.
//!
//! Pixel positions count from the top-left corner, pixel centers at +0.5; colors are opaque sRGB bytes. Marks outside
//! the image are clipped.

mod lettering;
mod lines;
mod masks;
mod plot;
mod sheet;

pub use lettering::{draw_text, text_width_px};
pub use lines::{draw_axes, draw_box, draw_line, draw_polyline};
pub use masks::{draw_mask_outline, tint_mask};
pub use plot::{Curve, plot_curves};
pub use sheet::{fitted, sheet, side_by_side};

use imaging::Image;

/// A color that differs clearly from its neighbors in the list.
pub fn distinct_color(index: usize) -> [u8; 4] {
    const COLORS: [u32; 12] = [
        0xe6194b, 0x3cb44b, 0x4363d8, 0xf58231, 0x911eb4, 0x00a5a5, 0xd43fb3, 0x7fa800, 0x9a6324, 0xc99a00,
        0x000095, 0x7d0000,
    ];
    let c = COLORS[index % COLORS.len()];
    [(c >> 16) as u8, (c >> 8) as u8, c as u8, 255]
}

/// Mixes `color` into a pixel; positions outside the image are ignored.
fn blend(image: &mut Image, x: i64, y: i64, color: [u8; 4], amount: f64) {
    if x < 0 || y < 0 || x >= i64::from(image.width_px()) || y >= i64::from(image.height_px()) {
        return;
    }
    let mut pixel = image.pixel(x as u32, y as u32);
    for (channel, to) in pixel.iter_mut().zip(color).take(3) {
        *channel = (f64::from(*channel) + (f64::from(to) - f64::from(*channel)) * amount).round() as u8;
    }
    pixel[3] = 255;
    image.set_pixel(x as u32, y as u32, pixel);
}

#[cfg(test)]
mod tests;
