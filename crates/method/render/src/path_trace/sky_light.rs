//! Light from all directions in which a ray meets neither an object nor a floor: a room's windows, walls and ceiling,
//! or two hemispheres in the colors of sky and ground.
//!
//! A room is the one that lights the forward renderer. Its directions are drawn from a grid over the octahedral square
//! in proportion to their light (Pharr et al., "Physically Based Rendering", 4th edition, section 12.5), so that
//! windows are found at once. The hemispheres give a white matte surface exactly the light that [`Lighting`] states.
//!
//! [`Lighting`]: crate::Lighting

use glam::{Vec2, Vec3, Vec3A};

use super::key_light::LightSample;
use crate::forward::environment::{Ambient, Below, Environment};
use crate::forward::room_light::RoomLight;
use crate::forward::sky::SkyShare;
use crate::room::luminance;

/// Cells along each side of the grid.
const SIDE: usize = 128;
/// Share of directions that are drawn evenly over the cells above the horizon, so that none is missed.
const EVEN: f32 = 0.05;

/// Light at infinity.
pub enum SkyLight {
    Hemispheres { sky: Vec3, ground: Vec3 },
    Room(Grid),
}

/// Probabilities of the cells of the octahedral square.
pub struct Grid {
    /// Of each cell, row by row, their sum being one.
    cells: Vec<f32>,
    /// Sums of the cells of a row up to each.
    sums_in_rows: Vec<f32>,
    /// Sums of the rows up to each.
    sums_of_rows: Vec<f32>,
}

/// Unoccluded sky.
const OPEN: SkyShare = SkyShare { arriving: 1.0, open: 1.0 };
/// A place so deep below the tabletop that mirrors show nothing of it.
const BELOW_ALL: Vec3A = Vec3A::new(0.0, 0.0, -1e6);

/// Radiance of a room above the horizon.
pub fn room_radiance(room: &RoomLight, direction: Vec3A) -> Vec3 {
    let around = Ambient { seen: OPEN, below: Below { light: room.open_floor, open: 1.0 } };
    room.mirrored(BELOW_ALL, direction, 0.0, &around).between(Vec3::ZERO)
}

impl SkyLight {
    pub fn new(environment: &Environment) -> Self {
        match &environment.room {
            Some(room) => Self::Room(Grid::new(room)),
            None => Self::Hemispheres {
                sky: environment.lighting.sky_color,
                ground: environment.lighting.ground_color,
            },
        }
    }

    /// Radiance from a direction, above the horizon of a room.
    pub fn radiance(&self, environment: &Environment, direction: Vec3A) -> Vec3 {
        match (self, &environment.room) {
            (Self::Room(_), Some(room)) => room_radiance(room, direction),
            (Self::Hemispheres { sky, ground }, _) => {
                if direction.z >= 0.0 {
                    *sky
                } else {
                    *ground
                }
            }
            (Self::Room(_), None) => Vec3::ZERO,
        }
    }

    /// A direction above the horizon of a room; `None` where surfaces sample well enough.
    pub fn sample(&self, environment: &Environment, u: Vec2) -> Option<LightSample> {
        let Self::Room(grid) = self else { return None };
        let (direction, density) = grid.sample(u)?;
        let radiance = if direction.z > 0.0 { self.radiance(environment, direction) } else { Vec3::ZERO };
        Some(LightSample { direction, weight: radiance / density, density: Some(density) })
    }

    /// Probability per solid angle of [`Self::sample`].
    pub fn density(&self, direction: Vec3A) -> f32 {
        match self {
            Self::Room(grid) => grid.density(direction),
            Self::Hemispheres { .. } => 0.0,
        }
    }
}

impl Grid {
    fn new(room: &RoomLight) -> Self {
        let cell_light = |k: usize| {
            // The mean of 3 x 3 directions, since the light is smooth between texels of its map.
            let corner = Vec2::new((k % SIDE) as f32, (k / SIDE) as f32);
            let light: f32 = (0..9)
                .map(|j| {
                    let inside = (Vec2::new((j % 3) as f32, (j / 3) as f32) + 0.5) / 3.0;
                    let direction = direction_of((corner + inside) / SIDE as f32);
                    let seen =
                        if direction.z > 0.0 { luminance(room_radiance(room, direction)) } else { 0.0 };
                    seen.max(0.0) * per_area(direction)
                })
                .sum();
            light / 9.0
        };
        let mut cells: Vec<f32> = (0..SIDE * SIDE).map(cell_light).collect();
        let total: f64 = cells.iter().map(|cell| f64::from(*cell)).sum();
        let lit = cells.iter().filter(|cell| **cell > 0.0).count().max(1);
        for cell in cells.iter_mut().filter(|cell| **cell > 0.0) {
            *cell = (1.0 - EVEN) * (f64::from(*cell) / total) as f32 + EVEN / lit as f32;
        }
        let sums = |numbers: &mut dyn Iterator<Item = f32>| -> Vec<f32> {
            let mut sum = 0.0_f64;
            numbers
                .map(|number| {
                    sum += f64::from(number);
                    sum as f32
                })
                .collect()
        };
        let sums_in_rows: Vec<f32> =
            cells.chunks(SIDE).flat_map(|row| sums(&mut row.iter().copied())).collect();
        let sums_of_rows = sums(&mut sums_in_rows.chunks(SIDE).map(|row| row[SIDE - 1]));
        Self { cells, sums_in_rows, sums_of_rows }
    }

    fn sample(&self, u: Vec2) -> Option<(Vec3A, f32)> {
        let (row, y) = drawn(&self.sums_of_rows, u.y);
        let (column, x) = drawn(&self.sums_in_rows[row * SIDE..][..SIDE], u.x);
        let at = (Vec2::new(column as f32, row as f32) + Vec2::new(x, y)) / SIDE as f32;
        let direction = direction_of(at);
        let density = self.density(direction);
        (density > 0.0).then_some((direction, density))
    }

    fn density(&self, direction: Vec3A) -> f32 {
        let p = position_of(direction) * SIDE as f32;
        let (x, y) = ((p.x as usize).min(SIDE - 1), (p.y as usize).min(SIDE - 1));
        self.cells[y * SIDE + x] * (SIDE * SIDE) as f32 / per_area(direction)
    }
}

/// The place at which running sums pass a share `u` of their total, and the share of the way through it.
fn drawn(sums: &[f32], u: f32) -> (usize, f32) {
    let wanted = u * sums[sums.len() - 1];
    let place = sums.partition_point(|sum| *sum <= wanted).min(sums.len() - 1);
    let before = if place > 0 { sums[place - 1] } else { 0.0 };
    let inside = (wanted - before) / (sums[place] - before).max(1e-20);
    (place, inside.clamp(0.0, 0.999_999))
}

/// Solid angle per area of the octahedral square, whose side is one.
fn per_area(d: Vec3A) -> f32 {
    4.0 * (d.x.abs() + d.y.abs() + d.z.abs()).powi(3)
}

/// Unit direction of a position in the octahedral square, 0..1 each way.
fn direction_of(at: Vec2) -> Vec3A {
    let p = 2.0 * at - 1.0;
    let z = 1.0 - p.x.abs() - p.y.abs();
    let folded = (-z).max(0.0);
    Vec3A::new(p.x - folded.copysign(p.x), p.y - folded.copysign(p.y), z).normalize()
}

/// Position of a unit direction in the octahedral square.
fn position_of(d: Vec3A) -> Vec2 {
    let p = Vec2::new(d.x, d.y) / (d.x.abs() + d.y.abs() + d.z.abs());
    let p = match d.z < 0.0 {
        true => Vec2::new((1.0 - p.y.abs()).copysign(d.x), (1.0 - p.x.abs()).copysign(d.y)),
        false => p,
    };
    (0.5 * p + 0.5).clamp(Vec2::ZERO, Vec2::ONE)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{Lighting, Room, Tabletop};

    fn room_light() -> RoomLight {
        let tabletop = Tabletop {
            z_m: 0.0,
            low_m: glam::DVec2::splat(-0.5),
            high_m: glam::DVec2::splat(0.5),
            color: Vec3::splat(0.2),
        };
        let room = Room::around(DVec3::new(-0.5, -0.5, -0.7), DVec3::new(0.5, 0.5, 0.2), tabletop, 1);
        RoomLight::new(room, &Lighting::daylight(-0.3, 0.95))
    }

    #[test]
    fn positions_and_directions_are_inverse() {
        for k in 0..500 {
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / 500.0;
            let (radius, angle) = ((1.0 - z * z).sqrt(), k as f32 * 2.399_963_2);
            let d = Vec3A::new(radius * angle.cos(), radius * angle.sin(), z);
            assert!(direction_of(position_of(d)).abs_diff_eq(d, 1e-5), "{d}");
        }
    }

    #[test]
    fn sampled_light_is_that_of_an_even_integral() {
        let room = room_light();
        let grid = Grid::new(&room);
        let (mut sampled, mut even, mut whole) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        let count = 200 * 200;
        for k in 0..count {
            let u = (Vec2::new((k % 200) as f32, (k / 200) as f32) + 0.5) / 200.0;
            let (direction, density) = grid.sample(u).expect("lies in a cell");
            if direction.z > 0.0 {
                sampled += direction.z * room_radiance(&room, direction) / density;
            }
            let direction = direction_of(u);
            whole += grid.density(direction) * per_area(direction);
            if direction.z > 0.0 {
                even += direction.z * per_area(direction) * room_radiance(&room, direction);
            }
        }
        (sampled, even, whole) = (sampled / count as f32, even / count as f32, whole / count as f32);
        assert!((whole - 1.0).abs() < 0.01, "{whole}");
        assert!(sampled.abs_diff_eq(even, 0.01 * even.max_element()), "{sampled} {even}");
    }
}
