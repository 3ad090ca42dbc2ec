//! Strokes with smooth edges, round corners and centered words. Pixel coordinates start at the top left.

use crate::texture::{draw_text, fill_rectangle, text_width_px};
use geometry::Rgb;
use imaging::Image;

/// Share of a pixel that lies inside an edge at this signed distance, positive outside.
pub(super) fn covered(distance_px: f32) -> f32 {
    (0.5 - distance_px).clamp(0.0, 1.0)
}

/// Share of a pixel on a radial stroke, whose place along its direction and beside it is given in pixels. The
/// stroke runs from `from_px` to `to_px` and is `half_px` wide on either side, `taper` less at its end.
pub(super) fn radial(along_px: f32, beside_px: f32, [from_px, to_px]: [f32; 2], half: [f32; 2]) -> f32 {
    let share = ((along_px - from_px) / (to_px - from_px)).clamp(0.0, 1.0);
    let half_px = half[0] + (half[1] - half[0]) * share;
    covered((beside_px.abs() - half_px).max(from_px - along_px).max(along_px - to_px))
}

/// Mean of a function over four points of a pixel, which smooths its edges. `step` is the size of a pixel.
pub(super) fn smoothed(u: f32, v: f32, step: [f32; 2], color: impl Fn(f32, f32) -> Rgb) -> Rgb {
    let mut sum = [0.0; 3];
    for (du, dv) in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)] {
        let sample = color(u + du * step[0], v + dv * step[1]);
        for (total, channel) in sum.iter_mut().zip(sample.0) {
            *total += 0.25 * channel;
        }
    }
    Rgb(sum)
}

/// Fills a rectangle, given as x, y, width and height, with round corners.
pub(super) fn fill_rounded(image: &mut Image, [x, y, width, height]: [i32; 4], radius: i32, color: Rgb) {
    for row in 0..height {
        let beyond = (radius - row).max(radius - (height - 1 - row)).max(0);
        let inset = radius - ((radius * radius - beyond * beyond).max(0) as f32).sqrt() as i32;
        fill_rectangle(image, x + inset, y + row, width - 2 * inset, 1, color);
    }
}

/// Writes a word with its center at x and its top at y.
pub(super) fn centered_text(image: &mut Image, text: &str, [x, y]: [i32; 2], scale: i32, color: Rgb) {
    draw_text(image, text, x - text_width_px(text, scale) / 2, y, scale, color);
}

/// Draws a line, `thick` pixels wide, between two points.
pub(super) fn draw_line(image: &mut Image, from: [f32; 2], to: [f32; 2], thick: i32, color: Rgb) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
    for k in 0..=steps as i32 {
        let share = k as f32 / steps;
        let (x, y) = ((from[0] + dx * share).round() as i32, (from[1] + dy * share).round() as i32);
        fill_rectangle(image, x - thick / 2, y - thick / 2, thick, thick, color);
    }
}

/// The ink where it has a hue, else `usual`: the second color of a surface is a gray unless one is asked for.
pub(super) fn colored_or(ink: Rgb, usual: Rgb) -> Rgb {
    let (low, high) = ink.0.iter().fold((1.0_f32, 0.0_f32), |(low, high), c| (low.min(*c), high.max(*c)));
    if high - low > 0.15 { ink } else { usual }
}
