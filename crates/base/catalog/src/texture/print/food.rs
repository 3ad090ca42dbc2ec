//! Skins, crusts and cut faces of food.

use rand::RngExt;

use super::PrintOrder;
use super::strokes::smoothed;
use crate::texture::{Noise, draw_texture, fruit_skin};
use geometry::Rgb;
use imaging::Texture;

/// Smooth skin with a blush of the ink; 256 x 128 px.
pub(super) fn skin(order: &mut PrintOrder) -> Texture {
    fruit_skin(order.ground, order.ink, order.rng)
}

/// Dimpled peel; 256 x 128 px.
pub(super) fn peel(order: &mut PrintOrder) -> Texture {
    crate::texture::citrus_peel(order.ground, order.rng)
}

/// Banana peel along v; 128 x 256 px.
pub(super) fn banana_skin(order: &mut PrintOrder) -> Texture {
    crate::texture::banana_skin(order.ground, order.rng)
}

/// Baked crust, paler toward the ink; 256 px.
pub(super) fn crust(order: &mut PrintOrder) -> Texture {
    crate::texture::crust(order.ground, order.ink, order.rng)
}

/// Icing with `count` sprinkles; 256 px.
pub(super) fn sprinkles(order: &mut PrintOrder) -> Texture {
    crate::texture::sprinkles(order.ground, order.count.unwrap_or(60) as usize, order.rng)
}

/// Inside of bread: pale with pores; 128 px, repeats.
pub(super) fn crumb(order: &mut PrintOrder) -> Texture {
    let (pores, cloud) = (Noise::new(34, 34, order.rng), Noise::new(6, 6, order.rng));
    draw_texture(128, 128, |u, v| {
        let pore = (pores.at(u, v) - 0.72).max(0.0);
        order.ground.scaled(0.96 + 0.06 * cloud.at(u, v) - 0.9 * pore)
    })
}

/// Sponge, of cake or for washing: large and small pores; 256 px, repeats.
pub(super) fn sponge(order: &mut PrintOrder) -> Texture {
    let (large, small) = (Noise::new(26, 26, order.rng), Noise::new(64, 64, order.rng));
    let cloud = Noise::new(5, 5, order.rng);
    draw_texture(256, 256, |u, v| {
        let pore = (large.at(u, v) - 0.74).max(0.0) * 1.3 + (small.at(u, v) - 0.7).max(0.0) * 0.7;
        order.ground.scaled(0.97 + 0.09 * cloud.at(u, v) - pore.min(0.45))
    })
}

/// Cheese with round holes, lit from above; 256 px. `count` is their number.
pub(super) fn cheese(order: &mut PrintOrder) -> Texture {
    let rng = &mut *order.rng;
    let mut spots: Vec<[f32; 3]> = Vec::new();
    for k in 0..order.count.unwrap_or(13).min(60) * 8 {
        let radius = if k < 40 { rng.random_range(0.045..0.085) } else { rng.random_range(0.015..0.04) };
        let spot = [rng.random_range(0.08..0.92), rng.random_range(0.1..0.9), radius];
        let is_free = |[x, y, other]: &[f32; 3]| (x - spot[0]).hypot(y - spot[1]) > other + radius + 0.02;
        if spots.len() < order.count.unwrap_or(13) as usize && spots.iter().all(is_free) {
            spots.push(spot);
        }
    }
    let cloud = Noise::new(5, 5, rng);
    let ground = order.ground;
    draw_texture(256, 256, |u, v| {
        smoothed(u, v, [1.0 / 256.0; 2], |u, v| {
            let mut shade = 0.97 + 0.05 * cloud.at(u, v);
            for [x, y, radius] in &spots {
                let (dx, dy) = ((u - x) / radius, (v - y) / radius);
                let square = dx * dx + dy * dy;
                if square < 1.0 {
                    // The hole's upper wall is in shadow, its lower one is lit.
                    shade = 0.8 - 0.16 * dy - 0.06 * (1.0 - square);
                } else if square < 1.2 {
                    shade += 0.04;
                }
            }
            ground.scaled(shade)
        })
    })
}

/// A baguette's crust seen from above, along u, with `count` slanted cuts of the ink; 512 x 128 px.
pub(super) fn scored_crust(order: &mut PrintOrder) -> Texture {
    /// Length by width of the loaf.
    const LENGTH: f32 = 8.0;
    let count = order.count.unwrap_or(5).clamp(1, 12);
    let (broad, fine) = (Noise::new(14, 4, order.rng), Noise::new(90, 24, order.rng));
    let jitter = Noise::new(count as usize, 1, order.rng);
    let (ground, ink) = (order.ground, order.ink);
    let pale = ground.mix(Rgb::hex(0xe8_bd_7c), 0.6);
    let half = 0.36 * LENGTH / count as f32;
    draw_texture(512, 128, |u, v| {
        let mixed = ground.mix(pale, (0.9 * broad.at(u, v) - 0.1).clamp(0.0, 1.0));
        let crust = mixed.scaled(0.86 + 0.24 * fine.at(u, v));
        let cut = (0..count).find_map(|k| {
            let share = (k as f32 + 0.5) / count as f32;
            let shift = 0.06 * (jitter.at(share, 0.0) - 0.5);
            let (dx, dy) = ((u - 0.5 - 0.84 * (share - 0.5)) * LENGTH, v - 0.5 - shift);
            let (sin, cos) = 0.3_f32.sin_cos();
            let (along, across) = ((dx * cos + dy * sin) / half, (dy * cos - dx * sin) / 0.19);
            let square = along * along + across * across;
            (square < 1.0).then_some((square, across))
        });
        match cut {
            Some((square, across)) if square > 0.6 && across > 0.0 => ground.scaled(0.62),
            Some((square, _)) => crust.mix(ink, 0.85 - 0.5 * square).scaled(0.9 + 0.15 * fine.at(v, u)),
            None => crust,
        }
    })
}

/// Layers of pastry across v, darker on each roll; 128 x 256 px.
pub(super) fn croissant_crust(order: &mut PrintOrder) -> Texture {
    let (streak, fine) = (Noise::new(5, 42, order.rng), Noise::new(20, 60, order.rng));
    draw_texture(128, 256, |u, v| {
        let layer = 0.5 + 0.5 * (v * 7.0 * std::f32::consts::TAU).cos();
        let pale = (0.45 * layer + 0.7 * streak.at(u, v) - 0.35).clamp(0.0, 0.8);
        order.ground.mix(Rgb::hex(0xe9_b8_66), pale).scaled(0.9 + 0.2 * fine.at(u, v))
    })
}

/// A root's skin with short darker rings across, greenish at the end, along v; 64 x 256 px.
pub(super) fn ringed_skin(order: &mut PrintOrder) -> Texture {
    let marks = Noise::new(9, 48, order.rng);
    draw_texture(64, 256, |u, v| {
        let mark = (marks.at(u, v) - 0.72).max(0.0) * 1.6;
        let end = ((v - 0.95) * 14.0).clamp(0.0, 0.7);
        order.ground.scaled(1.0 - mark).mix(Rgb::hex(0x7d_8a_2e), end)
    })
}

/// Skin with pale streaks and bumps along v, as of a cucumber; 128 x 256 px.
pub(super) fn bumpy_skin(order: &mut PrintOrder) -> Texture {
    let (streak, bumps) = (Noise::new(18, 3, order.rng), Noise::new(24, 60, order.rng));
    let pale = order.ground.mix(Rgb::hex(0xd8_dc_8a), 0.7);
    draw_texture(128, 256, |u, v| {
        let end = ((v - 0.5).abs() * 2.0 - 0.85).max(0.0);
        let bump = ((bumps.at(u, v) - 0.86) * 5.0).clamp(0.0, 0.4);
        order.ground.mix(pale, ((streak.at(u, v) - 0.5).max(0.0) * 1.1 + end + bump).min(0.85))
    })
}
