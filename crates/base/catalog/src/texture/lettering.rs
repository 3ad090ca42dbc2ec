//! Texts on textures, at whole multiples of a pixel.

use super::fill_rectangle;
use geometry::Rgb;
use imaging::{Image, text};

/// Width of `text` at `scale` pixels a dot, without the last letter's gap.
pub fn text_width_px(text: &str, scale: i32) -> i32 {
    text::width_dots(text) as i32 * scale
}

/// Writes `text` with its top left corner at (x, y), `scale` pixels a dot, in upper case. Letters without a glyph are
/// blank.
pub fn draw_text(image: &mut Image, text: &str, x: i32, y: i32, scale: i32, color: Rgb) {
    for (column, row) in text::dots(&text.to_ascii_uppercase(), ' ') {
        fill_rectangle(image, x + column as i32 * scale, y + row as i32 * scale, scale, scale, color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_stay_inside_the_text_width() {
        let (black, white) = (Rgb([0.0; 3]), Rgb([1.0; 3]));
        let mut image = Image::filled(64, 16, white.to_rgba8());
        draw_text(&mut image, "Hi!", 2, 1, 2, black);
        let dark: Vec<u32> =
            (0..64).filter(|&x| (0..16).any(|y| image.pixel(x, y) == black.to_rgba8())).collect();
        assert_eq!(dark.first(), Some(&2));
        assert!(dark.iter().all(|&x| (x as i32) < 2 + text_width_px("Hi!", 2)));
    }
}
