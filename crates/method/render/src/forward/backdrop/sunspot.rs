//! Sunlight through a window onto the wall behind the scene, another one for each room: panes, blinds, a curtain or
//! leaves before them, or none.

use glam::{Vec2, Vec3A};

use super::{Ray, farthest};
use crate::forward::noise::{hash, value_noise};
use crate::room::Room;

/// A window as the sun shows it: positions on a plane across the key light, meters.
#[derive(Clone, Copy, Debug)]
pub struct Sunspot {
    pub right: Vec3A,
    pub up: Vec3A,
    /// Of the center of the window along both.
    pub center: Vec2,
    pub half_m: Vec2,
    /// Numbers of panes along both.
    pub panes: Vec2,
    /// Half the width of the bars between panes, and of the soft edges of all.
    pub bar_m: f32,
    pub penumbra_m: f32,
    /// Distance of the slats of blinds, 0 = none.
    pub slats_m: f32,
    /// Position at which a curtain begins, and its side, +1 or -1.
    pub curtain_m: f32,
    pub curtain_side: f32,
    /// Darkness of leaves, 0..1.
    pub leaves: f32,
    /// Brightness of the whole, 0..1.
    pub strength: f32,
    pub seed: u32,
}

/// Light that passes bars, curtain and closed blinds, from all sides, as a share.
pub const PAST_BARS: f32 = 0.45;
pub const PAST_CURTAIN: f32 = 0.3;
pub const PAST_SLATS: f32 = 0.25;

impl Sunspot {
    /// The window of a room whose light falls onto the wall behind the scene as seen along the key light.
    pub fn new(room: &Room, toward_key: Vec3A) -> Self {
        let right = Vec3A::Z.cross(toward_key).normalize_or(Vec3A::X);
        let up = toward_key.cross(right);
        let tabletop = &room.tabletop;
        let center = 0.5 * (tabletop.low_m + tabletop.high_m).as_vec2();
        let origin = Vec3A::new(center.x, center.y, tabletop.z_m as f32);
        let away = -toward_key.with_z(0.0);
        let (depth, _) = farthest(room, &Ray { origin, direction: away });
        let on_wall = if depth.is_finite() { origin + depth * away } else { origin };
        let seed = room.seed ^ 0x5eed_0517;
        let drawn = |number: i32, low: f32, high: f32| low + (high - low) * hash(number, 3, seed);
        let one_of = |number: i32, count: i32| (drawn(number, 0.0, count as f32) as i32).min(count - 1);
        let kind = one_of(0, 7);
        // Rarely straight behind the objects, which would hide it.
        let aside = drawn(1, 0.25, 1.0) * if one_of(2, 3) == 0 { 1.0 } else { -1.0 };
        let panes = Vec2::new((1 + one_of(3, 3)) as f32, (1 + one_of(4, 3)) as f32);
        let half_m = Vec2::new(drawn(5, 0.24, 0.62), drawn(6, 0.34, 0.72));
        Self {
            right,
            up,
            center: Vec2::new(on_wall.dot(right) + aside, on_wall.dot(up) + drawn(7, -0.15, 0.4)),
            half_m: if kind == 5 { Vec2::new(0.35 * half_m.x, 1.3 * half_m.y) } else { half_m },
            panes: if kind == 5 { Vec2::ONE } else { panes },
            bar_m: drawn(8, 0.015, 0.035),
            penumbra_m: drawn(9, 0.035, 0.1),
            slats_m: if kind == 2 { drawn(10, 0.06, 0.1) } else { 0.0 },
            curtain_m: if kind == 3 { drawn(11, -0.4, 0.5) * half_m.x } else { 1e3 },
            curtain_side: if one_of(12, 2) == 0 { 1.0 } else { -1.0 },
            leaves: if kind == 4 { drawn(13, 0.5, 0.85) } else { 0.0 },
            strength: if kind == 6 { 0.0 } else { drawn(14, 0.6, 1.0) },
            seed,
        }
    }

    /// Share of sunlight at a point, 0..1.
    pub fn share(&self, point: Vec3A) -> f32 {
        if self.strength <= 0.0 {
            return 0.0;
        }
        let p = Vec2::new(point.dot(self.right), point.dot(self.up)) - self.center;
        let inside = self.half_m - p.abs();
        let outer = self.soft(inside.x) * self.soft(inside.y);
        if outer <= 0.0 {
            return 0.0;
        }
        let pane = 2.0 * self.half_m / self.panes;
        let bar = self
            .soft(self.bar_m - to_bar(p.x, self.half_m.x, pane.x))
            .max(self.soft(self.bar_m - to_bar(p.y, self.half_m.y, pane.y)));
        let mut light = outer * (1.0 - (1.0 - PAST_BARS) * bar);
        if self.slats_m > 0.0 {
            let wave = 0.5 + 0.5 * (p.y * (std::f32::consts::TAU / self.slats_m)).cos();
            light *= PAST_SLATS + (1.0 - PAST_SLATS) * wave;
        }
        let beyond = self.curtain_side * p.x - self.curtain_m + 0.02 * (7.0 * p.y).sin();
        light *= 1.0 - (1.0 - PAST_CURTAIN) * self.soft(beyond);
        if self.leaves > 0.0 {
            let boughs = value_noise(3.1 * p, self.seed);
            let leaves = value_noise(14.0 * p, self.seed ^ 0x51);
            light *= 1.0 - self.leaves * (3.0 * (0.55 * boughs + 0.45 * leaves - 0.36)).clamp(0.0, 1.0);
        }
        self.strength * light
    }

    /// Soft step over a penumbra.
    fn soft(&self, inside_m: f32) -> f32 {
        let t = (inside_m / self.penumbra_m + 0.5).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}

/// Distance to the nearest bar between panes; large where there is none.
fn to_bar(p: f32, half: f32, pane: f32) -> f32 {
    let bar = ((p + half) / pane).round();
    if bar * pane < 0.5 * pane || bar * pane > 2.0 * half - 0.5 * pane {
        return 1e3;
    }
    (p + half - bar * pane).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tabletop;
    use glam::{DVec2, DVec3, Vec3};

    #[test]
    fn windows_differ_between_rooms_and_light_no_more_than_all() {
        let tabletop = Tabletop {
            z_m: 0.0,
            low_m: DVec2::splat(-0.5),
            high_m: DVec2::splat(0.5),
            color: Vec3::splat(0.3),
        };
        let toward_key = Vec3A::new(-0.4, -0.45, 0.8).normalize();
        let spots: Vec<Sunspot> = (0..24)
            .map(|seed| {
                let (low, high) = (DVec3::new(-0.5, -0.5, -0.74), DVec3::new(0.5, 0.5, 0.2));
                Sunspot::new(&Room::around(low, high, tabletop, seed), toward_key)
            })
            .collect();
        let mut sums = Vec::new();
        for spot in &spots {
            let on_plane = |k: i32| {
                let (x, y) = (0.05 * (k % 40 - 20) as f32, 0.05 * (k / 40 - 20) as f32);
                (spot.center.x + x) * spot.right + (spot.center.y + y) * spot.up
            };
            let shares: Vec<f32> = (0..1600).map(|k| spot.share(on_plane(k))).collect();
            assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{spot:?}");
            sums.push(shares.iter().sum::<f32>());
        }
        assert!(sums.contains(&0.0), "every room has a window");
        sums.sort_by(f32::total_cmp);
        sums.dedup();
        assert!(sums.len() > 12, "{} kinds of light among {} rooms", sums.len(), spots.len());
        assert!([spots.iter().any(|s| s.slats_m > 0.0), spots.iter().any(|s| s.leaves > 0.0)] == [true; 2]);
    }
}
