//! Works of art on canvas.

use rand::RngExt;
use std::f32::consts::TAU;

use super::PrintOrder;
use super::crafts::PIGMENTS;
use crate::texture::{Noise, draw_texture, fill_disc, fill_rectangle};
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

/// A landscape, an abstract work or a vase of flowers on canvas, some of it in the ground's color; 256 px.
pub(super) fn artwork(order: &mut PrintOrder) -> Texture {
    let (color, rng) = (order.ground, &mut *order.rng);
    let drawn = match rng.random_range(0..3) {
        0 => landscape(rng),
        1 => abstract_work(color, rng),
        _ => vase(color, rng),
    };
    let brush = Noise::new(60, 24, rng);
    draw_texture(256, 256, |u, v| {
        let [red, green, blue, _] = drawn.pixel((u * 256.0) as u32, ((1.0 - v) * 256.0) as u32);
        let color = Rgb([red, green, blue].map(|channel| f32::from(channel) / 255.0));
        color.scaled(0.92 + 0.14 * brush.at(u, v))
    })
}

fn pigment(rng: &mut Rng) -> Rgb {
    Rgb::hex(PIGMENTS[rng.random_range(0..PIGMENTS.len())])
}

fn landscape(rng: &mut Rng) -> Texture {
    let (ridge, far) = (Noise::new(5, 1, rng), Noise::new(9, 1, rng));
    let is_dusk = rng.random_range(0..2) == 0;
    let (high, low) = if is_dusk { (0x3a_5a_9a, 0xf4_b0_7a) } else { (0x4a_96_d8, 0xd8_ec_f4) };
    let (sun_u, sun_v) = (rng.random_range(0.2..0.8_f32), rng.random_range(0.66..0.84_f32));
    draw_texture(256, 256, |u, v| {
        let distance = ((u - sun_u).powi(2) * 1.5 + (v - sun_v).powi(2)).sqrt();
        if v < 0.30 + 0.10 * ridge.at(u, 0.0) {
            Rgb::hex(0x3f_7a_3c).mix(Rgb::hex(0xc8_b8_4a), (v * 3.0 * far.at(2.0 * u, v)).clamp(0.0, 1.0))
        } else if v < 0.38 + 0.28 * far.at(u, 0.3) {
            Rgb::hex(0x4c_5c_82).mix(Rgb([1.0; 3]), if v > 0.52 { 0.75 } else { 0.1 })
        } else if distance < 0.085 {
            Rgb::hex(0xff_ec_a0)
        } else {
            Rgb::hex(low).mix(Rgb::hex(high), ((v - 0.4) / 0.6).clamp(0.0, 1.0))
        }
    })
}

fn abstract_work(color: Rgb, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(256, 256, Rgb::hex(0xee_e6_d2).to_rgba8());
    for k in 0..9 {
        let color = if k == 0 { color } else { pigment(rng) };
        let (x, y) = (rng.random_range(0..220), rng.random_range(0..220));
        if rng.random_range(0..2) == 0 {
            fill_disc(&mut image, x + 16, y + 16, rng.random_range(14..48), color);
        } else {
            let (width, height) = (rng.random_range(30..110), rng.random_range(12..72));
            fill_rectangle(&mut image, x, y, width, height, color);
        }
    }
    for _ in 0..3 {
        let (x, y) = (rng.random_range(0..256), rng.random_range(0..256));
        fill_rectangle(&mut image, x, 0, 4, 256, Rgb::hex(0x1c_1c_20));
        fill_rectangle(&mut image, 0, y, 256, 4, Rgb::hex(0x1c_1c_20));
    }
    Texture::new(image)
}

fn vase(color: Rgb, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(256, 256, Rgb::hex(0xd8_e4_e0).to_rgba8());
    fill_rectangle(&mut image, 0, 190, 256, 66, Rgb::hex(0xb0_80_52));
    let blossoms: Vec<(i32, i32, Rgb)> = (0..6)
        .map(|k| (62 + 26 * k, rng.random_range(52..104), if k == 2 { color } else { pigment(rng) }))
        .collect();
    for (x, y, _) in &blossoms {
        super::strokes::draw_line(
            &mut image,
            [*x as f32, *y as f32],
            [128.0 + 0.25 * (x - 128) as f32, 152.0],
            5,
            Rgb::hex(0x3c_80_44),
        );
    }
    for (x, y, color) in blossoms {
        for petal in 0..6 {
            let (sin, cos) = (TAU * petal as f32 / 6.0).sin_cos();
            fill_disc(&mut image, x + (15.0 * cos) as i32, y + (15.0 * sin) as i32, 10, color);
        }
        fill_disc(&mut image, x, y, 8, Rgb::hex(0xf6_d8_4a));
    }
    for row in 0..80 {
        let half = 32 + (10.0 * (row as f32 / 80.0 * TAU / 2.0).sin()) as i32;
        fill_rectangle(&mut image, 128 - half, 146 + row, 2 * half, 1, Rgb::hex(0x3a_5a_92));
    }
    fill_rectangle(&mut image, 88, 144, 80, 8, Rgb::hex(0x4a_6c_a8));
    Texture::new(image)
}
