//! Marks of makers: labels, words, emblems, the front of a package.

use rand::RngExt;
use std::f32::consts::TAU;

use super::PrintOrder;
use super::strokes::{centered_text, colored_or, smoothed};
use crate::texture::{draw_texture, fill_disc, fill_rectangle, label, text_width_px, wrap_label};
use geometry::Rgb;
use imaging::{Image, Texture};

/// A label for the front; 256 px.
pub(super) fn plain_label(order: &mut PrintOrder) -> Texture {
    label(order.ground, order.ink, order.word, order.rng)
}

/// A label once around; 512 x 256 px.
pub(super) fn round_label(order: &mut PrintOrder) -> Texture {
    wrap_label(order.ground, order.ink, order.word, order.rng)
}

/// The word, or a made-up name, as large as fits; 256 x 64 px.
pub(super) fn lettering(order: &mut PrintOrder) -> Texture {
    const NAMES: [&str; 6] = ["STELLA", "NOVA", "ALTA", "MIRA", "TERRA", "SOLO"];
    let name = NAMES[order.rng.random_range(0..NAMES.len())];
    let word = if order.word.is_empty() { name } else { order.word };
    let scale = (236 / text_width_px(word, 1).max(1)).clamp(1, 7);
    let mut image = Image::filled(256, 64, order.ground.to_rgba8());
    centered_text(&mut image, word, [128, 32 - 7 * scale / 2], scale, order.ink);
    Texture::new(image)
}

/// A mark without letters: a peak in a ring, a star, leaves or chevrons; 256 px.
pub(super) fn emblem(order: &mut PrintOrder) -> Texture {
    mark(order, 1.0)
}

/// The mark in the center of a band twice as long as it is high or more; 512 x 256 px.
pub(super) fn round_emblem(order: &mut PrintOrder) -> Texture {
    mark(order, 2.7)
}

fn mark(order: &mut PrintOrder, aspect: f32) -> Texture {
    let width = if aspect > 1.0 { 512 } else { 256 };
    let zoom = if aspect > 1.0 { 3.2 } else { 2.6 };
    let style = order.rng.random_range(0..4);
    let (ground, ink) = (order.ground, order.ink);
    draw_texture(width, 256, |u, v| {
        smoothed(u, v, [1.0 / width as f32, 1.0 / 256.0], |u, v| {
            let (x, y) = ((u - 0.5) * zoom * aspect, (v - 0.5) * zoom);
            if is_in_emblem(style, x, y) { ink } else { ground }
        })
    })
}

/// Whether a point, with the emblem within 1 of the origin, is inked.
fn is_in_emblem(style: i32, x: f32, y: f32) -> bool {
    let radius = x.hypot(y);
    match style {
        0 => {
            let peak = y > -0.45 && y < 0.45 - 1.3 * x.abs();
            let second = y > -0.45 && y < 0.05 - 1.2 * (x - 0.38).abs();
            let snow = y > 0.12 && (y - 0.12) > 0.8 * (x * 9.0).sin().abs() * 0.12;
            (0.82..1.0).contains(&radius) || ((peak && !snow) || second) && radius < 0.76
        }
        1 => {
            // Ten corners, far and near in turn, joined by straight lines.
            let sector = TAU / 10.0;
            let turn = x.atan2(y).rem_euclid(2.0 * sector);
            let from_tip = if turn > sector { 2.0 * sector - turn } else { turn };
            let inner = 0.4;
            let edge = inner * sector.sin() / (inner * (sector - from_tip).sin() + from_tip.sin());
            radius < edge
        }
        2 => [-0.9_f32, 0.0, 0.9].iter().any(|turn| {
            let (sin, cos) = turn.sin_cos();
            let (across, along) = (x * cos - (y + 0.8) * sin, x * sin + (y + 0.8) * cos);
            let share = along / 1.5;
            (0.1..1.0).contains(&share)
                && across.abs() < 0.3 * (share * TAU / 2.0).sin()
                && (across.abs() > 0.03 || share > 0.8)
        }),
        _ => {
            let level = y - 0.7 * x.abs() + 0.75;
            x.abs() < 0.85 && (0.0..1.35).contains(&level) && level.rem_euclid(0.45) < 0.27
        }
    }
}

/// A heart in the center; 512 x 256 px, for a band twice as long as it is high.
pub(super) fn heart(order: &mut PrintOrder) -> Texture {
    let is_light = order.ground.0.iter().sum::<f32>() > 1.8;
    let usual = if is_light { Rgb::hex(0xc0_39_2f) } else { order.ink };
    let ink = colored_or(order.ink, usual);
    let ground = order.ground;
    draw_texture(512, 256, |u, v| {
        smoothed(u, v, [1.0 / 512.0, 1.0 / 256.0], |u, v| {
            let (x, y) = ((u - 0.5) * 9.0, (v - 0.48) * 3.6);
            let r = x * x + y * y - 1.0;
            if r * r * r - x * x * y * y * y < 0.0 { ink } else { ground }
        })
    })
}

/// The front of a cereal box: the word, or a name, over a bowl of flakes; 256 px.
pub(super) fn cereal(order: &mut PrintOrder) -> Texture {
    const NAMES: [&str; 5] = ["FLAKES", "OATS", "CRUNCH", "LOOPS", "MUESLI"];
    let (ground, accent) = (order.ground, order.ink);
    let name = NAMES[order.rng.random_range(0..NAMES.len())];
    let is_sunny = order.rng.random_range(0..2) == 0;
    let word = if order.word.is_empty() { name } else { order.word };
    let scale = (228 / text_width_px(word, 1).max(1)).clamp(1, 8);
    let band = accent.mix(ground, 0.55);
    let mut image = Image::filled(256, 256, ground.to_rgba8());
    if is_sunny {
        fill_disc(&mut image, 128, 66, 88, band);
    } else {
        fill_rectangle(&mut image, 0, 20, 256, 92, band);
    }
    let china = Rgb([0.96, 0.96, 0.97]);
    for y in 0..74 {
        let half = ((74.0_f32.powi(2) - (y as f32).powi(2)).sqrt()) as i32;
        fill_rectangle(&mut image, 128 - half, 168 + y, 2 * half, 1, china.scaled(1.0 - 0.002 * y as f32));
    }
    for k in 0..60 {
        let share = k as f32 / 59.0;
        let x = 128 + (66.0 * (2.0 * ((k * 37) % 59) as f32 / 58.0 - 1.0)) as i32;
        let y = 150 + (20.0 * share) as i32 + ((x - 128).pow(2)) / 360;
        let tone = [0xb8_70_22, 0xd9_96_3a, 0xe6_b0_58][(k % 3) as usize];
        fill_disc(&mut image, x, y.min(170), 8, Rgb::hex(tone));
    }
    fill_rectangle(&mut image, 50, 174, 156, 4, china.scaled(0.9));
    fill_rectangle(&mut image, 0, 244, 256, 12, accent);
    let light = Rgb([0.98, 0.97, 0.94]);
    centered_text(&mut image, word, [131, 69 - 7 * scale / 2], scale, ground.scaled(0.4));
    centered_text(&mut image, word, [128, 66 - 7 * scale / 2], scale, light);
    Texture::new(image)
}
