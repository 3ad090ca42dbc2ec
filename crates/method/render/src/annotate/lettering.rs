//! Short labels on images.

use super::blend;
use imaging::{Image, text};

/// Width of a text drawn at that scale, pixels.
pub fn text_width_px(text: &str, scale: u32) -> u32 {
    text::width_dots(text) * scale
}

/// Writes `text` with its top-left corner at (x, y), letters 7 x `scale` pixels high. Characters beyond
/// ASCII show as `?`.
pub fn draw_text(image: &mut Image, x: i64, y: i64, text: &str, scale: u32, color: [u8; 4]) {
    let scale = i64::from(scale.max(1));
    for (column, row) in text::dots(text, '?') {
        let (left, top) = (x + i64::from(column) * scale, y + i64::from(row) * scale);
        for (u, v) in (0..scale * scale).map(|s| (s % scale, s / scale)) {
            blend(image, left + u, top + v, color, 1.0);
        }
    }
}
