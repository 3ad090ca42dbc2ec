//! Printed and written paper: pages, covers, notes, tables.

use rand::RngExt;

use super::PrintOrder;
use super::strokes::{centered_text, draw_line};
use super::world::View;
use crate::texture::{
    Noise, draw_text, draw_texture, fill_disc, fill_rectangle, frame_rectangle, text_width_px,
};
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

/// A book's front with the word, or a title, in one of four layouts; 256 px.
pub(super) fn book_cover(order: &mut PrintOrder) -> Texture {
    const TITLES: [&str; 9] =
        ["ATLAS", "PHYSICS", "THE SEA", "GARDEN", "POEMS", "HISTORY", "VOYAGE", "ALGEBRA", "COOKING"];
    let (ground, ink) = (order.ground, order.ink);
    let rng = &mut *order.rng;
    let title = TITLES[rng.random_range(0..TITLES.len())];
    let title = if order.word.is_empty() { title } else { order.word };
    let scale = (212 / text_width_px(title, 1).max(1)).clamp(1, 6);
    let mut image = Image::filled(256, 256, ground.to_rgba8());
    match rng.random_range(0..4) {
        0 => {
            frame_rectangle(&mut image, 14, 14, 228, 228, 4, ink);
            frame_rectangle(&mut image, 22, 22, 212, 212, 1, ink);
            centered_text(
                &mut image,
                title,
                [128, 52],
                (196 / text_width_px(title, 1).max(1)).clamp(1, 5),
                ink,
            );
            for (radius, color) in [(38, ink), (30, ground), (14, ink)] {
                fill_disc(&mut image, 128, 146, radius, color);
            }
            fill_rectangle(&mut image, 78, 210, 100, 5, ink);
        }
        1 => {
            let view = View::random(256.0 / 110.0, rng);
            for y in 0..110_u32 {
                for x in 0..256_u32 {
                    let shade = view.at(x as f32 / 256.0, 1.0 - y as f32 / 110.0);
                    image.set_pixel(x, 116 + y, shade.to_rgba8());
                }
            }
            centered_text(&mut image, title, [128, 38], scale, ink);
            fill_rectangle(&mut image, 60, 94, 136, 5, ink);
        }
        2 => {
            let (x, y) = (rng.random_range(60..200), rng.random_range(150..190));
            for (k, shade) in (0..5).zip([0.75, 0.6, 0.4, 0.2, 0.0]) {
                fill_disc(&mut image, x, y, 110 - 22 * k, ink.mix(ground, shade));
            }
            fill_rectangle(&mut image, 0, 0, 256, 28 + 7 * scale, ground);
            centered_text(&mut image, title, [128, 20], scale, ink);
        }
        _ => {
            fill_rectangle(&mut image, 0, 24, 256, 86, ink);
            centered_text(&mut image, title, [128, 67 - 7 * scale / 2], scale, ground);
            for k in 0..4 {
                fill_rectangle(&mut image, 40 + 44 * k, 140, 26, 84, ink.mix(ground, 0.25 * k as f32));
            }
        }
    }
    Texture::new(image)
}

/// Edges of a block of pages: fine lines along u; 64 x 128 px.
pub(super) fn page_edges(order: &mut PrintOrder) -> Texture {
    let tone = Noise::new(2, 60, order.rng);
    draw_texture(64, 128, |u, v| order.ground.scaled(0.82 + 0.2 * tone.at(u, v)))
}

/// A page with a heading, lines of words, sometimes an image; 256 px. Two facing pages with a gutter where
/// `count` is 2, 512 x 256 px.
pub(super) fn printed_page(order: &mut PrintOrder) -> Texture {
    let pages = order.count.unwrap_or(1).clamp(1, 2);
    let mut image = Image::filled(256 * pages, 256, order.ground.to_rgba8());
    for k in 0..pages {
        page(&mut image, 256 * k as i32, order.ground, order.ink, order.rng);
    }
    for step in (0..14).filter(|_| pages == 2) {
        let shade = order.ground.scaled(0.72 + 0.02 * step as f32);
        fill_rectangle(&mut image, 255 - step, 0, 1, 256, shade);
        fill_rectangle(&mut image, 256 + step, 0, 1, 256, shade);
    }
    Texture::new(image)
}

fn page(image: &mut Image, left: i32, paper: Rgb, ink: Rgb, rng: &mut Rng) {
    let ink = ink.mix(paper, 0.15);
    let (low, high) = (left + 28, left + 228);
    fill_rectangle(image, low, 22, rng.random_range(70..150), 10, ink);
    let illustration = (rng.random_range(0..3) == 0).then(|| rng.random_range(70..150));
    if let Some(top) = illustration {
        let view = View::random(200.0 / 60.0, rng);
        for y in 0..60 {
            for x in 0..200 {
                let shade = view.at(x as f32 / 200.0, 1.0 - y as f32 / 60.0);
                image.set_pixel((low + x) as u32, (top + y) as u32, shade.to_rgba8());
            }
        }
    }
    let mut y = 46;
    while y < 234 {
        let inside = illustration.is_some_and(|top| y + 6 > top && y < top + 64);
        let last = rng.random_range(0..6) == 0;
        let end = if last { low + rng.random_range(40..150) } else { high };
        let mut x = low;
        while x < end && !inside {
            let word = rng.random_range(9..30).min(end - x);
            fill_rectangle(image, x, y, word, 4, ink.mix(paper, 0.2));
            x += word + 5;
        }
        y += 9;
    }
}

/// Six staves of music with clefs, bars and notes; 256 px.
pub(super) fn staves(order: &mut PrintOrder) -> Texture {
    let mut image = Image::filled(256, 256, order.ground.to_rgba8());
    let (ink, rng) = (order.ink, &mut *order.rng);
    fill_rectangle(&mut image, 84, 12, 88, 7, ink);
    for staff in 0..6 {
        let top = 34 + 36 * staff;
        (0..5).for_each(|line| fill_rectangle(&mut image, 16, top + 4 * line, 224, 1, ink));
        (0..5).for_each(|bar| fill_rectangle(&mut image, 16 + 56 * bar, top, 1, 17, ink));
        fill_disc(&mut image, 24, top + 11, 4, ink);
        fill_rectangle(&mut image, 24, top - 3, 2, 22, ink);
        for beat in 0..14 {
            let (x, y) = (40 + 14 * beat + rng.random_range(0..4), top + 2 * rng.random_range(-1..9));
            fill_disc(&mut image, x, y, 2, ink);
            fill_rectangle(&mut image, x + 2, y - 11, 1, 11, ink);
        }
    }
    Texture::new(image)
}

/// Lines of handwriting; 128 px.
pub(super) fn note(order: &mut PrintOrder) -> Texture {
    let mut image = Image::filled(128, 128, order.ground.to_rgba8());
    let rng = &mut *order.rng;
    for line in 0..4 {
        let base = 32.0 + 24.0 * line as f32;
        let end = rng.random_range(76.0..114.0);
        let mut x = 14.0;
        while x < end {
            let word_end = (x + rng.random_range(14.0_f32..34.0)).min(end);
            let mut last = [x, base];
            while x < word_end {
                x += rng.random_range(2.0..4.5_f32);
                let rise = if rng.random_range(0..6) == 0 { 11.0 } else { 5.5 };
                let next = if last[1] < base - 1.0 { base } else { base - rise };
                draw_line(&mut image, last, [x, next], 2, order.ink);
                last = [x, next];
            }
            x += 7.0;
        }
    }
    Texture::new(image)
}

/// A table of nutrition facts on white between bands of the ink, with a bar code below; 256 px.
pub(super) fn nutrition_facts(order: &mut PrintOrder) -> Texture {
    let (paper, black) = (Rgb::hex(0xfb_fa_f6), Rgb::hex(0x20_20_22));
    let rng = &mut *order.rng;
    let mut image = Image::filled(256, 256, order.ground.to_rgba8());
    fill_rectangle(&mut image, 0, 0, 256, 14, order.ink);
    fill_rectangle(&mut image, 0, 242, 256, 14, order.ink);
    fill_rectangle(&mut image, 24, 26, 208, 150, paper);
    frame_rectangle(&mut image, 24, 26, 208, 150, 2, black);
    draw_text(&mut image, "NUTRITION FACTS", 36, 33, 2, black);
    fill_rectangle(&mut image, 30, 52, 196, 5, black);
    let rows = ["ENERGY", "FAT", "SUGARS", "FIBER", "PROTEIN", "SALT", "VITAMIN C"];
    for (k, name) in (0..).zip(rows) {
        let y = 62 + 16 * k;
        draw_text(&mut image, name, 34, y, 1, black);
        let amount = format!("{}%", rng.random_range(1..60));
        draw_text(&mut image, &amount, 222 - text_width_px(&amount, 1), y, 1, black);
        fill_rectangle(&mut image, 30, y + 11, 196, 1, black.mix(paper, 0.4));
    }
    for line in 0..4 {
        fill_rectangle(&mut image, 24, 186 + 11 * line, rng.random_range(76..110), 3, order.ink);
    }
    fill_rectangle(&mut image, 146, 184, 86, 50, paper);
    let mut x = 152;
    while x < 226 {
        let bar = rng.random_range(1..5).min(228 - x);
        fill_rectangle(&mut image, x, 188, bar, 42, black);
        x += bar + rng.random_range(2..5);
    }
    Texture::new(image)
}

/// Numbered rows of stitches, as on a sewing machine; 128 px.
pub(super) fn stitches(order: &mut PrintOrder) -> Texture {
    let mut image = Image::filled(128, 128, order.ground.to_rgba8());
    for row in 0..5 {
        let y = 10 + 24 * row;
        for k in 0..12 {
            let rise = match row {
                0 => 0,
                1 => (k % 2) * 8,
                2 => (k % 4) * 4,
                3 => (k % 3) * 5,
                _ => i32::from(k % 4 < 2) * 9,
            };
            fill_rectangle(&mut image, 28 + 8 * k, y + rise, 6, 3, order.ink);
        }
        draw_text(&mut image, &(row + 1).to_string(), 8, y, 2, Rgb::hex(0xc0_30_40));
    }
    Texture::new(image)
}
