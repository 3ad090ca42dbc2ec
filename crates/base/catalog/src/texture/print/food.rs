//! Skins, crusts and cut faces of food.

use rand::RngExt;

use super::PrintOrder;
use super::strokes::smoothed;
use crate::texture::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;

/// Smooth skin: streaks from stem to base, a blush of the ink on one side, paler dots; u repeats.
pub(super) fn skin(order: &mut PrintOrder) -> Texture {
    let (color, blush, rng) = (order.ground, order.ink, &mut *order.rng);
    let (side, streak, dots) = (Noise::new(2, 2, rng), Noise::new(40, 3, rng), Noise::new(56, 40, rng));
    draw_texture(256, 128, |u, v| {
        let amount = (1.3 * side.at(u, v) - 0.6 + 0.5 * (streak.at(u, v) - 0.5)).clamp(0.0, 0.8);
        let dot = if dots.at(u, v) > 0.93 { 0.25 } else { 0.0 };
        color.mix(blush, amount).mix(Rgb([1.0, 0.95, 0.75]), dot)
    })
}

/// Dimpled peel; repeats.
pub(super) fn peel(order: &mut PrintOrder) -> Texture {
    let (color, rng) = (order.ground, &mut *order.rng);
    let (pits, tone) = (Noise::new(110, 60, rng), Noise::new(5, 4, rng));
    draw_texture(256, 128, |u, v| {
        let pit = (pits.at(u, v) - 0.7).max(0.0);
        color.scaled(0.97 + 0.08 * tone.at(u, v) - 0.45 * pit)
    })
}

/// Banana peel along v: green-brown ends, fine brown lines and flecks along the fruit; u repeats.
pub(super) fn banana_skin(order: &mut PrintOrder) -> Texture {
    let (color, rng) = (order.ground, &mut *order.rng);
    let (fleck, line) = (Noise::new(24, 30, rng), Noise::new(30, 4, rng));
    let brown = Rgb([0.32, 0.2, 0.08]);
    draw_texture(128, 256, |u, v| {
        let tip = (1.0 - v / 0.05).max(0.0).max((v - 0.9) / 0.1).clamp(0.0, 1.0);
        let spot = if fleck.at(u, v) > 0.88 { 0.6 } else { 0.0 };
        let streak = (line.at(u, v) - 0.75).max(0.0);
        color.mix(Rgb([0.55, 0.6, 0.15]), 0.6 * tip).mix(brown, (spot + streak + tip * tip * 0.8).min(0.9))
    })
}

/// Baked crust: brown in the center, paler toward the ink, floury patches; repeats.
pub(super) fn crust(order: &mut PrintOrder) -> Texture {
    let (brown, pale, rng) = (order.ground, order.ink, &mut *order.rng);
    let (broad, fine) = (Noise::new(5, 5, rng), Noise::new(40, 40, rng));
    draw_texture(256, 256, |u, v| {
        let mixed = brown.mix(pale, (0.9 * broad.at(u, v) - 0.1).clamp(0.0, 1.0));
        mixed.scaled(0.88 + 0.22 * fine.at(u, v))
    })
}

/// Icing of the ground's color with short bright sprinkles, 256 px.
pub(super) fn sprinkles(order: &mut PrintOrder) -> Texture {
    let (base, count, rng) = (order.ground, order.count.unwrap_or(60), &mut *order.rng);
    let colors = [0xf2_d0_3b, 0x4f_b4_e0, 0xf4_f0_ea, 0x6c_c0_56, 0xe0_4f_6d].map(Rgb::hex);
    let sticks: Vec<(f32, f32, f32, Rgb)> = (0..count)
        .map(|_| {
            let angle = rng.random_range(0.0..std::f32::consts::PI);
            let pick = rng.random_range(0..colors.len());
            (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0), angle, colors[pick])
        })
        .collect();
    draw_texture(256, 256, |u, v| {
        let hit = sticks.iter().find(|(su, sv, angle, _)| {
            let (dx, dy) = (u - su, v - sv);
            let along = dx * angle.cos() + dy * angle.sin();
            let across = dy * angle.cos() - dx * angle.sin();
            along.abs() < 0.026 && across.abs() < 0.009
        });
        hit.map_or(base, |stick| stick.3)
    })
}

/// Rind with `count` wavy stripes of the ink from pole to pole; 256 x 128 px.
pub(super) fn rind(order: &mut PrintOrder) -> Texture {
    let (wave, edge) = (Noise::new(5, 6, order.rng), Noise::new(40, 24, order.rng));
    let (ground, ink, count) = (order.ground, order.ink, order.count.unwrap_or(11) as f32);
    draw_texture(256, 128, |u, v| {
        let across = (u * count + 0.5 * wave.at(u, v)).fract() - 0.5;
        let width = 0.2 + 0.16 * (edge.at(u, v) - 0.5);
        if across.abs() < width { ink } else { ground.scaled(0.94 + 0.12 * edge.at(u, v)) }
    })
}

/// Scales of a pineapple: `count` diamonds around, dark between them, with a dry tip; 256 px.
pub(super) fn diamonds(order: &mut PrintOrder) -> Texture {
    let tone = Noise::new(30, 30, order.rng);
    let (ground, ink, count) = (order.ground, order.ink, order.count.unwrap_or(10) as f32);
    draw_texture(256, 256, |u, v| {
        let [a, b] = [u + 0.7 * v, u - 0.7 * v].map(|at| (count * at).rem_euclid(1.0) - 0.5);
        let (edge, tip) = (a.abs().max(b.abs()), (a * a + b * b).sqrt());
        let scale = ground.scaled(0.8 + 0.3 * tone.at(u, v)).mix(ink, ((edge - 0.36) / 0.1).clamp(0.0, 1.0));
        scale.mix(ink.scaled(0.8), (0.7 * (0.13 - tip) / 0.06).clamp(0.0, 0.7))
    })
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
