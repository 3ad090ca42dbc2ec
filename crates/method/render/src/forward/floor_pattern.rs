//! Procedural floors: boards, tiles, concrete, carpet and terrazzo, filtered to the size of a pixel.

use glam::{Vec2, Vec3};

use super::noise::{hash, value_noise};
use crate::room::{FloorFinish, Room};
use imaging::rounding::floor;

/// Reflectance of the floor at a position in meters, averaged over about `footprint_m`.
pub fn floor_reflectance(room: &Room, p: Vec2, footprint_m: f32) -> Vec3 {
    let seed = room.seed;
    let [dark, light] = room.decor.floor_colors;
    match room.decor.floor {
        FloorFinish::Boards => boards(p, footprint_m, seed, dark, light),
        FloorFinish::Tiles => tiles(p, footprint_m, seed, dark, light),
        FloorFinish::Concrete => dark.lerp(light, concrete(p, footprint_m, seed)),
        FloorFinish::Carpet => dark.lerp(light, carpet(p, footprint_m, seed)),
        FloorFinish::Terrazzo => terrazzo(p, footprint_m, seed, dark, light),
    }
}

/// Share of a detail of that size that remains visible after averaging over the footprint, 0..1.
#[inline]
fn kept(size_m: f32, footprint_m: f32) -> f32 {
    (size_m / (footprint_m + 1e-6) - 0.5).clamp(0.0, 1.0)
}

/// Darkness of a gap `distance_m` away, 0..1; a gap thinner than the footprint fades.
#[inline]
fn gap(distance_m: f32, half_width_m: f32, footprint_m: f32) -> f32 {
    let blur = half_width_m + 0.75 * footprint_m;
    let near = (1.0 - distance_m / (2.0 * blur)).clamp(0.0, 1.0);
    near * near * (3.0 - 2.0 * near) * (half_width_m / blur)
}

/// Boards along x with staggered ends; each has its own tone and grain.
fn boards(p: Vec2, footprint_m: f32, seed: u32, dark: Vec3, light: Vec3) -> Vec3 {
    const WIDTH_M: f32 = 0.13;
    const LENGTH_M: f32 = 1.35;
    let across = p.y / WIDTH_M;
    let row = floor(across);
    let along = p.x / LENGTH_M + hash(row, 17, seed);
    let plank = floor(along);
    let tone = hash(row, plank, seed);
    // Each plank is cut from its own place of one infinite grain.
    let cut = Vec2::new(61.0 * tone, 37.0 * hash(plank, row, seed ^ 0x9e37));
    let bend = value_noise(Vec2::new(2.2 * p.x, 6.0 * p.y) + cut, seed) - 0.5;
    let grain = value_noise(Vec2::new(3.0 * p.x, 95.0 * p.y + 7.0 * bend) + cut, seed) - 0.5;
    let share = 0.5 + 0.62 * (tone - 0.5) + 0.35 * bend + 0.5 * kept(0.011, footprint_m) * grain;
    let in_row = across - row as f32;
    let in_plank = along - plank as f32;
    let side_m = WIDTH_M * in_row.min(1.0 - in_row);
    let end_m = LENGTH_M * in_plank.min(1.0 - in_plank);
    let shade = 1.0 - 0.55 * gap(side_m.min(end_m), 0.0016, footprint_m);
    dark.lerp(light, share) * shade
}

/// Square tiles with grout; each has its own tone.
fn tiles(p: Vec2, footprint_m: f32, seed: u32, dark: Vec3, light: Vec3) -> Vec3 {
    const SIDE_M: f32 = 0.3;
    let q = p / SIDE_M;
    let (x, y) = (floor(q.x), floor(q.y));
    let inside = q - Vec2::new(x as f32, y as f32);
    let edge = inside.min(Vec2::ONE - inside).min_element() * SIDE_M;
    let cloud = value_noise(4.5 * p, seed) - 0.5;
    let share = 0.5 + 0.7 * (hash(x, y, seed) - 0.5) + 0.6 * cloud;
    let grout = gap(edge, 0.0028, footprint_m);
    dark.lerp(light, share) * (1.0 - 0.42 * grout)
}

/// Clouds and fine pores, 0..1.
fn concrete(p: Vec2, footprint_m: f32, seed: u32) -> f32 {
    let large = value_noise(1.3 * p, seed);
    let medium = value_noise(6.1 * p, seed ^ 0x51);
    let fine = value_noise(90.0 * p, seed ^ 0xa2) - 0.5;
    0.55 * large + 0.4 * medium + 0.35 * kept(0.011, footprint_m) * fine
}

/// Tufts, and faint tracks of the pile, 0..1.
fn carpet(p: Vec2, footprint_m: f32, seed: u32) -> f32 {
    let tufts = value_noise(180.0 * p, seed) - 0.5;
    let flecks = value_noise(55.0 * p, seed ^ 0x51) - 0.5;
    let tracks = value_noise(Vec2::new(2.4 * p.x, 5.0 * p.y), seed ^ 0xa2) - 0.5;
    0.5 + 0.9 * kept(0.006, footprint_m) * tufts + 0.8 * kept(0.018, footprint_m) * flecks + 0.3 * tracks
}

/// Chips of stone, one in each cell of a grid, in a plain binder.
fn terrazzo(p: Vec2, footprint_m: f32, seed: u32, dark: Vec3, light: Vec3) -> Vec3 {
    const CELL_M: f32 = 0.034;
    let base = dark.lerp(light, 0.25 + 0.5 * value_noise(2.0 * p, seed));
    let q = p / CELL_M;
    let (x, y) = (floor(q.x), floor(q.y));
    let inside = q - Vec2::new(x as f32, y as f32);
    let center = Vec2::new(0.3 + 0.4 * hash(x, y, seed), 0.3 + 0.4 * hash(x, y, seed ^ 0x51));
    let radius = 0.1 + 0.2 * hash(x, y, seed ^ 0xa2);
    let turn = 3.0 * hash(x, y, seed ^ 0xf3);
    let off = inside - center;
    // An ellipse with a random axis.
    let stretched = off + 0.5 * off.dot(Vec2::new(1.0 - turn, turn - 0.5)) * Vec2::new(1.0, -0.6);
    let blur = 0.06 + footprint_m / CELL_M;
    let share = ((radius - stretched.length()) / blur + 0.5).clamp(0.0, 1.0) * kept(0.012, footprint_m);
    let kind = hash(y, x, seed);
    let chip = if kind < 0.35 {
        0.45 * dark
    } else if kind < 0.7 {
        (1.2 * light).min(Vec3::ONE)
    } else {
        Vec3::new(0.75, 0.52, 0.4) * light
    };
    base.lerp(chip, share)
}
