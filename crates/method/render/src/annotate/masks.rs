//! Mask outlines and tints on an image.

use super::blend;
use imaging::{Image, Mask};

/// Colors the mask's pixels that have a neighbor outside it, `width_px` deep.
pub fn draw_mask_outline(image: &mut Image, mask: &Mask, color: [u8; 4], width_px: u32) {
    let Some([x0, y0, x1, y1]) = mask.bbox_px() else { return };
    let reach = i64::from(width_px.max(1));
    let inside = |x: i64, y: i64| x >= 0 && y >= 0 && mask.contains(x as u32, y as u32);
    for y in i64::from(y0)..i64::from(y1) {
        for x in i64::from(x0)..i64::from(x1) {
            let edge = || {
                (1..=reach)
                    .any(|d| !inside(x - d, y) || !inside(x + d, y) || !inside(x, y - d) || !inside(x, y + d))
            };
            if inside(x, y) && edge() {
                blend(image, x, y, color, 1.0);
            }
        }
    }
}

/// Mixes `color` into the mask's pixels; `amount` 0..1.
pub fn tint_mask(image: &mut Image, mask: &Mask, color: [u8; 4], amount: f64) {
    let Some([x0, y0, x1, y1]) = mask.bbox_px() else { return };
    for y in y0..y1 {
        for x in x0..x1 {
            if mask.contains(x, y) {
                blend(image, i64::from(x), i64::from(y), color, amount.clamp(0.0, 1.0));
            }
        }
    }
}
