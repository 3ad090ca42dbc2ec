//! Value noise on the plane, from an integer hash, so that it is the same on every machine.

use glam::Vec2;

use imaging::rounding::floor;

/// A number in 0..1 of a lattice point (Wellons' "lowbias32" over a sum of multiples).
#[inline]
pub fn hash(x: i32, y: i32, seed: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ seed.wrapping_mul(0xcb1a_b31f);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^= h >> 16;
    (h >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Smooth noise in 0..1 with one feature per unit (Perlin's "value noise", cubic interpolation).
pub fn value_noise(p: Vec2, seed: u32) -> f32 {
    let (x, y) = (floor(p.x), floor(p.y));
    let t = Vec2::new(p.x - x as f32, p.y - y as f32);
    let s = t * t * (Vec2::splat(3.0) - 2.0 * t);
    let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
    let lower = mix(hash(x, y, seed), hash(x + 1, y, seed), s.x);
    let upper = mix(hash(x, y + 1, seed), hash(x + 1, y + 1, seed), s.x);
    mix(lower, upper, s.y)
}
