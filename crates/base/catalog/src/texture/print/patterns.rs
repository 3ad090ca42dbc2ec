//! Patterns: stripes, squares, rings, holes, blossoms.

use rand::RngExt;
use std::f32::consts::TAU;

use super::PrintOrder;
use super::strokes::{colored_or, smoothed};
use crate::texture::{Noise, brushed_metal, ceramic_speckle, checker, draw_texture, fill_disc, wicker};
use geometry::Rgb;
use imaging::{Image, Texture};

/// Bands along v; 64 x 256 px.
pub(super) fn stripes(order: &mut PrintOrder) -> Texture {
    crate::texture::stripes(order.ground, order.ink, order.count.unwrap_or(8) as usize)
}

/// Squares; 256 px.
pub(super) fn squares(order: &mut PrintOrder) -> Texture {
    let count = order.count.unwrap_or(6) as usize;
    checker(order.ground, order.ink, count, count)
}

/// `count` lines around: up to eight of them below the rim, more from the foot to the rim; 64 x 256 px.
pub(super) fn bands(order: &mut PrintOrder) -> Texture {
    let count = order.count.unwrap_or(3).max(1) as f32;
    let width = order.rng.random_range(0.3..0.5_f32);
    let (low, high) = match count as u32 {
        1 => (0.45, 0.8),
        2..=8 => (0.55, 0.85),
        _ => (0.0, 1.0),
    };
    let (ground, ink) = (order.ground, order.ink);
    draw_texture(64, 256, |_, v| {
        let along = (v - low) / (high - low) * count;
        if (0.0..count).contains(&along) && along.fract() < width { ink } else { ground }
    })
}

/// Two glazes, the lower one in the ink up to a wavy edge; 256 px.
pub(super) fn dipped(order: &mut PrintOrder) -> Texture {
    let wave = Noise::new(7, 1, order.rng);
    let (ground, ink) = (order.ground, order.ink);
    draw_texture(256, 256, |u, v| {
        let edge = 0.42 + 0.06 * (wave.at(u, 0.0) - 0.5);
        let seam = 1.0 - 0.12 * (1.0 - ((v - edge) / 0.012).abs()).max(0.0);
        if v < edge { ink.scaled(seam) } else { ground.scaled(seam) }
    })
}

/// Glaze with darker specks; 256 px, repeats.
pub(super) fn speckle(order: &mut PrintOrder) -> Texture {
    ceramic_speckle(order.ground, order.rng)
}

/// Metal with fine streaks along u; 128 px, repeats.
pub(super) fn brushed(order: &mut PrintOrder) -> Texture {
    brushed_metal(order.ground, order.rng)
}

/// Basketwork; 256 px, repeats. `count` is the number of withies across.
pub(super) fn woven(order: &mut PrintOrder) -> Texture {
    let strands = order.count.unwrap_or(16).clamp(2, 64).next_multiple_of(2);
    wicker(order.ground, strands as usize, order.rng)
}

/// Expanded metal: dark openings between strands; 256 px, repeats. `count` is the number of openings along u.
pub(super) fn lattice(order: &mut PrintOrder) -> Texture {
    let count = order.count.unwrap_or(8) as f32;
    let ground = order.ground;
    draw_texture(256, 256, |u, v| {
        smoothed(u, v, [1.0 / 256.0; 2], |u, v| {
            let (a, b) = ((count * (u + v)).fract(), (count * (u - v)).rem_euclid(1.0));
            if a < 0.32 || b < 0.32 { ground } else { ground.scaled(0.3) }
        })
    })
}

/// Rows of round holes, as before a loudspeaker; 256 px, repeats. `count` is the number of holes along u.
pub(super) fn grille(order: &mut PrintOrder) -> Texture {
    let count = order.count.unwrap_or(16) as f32;
    let ground = order.ground;
    draw_texture(256, 256, |u, v| {
        smoothed(u, v, [1.0 / 256.0; 2], |u, v| {
            let (x, y) = ((count * u).fract() - 0.5, (count * v).fract() - 0.5);
            if x * x + y * y < 0.1 { ground.scaled(0.35) } else { ground }
        })
    })
}

/// Blossoms of the ink with yellow centers, scattered; 256 px, repeats.
pub(super) fn blossoms(order: &mut PrintOrder) -> Texture {
    let mut image = Image::filled(256, 256, order.ground.to_rgba8());
    let rng = &mut *order.rng;
    for k in 0..16 {
        let center = [32 + 64 * (k % 4), 32 + 64 * (k / 4)].map(|c| c + rng.random_range(-8..9));
        let (reach, turn) = (rng.random_range(10.0..14.0_f32), rng.random_range(0.0..TAU));
        blossom(&mut image, center, reach, turn, order.ink);
    }
    Texture::new(image)
}

/// Draws a blossom with five petals.
fn blossom(image: &mut Image, [x, y]: [i32; 2], reach: f32, turn: f32, petals: Rgb) {
    for k in 0..5 {
        let (sin, cos) = (turn + TAU * k as f32 / 5.0).sin_cos();
        fill_disc(image, x + (reach * cos).round() as i32, y + (reach * sin).round() as i32, 8, petals);
    }
    fill_disc(image, x, y, 6, Rgb::hex(0xf2_c8_3f));
}

/// A row of blossoms with leaves, as around a teacup; 512 x 256 px. The petals are the ink where it has a
/// hue.
pub(super) fn flowers(order: &mut PrintOrder) -> Texture {
    let rng = &mut *order.rng;
    let usual = [0xc7_5b_7a, 0x4f_6f_b0, 0xd0_8a_3c].map(Rgb::hex)[rng.random_range(0..3)];
    let petals = colored_or(order.ink, usual);
    let spots: Vec<(f32, f32, f32)> = (0..9)
        .map(|k| {
            let u = (k as f32 + rng.random_range(0.2..0.8)) / 9.0;
            (u, rng.random_range(0.45..0.8), rng.random_range(0.0..TAU))
        })
        .collect();
    let ground = order.ground;
    draw_texture(512, 256, |u, v| {
        smoothed(u, v, [1.0 / 512.0, 1.0 / 256.0], |u, v| {
            let colors = spots.iter().filter_map(|&(su, sv, turn)| {
                let (x, y) = ((u - su - (u - su).round()) * 6.0, (v - sv) * 2.0);
                flower(x, y, turn, petals)
            });
            colors.reduce(|first, next| if first.0 >= next.0 { first } else { next }).map_or(ground, |c| c.1)
        })
    })
}

/// Color of a flower at a point, and its layer: center over petals over leaves.
fn flower(x: f32, y: f32, turn: f32, petals: Rgb) -> Option<(u8, Rgb)> {
    if x.abs() > 0.34 || y.abs() > 0.34 {
        return None;
    }
    let (radius, angle) = (x.hypot(y), y.atan2(x) + turn);
    if radius < 0.06 {
        return Some((2, Rgb::hex(0xe8_c0_4a)));
    }
    if radius < 0.19 * (0.7 + 0.3 * (5.0 * angle).cos()) {
        return Some((1, petals.scaled(0.85 + radius)));
    }
    let (sin, cos) = turn.sin_cos();
    let (along, across) = (x * cos + y * sin, y * cos - x * sin);
    let is_in_leaf = [-1.0, 1.0].iter().any(|side| {
        let share = (side * along - 0.1) / 0.22;
        (0.0..1.0).contains(&share) && across.abs() < 0.055 * (share * TAU / 2.0).sin()
    });
    is_in_leaf.then(|| (0, Rgb::hex(0x5a_8a_4a)))
}
