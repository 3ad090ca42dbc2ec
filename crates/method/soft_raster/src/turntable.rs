//! Test objects on a turntable before a fixed camera, in double precision, with the derivative by yaw.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};

use super::loss::Target;
use super::{MovingPoint, Surface, reference};

/// From the camera to the turntable's axis, meters.
const DISTANCE: f64 = 3.0;

/// An object about a meter large and a camera that sees it whole, whatever the yaw.
pub struct Turntable {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    pub side_px: usize,
    pub elevation_rad: f64,
}

/// Images that a drawing is compared with.
pub struct Planes {
    pub mask: Vec<f32>,
    pub known: Vec<f32>,
    pub distance_px: Vec<f32>,
}

impl Planes {
    pub fn target(&self, side_px: usize) -> Target<'_> {
        let mask_area_px2 = self.mask.iter().map(|&m| f64::from(m)).sum();
        let Self { mask, known, distance_px } = self;
        Target { mask, known, distance_px, mask_area_px2, side_px: side_px as f64 }
    }
}

impl Turntable {
    pub fn surface(&self) -> Surface {
        Surface::new(&self.triangles)
    }

    /// Positions in the camera's frame (along +z, y down) and their derivatives by yaw.
    pub fn in_camera(&self, yaw_rad: f64) -> Vec<(DVec3, DVec3)> {
        let (sin, cos) = yaw_rad.sin_cos();
        let (sin_e, cos_e) = self.elevation_rad.sin_cos();
        let seen = |p: DVec3| DVec3::new(p.x, p.y * sin_e - p.z * cos_e, p.y * cos_e + p.z * sin_e);
        self.positions
            .iter()
            .map(|&p| {
                let turned = DVec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z);
                let moving = DVec3::new(-turned.y, turned.x, 0.0);
                (seen(turned) + DVec3::Z * DISTANCE, seen(moving))
            })
            .collect()
    }

    pub fn focal_px(&self) -> f64 {
        1.15 * self.side_px as f64
    }

    /// Pixel positions and their derivatives by yaw.
    pub fn projected(&self, yaw_rad: f64) -> Vec<(DVec2, DVec2)> {
        let (side, focal_px) = (self.side_px as f64, self.focal_px());
        self.in_camera(yaw_rad)
            .into_iter()
            .map(|(q, v)| {
                let at = focal_px * q.truncate() / q.z;
                (at + 0.5 * side, (focal_px * v.truncate() - at * v.z) / q.z)
            })
            .collect()
    }

    pub fn points(&self, yaw_rad: f64) -> Vec<MovingPoint<1>> {
        self.projected(yaw_rad)
            .into_iter()
            .map(|(p, v)| MovingPoint { at_px: p.as_vec2().into(), slopes: [v.as_vec2().into()] })
            .collect()
    }

    pub fn faces(&self, yaw_rad: f64) -> Vec<[DVec2; 3]> {
        let points = self.projected(yaw_rad);
        self.triangles.iter().map(|t| t.map(|v| points[v as usize].0)).collect()
    }

    /// The mask at a yaw, a corner of it hidden, and the distance to its contour.
    pub fn planes(&self, yaw_rad: f64, hidden: impl Fn(usize, usize) -> bool) -> Planes {
        let side = self.side_px;
        let soft = reference::coverage(&self.faces(yaw_rad), side, side, 0.1);
        self.planes_of(&soft, hidden)
    }

    pub fn planes_of(&self, soft: &[f64], hidden: impl Fn(usize, usize) -> bool) -> Planes {
        let side = self.side_px;
        let inside = |x: usize, y: usize| soft[y * side + x] > 0.5;
        let all = || (0..side * side).map(|at| (at % side, at / side));
        let known: Vec<f32> = all().map(|(x, y)| if hidden(x, y) { 0.0 } else { 1.0 }).collect();
        let mask = all().zip(&known).map(|((x, y), k)| soft[y * side + x] as f32 * k).collect();
        let contour: Vec<DVec2> = all()
            .filter(|&(x, y)| x > 0 && y > 0 && x + 1 < side && y + 1 < side && inside(x, y))
            .filter(|&(x, y)| {
                let out = |u: usize, v: usize| !inside(u, v) && !hidden(u, v);
                !hidden(x, y) && (out(x - 1, y) || out(x + 1, y) || out(x, y - 1) || out(x, y + 1))
            })
            .map(|(x, y)| DVec2::new(x as f64, y as f64))
            .collect();
        let distance_px = all()
            .map(|(x, y)| {
                let p = DVec2::new(x as f64, y as f64);
                contour.iter().map(|c| c.distance_squared(p)).fold(f64::INFINITY, f64::min).sqrt() as f32
            })
            .collect();
        Planes { mask, known, distance_px }
    }
}

/// One of five kinds of objects: a lump, an open lump, crossing boxes, a ring, a ring and a lump.
pub fn random_object(rng: &mut impl Rng, kind: usize, side_px: usize) -> Turntable {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut add = |part: (Vec<DVec3>, Vec<[u32; 3]>)| {
        let first = positions.len() as u32;
        positions.extend(part.0);
        triangles.extend(part.1.into_iter().map(|t| t.map(|v| v + first)));
    };
    match kind % 5 {
        0 => add(lump(rng, 2, 0.25)),
        1 => {
            let (positions, mut triangles) = lump(rng, 2, 0.15);
            triangles.retain(|_| rng.random_range(0.0..1.0) < 0.8);
            add((positions, triangles));
        }
        2 => (0..4).for_each(|_| add(block(rng))),
        3 => add(ring(rng, 16, 8)),
        _ => {
            add(ring(rng, 14, 6));
            add(lump(rng, 1, 0.3));
        }
    }
    // Within a ball that the camera sees whole.
    let largest = positions.iter().map(|p: &DVec3| p.length()).fold(0.0, f64::max);
    positions.iter_mut().for_each(|p| *p *= 1.0 / largest);
    Turntable { positions, triangles, side_px, elevation_rad: rng.random_range(0.1..1.2) }
}

/// A sphere of 20 * 4^levels triangles with bumps.
fn lump(rng: &mut impl Rng, levels: usize, bumps: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = 0.5 + 1.25_f64.sqrt();
    let mut positions = Vec::new();
    for (a, b) in [(-1.0, -golden), (-1.0, golden), (1.0, -golden), (1.0, golden)] {
        positions.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    let edge = 2.0;
    let mut triangles = Vec::new();
    for (a, b, c) in (0..12).flat_map(|a| (0..12).flat_map(move |b| (0..12).map(move |c| (a, b, c)))) {
        let [p, q, r] = [a, b, c].map(|v: usize| positions[v]);
        let near = |p: DVec3, q: DVec3| (p.distance(q) - edge).abs() < 1e-6;
        if a < b && a < c && near(p, q) && near(q, r) && near(r, p) && (q - p).cross(r - p).dot(p) > 0.0 {
            triangles.push([a, b, c].map(|v| v as u32));
        }
    }
    for _ in 0..levels {
        let mut centers = BTreeMap::new();
        let mut center = |a: u32, b: u32| {
            *centers.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push(0.5 * (positions[a as usize] + positions[b as usize]));
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (center(a, b), center(b, c), center(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let waves: Vec<(DVec3, f64)> = (0..6)
        .map(|_| {
            (6.0 * DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0))), rng.random())
        })
        .collect();
    for p in &mut positions {
        *p = p.normalize();
        let height: f64 = waves.iter().map(|(k, phase)| (k.dot(*p) + TAU * phase).sin()).sum();
        *p *= 1.0 + bumps * height / 2.0_f64.sqrt() / 2.0;
    }
    (positions, triangles)
}

fn block(rng: &mut impl Rng) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut three = |low: f64, high: f64| -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| rng.random_range(low..high)))
    };
    let (center, half) = (three(-0.5, 0.5), three(0.1, 0.6));
    let corner = |k: u32| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64) * 2.0 - 1.0;
    let positions = (0..8).map(|k| center + half * corner(k)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (positions, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

fn ring(rng: &mut impl Rng, around: u32, across: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (stretch, thick, tilt) =
        (rng.random_range(0.6..1.4), rng.random_range(0.1..0.45), rng.random_range(0.0..1.5_f64));
    let turn = glam::DQuat::from_rotation_x(tilt);
    let mut positions = Vec::new();
    for (u, v) in (0..around).flat_map(|u| (0..across).map(move |v| (u, v))) {
        let (a, b) = (TAU * f64::from(u) / f64::from(around), TAU * f64::from(v) / f64::from(across));
        let radius = 1.0 + thick * b.cos();
        positions.push(turn * DVec3::new(stretch * radius * a.cos(), radius * a.sin(), thick * b.sin()));
    }
    let at = |u: u32, v: u32| u % around * across + v % across;
    let triangles = (0..around)
        .flat_map(|u| (0..across).map(move |v| (u, v)))
        .flat_map(|(u, v)| {
            let [a, b, c, d] = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    (positions, triangles)
}
