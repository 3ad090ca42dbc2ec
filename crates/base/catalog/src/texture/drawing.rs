//! Drawing on textures: a function of (u, v), filled rectangles, frames, discs. Pixel coordinates start at the top
//! left; shapes are clipped to the image.

use geometry::Rgb;
use imaging::{Image, Texture};

/// A texture whose pixel centers get `color(u, v)`; u runs right, v runs *up*, both 0..1.
pub fn draw_texture(width_px: u32, height_px: u32, mut color: impl FnMut(f32, f32) -> Rgb) -> Texture {
    let mut image = Image::filled(width_px, height_px, [0, 0, 0, 255]);
    for y in 0..height_px {
        for x in 0..width_px {
            let u = (x as f32 + 0.5) / width_px as f32;
            let v = 1.0 - (y as f32 + 0.5) / height_px as f32;
            image.set_pixel(x, y, color(u, v).to_rgba8());
        }
    }
    Texture::new(image)
}

/// Fills the rectangle with its top left corner at (x, y).
pub fn fill_rectangle(image: &mut Image, x: i32, y: i32, width: i32, height: i32, color: Rgb) {
    let rgba = color.to_rgba8();
    for py in y.max(0)..(y + height).min(image.height_px() as i32) {
        for px in x.max(0)..(x + width).min(image.width_px() as i32) {
            image.set_pixel(px as u32, py as u32, rgba);
        }
    }
}

/// Draws the rectangle's border, `thick` pixels wide, inside its edge.
pub fn frame_rectangle(image: &mut Image, x: i32, y: i32, width: i32, height: i32, thick: i32, color: Rgb) {
    fill_rectangle(image, x, y, width, thick, color);
    fill_rectangle(image, x, y + height - thick, width, thick, color);
    fill_rectangle(image, x, y, thick, height, color);
    fill_rectangle(image, x + width - thick, y, thick, height, color);
}

/// Fills the disc around (x, y).
pub fn fill_disc(image: &mut Image, x: i32, y: i32, radius: i32, color: Rgb) {
    let rgba = color.to_rgba8();
    for py in (y - radius).max(0)..(y + radius + 1).min(image.height_px() as i32) {
        for px in (x - radius).max(0)..(x + radius + 1).min(image.width_px() as i32) {
            if (px - x).pow(2) + (py - y).pow(2) <= radius * radius {
                image.set_pixel(px as u32, py as u32, rgba);
            }
        }
    }
}
