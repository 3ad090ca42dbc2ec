//! Squares and stripes.

use super::draw_texture;
use geometry::Rgb;
use imaging::Texture;

/// `columns` x `rows` squares, 256 px; repeats for even counts.
pub fn checker(first: Rgb, second: Rgb, columns: usize, rows: usize) -> Texture {
    draw_texture(256, 256, |u, v| {
        let square = (u * columns as f32) as usize + (v * rows as f32) as usize;
        if square.is_multiple_of(2) { first } else { second }
    })
}

/// `count` bands along v, alternating between two colors, 64 x 256 px; repeats for even counts.
pub fn stripes(first: Rgb, second: Rgb, count: usize) -> Texture {
    draw_texture(64, 256, |_, v| if ((v * count as f32) as usize).is_multiple_of(2) { first } else { second })
}
