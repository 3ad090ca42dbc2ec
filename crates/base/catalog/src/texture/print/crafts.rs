//! Needlework, colors and small parts.

use rand::RngExt;
use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};

use super::PrintOrder;
use super::strokes::{covered, smoothed};
use crate::texture::{Noise, draw_texture, fill_disc};
use geometry::Rgb;
use imaging::{Image, Texture};

/// Pigments of an artist's set, white last.
pub(super) const PIGMENTS: [u32; 12] = [
    0xd8_2c_2c, 0xf0_7c_1e, 0xf4_d0_28, 0x8a_c0_38, 0x2f_8a_48, 0x26_9a_a8, 0x2c_5c_c0, 0x5a_3a_a0,
    0xc0_3a_8a, 0x8a_5a_33, 0x22_22_26, 0xf4_f2_ec,
];

/// Strands of a ball of yarn, wound about seven axes; 512 x 256 px, u around the ball and v from its foot.
pub(super) fn windings(order: &mut PrintOrder) -> Texture {
    let axes: Vec<Vec3> = (0..7)
        .map(|k| {
            let bundle = k as f32;
            let tilt = 0.5 + 0.62 * bundle + order.rng.random_range(0.0..0.3);
            Quat::from_rotation_z(1.9 * bundle + 0.3) * Quat::from_rotation_x(tilt) * Vec3::Z
        })
        .collect();
    let (crest, shade) = (order.ground.scaled(1.1), order.ground.scaled(0.6));
    draw_texture(512, 256, |u, v| {
        let ((sin, cos), polar) = ((TAU * u).sin_cos(), PI * v);
        let direction = Vec3::new(polar.sin() * cos, polar.sin() * sin, -polar.cos());
        shade.mix(crest, strand_brightness(&axes, direction))
    })
}

/// Brightness in a direction, 0 in a groove and 1 on a crest: three strands side by side around each axis,
/// the later axes over the earlier ones, and fine strands where none of them lies.
fn strand_brightness(axes: &[Vec3], direction: Vec3) -> f32 {
    /// Width of a strand, radians.
    const STRAND: f32 = 0.17;
    let across = |axis: &Vec3| axis.dot(direction).clamp(-1.0, 1.0).asin();
    let covering = axes.iter().rev().map(across).find(|s| s.abs() < 1.5 * STRAND);
    let (s, width, share) = match covering {
        Some(s) => (s, STRAND, 1.0),
        None => (across(&axes[0]), 0.5 * STRAND, 0.8),
    };
    let from_crest = s / width - (s / width).round();
    share * (0.25 + 0.75 * (PI * from_crest).cos())
}

/// Short fur in tufts; 256 px, repeats.
pub(super) fn plush(order: &mut PrintOrder) -> Texture {
    let (tufts, hair) = (Noise::new(36, 36, order.rng), Noise::new(100, 60, order.rng));
    let lean = Noise::new(9, 9, order.rng);
    draw_texture(256, 256, |u, v| {
        let shift = 0.05 * lean.at(u, v);
        let shade = 0.72 + 0.2 * tufts.at(u + shift, v) + 0.3 * hair.at(u + shift, v + shift);
        order.ground.scaled(shade)
    })
}

/// Cloth of the ground with a satin-stitched flower of the ink; 256 px. `count` is the number of petals.
pub(super) fn embroidery(order: &mut PrintOrder) -> Texture {
    let weave = Noise::new(64, 64, order.rng);
    let random = [5, 6, 8][order.rng.random_range(0..3)];
    let petals = order.count.unwrap_or(random) as f32;
    let (ground, ink) = (order.ground, order.ink);
    let cloth = draw_texture(256, 256, |u, v| {
        smoothed(u, v, [1.0 / 256.0; 2], |u, v| {
            let (x, y) = (u - 0.5, v - 0.58);
            let (radius, angle) = (x.hypot(y), y.atan2(x));
            let wave = (angle * petals * 0.5).cos().abs();
            let thread = 0.88 + 0.16 * ((angle * 60.0).sin() * 0.5 + 0.5);
            let stem = (u - 0.5 + 0.05 * (v * 9.0).sin()).abs();
            if radius < 0.055 {
                Rgb::hex(0xf2_c0_30).scaled(thread)
            } else if radius < 0.09 + 0.14 * wave {
                ink.scaled(thread)
            } else if ((0.14..0.46).contains(&v) && stem < 0.012) || is_in_leaf(u, v) {
                Rgb::hex(0x3f_8a_48).scaled(0.9 + 0.14 * (160.0 * (u + 0.5 * v)).sin())
            } else {
                ground.scaled(0.94 + 0.08 * weave.at(u, v))
            }
        })
    });
    let mut image = (*cloth).clone();
    for k in 0..10 {
        let (sin, cos) = (TAU * k as f32 / 10.0).sin_cos();
        let (x, y) = (128.0 - 98.0 * sin, 128.0 + 98.0 * cos);
        fill_disc(&mut image, x as i32, y as i32, 4, ink.scaled(0.8));
    }
    Texture::new(image)
}

fn is_in_leaf(u: f32, v: f32) -> bool {
    [(0.38, 0.30, -0.6_f32), (0.62, 0.26, 0.6)].iter().any(|(center_u, center_v, lean)| {
        let ((sin, cos), du, dv) = (lean.sin_cos(), u - center_u, v - center_v);
        let (along, across) = ((du * cos + dv * sin) / 0.09, (dv * cos - du * sin) / 0.032);
        along * along + across * across < 1.0
    })
}

/// Two rows of round pans of color; 512 x 256 px. `count` is their number.
pub(super) fn color_wells(order: &mut PrintOrder) -> Texture {
    let columns = order.count.unwrap_or(12).div_ceil(2).clamp(1, 12);
    let wet = Noise::new(40, 20, order.rng);
    let (pitch_x, pitch_y) = (512.0 / columns as f32, 128.0);
    let radius = 0.42 * pitch_x.min(pitch_y);
    let ground = order.ground;
    draw_texture(512, 256, |u, v| {
        let (x, y) = (u * 512.0, v * 256.0);
        let (column, row) = ((x / pitch_x) as usize, (y / pitch_y) as usize);
        let (dx, dy) = (x - (column as f32 + 0.5) * pitch_x, y - (row as f32 + 0.5) * pitch_y);
        let distance = dx.hypot(dy);
        let pigment = Rgb::hex(PIGMENTS[(row * columns as usize + column) % PIGMENTS.len()]);
        let shadow = 0.75 + 0.25 * (distance / radius - dy / radius).clamp(0.0, 1.0);
        let rim = ground.scaled(if distance > radius { 0.86 } else { 1.0 });
        let edge = ground.mix(rim, covered((distance - radius - 2.0).abs() - 2.0));
        edge.mix(pigment.scaled(shadow * (0.9 + 0.15 * wet.at(u, v))), covered(distance - radius))
    })
}

/// Dabs of color around the ground and a mixed smear at the center; 256 px. `count` is their number.
pub(super) fn palette_spots(order: &mut PrintOrder) -> Texture {
    let count = order.count.unwrap_or(9).clamp(1, 12) as usize;
    let rng = &mut *order.rng;
    let first = rng.random_range(0..PIGMENTS.len());
    let pigment = |k: usize| Rgb::hex(PIGMENTS[(first + k) % PIGMENTS.len()]);
    let mut dabs: Vec<[f32; 4]> = (0..count)
        .map(|k| {
            let angle = PI * (0.15 + 1.35 * k as f32 / count as f32);
            let radius = rng.random_range(0.055..0.075);
            let turn = rng.random_range(0.0..TAU);
            [0.5 + 0.36 * angle.cos(), 0.5 + 0.36 * angle.sin(), radius, turn]
        })
        .collect();
    dabs.push([0.5, 0.46, 0.12, 0.6]);
    let ground = order.ground;
    draw_texture(256, 256, |u, v| {
        let mut color = ground;
        for (k, [x, y, radius, turn]) in dabs.iter().enumerate() {
            let (dx, dy) = (u - x, v - y);
            let distance = dx.hypot(dy);
            if distance > 1.2 * radius {
                continue;
            }
            let angle = dy.atan2(dx) + turn;
            let edge = radius * (1.0 + 0.09 * (3.0 * angle).sin() + 0.04 * (5.0 * angle).cos());
            let gloss = 1.0 + 0.5 * ((dy - dx) / radius - 0.5).clamp(0.0, 0.5);
            let smear = pigment(1).mix(pigment(6), 0.5 + 0.5 * (40.0 * dx + 12.0 * dy).sin());
            let dab = if k == count { smear } else { pigment(k).scaled(gloss) };
            color = color.mix(dab, covered((distance - edge) * 256.0));
        }
        color
    })
}

/// A layer of beads of the two colors and shades between them; 128 px, repeats. `count` is their number along
/// u.
pub(super) fn beads(order: &mut PrintOrder) -> Texture {
    let count = order.count.unwrap_or(8).clamp(2, 16) as i32;
    let (ground, ink) = (order.ground, order.ink);
    let colors = [ground, ink, ground.mix(ink, 0.5), ground.scaled(0.75)];
    let (pitch, radius) = (128 / count, 70 / count);
    let rng = &mut *order.rng;
    let mut image = Image::filled(128, 128, ground.scaled(0.4).to_rgba8());
    for k in 0..count * count {
        let [x, y] = [k % count, k / count].map(|c| pitch / 2 + pitch * c + rng.random_range(-2..3));
        let color = colors[rng.random_range(0..colors.len())];
        fill_disc(&mut image, x, y, radius, color.scaled(0.8));
        fill_disc(&mut image, x - radius / 8, y - radius / 8, radius * 7 / 8, color);
        fill_disc(&mut image, x - radius / 3, y - radius / 3, radius / 4, color.mix(Rgb([1.0; 3]), 0.6));
    }
    Texture::new(image)
}
