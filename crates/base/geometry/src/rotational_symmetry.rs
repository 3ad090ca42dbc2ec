//! Rotational symmetry of a surface about a vertical axis.
//!
//! The only possible axis of a symmetric surface passes through the centroid of the convex hull of its projection
//! onto the floor. Points are sampled evenly over the surface, without those inside other parts of it, and rotated
//! about that axis. If the rotated points lie on the surface again, the rotation is a symmetry. Only shape is
//! compared; labels and colors are compared by image-based methods.
//!
//! The result does not depend on the yaw of the mesh, to within sampling, and is deterministic. A surface that was
//! decimated, or stretched by a few percent, keeps its order. Cost: some 3,000 projections, about 10 ms for 5,000
//! triangles. Limitation: a detail that is small compared with the object (a wick, a stem) is ignored.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2, DVec3};
use parry3d_f64::query::{PointQuery, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, Triangle};
use serde::{Deserialize, Serialize};

use super::TexturedMesh;
use super::polygon::convex_hull_2d;

/// Number of sample points.
const POINTS: usize = 320;

/// Orders that are tried, highest first. A symmetry of one order is also one of its divisors.
const ORDERS: [u32; 8] = [12, 10, 8, 6, 5, 4, 3, 2];

/// Rotations, in full turns, that belong to none of the orders above. A surface symmetric under all of them is
/// treated as symmetric under any rotation.
const ODD_TURNS: [f64; 3] = [0.0713, 0.1937, 0.4111];

/// Root mean square distance up to which rotated points count as on the surface, as a share of the surface's largest
/// radius.
const TOLERANCE: f64 = 0.025;

/// Distances that differ by no more than this share of the radius count as equal.
const AS_GOOD: f64 = 0.005;

/// Offset of ray origins from their own triangle, meters.
const CLEAR_M: f64 = 1e-6;

/// Rotational symmetry of a shape about the vertical.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RotationalSymmetry {
    /// 1 = not at all, n = every 360/n degrees, 0 = at any angle.
    pub order: u32,
    /// Intersection of the axis with the mesh's xy plane, meters.
    pub axis_m: DVec2,
}

impl RotationalSymmetry {
    /// The highest order shared by this shape and a property of the given order, for example its outline or its colors.
    pub fn order_with(&self, order: u32) -> u32 {
        let (mut a, mut b) = (self.order, order);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    }

    /// Of the yaws that the shape cannot tell from `yaw_rad`, the one nearest to `wanted_rad`, not wrapped.
    pub fn nearest_equivalent_rad(&self, yaw_rad: f64, wanted_rad: f64) -> f64 {
        if self.order == 0 {
            return wanted_rad;
        }
        let period_rad = TAU / f64::from(self.order);
        yaw_rad + period_rad * ((wanted_rad - yaw_rad) / period_rad).round()
    }

    /// The symmetry of the mesh's surface. Without a surface: order 1 about the origin.
    pub fn of(mesh: &TexturedMesh) -> Self {
        let triangles: Vec<[u32; 3]> =
            mesh.groups.iter().flat_map(|group| &group.triangles).copied().collect();
        let none = Self { order: 1, axis_m: DVec2::ZERO };
        let Some(samples) = spread(&mesh.positions, &triangles) else { return none };
        let axis_m = center_of_shadow(&mesh.positions);
        let Ok(surface) = TriMesh::new(mesh.positions.clone(), triangles) else { return none };
        let points = outer(&surface, samples);
        let radius_m = points.iter().map(|p| p.truncate().distance(axis_m)).fold(0.0, f64::max);
        let max_squares = points.len() as f64 * (TOLERANCE * radius_m).powi(2);
        // Root mean square distance from the surface after a turn, as a share of the radius; infinite where it is sure
        // to be beyond the tolerance.
        let off = |turn: f64| {
            let rotation = DMat2::from_angle(TAU * turn);
            let mut squares = 0.0;
            for p in &points {
                let turned = (rotation * (p.truncate() - axis_m) + axis_m).extend(p.z);
                squares += surface.project_local_point(turned, false).point.distance_squared(turned);
                if squares > max_squares {
                    return f64::INFINITY;
                }
            }
            (squares / points.len() as f64).sqrt() / radius_m
        };
        if ODD_TURNS.into_iter().all(|turn| off(turn) <= TOLERANCE) {
            return Self { order: 0, axis_m };
        }
        let tried = ORDERS.map(|order| (order, off(1.0 / f64::from(order))));
        // A hexagon is nearly an octagon: of the orders that are about as good as the best, the highest.
        let best = tried.iter().map(|(_, off)| *off).fold(TOLERANCE, f64::min);
        let borne = tried.iter().find(|(_, off)| *off <= TOLERANCE.min(best + AS_GOOD));
        Self { order: borne.map_or(1, |(order, _)| *order), axis_m }
    }
}

/// The centroid of the convex hull seen from above.
fn center_of_shadow(positions: &[DVec3]) -> DVec2 {
    let hull = convex_hull_2d(&positions.iter().map(|p| p.truncate()).collect::<Vec<_>>());
    let Some(&first) = hull.first() else { return DVec2::ZERO };
    let (mut moment, mut area) = (DVec2::ZERO, 0.0);
    for side in hull[1..].windows(2) {
        let (a, b) = (side[0] - first, side[1] - first);
        let twice = a.perp_dot(b);
        moment += (a + b) / 3.0 * twice;
        area += twice;
    }
    if area > 0.0 { first + moment / area } else { first }
}

/// A point of the surface.
struct SurfaceSample {
    at: DVec3,
    /// Of its triangle, unit.
    normal: DVec3,
}

/// The samples that are not inside another part of the mesh, such as the foot of a badge inside the object that
/// carries it. All samples if hardly any is outside, as for an inverted surface.
fn outer(surface: &TriMesh, samples: Vec<SurfaceSample>) -> Vec<DVec3> {
    let is_outer = |spot: &&SurfaceSample| {
        let start = spot.at + CLEAR_M * spot.normal;
        let hit = surface.cast_local_ray_and_get_normal(&Ray::new(start, spot.normal), f64::MAX, false);
        let Some(hit) = hit else { return true };
        let Triangle { a, b, c } = surface.triangle(hit.subshape);
        (b - a).cross(c - a).dot(spot.normal) <= 0.0
    };
    let outer: Vec<DVec3> = samples.iter().filter(is_outer).map(|spot| spot.at).collect();
    if 2 * outer.len() >= samples.len() { outer } else { samples.iter().map(|spot| spot.at).collect() }
}

/// Points evenly over the triangles; `None` where they have no area.
fn spread(positions: &[DVec3], triangles: &[[u32; 3]]) -> Option<Vec<SurfaceSample>> {
    let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = corners(t);
        0.5 * (b - a).cross(c - a).length()
    };
    let total: f64 = triangles.iter().map(area).sum();
    if !total.is_finite() || total <= 0.0 {
        return None;
    }
    let step = total / POINTS as f64;
    let mut points = Vec::with_capacity(POINTS);
    let mut before = 0.0;
    for triangle in triangles {
        let [a, b, c] = corners(triangle);
        let own = area(triangle);
        // One point for every `step` of area; within a triangle by the R2 sequence
        // (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
        while points.len() < POINTS && (points.len() as f64 + 0.5) * step < before + own {
            let k = points.len() as f64;
            let (u, v) = ((k * 0.754_877_666).fract(), (k * 0.569_840_291).fract());
            // The other half of the parallelogram is mirrored into the triangle.
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let normal = (b - a).cross(c - a).normalize_or_zero();
            points.push(SurfaceSample { at: a + u * (b - a) + v * (c - a), normal });
        }
        before += own;
    }
    Some(points)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::shapes::{block, cylinder, prism, regular_polygon, sphere};
    use crate::{Material, Rgb, Solid};

    fn mesh(solids: impl IntoIterator<Item = Solid>) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        let plain = Material::plain("plain", Rgb::hex(0x80_80_80), 0.5);
        solids.into_iter().for_each(|solid| mesh.add(solid, &plain));
        mesh
    }

    #[test]
    fn symmetry_order_of_known_shapes() {
        let order = |solid: Solid| {
            let turned = solid.rotated(DQuat::from_rotation_z(0.7)).translated(DVec3::new(0.3, -0.2, 0.0));
            let found = RotationalSymmetry::of(&mesh([turned]));
            assert!((found.axis_m - DVec2::new(0.3, -0.2)).length() < 1e-3, "{found:?}");
            found.order
        };
        assert_eq!(order(cylinder(0.05, 0.1, 0.002, 48)), 0);
        assert_eq!(order(sphere(0.05, 32).translated(DVec3::Z * 0.05)), 0);
        assert_eq!(order(block(DVec3::new(0.1, 0.1, 0.05))), 4);
        assert_eq!(order(block(DVec3::new(0.16, 0.1, 0.05))), 2);
        assert_eq!(order(prism(&regular_polygon(0.06, 3), 0.05)), 3);
        assert_eq!(order(prism(&regular_polygon(0.06, 6), 0.05)), 6);
    }

    #[test]
    fn symmetry_ignores_parts_inside_other_parts() {
        let badge = block(DVec3::new(0.08, 0.04, 0.0405)).translated(DVec3::new(0.0, 0.07, 0.0));
        let parts = mesh([block(DVec3::new(0.12, 0.2, 0.04)), badge]);
        assert_eq!(RotationalSymmetry::of(&parts).order, 2);
    }

    #[test]
    fn order_with_any_rotation_is_the_order_of_the_other() {
        let with = |a: u32, b: u32| RotationalSymmetry { order: a, axis_m: DVec2::ZERO }.order_with(b);
        assert_eq!([with(0, 0), with(0, 6), with(4, 0), with(4, 6), with(1, 0)], [0, 6, 4, 2, 1]);
    }

    #[test]
    fn symmetry_of_a_mug_with_handle_is_one() {
        let handle = block(DVec3::new(0.02, 0.008, 0.05)).translated(DVec3::new(0.058, 0.0, 0.02));
        assert_eq!(RotationalSymmetry::of(&mesh([cylinder(0.05, 0.1, 0.002, 48), handle])).order, 1);
        assert_eq!(RotationalSymmetry::of(&TexturedMesh::default()).order, 1);
    }
}
