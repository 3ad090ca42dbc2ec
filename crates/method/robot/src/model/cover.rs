//! Spheres that together contain a primitive and stick out of it by no more than a tolerance.
//!
//! A capsule is covered by equal spheres along its line, a box by one sphere around each cell of a grid, a cylinder by
//! one column of spheres or by a grid whose cells outside of it are left out. Of all grids that meet the tolerance the
//! one with the fewest spheres is taken. A sphere of radius `r` at signed distance `s` of a convex primitive sticks
//! out by exactly `s + r`, so the tolerance is a bound and not an estimate.

use nalgebra::{Point3, Vector3};

use crate::model::link::Link;
use crate::model::shape::Primitive;
use crate::model::sphere_model::LinkSphere;

/// A sphere in the frame of a primitive or link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverSphere {
    pub center_m: Point3<f64>,
    pub radius_m: f64,
}

/// Rounding to `f32` must not uncover a surface.
const ROUNDING_M: f64 = 1e-6;

/// Computes spheres in the frame of `primitive` that contain it and stick out of it by at most `tolerance_m`, which
/// must be positive.
pub fn cover(primitive: &Primitive, tolerance_m: f64) -> Vec<CoverSphere> {
    match *primitive {
        Primitive::Sphere { radius_m } => vec![CoverSphere { center_m: Point3::origin(), radius_m }],
        Primitive::Capsule { radius_m, half_length_m } => cover_capsule(radius_m, half_length_m, tolerance_m),
        Primitive::Box { half_size_m } => cover_box(half_size_m, tolerance_m),
        Primitive::Cylinder { radius_m, half_length_m } => {
            cover_cylinder(radius_m, half_length_m, tolerance_m)
        }
    }
}

/// Computes the spheres of a link whose shapes collide, in the frame of the link, as link `index`. A sphere inside
/// another one is left out.
pub fn cover_link(link: &Link, index: usize) -> Vec<LinkSphere> {
    let mut spheres: Vec<CoverSphere> = Vec::new();
    for shape in link.shapes.iter().filter(|shape| shape.collides()) {
        for sphere in cover(&shape.primitive, link.sphere_tolerance_m) {
            spheres.push(CoverSphere { center_m: shape.link_from_shape * sphere.center_m, ..sphere });
        }
    }
    spheres.sort_by(|a, b| b.radius_m.total_cmp(&a.radius_m));
    let mut kept: Vec<CoverSphere> = Vec::new();
    for sphere in spheres {
        let is_inside = |outer: &CoverSphere| {
            (outer.center_m - sphere.center_m).norm() + sphere.radius_m <= outer.radius_m
        };
        if !kept.iter().any(is_inside) {
            kept.push(sphere);
        }
    }
    kept.iter().map(|sphere| sphere.of_link(index)).collect()
}

/// Computes a sphere that contains all of `spheres`. `None` for none.
///
/// It starts as the largest and grows just enough to contain the farthest of the others, one after another; then the
/// radius shrinks to what its center needs (Ritter 1990, for spheres).
pub fn bounding_sphere(spheres: &[LinkSphere]) -> Option<LinkSphere> {
    let center = |sphere: &LinkSphere| Point3::from(sphere.center_m.map(f64::from));
    let reach =
        |from: &Point3<f64>, sphere: &LinkSphere| (center(sphere) - from).norm() + f64::from(sphere.radius_m);
    let largest = spheres.iter().max_by(|a, b| a.radius_m.total_cmp(&b.radius_m))?;
    let mut bound = CoverSphere { center_m: center(largest), radius_m: f64::from(largest.radius_m) };
    for _ in 0..spheres.len() {
        let from = bound.center_m;
        let farthest = spheres.iter().max_by(|a, b| reach(&from, a).total_cmp(&reach(&from, b)))?;
        let grown = (bound.radius_m + reach(&from, farthest)) / 2.0;
        if let Some(toward) = (center(farthest) - from).try_normalize(1e-9).filter(|_| grown > bound.radius_m)
        {
            bound.center_m += toward * (grown - bound.radius_m);
            bound.radius_m = grown;
        }
    }
    let needed = spheres.iter().map(|sphere| reach(&bound.center_m, sphere)).fold(0.0, f64::max);
    Some(CoverSphere { radius_m: needed, ..bound }.of_link(largest.link))
}

impl CoverSphere {
    fn of_link(&self, link: usize) -> LinkSphere {
        LinkSphere {
            link,
            center_m: self.center_m.coords.map(|c| c as f32).into(),
            radius_m: (self.radius_m + ROUNDING_M) as f32,
        }
    }
}

fn cover_capsule(radius_m: f64, half_length_m: f64, tolerance_m: f64) -> Vec<CoverSphere> {
    let at = |z: f64, radius_m: f64| CoverSphere { center_m: Point3::new(0.0, 0.0, z), radius_m };
    if half_length_m <= tolerance_m {
        return vec![at(0.0, radius_m + half_length_m)];
    }
    // The outer two contain the round ends; neighbors meet on the tube.
    let outer = half_length_m - tolerance_m;
    let radius = radius_m + tolerance_m;
    let spacing = 2.0 * (radius * radius - radius_m * radius_m).sqrt();
    let gaps = (2.0 * outer / spacing).ceil().max(1.0);
    (0..=gaps as usize).map(|k| at(outer * (2.0 * k as f64 / gaps - 1.0), radius)).collect()
}

fn cover_box(half: Vector3<f64>, tolerance_m: f64) -> Vec<CoverSphere> {
    let cell = |counts: [usize; 3]| Vector3::from_fn(|k, _| half[k] / counts[k] as f64);
    let meets = |counts: [usize; 3]| cell(counts).norm() - cell(counts).min() <= tolerance_m;
    // With cells of this half size along each axis, no sphere exceeds the tolerance even in a flat box.
    let limit = |k: usize| (half[k] * std::f64::consts::SQRT_2 / tolerance_m).ceil().max(1.0) as usize;
    let mut best = [limit(0), limit(1), limit(2)];
    let size = |counts: [usize; 3]| counts.iter().product::<usize>();
    for x in 1..=limit(0) {
        for y in 1..=limit(1) {
            if let Some(z) = (1..=limit(2)).find(|z| meets([x, y, *z])) {
                let counts = [x, y, z];
                let smaller = size(counts) == size(best) && cell(counts).norm() < cell(best).norm();
                if size(counts) < size(best) || smaller {
                    best = counts;
                }
            }
        }
    }
    grid(half, best).map(|center_m| CoverSphere { center_m, radius_m: cell(best).norm() }).collect()
}

fn cover_cylinder(radius_m: f64, half_length_m: f64, tolerance_m: f64) -> Vec<CoverSphere> {
    let primitive = Primitive::Cylinder { radius_m, half_length_m };
    // With cells of half sizes t / 4 across and t / 2 along for a tolerance t, a center lies at most sqrt(2) t / 4
    // outside, its radius is at most sqrt(3 / 8) t, and the sum stays below t: the finest grid always meets it.
    let max_across = (4.0 * radius_m / tolerance_m).ceil().max(1.0) as usize;
    let max_along = (2.0 * half_length_m / tolerance_m).ceil().max(1.0) as usize;
    let mut best: Option<Vec<CoverSphere>> = None;
    for across in 1..=max_across {
        for along in 1..=max_along {
            let spheres = cylinder_grid(radius_m, half_length_m, [across, across, along]);
            let sticks_out = |s: &CoverSphere| primitive.signed_distance_m(&s.center_m) + s.radius_m;
            let is_fewer = best.as_ref().is_none_or(|best| spheres.len() < best.len());
            if is_fewer && spheres.iter().all(|sphere| sticks_out(sphere) <= tolerance_m) {
                best = Some(spheres);
            }
        }
    }
    best.unwrap_or_else(|| cylinder_grid(radius_m, half_length_m, [max_across, max_across, max_along]))
}

/// The spheres around the cells of a grid that meet the cylinder; around whole slices where the grid is one cell wide.
fn cylinder_grid(radius_m: f64, half_length_m: f64, counts: [usize; 3]) -> Vec<CoverSphere> {
    let half = Vector3::new(radius_m, radius_m, half_length_m);
    let across = radius_m / counts[0] as f64;
    let along = half_length_m / counts[2] as f64;
    let radius =
        if counts[0] == 1 { radius_m.hypot(along) } else { (2.0 * across * across + along * along).sqrt() };
    let meets = |center: &Point3<f64>| {
        let nearest = |c: f64| (c.abs() - across).max(0.0);
        nearest(center.x).hypot(nearest(center.y)) <= radius_m
    };
    grid(half, counts).filter(meets).map(|center_m| CoverSphere { center_m, radius_m: radius }).collect()
}

/// The centers of the cells of a box about the origin.
fn grid(half: Vector3<f64>, counts: [usize; 3]) -> impl Iterator<Item = Point3<f64>> {
    let center = move |axis: usize, k: usize| half[axis] * ((2 * k + 1) as f64 / counts[axis] as f64 - 1.0);
    let [nx, ny, nz] = counts;
    (0..nx * ny * nz)
        .map(move |k| Point3::new(center(0, k % nx), center(1, k / nx % ny), center(2, k / (nx * ny))))
}

#[cfg(test)]
mod tests;
