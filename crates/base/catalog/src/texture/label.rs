//! Product labels: bands, an emblem, a made-up word, small print.

use rand::RngExt;

use super::{draw_text, fill_disc, fill_rectangle, frame_rectangle, text_width_px};
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

/// A label of 256 x 256 px for the front of something: `word` (a made-up brand where empty) on
/// `background` with `accent` bands and emblem; three layouts.
pub fn label(background: Rgb, accent: Rgb, word: &str, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(256, 256, background.to_rgba8());
    front(&mut image, (0, 236), (background, accent), word, rng);
    Texture::new(image)
}

/// A label of 512 x 256 px that runs once around: the front of [`label`] in the center (u = 0.5),
/// small print and a bar code at the back.
pub fn wrap_label(background: Rgb, accent: Rgb, word: &str, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(512, 256, background.to_rgba8());
    front(&mut image, (128, WRAPPED_WORD_PX), (background, accent), word, rng);
    let ink = ink_on(background);
    for line in 0..11 {
        let width = rng.random_range(50..92);
        fill_rectangle(&mut image, 16, 70 + 12 * line, width, 4, ink.mix(background, 0.35));
    }
    fill_rectangle(&mut image, 410, 90, 84, 70, Rgb([1.0; 3]));
    let mut x = 416;
    while x < 486 {
        let bar = rng.random_range(1..5);
        fill_rectangle(&mut image, x, 96, bar, 58, Rgb([0.05; 3]));
        x += bar + rng.random_range(2..5);
    }
    Texture::new(image)
}

/// Width of the word on a label that runs around: a quarter turn, so that one sees all of it.
const WRAPPED_WORD_PX: i32 = 136;

/// The front of a label, its left edge and the width of its word in pixels, in two colors.
fn front(
    image: &mut Image,
    (left, word_px): (i32, i32),
    (background, accent): (Rgb, Rgb),
    word: &str,
    rng: &mut Rng,
) {
    let made_up = ["NOVA", "LUNA", "ALTA", "MIRA", "ORBI", "TERRA", "VITA", "SOLO"];
    let chosen = made_up[rng.random_range(0..made_up.len())];
    let word = if word.is_empty() { chosen } else { word };
    let width = image.width_px() as i32;
    let (ink, on_accent) = (ink_on(background), ink_on(accent));
    let scale = (word_px / text_width_px(word, 1)).clamp(2, 9);
    let text_x = left + (256 - text_width_px(word, scale)) / 2;
    match rng.random_range(0..3) {
        0 => {
            fill_rectangle(image, 0, 88, width, 84, accent);
            draw_text(image, word, text_x, 130 - 7 * scale / 2, scale, on_accent);
            fill_disc(image, left + 128, 46, 26, accent);
            fill_disc(image, left + 128, 46, 15, background);
        }
        1 => {
            fill_rectangle(image, 0, 0, width, 40, accent);
            fill_rectangle(image, 0, 216, width, 40, accent);
            draw_text(image, word, text_x, 78 - 7 * scale / 2, scale, ink);
            fill_disc(image, left + 128, 158, 42, accent);
            fill_disc(image, left + 142, 146, 26, accent.mix(Rgb([1.0; 3]), 0.35));
        }
        _ => {
            frame_rectangle(image, left + 8, 12, 240, 232, 6, accent);
            for step in 0..60 {
                let half = 60 - step;
                fill_rectangle(image, left + 128 - half, 120 + step, 2 * half, 1, accent);
            }
            draw_text(image, word, text_x, 68 - 7 * scale / 2, scale, ink);
        }
    }
    for line in 0..2 {
        let long = rng.random_range(60..130);
        let y = 190 + 12 * line;
        fill_rectangle(image, left + 128 - long / 2, y, long, 4, ink.mix(background, 0.3));
    }
}

/// Dark ink on a light ground, light ink on a dark one.
fn ink_on(ground: Rgb) -> Rgb {
    let [r, g, b] = ground.0;
    if 0.3 * r + 0.6 * g + 0.1 * b > 0.5 { Rgb([0.1, 0.1, 0.12]) } else { Rgb([0.97, 0.96, 0.93]) }
}
