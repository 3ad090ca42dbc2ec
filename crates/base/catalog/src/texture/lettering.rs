//! Texts on textures: letters of a dot font, drawn as strokes between neighboring dots.

use super::fill_rectangle;
use geometry::Rgb;
use imaging::{Image, text};

/// Letters smaller than this many pixels a dot stay dots.
const MIN_STROKE_PX: i32 = 3;
/// Half the width of a stroke, dots.
const PEN_DOTS: f32 = 0.56;

/// Width of `text` at `scale` pixels a dot, without the last letter's gap.
pub fn text_width_px(text: &str, scale: i32) -> i32 {
    text::width_dots(text) as i32 * scale
}

/// Writes `text` with its top left corner at (x, y), `scale` pixels a dot, in upper case. Letters without a glyph are
/// blank.
pub fn draw_text(image: &mut Image, text: &str, x: i32, y: i32, scale: i32, color: Rgb) {
    let text = text.to_ascii_uppercase();
    if scale < MIN_STROKE_PX {
        for (column, row) in text::dots(&text, ' ') {
            fill_rectangle(image, x + column as i32 * scale, y + row as i32 * scale, scale, scale, color);
        }
        return;
    }
    let advance_px = text::ADVANCE_DOTS as i32 * scale;
    for (index, letter) in text.chars().enumerate() {
        let columns = text::glyph(letter).unwrap_or_default();
        draw_letter(image, &strokes(columns), [x + index as i32 * advance_px, y], scale, color);
    }
}

/// A line between two dots, or a dot: columns and rows.
type Stroke = [[f32; 2]; 2];

/// Lines between the neighboring dots of a glyph. Dots are neighbors across a corner only where no third one joins
/// them.
fn strokes(columns: text::Glyph) -> Vec<Stroke> {
    let is_on = |column: i32, row: i32| {
        let bits = usize::try_from(column).ok().and_then(|column| columns.get(column)).copied();
        (0..8).contains(&row) && bits.is_some_and(|bits| bits >> row & 1 == 1)
    };
    let mut strokes = Vec::new();
    for (column, row) in (0..5).flat_map(|column| (0..8).map(move |row| (column, row))) {
        if !is_on(column, row) {
            continue;
        }
        let here = [column as f32, row as f32];
        strokes.push([here, here]);
        for (right, down) in [(1, 0), (0, 1), (1, 1), (-1, 1)] {
            let across = right != 0 && down != 0;
            let joined = across && (is_on(column + right, row) || is_on(column, row + down));
            if is_on(column + right, row + down) && !joined {
                strokes.push([here, [(column + right) as f32, (row + down) as f32]]);
            }
        }
    }
    strokes
}

/// Draws strokes with smooth edges; the letter's top left corner is at `corner`.
fn draw_letter(image: &mut Image, strokes: &[Stroke], corner: [i32; 2], scale: i32, color: Rgb) {
    for row in -1..=8 * scale {
        for column in -1..=5 * scale {
            let (Ok(x), Ok(y)) = (u32::try_from(corner[0] + column), u32::try_from(corner[1] + row)) else {
                continue;
            };
            if x >= image.width_px() || y >= image.height_px() {
                continue;
            }
            // The center of the first dot is half a dot inside the corner.
            let dots = [column, row].map(|c| (c as f32 + 0.5) / scale as f32 - 0.5);
            let nearest = strokes.iter().map(|stroke| distance(dots, stroke)).fold(f32::INFINITY, f32::min);
            let share = (0.5 + scale as f32 * (PEN_DOTS - nearest)).clamp(0.0, 1.0);
            if share > 0.0 {
                let (ground, ink) = (image.pixel(x, y), color.to_rgba8());
                let mixed = |channel: usize| {
                    let [from, to] = [ground, ink].map(|color| f32::from(color[channel]));
                    (from + share * (to - from)).round() as u8
                };
                image.set_pixel(x, y, [0, 1, 2, 3].map(mixed));
            }
        }
    }
}

fn distance(p: [f32; 2], [from, to]: &Stroke) -> f32 {
    let (along, away) = ([to[0] - from[0], to[1] - from[1]], [p[0] - from[0], p[1] - from[1]]);
    let length2 = (along[0] * along[0] + along[1] * along[1]).max(1e-9);
    let t = ((along[0] * away[0] + along[1] * away[1]) / length2).clamp(0.0, 1.0);
    (away[0] - t * along[0]).hypot(away[1] - t * along[1])
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
    #[test]
    fn strokes_join_the_dots_of_a_letter() {
        // A vertical bar with dots at the top and the bottom: one line through all of them, none across corners.
        let bar = strokes([0, 0, 0x7f, 0, 0]);
        assert_eq!(bar.iter().filter(|[from, to]| from != to).count(), 6);
        let slash = strokes([0x20, 0x10, 0x08, 0x04, 0x02]);
        assert_eq!(slash.iter().filter(|[from, to]| from != to).count(), 4);
    }

    #[test]
    fn large_letters_have_smooth_edges_inside_their_width() {
        let (black, white) = (Rgb([0.0; 3]), Rgb([1.0; 3]));
        let mut image = Image::filled(64, 64, white.to_rgba8());
        draw_text(&mut image, "S", 8, 4, 8, black);
        let pixels = || (0..64).flat_map(|x| (0..64).map(move |y| (x, y)));
        let grays = pixels().filter(|&(x, y)| (20..235).contains(&image.pixel(x, y)[0])).count();
        assert!(grays > 40, "{grays}");
        assert!(pixels().all(|(x, y)| (7..50).contains(&x) || image.pixel(x, y) == white.to_rgba8()));
    }
}
