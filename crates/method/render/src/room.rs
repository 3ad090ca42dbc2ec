//! A procedural room around a scene: floor, walls with skirting, and the light that arrives from them.
//!
//! The room is a backdrop and a light at once. Its nearest walls are never drawn, since a ray from the eye ends on the
//! far side of the floor plan. All colors are linear reflectances.

use glam::{DVec2, Vec3};

use crate::tabletop::Tabletop;
use geometry::Rgb;

/// Kind of floor; each is a procedural pattern in meters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloorFinish {
    Boards = 0,
    Tiles = 1,
    Concrete = 2,
    Carpet = 3,
    Terrazzo = 4,
}

/// Finishes of floor and walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decor {
    pub floor: FloorFinish,
    /// The two colors between which the pattern varies.
    pub floor_colors: [Vec3; 2],
    pub wall_color: Vec3,
    pub skirting_color: Vec3,
}

/// A room whose walls stand along the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    pub decor: Decor,
    /// Selects planks, stains and chips.
    pub seed: u32,
    /// World height of the floor, meters.
    pub floor_z_m: f64,
    /// Corners of the floor plan, meters.
    pub low_m: DVec2,
    pub high_m: DVec2,
    /// The surface that carries the scene and throws light back at it.
    pub tabletop: Tabletop,
}

/// Distance of the walls from the outermost point of the scene, meters.
const WALL_DISTANCE_M: f64 = 0.75;
/// Smallest difference between the lightness of floor and tabletop, 0..1.
const MIN_CONTRAST: f32 = 0.13;

/// Floor, its colors, wall and skirting as sRGB.
const DECORS: [(FloorFinish, [u32; 2], u32, u32); 8] = [
    (FloorFinish::Boards, [0xb98f62, 0xcfab80], 0xe6e0d6, 0xf4f2ee),
    (FloorFinish::Concrete, [0x93918d, 0xa9a6a1], 0xd6d5d1, 0xb9b7b3),
    (FloorFinish::Boards, [0x5c4637, 0x745a48], 0xb4bcac, 0xeeece6),
    (FloorFinish::Tiles, [0xc9c6c0, 0xdad7d1], 0xb9c7d1, 0xeef0f0),
    (FloorFinish::Carpet, [0x858686, 0x9a9a98], 0xe4dfd6, 0xf2f0ec),
    (FloorFinish::Tiles, [0x9c715b, 0xb28a73], 0xe9dec9, 0xd8c7aa),
    (FloorFinish::Boards, [0xcdc3b4, 0xdfd7ca], 0x8fa3a3, 0xe9e9e4),
    (FloorFinish::Terrazzo, [0xbdb5aa, 0xd6cfc5], 0xdccabd, 0xf1ece6),
];

impl Decor {
    /// Every decor there is.
    pub fn all() -> [Self; 8] {
        DECORS.map(|(floor, floor_colors, wall, skirting)| Self {
            floor,
            floor_colors: floor_colors.map(linear),
            wall_color: linear(wall),
            skirting_color: linear(skirting),
        })
    }

    /// One of the decors for each seed, among those whose floor stands out from the tabletop.
    pub fn of_seed(seed: u64, tabletop_color: Vec3) -> Self {
        let decors = Self::all();
        let tabletop = lightness(tabletop_color);
        let stands_out = |decor: &&Self| (lightness(decor.floor_color()) - tabletop).abs() > MIN_CONTRAST;
        let fit: Vec<&Self> = decors.iter().filter(stands_out).collect();
        fit.get((seed % fit.len().max(1) as u64) as usize).map_or(decors[1], |decor| **decor)
    }

    /// Mean color of the floor.
    pub fn floor_color(&self) -> Vec3 {
        0.5 * (self.floor_colors[0] + self.floor_colors[1])
    }
}

impl Room {
    /// The room of a seed around a scene that fills a box from `low_m` up, with walls a step away from it.
    pub fn around(low_m: glam::DVec3, high_m: glam::DVec3, tabletop: Tabletop, seed: u64) -> Self {
        Self {
            decor: Decor::of_seed(seed, tabletop.color),
            seed: (seed ^ (seed >> 32)) as u32,
            floor_z_m: low_m.z,
            low_m: low_m.truncate() - WALL_DISTANCE_M,
            high_m: high_m.truncate() + WALL_DISTANCE_M,
            tabletop,
        }
    }
}

fn linear(hex: u32) -> Vec3 {
    Vec3::from(Rgb::hex(hex).to_linear())
}

/// Rec. 709 luminance of a linear color.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Perceived lightness of a linear color, 0..1 (CIE 1976 L*, without its linear toe).
fn lightness(color: Vec3) -> f32 {
    1.16 * luminance(color).max(0.0).cbrt() - 0.16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floors_stand_out_from_every_tabletop_and_seeds_differ() {
        for gray in [0.02, 0.1, 0.2, 0.35, 0.5, 0.8] {
            let tabletop = Vec3::splat(gray);
            let decors: Vec<Decor> = (0..16).map(|seed| Decor::of_seed(seed, tabletop)).collect();
            for decor in &decors {
                let apart = (lightness(decor.floor_color()) - lightness(tabletop)).abs();
                assert!(apart > MIN_CONTRAST, "{gray}: {apart}");
            }
            assert!(decors.iter().any(|decor| *decor != decors[0]), "one decor for all at {gray}");
        }
    }
}
