//! Lit and liquid-crystal screens.

use rand::RngExt;

use super::PrintOrder;
use super::strokes::{centered_text, fill_rounded};
use super::world::View;
use crate::texture::{Noise, draw_text, draw_texture, fill_disc, fill_rectangle};
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

const APP_COLORS: [u32; 8] =
    [0x2f_7d_e0, 0xe0_4f_3a, 0x35_b0_5c, 0xf2_b5_33, 0x8a_55_d6, 0x1f_b5_c2, 0xe8_5a_9b, 0xf0_f0_f0];
const WHITE: Rgb = Rgb([1.0; 3]);

/// A computer's desktop: a view, icons, an open window, a task bar; 512 x 256 px.
pub(super) fn desktop(order: &mut PrintOrder) -> Texture {
    let rng = &mut *order.rng;
    let view = View::random(2.0, rng);
    let ground = draw_texture(512, 256, |u, v| view.at(u, v));
    let mut image = (*ground).clone();
    for k in 0..4 {
        let color = Rgb::hex(APP_COLORS[rng.random_range(0..7)]);
        fill_rounded(&mut image, [16, 16 + 50 * k, 26, 26], 5, color);
        fill_rounded(&mut image, [22, 24 + 50 * k, 14, 10], 2, color.mix(WHITE, 0.7));
        fill_rectangle(&mut image, 14, 46 + 50 * k, 30, 3, Rgb::hex(0xf4_f4_f4));
    }
    window(&mut image, [rng.random_range(90..150), rng.random_range(18..34), 300, 186], rng);
    fill_rectangle(&mut image, 0, 236, 512, 20, Rgb::hex(0x1d_22_2c));
    for (k, color) in (0..).zip(APP_COLORS) {
        fill_rounded(&mut image, [166 + 24 * k, 239, 14, 14], 3, Rgb::hex(color));
    }
    let time = time_of_day(rng);
    draw_text(&mut image, &time, 472, 243, 1, Rgb::hex(0xe8_ea_ee));
    Texture::new(image)
}

/// A window with a side bar, text and an image, at x, y, width and height.
fn window(image: &mut Image, [x, y, width, height]: [i32; 4], rng: &mut Rng) {
    fill_rounded(image, [x, y, width, height], 6, Rgb::hex(0x3a_44_55));
    fill_rectangle(image, x, y + 18, width, height - 18, Rgb::hex(0xf7_f7_f8));
    for (k, color) in (0..).zip([0xe8_5a_4f, 0xf2_b5_33, 0x4f_b8_5a]) {
        fill_disc(image, x + 12 + 14 * k, y + 9, 4, Rgb::hex(color));
    }
    fill_rectangle(image, x, y + 18, 66, height - 18, Rgb::hex(0xdd_e2_ea));
    let (view_x, view_y) = (x + 78, y + 28);
    let view = View::random(210.0 / 60.0, rng);
    for row in 0..60 {
        for column in 0..210 {
            let shade = view.at(column as f32 / 210.0, 1.0 - row as f32 / 60.0);
            image.set_pixel((view_x + column) as u32, (view_y + row) as u32, shade.to_rgba8());
        }
    }
    for k in 0..12 {
        let line_y = y + 28 + 12 * k;
        fill_rectangle(image, x + 8, line_y, rng.random_range(24..48), 5, Rgb::hex(0x7a_88_9c));
        if k > 5 {
            let accent = if k == 6 { Rgb::hex(0x2f_6f_c8) } else { Rgb::hex(0x9a_a0_a8) };
            fill_rectangle(image, view_x, line_y, rng.random_range(90..210), 5, accent);
        }
    }
}

fn time_of_day(rng: &mut Rng) -> String {
    format!("{}:{:02}", rng.random_range(1..13), rng.random_range(0..60))
}

/// A telephone's or tablet's home screen: clock, rows of app icons, a dock; 256 x 512 px. `count` is the
/// number of columns.
pub(super) fn home_screen(order: &mut PrintOrder) -> Texture {
    let (columns, rows) = (order.count.unwrap_or(4).clamp(2, 8) as i32, 5);
    let rng = &mut *order.rng;
    let view = View::random(0.5, rng);
    let blob = Noise::new(3, 4, rng);
    let (low, high) = view.colors();
    let ground = draw_texture(256, 512, |u, v| {
        low.mix(high, (0.9 * blob.at(u, v) + 0.3 * (v - 0.5)).clamp(0.0, 1.0)).scaled(0.92)
    });
    let mut image = (*ground).clone();
    fill_rectangle(&mut image, 12, 8, 30, 5, WHITE);
    fill_rounded(&mut image, [216, 6, 26, 9], 2, WHITE);
    centered_text(&mut image, &time_of_day(rng), [128, 34], 7, WHITE);
    fill_rectangle(&mut image, 88, 94, 80, 4, WHITE);
    let (pitch_x, pitch_y) = (232 / columns, 62);
    let side = (pitch_x * 2 / 3).min(44);
    for k in 0..rows * columns {
        let color = Rgb::hex(APP_COLORS[rng.random_range(0..APP_COLORS.len())]);
        let (x, y) = (12 + pitch_x * (k % columns) + (pitch_x - side) / 2, 118 + pitch_y * (k / columns));
        app_icon(&mut image, [x, y], side, color, rng);
        fill_rectangle(&mut image, x + side / 8, y + side + 4, side * 3 / 4, 3, WHITE);
    }
    fill_rounded(&mut image, [10, 434, 236, 66], 16, low.mix(WHITE, 0.55));
    for (k, color) in (0..4).zip(APP_COLORS) {
        app_icon(&mut image, [22 + 57 * k, 446], 42, Rgb::hex(color), rng);
    }
    Texture::new(image)
}

fn app_icon(image: &mut Image, [x, y]: [i32; 2], side: i32, color: Rgb, rng: &mut Rng) {
    fill_rounded(image, [x, y, side, side], side / 4, color);
    let mark = if color.0.iter().sum::<f32>() > 2.4 { Rgb::hex(0x5a_60_6a) } else { WHITE };
    let (third, center) = (side / 3, side / 2);
    match rng.random_range(0..3) {
        0 => fill_disc(image, x + center, y + center, side / 5, mark),
        1 => fill_rounded(image, [x + third / 2 + 1, y + third, side - third - 2, third], third / 4, mark),
        _ => {
            for k in 0..3 {
                let height = third / 2 + k * third / 3;
                fill_rectangle(
                    image,
                    x + third / 2 + k * third,
                    y + side - third / 2 - height,
                    third * 2 / 3,
                    height,
                    mark,
                );
            }
        }
    }
}

/// Lit segments of the figures 0 to 9: bits for the top, upper right, lower right, bottom, lower left, upper
/// left and central segment.
const SEGMENTS: [u8; 10] = [0x3f, 0x06, 0x5b, 0x4f, 0x66, 0x6d, 0x7d, 0x07, 0x7f, 0x6f];

/// A liquid-crystal display that shows the word, a number where it is empty; 256 x 64 px. Figures have seven
/// segments, also those that are not lit.
pub(super) fn lcd(order: &mut PrintOrder) -> Texture {
    let (ground, ink) = (order.ground, order.ink);
    let number = f64::from(order.rng.random_range(1_000..999_999)) / 10.0;
    let text = if order.word.is_empty() { format!("{number:.1}") } else { order.word.to_owned() };
    let mut image = Image::filled(256, 64, ground.to_rgba8());
    let width = |letter: char| if matches!(letter, '.' | ':' | ' ') { 12.0 } else { 30.0 };
    let total: f32 = text.chars().map(width).sum();
    let shrink = (236.0 / total).min(1.0);
    let mut x = 250.0 - total * shrink;
    for letter in text.chars() {
        let cell = [x as i32, (24.0 * shrink) as i32];
        match letter.to_digit(10) {
            Some(figure) => {
                segments(&mut image, cell, 0x7f, ground.mix(ink, 0.06));
                segments(&mut image, cell, SEGMENTS[figure as usize], ink);
            }
            None => sign(&mut image, letter, cell, ink),
        }
        x += width(letter) * shrink;
    }
    Texture::new(image)
}

/// Draws the segments whose bits are set in a cell with this left edge and width.
fn segments(image: &mut Image, [x, width]: [i32; 2], bits: u8, color: Rgb) {
    const TOP: i32 = 9;
    const HALF: i32 = 23;
    let thick = (width / 4).clamp(2, 5);
    let bars = [
        [x + 2, TOP, width - 4, thick],
        [x + width - thick, TOP + 2, thick, HALF - 3],
        [x + width - thick, TOP + HALF + 1, thick, HALF - 3],
        [x + 2, TOP + 2 * HALF - thick, width - 4, thick],
        [x, TOP + HALF + 1, thick, HALF - 3],
        [x, TOP + 2, thick, HALF - 3],
        [x + 2, TOP + HALF - thick / 2 - 1, width - 4, thick],
    ];
    for (k, [left, top, wide, tall]) in bars.into_iter().enumerate() {
        if bits >> k & 1 == 1 {
            fill_rounded(image, [left, top, wide, tall], 1, color);
        }
    }
}

fn sign(image: &mut Image, letter: char, [x, width]: [i32; 2], ink: Rgb) {
    match letter {
        '.' => fill_rectangle(image, x, 50, 5, 5, ink),
        ':' => {
            fill_rectangle(image, x, 22, 5, 5, ink);
            fill_rectangle(image, x, 40, 5, 5, ink);
        }
        '-' => segments(image, [x, width], 0x40, ink),
        _ => {
            let scale = (width / 5).max(1);
            draw_text(image, &letter.to_string(), x, 55 - 7 * scale, scale, ink);
        }
    }
}
