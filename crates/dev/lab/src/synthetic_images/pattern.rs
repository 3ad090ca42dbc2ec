//! Procedural table-top textures that the catalog lacks: staves, slats, terrazzo, herringbone, tiles, inlays.
//!
//! Textures have 256 pixels a side. All but inlays tile seamlessly.

use rand::RngExt;

use super::sampling::{any_color, near, pale, pick, uniform, weighted, wood_color};
use catalog::texture::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

const SIDE_PX: u32 = 256;

/// Short glued staves in rows along u, each stave with its own shade.
pub(super) fn staves(rng: &mut Rng, rows: usize, across: usize) -> Texture {
    let color = wood_color(rng);
    let contrast = uniform(rng, 0.08, 0.4) as f32;
    let shades: Vec<f32> = (0..rows * across).map(|_| rng.random_range(-0.5..0.5)).collect();
    let shifts: Vec<f32> = (0..rows).map(|_| rng.random_range(0.0..1.0)).collect();
    let grain = Noise::new(8, 8 * rows, rng);
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let row = ((v * rows as f32) as usize).min(rows - 1);
        let along = (u + shifts[row]).fract() * across as f32;
        let stave = (along as usize).min(across - 1);
        let seam = if (v * rows as f32).fract() < 0.05 || along.fract() < 0.02 { 0.84 } else { 1.0 };
        color.scaled((1.0 + contrast * shades[row * across + stave] + 0.12 * (grain.at(u, v) - 0.5)) * seam)
    })
}

/// Boards along u with dark gaps.
pub(super) fn slats(rng: &mut Rng) -> Texture {
    let color = if rng.random_range(0.0..1.0) < 0.7 { wood_color(rng) } else { any_color(rng) };
    let boards = rng.random_range(3..9_usize) as f32;
    let gap = uniform(rng, 0.04, 0.16) as f32;
    let grain = Noise::new(3, 64, rng);
    let dark = color.scaled(uniform(rng, 0.1, 0.45) as f32);
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let across = (v * boards).fract();
        if across < gap { dark } else { color.scaled(0.92 + 0.16 * grain.at(u, v)) }
    })
}

/// Stone chips in a matrix.
pub(super) fn terrazzo(rng: &mut Rng) -> Texture {
    let ground = weighted(rng, &[(0, 3.0), (1, 1.0)]);
    let ground = if ground == 0 { pale(rng) } else { any_color(rng) };
    let chips: Vec<([f32; 2], f32, Rgb)> = (0..rng.random_range(60..200))
        .map(|_| {
            let at = [rng.random_range(0.0..1.0), rng.random_range(0.0..1.0)];
            let color = any_color(rng).mix(ground, uniform(rng, 0.2, 0.7) as f32);
            (at, rng.random_range(0.004..0.02), color)
        })
        .collect();
    let wobble = Noise::new(24, 24, rng);
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let apart = |a: f32, b: f32| {
            let d = (a - b).abs();
            d.min(1.0 - d)
        };
        let reach = 0.6 + 0.9 * wobble.at(u, v);
        let chip = chips.iter().find(|([x, y], radius, _)| {
            apart(u, *x) + apart(v, *y) < 1.3 * radius * reach
                && apart(u, *x).hypot(apart(v, *y)) < radius * reach
        });
        chip.map_or(ground, |(_, _, color)| *color)
    })
}

/// Basket-weave parquet: pairs of blocks at right angles, each pair with its own shade.
pub(super) fn basket_parquet(rng: &mut Rng) -> Texture {
    let color = wood_color(rng);
    let blocks = 2 * rng.random_range(1..4_usize);
    let strips = rng.random_range(3..7_usize);
    let contrast = uniform(rng, 0.1, 0.35) as f32;
    let shades = Noise::new(blocks * strips, blocks * strips, rng);
    let grain = [Noise::new(4, 96, rng), Noise::new(96, 4, rng)];
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let (x, y) = (u * blocks as f32, v * blocks as f32);
        let lying = (x as usize + y as usize).is_multiple_of(2);
        let across = if lying { y.fract() } else { x.fract() } * strips as f32;
        let end = if lying { x.fract() } else { y.fract() };
        let seam = if across.fract() < 0.06 || end < 0.015 { 0.7 } else { 1.0 };
        let strip = (across as usize) as f32 / strips as f32;
        let shade = shades
            .at((x as usize as f32 + strip) / blocks as f32, (y as usize as f32 + strip) / blocks as f32);
        let fine = grain[usize::from(!lying)].at(u, v);
        color.scaled((0.86 + contrast * shade + 0.1 * fine) * seam)
    })
}

/// Tiles with joints, each tile with its own shade.
pub(super) fn tiles(rng: &mut Rng) -> Texture {
    let color = if rng.random_range(0.0..1.0) < 0.5 { pale(rng) } else { any_color(rng) };
    let count = rng.random_range(2..6_usize);
    let shades: Vec<f32> = (0..count * count).map(|_| rng.random_range(-0.06..0.06)).collect();
    let joint = near(rng, Rgb([0.55; 3]), 0.3);
    let width = uniform(rng, 0.02, 0.07) as f32;
    let cloud = Noise::new(9, 9, rng);
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let (x, y) = (u * count as f32, v * count as f32);
        if x.fract() < width || y.fract() < width {
            return joint;
        }
        let shade = shades[(y as usize).min(count - 1) * count + (x as usize).min(count - 1)];
        color.scaled(0.97 + shade + 0.08 * (cloud.at(u, v) - 0.5))
    })
}

/// A border band and a medallion of other woods; covers the whole top once.
pub(super) fn inlay(rng: &mut Rng) -> Texture {
    let color = wood_color(rng);
    let other = [wood_color(rng), any_color(rng)];
    let (outer, width) = (uniform(rng, 0.03, 0.12) as f32, uniform(rng, 0.01, 0.05) as f32);
    let medallion = uniform(rng, -0.1, 0.28) as f32;
    let petals = pick(rng, &[0.0_f32, 4.0, 6.0, 8.0]);
    let grain = Noise::new(4, 80, rng);
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let edge = u.min(1.0 - u).min(v).min(1.0 - v);
        let (x, y) = (u - 0.5, v - 0.5);
        let reach = medallion * (1.0 + 0.25 * (petals * y.atan2(x)).cos());
        let base = if (outer..outer + width).contains(&edge) {
            other[0]
        } else if x.hypot(y) < reach {
            other[usize::from(x.hypot(y) < 0.55 * reach)]
        } else {
            color
        };
        base.scaled(0.93 + 0.14 * grain.at(u, v))
    })
}

/// Clouded cement with stains and pores.
pub(super) fn cement(rng: &mut Rng) -> Texture {
    let color = near(rng, Rgb([0.66, 0.65, 0.63]), 0.2);
    let octaves = [3, 8, 21].map(|n| Noise::new(n, n, rng));
    let pores = Noise::new(90, 90, rng);
    let depth = uniform(rng, 0.1, 0.35) as f32;
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let cloud: f32 =
            octaves.iter().zip([0.5, 0.3, 0.2]).map(|(noise, weight)| weight * noise.at(u, v)).sum();
        let pore = (pores.at(u, v) - 0.86).max(0.0) * 2.5;
        color.scaled(1.0 + depth * (cloud - 0.5) - pore)
    })
}

/// Woven colored stripes in both directions.
pub(super) fn plaid(rng: &mut Rng) -> Texture {
    let ground = if rng.random_range(0.0..1.0) < 0.5 { pale(rng) } else { any_color(rng) };
    let band = any_color(rng);
    let (wide, thin) = (rng.random_range(2..6_usize) as f32, uniform(rng, 0.05, 0.3) as f32);
    let strength = uniform(rng, 0.2, 0.6) as f32;
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let on = |t: f32| {
            let t = (t * wide).fract();
            f32::from(u8::from(t < 0.4)) + 0.5 * f32::from(u8::from((0.6..0.6 + thin).contains(&t)))
        };
        let thread = if ((u * 128.0) as usize + (v * 128.0) as usize).is_multiple_of(2) { 1.0 } else { 0.97 };
        ground.mix(band, (strength * 0.5 * (on(u) + on(v))).min(1.0)).scaled(thread)
    })
}

/// Figured veneer: light and dark swirls.
pub(super) fn burl(rng: &mut Rng) -> Texture {
    let color = wood_color(rng);
    let octaves = [4, 9, 20].map(|n| Noise::new(n, n, rng));
    let rings = uniform(rng, 3.0, 9.0) as f32;
    let depth = uniform(rng, 0.15, 0.45) as f32;
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        let swirl = octaves[0].at(u, v) + 0.5 * octaves[1].at(u, v) + 0.2 * octaves[2].at(u, v);
        let wave = (swirl * rings * std::f32::consts::TAU).sin();
        color.scaled(0.95 + 0.5 * depth * wave * (0.4 + 0.6 * octaves[1].at(v, u)))
    })
}

/// A pale board with a faint fine pattern, like laminate.
pub(super) fn laminate(rng: &mut Rng) -> Texture {
    let color = if rng.random_range(0.0..1.0) < 0.75 { pale(rng) } else { any_color(rng) };
    let (fine, coarse) = (Noise::new(60, 110, rng), Noise::new(5, 7, rng));
    let depth = uniform(rng, 0.0, 0.07) as f32;
    draw_texture(SIDE_PX, SIDE_PX, |u, v| {
        color.scaled(1.0 + depth * (fine.at(u, v) - 0.5) + 0.5 * depth * (coarse.at(u, v) - 0.5))
    })
}
