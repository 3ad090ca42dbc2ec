//! Graduations and dials.

use rand::RngExt;
use std::f32::consts::TAU;

use super::PrintOrder;
use super::strokes::{centered_text, covered, draw_line, radial};
use crate::texture::{draw_text, draw_texture, fill_disc, fill_rectangle};
use geometry::Rgb;
use imaging::{Image, Texture};

/// Length of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tick {
    Long,
    Medium,
    Short,
}

/// Ticks at equal distances, and figures at some of them.
struct Graduation {
    divisions: i32,
    /// Ticks of one division.
    parts: i32,
    /// Divisions from figure to figure.
    numbered: i32,
}

impl Graduation {
    /// As fine as fits on this length, with figures at this distance or more.
    fn new(divisions: u32, length_px: i32, room_px: i32) -> Self {
        let divisions = divisions.clamp(1, 200) as i32;
        let pitch = length_px / divisions;
        let parts = [10, 5, 2].into_iter().find(|parts| pitch >= 5 * parts).unwrap_or(1);
        let numbered = [1, 2, 5, 10, 20, 50].into_iter().find(|step| step * pitch >= room_px).unwrap_or(100);
        Self { divisions, parts, numbered }
    }

    /// Offset of each tick from the start, and the number of the division at which it is long.
    fn ticks(&self, length_px: i32) -> impl Iterator<Item = (i32, Tick, Option<i32>)> {
        let (parts, numbered, count) = (self.parts, self.numbered, self.divisions * self.parts);
        (0..=count).map(move |k| {
            let number = (k % (numbered * parts) == 0).then_some(k / parts);
            let is_medium = k % parts == 0 && numbered > 1 || parts == 10 && k % 5 == 0;
            let tick = match number {
                Some(_) => Tick::Long,
                None if is_medium => Tick::Medium,
                None => Tick::Short,
            };
            ((k * length_px + count / 2) / count, tick, number)
        })
    }
}

/// Ticks along u from both edges and figures between them; 512 x 64 px, for few divisions taller. `count` is
/// the number of divisions.
pub(super) fn scale(order: &mut PrintOrder) -> Texture {
    let count = order.count.unwrap_or(30);
    let (width, height, text_scale) = match count {
        0..=6 => (256, 128, 4),
        7..=15 => (512, 128, 3),
        _ => (512, 64, 2),
    };
    let mut image = Image::filled(width as u32, height as u32, order.ground.to_rgba8());
    let length = width - 12;
    let ink = order.ink;
    let room = (6 * count.to_string().len() as i32 + 1) * text_scale;
    for (offset, tick, number) in Graduation::new(count, length, room).ticks(length) {
        let (wide, tall) = match tick {
            Tick::Long => (3, 24),
            Tick::Medium => (2, 17),
            Tick::Short => (1, 10),
        };
        let (x, tall) = (6 + offset - wide / 2, tall * height / 64);
        fill_rectangle(&mut image, x, 0, wide, tall, ink);
        fill_rectangle(&mut image, x, height - tall / 2, wide, tall / 2, ink);
        if let Some(number) = number.filter(|_| (8..length - 8).contains(&offset)) {
            centered_text(&mut image, &number.to_string(), [7 + offset, tall + 4], text_scale, ink);
        }
    }
    Texture::new(image)
}

/// Ticks along v from the left edge and figures beside them, as on a thermometer or a measuring cup; 128 x
/// 512 px. The figures count in tens, for the unit ML in fifties; a word of at most three letters is the
/// unit.
pub(super) fn upright_scale(order: &mut PrintOrder) -> Texture {
    let unit = if order.word.len() <= 3 { order.word } else { "" };
    let step = if unit.eq_ignore_ascii_case("ml") { 50 } else { 10 };
    let mut image = Image::filled(128, 512, order.ground.to_rgba8());
    let (length, ink) = (456, order.ink);
    for (offset, tick, number) in Graduation::new(order.count.unwrap_or(5), length, 32).ticks(length) {
        let (wide, tall) = match tick {
            Tick::Long => (46, 4),
            Tick::Medium => (34, 3),
            Tick::Short => (22, 2),
        };
        let y = 496 - offset;
        fill_rectangle(&mut image, 0, y - tall / 2, wide, tall, ink);
        if let Some(number) = number.filter(|number| *number > 0) {
            draw_text(&mut image, &(step * number).to_string(), 54, y - 10, 3, ink);
        }
    }
    draw_text(&mut image, unit, 54, 4, 3, ink);
    Texture::new(image)
}

/// A cutting mat's squares with figures along two edges and two slanted lines; 512 px. `count` is the number
/// of squares along u.
pub(super) fn grid(order: &mut PrintOrder) -> Texture {
    let columns = order.count.unwrap_or(28).clamp(2, 60) as i32;
    let rows = (columns * 5 / 7).max(1);
    let (ground, ink) = (order.ground, order.ink);
    let mut image = Image::filled(512, 512, ground.to_rgba8());
    let (left, top, width, height) = (30, 24, 458, 454);
    let line = |k: i32| if k % 5 == 0 { (3, 0.15) } else { (1, 0.5) };
    let fine = ink.mix(ground, 0.3);
    draw_line(&mut image, [30.0, 478.0], [488.0, 24.0], 2, fine);
    draw_line(&mut image, [30.0, 478.0], [488.0, 216.0], 2, fine);
    for k in 0..=columns {
        let (x, (wide, shade)) = (left + k * width / columns, line(k));
        fill_rectangle(&mut image, x, top, wide, height, ink.mix(ground, shade));
        fill_rectangle(&mut image, x, top - 8, 1, 8, ink);
        if k % 5 == 0 && k > 0 {
            centered_text(&mut image, &k.to_string(), [x + 1, 488], 2, ink);
        }
    }
    for k in 0..=rows {
        let (y, (wide, shade)) = (top + height - k * height / rows, line(k));
        fill_rectangle(&mut image, left, y, width + 2, wide, ink.mix(ground, shade));
        if k % 5 == 0 && k > 0 {
            centered_text(&mut image, &k.to_string(), [15, y - 6], 2, ink);
        }
    }
    Texture::new(image)
}

/// A clock's dial with figures, ticks and hands; 256 px, twelve at the top. `count` of the twelve hours have
/// figures; a word is written above the center.
pub(super) fn clock_dial(order: &mut PrintOrder) -> Texture {
    let (ground, ink) = (order.ground, order.ink);
    let hour = order.rng.random_range(0.0..12.0_f32);
    let second = order.rng.random_range(0.0..1.0_f32);
    let hands = [
        (hour / 12.0, [-14.0, 58.0], [5.5, 3.5], ink),
        (hour.fract(), [-16.0, 92.0], [4.5, 2.0], ink),
        (second, [-26.0, 98.0], [1.5, 0.8], Rgb::hex(0xd0_3a_2a)),
    ];
    let dial = draw_texture(256, 256, |u, v| {
        let (x, y) = ((u - 0.5) * 256.0, (v - 0.5) * 256.0);
        let (radius, turn) = (x.hypot(y), x.atan2(y) / TAU);
        let from_tick = |count: f32| ((turn * count).round() / count - turn) * TAU * radius;
        let minute = radial(radius, from_tick(60.0), [112.0, 119.0], [0.8, 0.8]);
        let hour = radial(radius, from_tick(12.0), [107.0, 119.0], [2.2, 2.2]);
        ground.mix(ink, minute.max(hour))
    });
    let mut image = (*dial).clone();
    let every = 12 / order.count.unwrap_or(12).clamp(1, 12) as i32;
    for hour in (1..=12).filter(|hour| hour % every == 0) {
        let (sin, cos) = (TAU * hour as f32 / 12.0).sin_cos();
        let at = [129 + (89.0 * sin) as i32, 118 - (89.0 * cos) as i32];
        centered_text(&mut image, &hour.to_string(), at, 3, ink);
    }
    centered_text(&mut image, order.word, [128, 76], 2, ink);
    draw_texture(256, 256, |u, v| {
        let (x, y) = ((u - 0.5) * 256.0, (v - 0.5) * 256.0);
        let [red, green, blue, _] = image.pixel((u * 256.0) as u32, ((1.0 - v) * 256.0) as u32);
        let mut color = Rgb([red, green, blue].map(|channel| f32::from(channel) / 255.0));
        for (turn, reach, half, hand) in hands {
            let (sin, cos) = (TAU * turn).sin_cos();
            color = color.mix(hand, radial(x * sin + y * cos, x * cos - y * sin, reach, half));
        }
        color.mix(ink, covered(x.hypot(y) - 8.0))
    })
}

/// Marks and names around a rotary switch, every third mark in a warm color; 256 px. The names are the parts
/// of a word with spaces, figures up to `count`, or else the ranges of a meter.
pub(super) fn selector_dial(order: &mut PrintOrder) -> Texture {
    const RANGES: [&str; 12] = ["OFF", "V", "20", "2", "MV", "A", "10", "MA", "2K", "20", "R", "HZ"];
    let (ground, ink) = (order.ground, order.ink);
    let words: Vec<&str> = order.word.split_whitespace().collect();
    let names: Vec<String> = match order.count {
        _ if words.len() > 1 => words.iter().map(ToString::to_string).collect(),
        Some(count) => (0..count.clamp(2, 24)).map(|k| k.to_string()).collect(),
        None => RANGES.map(String::from).to_vec(),
    };
    let mut image = Image::filled(256, 256, ground.to_rgba8());
    let accent = Rgb::hex(0xf0_8c_2a);
    for (k, name) in names.iter().enumerate() {
        let (sin, cos) = (TAU * k as f32 / names.len() as f32).sin_cos();
        let at = |radius: f32| (128 + (radius * sin).round() as i32, 128 - (radius * cos).round() as i32);
        let (color, (x, y)) = (if k % 3 == 0 { accent } else { ink }, at(117.0));
        fill_disc(&mut image, x, y, 6, color);
        let (x, y) = at(94.0);
        centered_text(&mut image, name, [x, y - 7], 2, if k % 3 == 0 { color } else { ink });
    }
    let mut ring = |radius: f32| {
        for k in 0..720 {
            let (sin, cos) = (TAU * k as f32 / 720.0).sin_cos();
            let (x, y) = (128.0 + radius * sin, 128.0 + radius * cos);
            fill_rectangle(&mut image, x as i32, y as i32, 2, 2, ink.mix(ground, 0.4));
        }
    };
    ring(72.0);
    Texture::new(image)
}
