//! Shapes of links as convex hulls.

use std::f64::consts::TAU;

use geometry::{ConvexHull, DVec3};
use nalgebra::{Isometry3, Point3};
use robot::model::{Primitive, Shape};

use crate::frames::to_vector;

/// Sides of round shapes. The corners lie on the surface, so that flats are up to 2 % of the radius inside it.
const SIDES: usize = 16;
/// Rings from the equator to the pole of a round end.
const RINGS: usize = 3;

/// The hull of a shape in the frame that `part_from_link` leads to. Boxes are exact; round shapes are inscribed.
pub fn hull_of(shape: &Shape, part_from_link: &Isometry3<f64>) -> ConvexHull {
    let part_from_shape = part_from_link * shape.link_from_shape;
    let (points, triangles) = match shape.primitive {
        Primitive::Box { half_size_m: h } => box_corners(DVec3::new(h.x, h.y, h.z)),
        Primitive::Cylinder { radius_m, half_length_m } => {
            rings(&[(radius_m, -half_length_m), (radius_m, half_length_m)])
        }
        Primitive::Capsule { radius_m, half_length_m } => rings(&round_profile(radius_m, half_length_m)),
        Primitive::Sphere { radius_m } => rings(&round_profile(radius_m, 0.0)),
    };
    let placed = |p: DVec3| to_vector(&(part_from_shape * Point3::new(p.x, p.y, p.z)).coords);
    ConvexHull { points: points.into_iter().map(placed).collect(), triangles }
}

/// Corners and outward triangles of a box about the origin.
fn box_corners(half: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    let points = (0..8).map(|k| half * DVec3::new(sign(k & 1), sign(k & 2), sign(k & 4))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (points, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Radius and height of the rings of a capsule along z, from below.
fn round_profile(radius_m: f64, half_length_m: f64) -> Vec<(f64, f64)> {
    let angle = |k: usize| 0.25 * TAU * k as f64 / (RINGS as f64 + 0.5);
    let upper = (0..=RINGS).map(|k| (radius_m * angle(k).cos(), half_length_m + radius_m * angle(k).sin()));
    let upper: Vec<(f64, f64)> = upper.collect();
    let lower = upper.iter().rev().map(|(radius, z)| (*radius, -z));
    // Without a tube both equators are one.
    let skipped = usize::from(half_length_m <= 0.0);
    lower.chain(upper.iter().skip(skipped).copied()).collect()
}

/// Corners and outward triangles of a solid of revolution along z with flat ends.
fn rings(profile: &[(f64, f64)]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let points = profile.iter().flat_map(|&(radius, z)| {
        (0..SIDES).map(move |k| {
            let angle = TAU * k as f64 / SIDES as f64;
            DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
    });
    let index = |ring: usize, side: usize| (ring * SIDES + side % SIDES) as u32;
    let mut triangles = Vec::new();
    for ring in 1..profile.len() {
        for side in 0..SIDES {
            let [a, b] = [index(ring - 1, side), index(ring - 1, side + 1)];
            let [c, d] = [index(ring, side + 1), index(ring, side)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let last = profile.len() - 1;
    for side in 1..SIDES - 1 {
        triangles.push([index(0, 0), index(0, side + 1), index(0, side)]);
        triangles.push([index(last, 0), index(last, side), index(last, side + 1)]);
    }
    (points.collect(), triangles)
}
