//! Backdrops behind and under the table: plain light most often, gradients, rooms, blurred surroundings.
//!
//! A backdrop is a function of the pixel ray, or a room of the renderer as in the previews of scenes. Floors and walls
//! of the former are aligned with the camera's azimuth, at the sampled distance behind the table.

use glam::{DVec2, DVec3, Vec3};
use rand::RngExt;

use super::Split;
use super::sampling::{any_color, chance, hsv, of_split, pale, pick, uniform, weighted, wood_color};
use catalog::texture::Noise;
use geometry::{Camera, Rgb};
use render::{Decor, FloorFinish, RenderObject, Room, Tabletop};
use runtime::seed::Rng;

/// Kinds of backdrops. Each belongs to one split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// One light color.
    Plain,
    /// Vertical gradient between two colors.
    Gradient,
    /// A wall, a skirting board, and a floor with boards or a carpet.
    Room,
    /// Defocused light and dark patches.
    Blurred,
    /// A paper sweep: floor and wall blend at a soft horizon.
    Sweep,
    /// A paneled wall over a plain floor.
    Paneled,
    /// Light paper with a bright spot behind the table.
    Spotlit,
    /// Two walls that meet in a corner over tiles.
    Corner,
    /// Defocused shelves with objects.
    Shelves,
    /// A room of the renderer with boards, a carpet or concrete below.
    LivingRoom,
    /// A room of the renderer with tiles.
    TiledRoom,
    /// A room of the renderer with terrazzo.
    TerrazzoRoom,
}

pub(super) const KINDS: &[(Kind, Split, f64)] = &[
    (Kind::Plain, Split::Training, 5.0),
    (Kind::Gradient, Split::Training, 2.0),
    (Kind::Room, Split::Training, 1.4),
    (Kind::Blurred, Split::Training, 1.0),
    (Kind::LivingRoom, Split::Training, 6.0),
    (Kind::Sweep, Split::Validation, 5.0),
    (Kind::Paneled, Split::Validation, 1.5),
    (Kind::TiledRoom, Split::Validation, 4.0),
    (Kind::Spotlit, Split::Test, 7.0),
    (Kind::Corner, Split::Test, 1.4),
    (Kind::Shelves, Split::Test, 1.0),
    (Kind::TerrazzoRoom, Split::Test, 6.0),
];

#[cfg(test)]
impl Kind {
    /// The split whose images use it.
    pub fn split(self) -> Split {
        KINDS.iter().find(|(kind, _, _)| *kind == self).expect("every kind is in the list").1
    }
}

impl Kind {
    /// `[a-z]+`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Gradient => "gradient",
            Self::Room => "room",
            Self::Blurred => "blurred",
            Self::Sweep => "sweep",
            Self::Paneled => "paneled",
            Self::Spotlit => "spotlit",
            Self::Corner => "corner",
            Self::Shelves => "shelves",
            Self::LivingRoom => "living_room",
            Self::TiledRoom => "tiled_room",
            Self::TerrazzoRoom => "terrazzo_room",
        }
    }

    /// Floors of the rooms of this kind; none where it is not a room of the renderer.
    fn floors(self) -> &'static [FloorFinish] {
        match self {
            Self::LivingRoom => &[FloorFinish::Boards, FloorFinish::Carpet, FloorFinish::Concrete],
            Self::TiledRoom => &[FloorFinish::Tiles],
            Self::TerrazzoRoom => &[FloorFinish::Terrazzo],
            _ => &[],
        }
    }
}

/// A sampled backdrop.
pub(super) struct Backdrop {
    pub kind: Kind,
    /// Whether the floor shows the table's shadow.
    pub shadowed: bool,
    colors: [Vec3; 4],
    /// Free parameters of the kinds, each 0..1.
    traits: [f32; 6],
    noise: [Noise; 2],
    /// Distance of the wall behind the table center, meters.
    wall_m: f64,
    /// Of a room of the renderer.
    decor: Option<Decor>,
    seed: u64,
}

impl Backdrop {
    pub(super) fn draw(split: Split, rng: &mut Rng) -> Self {
        let kind = of_split(rng, split, KINDS);
        let plain = matches!(kind, Kind::Plain | Kind::Gradient | Kind::Sweep | Kind::Spotlit);
        let color = |rng: &mut Rng| {
            let color = match weighted(rng, &[(0, 8.0), (1, 1.6), (2, 0.9), (3, 1.0)]) {
                0 if plain => {
                    let value = 1.0 - uniform(rng, 0.0, 0.25) * uniform(rng, 0.0, 1.0);
                    hsv(uniform(rng, 0.0, 1.0), uniform(rng, 0.0, 0.03), value)
                }
                0 => pale(rng),
                1 => hsv(uniform(rng, 0.0, 1.0), uniform(rng, 0.0, 0.18), uniform(rng, 0.7, 0.95)),
                2 if plain => hsv(uniform(rng, 0.0, 1.0), uniform(rng, 0.0, 0.5), uniform(rng, 0.25, 0.9)),
                _ if plain => pale(rng),
                2 => any_color(rng),
                _ => wood_color(rng),
            };
            Vec3::from(color.to_linear())
        };
        let first = color(rng);
        // A plain backdrop has nearly the same brightness below and above.
        let second =
            if plain && chance(rng, 0.6) { first * uniform(rng, 0.72, 1.0) as f32 } else { color(rng) };
        let wood = Rgb(wood_color(rng).0);
        let decors: Vec<Decor> =
            Decor::all().into_iter().filter(|decor| kind.floors().contains(&decor.floor)).collect();
        Self {
            kind,
            shadowed: chance(rng, 0.75),
            colors: [first, second, Vec3::from(wood.to_linear()), Vec3::from(any_color(rng).to_linear())],
            traits: std::array::from_fn(|_| rng.random_range(0.0..1.0)),
            noise: [Noise::new(7, 5, rng), Noise::new(23, 17, rng)],
            wall_m: uniform(rng, 0.9, 3.5),
            decor: (!decors.is_empty()).then(|| pick(rng, &decors)),
            seed: rng.random(),
        }
    }

    /// The room of the renderer around a table, the first of the objects; `None` where the backdrop is none.
    pub(super) fn room(&self, objects: &[RenderObject]) -> Option<Room> {
        let (decor, table) = (self.decor?, objects.first()?);
        let (low_m, high_m) = table.mesh.bounds();
        Some(Room { decor, ..Room::around(low_m, high_m, Tabletop::of(table), self.seed) })
    }

    /// Linear radiance of the pixel, 0..1; `floor_z_m` is the world height of the floor.
    pub(super) fn light_at(&self, camera: &Camera, pixel: DVec2, floor_z_m: f64) -> Vec3 {
        let (u, v) =
            ((pixel.x / f64::from(camera.width_px)) as f32, (pixel.y / f64::from(camera.height_px)) as f32);
        let [a, b, wood, other] = self.colors;
        let t = self.traits;
        match self.kind {
            Kind::Plain => a,
            Kind::Gradient => a.lerp(b, (v * (1.0 + t[0]) - t[0] * t[1]).clamp(0.0, 1.0)),
            Kind::Blurred => {
                let cloud = self.noise[0].at(0.7 * u, 0.7 * v);
                let lamp = (self.noise[1].at(u * 0.5, v * 0.5) - 0.75).max(0.0) * 3.0;
                a.lerp(other, smooth(cloud * 1.6 - 0.3)).lerp(wood, 0.5 * smooth(2.0 * v - 1.0))
                    + Vec3::splat(lamp)
            }
            Kind::Spotlit => {
                let off = ((u - 0.3 - 0.4 * t[0]).powi(2) + (v - 0.2 - 0.5 * t[1]).powi(2)).sqrt();
                let glow = (-(off / (0.35 + 0.6 * t[2])).powi(2)).exp();
                let shade = 0.72 + 0.28 * t[3].sqrt();
                a * (shade + (1.0 - shade) * glow)
            }
            // The rooms of the renderer are in its images.
            _ => self.enclosed(self.met(camera, pixel, floor_z_m), t),
        }
    }

    /// Intersection of the pixel ray with floor or wall.
    fn met(&self, camera: &Camera, pixel: DVec2, floor_z_m: f64) -> Met {
        let eye = camera.world_from_camera.translation_m;
        let direction = camera.ray_direction_in_world(pixel);
        let ahead = DVec2::new(-camera.azimuth_rad().sin(), camera.azimuth_rad().cos());
        let side = DVec2::new(ahead.y, -ahead.x);
        let along = |p: DVec3| (p.truncate().dot(side), p.truncate().dot(ahead), p.z - floor_z_m);
        let to_floor = (floor_z_m - eye.z) / direction.z;
        let floor = eye + to_floor * direction;
        if to_floor > 0.0 && floor.truncate().dot(ahead) < self.wall_m {
            let (x, y, _) = along(floor);
            return Met::Floor { x: x as f32, ahead: y as f32 };
        }
        let speed = direction.truncate().dot(ahead);
        let to_wall =
            (self.wall_m - eye.truncate().dot(ahead)) / if speed.abs() < 1e-6 { 1e-6 } else { speed };
        let (x, _, z) = along(eye + to_wall.abs().min(50.0) * direction);
        Met::Wall { x: x as f32, z: z as f32 }
    }

    fn enclosed(&self, met: Met, t: [f32; 6]) -> Vec3 {
        let [wall, floor, wood, other] = self.colors;
        match (self.kind, met) {
            (Kind::Sweep, Met::Floor { ahead, .. }) => {
                wall.lerp(floor, smooth(0.5 - (ahead - self.wall_m as f32 + 0.6) / (0.4 + 1.5 * t[0])))
            }
            (Kind::Sweep, Met::Wall { z, .. }) => wall * (1.0 - 0.2 * t[1] * (0.3 * z).clamp(0.0, 1.0)),
            (Kind::Room, Met::Floor { x, ahead }) if t[2] < 0.6 => {
                let (along, across) = if t[3] < 0.5 { (x, ahead) } else { (ahead, x) };
                let board = 0.08 + 0.15 * t[4];
                let row = (across / board).floor();
                let seam = if (across / board - row) < 0.04 { 0.6 } else { 1.0 };
                let shade =
                    0.8 + 0.4 * self.noise[0].at(0.21 * row, 0.11 * (along / 1.3 + 0.37 * row).floor());
                let grain = 0.92 + 0.16 * self.noise[1].at(0.3 * along, 2.0 * across);
                wood * seam * shade * grain
            }
            (Kind::Room, Met::Floor { x, ahead }) => {
                floor * (0.9 + 0.2 * self.noise[1].at(0.6 * x, 0.6 * ahead))
            }
            (Kind::Room, Met::Wall { z, .. }) if z < 0.04 + 0.1 * t[5] => Vec3::splat(0.75).lerp(wood, t[1]),
            (Kind::Room, Met::Wall { x, z }) => {
                let framed =
                    t[0] < 0.5 && (x - 1.4 * t[3] + 0.7).abs() < 0.25 + 0.3 * t[4] && (z - 1.3).abs() < 0.3;
                let light = 0.85 + 0.3 * self.noise[0].at(0.1 * x, 0.15 * z);
                if framed { other } else { wall * light }
            }
            (Kind::Paneled, Met::Wall { x, z }) => {
                let across = (x / (0.3 + 0.5 * t[0])).fract().abs();
                wall * if !(0.05..0.95).contains(&across) { 0.75 } else { 1.0 }
                    * (1.0 - 0.05 * z.clamp(0.0, 3.0))
            }
            (Kind::Corner, Met::Floor { x, ahead }) => {
                let size = 0.2 + 0.4 * t[0];
                let (i, j) = ((x + 0.5 * ahead) / size, (ahead - 0.5 * x) / size);
                let odd = (i.floor() + j.floor()).rem_euclid(2.0) > 0.5;
                let joint = i.rem_euclid(1.0).min(j.rem_euclid(1.0)) < 0.03;
                if joint {
                    floor * 0.7
                } else if odd && t[1] < 0.5 {
                    floor * 0.8
                } else {
                    floor
                }
            }
            (Kind::Corner, Met::Wall { x, z }) => {
                let lit = if x < 2.0 * t[2] - 1.0 { 1.0 } else { 0.82 };
                wall * lit * (1.0 - 0.06 * z.clamp(0.0, 3.0))
            }
            (Kind::Shelves, Met::Wall { x, z }) => {
                let level = (z / (0.3 + 0.2 * t[0])).rem_euclid(1.0);
                let objects = self.noise[1].at(0.35 * x, 0.05 * (z / (0.3 + 0.2 * t[0])).floor());
                let board = smooth((0.1 - (level - 0.05).abs()) * 30.0);
                let object = smooth((objects - level) * 6.0) * smooth((level - 0.08) * 12.0);
                wall.lerp(other.lerp(wood, objects), 0.8 * object).lerp(wood, board)
            }
            (Kind::Shelves | Kind::Paneled, Met::Floor { x, ahead }) => {
                floor * (0.93 + 0.14 * self.noise[0].at(0.3 * x, 0.3 * ahead))
            }
            _ => wall,
        }
    }
}

/// A point of the floor or the wall, meters: to the right, away from the camera, up.
enum Met {
    Floor { x: f32, ahead: f32 },
    Wall { x: f32, z: f32 },
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
