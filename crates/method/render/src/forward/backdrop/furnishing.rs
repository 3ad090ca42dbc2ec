//! Furnishing of the walls of a room, out of focus: a frame, a shelf with books, a door, or nothing, by seed.
//!
//! All are lists of rectangles with soft edges, drawn one over the other, so that another object needs no other code.

use glam::{Vec2, Vec3, Vec3A};

use super::DEFOCUS_M;
use crate::forward::noise::hash;
use crate::room::Room;

/// A rectangle on a wall; positions are along the wall and above the floor, meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    pub center: Vec2,
    pub half: Vec2,
    /// Width of its soft edges beyond that of the image.
    pub blur: f32,
    /// Reflectance, linear; and the share by which it replaces what is below.
    pub color: Vec3,
    pub cover: f32,
}

/// Objects on or before the four walls: at the high x, low x, high y and low y.
pub struct Furnishing {
    pub walls: [Vec<Patch>; 4],
}

/// Number of the wall of that inward normal.
pub fn wall_of(normal: Vec3A) -> usize {
    match (normal.x < -0.5, normal.x > 0.5, normal.y < -0.5) {
        (true, ..) => 0,
        (_, true, _) => 1,
        (.., true) => 2,
        _ => 3,
    }
}

impl Furnishing {
    /// The furnishing of a room.
    pub fn of(room: &Room) -> Self {
        const NORMALS: [Vec2; 4] = [Vec2::NEG_X, Vec2::X, Vec2::NEG_Y, Vec2::Y];
        let center = 0.5 * (room.low_m + room.high_m).as_vec2();
        let walls = std::array::from_fn(|wall| {
            let draw = Draw { seed: room.seed ^ 0x0a11_f00d, wall: wall as i32 };
            let across_m = center.dot(Vec2::new(NORMALS[wall].y, NORMALS[wall].x));
            match draw.one_of(0, 6) {
                0 | 1 => frames(&draw, across_m),
                2 => shelf(&draw, across_m, room.decor.skirting_color),
                3 => door(&draw, across_m, room.decor.skirting_color),
                _ => Vec::new(),
            }
        });
        Self { walls }
    }

    /// The reflectance of a wall with what is on it.
    pub fn over(&self, wall: usize, at: Vec2, footprint_m: f32, bare: Vec3) -> Vec3 {
        self.walls[wall].iter().fold(bare, |color, patch| patch.over(color, at, footprint_m))
    }
}

impl Patch {
    fn over(&self, below: Vec3, at: Vec2, footprint_m: f32) -> Vec3 {
        let blur = self.blur + 0.5 * footprint_m;
        let inside = (Vec2::splat(0.5) + (self.half - (at - self.center).abs()) / (2.0 * blur))
            .clamp(Vec2::ZERO, Vec2::ONE);
        let soft = inside * inside * (Vec2::splat(3.0) - 2.0 * inside);
        below.lerp(self.color, self.cover * soft.x * soft.y)
    }
}

/// Random numbers of one wall.
struct Draw {
    seed: u32,
    wall: i32,
}

impl Draw {
    fn number(&self, name: i32, low: f32, high: f32) -> f32 {
        low + (high - low) * hash(name, 40 + self.wall, self.seed)
    }

    fn one_of(&self, name: i32, count: i32) -> i32 {
        (self.number(name, 0.0, count as f32) as i32).min(count - 1)
    }

    /// A dull color, linear.
    fn color(&self, name: i32) -> Vec3 {
        let tone = self.number(name, 0.06, 0.45);
        let tint = Vec3::new(
            self.number(name + 1, 0.75, 1.25),
            self.number(name + 2, 0.8, 1.15),
            self.number(name + 3, 0.7, 1.25),
        );
        tone * tint
    }
}

fn patch(center: Vec2, half: Vec2, color: Vec3) -> Patch {
    Patch { center, half, blur: DEFOCUS_M, color, cover: 1.0 }
}

/// Shade that an object throws on the wall below it.
fn shade(center: Vec2, half: Vec2, blur: f32, cover: f32) -> Patch {
    Patch { center, half, blur, color: Vec3::splat(0.02), cover }
}

fn frames(draw: &Draw, across_m: f32) -> Vec<Patch> {
    const FRAMES: [Vec3; 4] = [
        Vec3::new(0.03, 0.028, 0.026),
        Vec3::new(0.24, 0.14, 0.075),
        Vec3::new(0.75, 0.74, 0.72),
        Vec3::new(0.42, 0.31, 0.18),
    ];
    let frame = FRAMES[draw.one_of(1, 4) as usize];
    let first = across_m + draw.number(2, -0.85, 0.6);
    let (width, height) = (draw.number(3, 0.13, 0.24), draw.number(4, 0.15, 0.28));
    let count = 1 + draw.one_of(5, 2);
    let mut patches = Vec::new();
    for k in 0..count {
        let center = Vec2::new(first + k as f32 * (2.0 * width + 0.12), draw.number(6, 1.3, 1.55));
        let half = Vec2::new(width, height);
        let sky = draw.color(10 + 8 * k);
        patches.push(shade(center + Vec2::new(0.012, -0.02), half, 0.025, 0.3));
        patches.push(patch(center, half, frame));
        patches.push(patch(center, half - 0.018, Vec3::splat(0.72)));
        patches.push(patch(center, 0.68 * half, 1.3 * sky));
        let horizon = 0.68 * half * Vec2::new(1.0, draw.number(30 + k, 0.3, 0.6));
        patches.push(patch(
            center - Vec2::new(0.0, 0.68 * half.y - horizon.y),
            horizon,
            draw.color(32 + 8 * k),
        ));
    }
    patches
}

fn shelf(draw: &Draw, across_m: f32, finish: Vec3) -> Vec<Patch> {
    let half = Vec2::new(draw.number(1, 0.3, 0.5), 0.014);
    let center = Vec2::new(across_m + draw.number(2, -0.6, 0.6), draw.number(3, 1.3, 1.5));
    let board = if draw.one_of(4, 2) == 0 { 0.9 * finish } else { Vec3::new(0.3, 0.19, 0.1) };
    let mut patches = vec![
        shade(center - Vec2::new(0.0, 0.09), Vec2::new(half.x - 0.01, 0.07), 0.05, 0.3),
        patch(center, half, board),
    ];
    let mut left = center.x - half.x + draw.number(5, 0.03, 0.2);
    for k in 0..5 {
        let book = Vec2::new(draw.number(10 + k, 0.012, 0.026), draw.number(20 + k, 0.08, 0.125));
        left += 2.0 * book.x + 0.002;
        let at = Vec2::new(left - book.x, center.y + half.y + book.y);
        patches.push(patch(at, book, draw.color(40 + 5 * k)));
    }
    patches
}

fn door(draw: &Draw, across_m: f32, finish: Vec3) -> Vec<Patch> {
    const HALF_M: Vec2 = Vec2::new(0.43, 1.03);
    let side = if draw.one_of(1, 2) == 0 { 1.0 } else { -1.0 };
    let center = Vec2::new(across_m + side * draw.number(2, 0.35, 0.9), HALF_M.y);
    let leaf = 0.92 * finish;
    let mut patches = vec![
        shade(center, HALF_M + 0.085, 0.02, 0.25),
        patch(center, HALF_M + 0.07, finish),
        patch(center, HALF_M + 0.006, 0.4 * finish),
        patch(center, HALF_M, leaf),
    ];
    for (height, half) in [(0.42, 0.26), (1.32, 0.5)] {
        let half = Vec2::new(0.27, half);
        let at = Vec2::new(center.x, height);
        patches.push(patch(at, half, 0.8 * leaf));
        patches.push(patch(at, half - 0.02, 0.97 * leaf));
    }
    let handle = Vec2::new(center.x - side * 0.37, 1.02);
    patches.push(patch(handle, Vec2::new(0.05, 0.01), Vec3::splat(0.25)));
    patches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tabletop;
    use glam::{DVec2, DVec3};

    #[test]
    fn some_walls_are_bare_and_furnishing_differs_by_seed() {
        let tabletop = Tabletop {
            z_m: 0.0,
            low_m: DVec2::splat(-0.5),
            high_m: DVec2::splat(0.5),
            color: Vec3::splat(0.3),
        };
        let (low, high) = (DVec3::new(-0.5, -0.5, -0.74), DVec3::new(0.5, 0.5, 0.2));
        let walls: Vec<Vec<Patch>> =
            (0..12).flat_map(|seed| Furnishing::of(&Room::around(low, high, tabletop, seed)).walls).collect();
        let bare = walls.iter().filter(|wall| wall.is_empty()).count();
        assert!((8..32).contains(&bare), "{bare} of {}", walls.len());
        let mut seen: Vec<&Vec<Patch>> = Vec::new();
        for wall in walls.iter().filter(|wall| !wall.is_empty()) {
            assert!(!seen.contains(&wall), "two walls are alike");
            seen.push(wall);
        }
    }

    #[test]
    fn patch_covers_its_center_and_fades_at_its_edge() {
        let patch = patch(Vec2::new(1.0, 2.0), Vec2::splat(0.2), Vec3::ZERO);
        let at = |x: f32| patch.over(Vec3::ONE, Vec2::new(x, 2.0), 0.0).x;
        assert_eq!((at(1.0), at(1.3)), (0.0, 1.0));
        assert!((at(1.2) - 0.5).abs() < 1e-5, "{}", at(1.2));
    }
}
