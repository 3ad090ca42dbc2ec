//! Rotational symmetry of a surface about a vertical axis.
//!
//! The only axis a symmetric surface can have is the one through the middle of the convex hull of its shadow on the
//! floor. Points spread evenly over the surface, less those inside other parts of it, are turned about that axis; where
//! the turned points lie on the surface again, the turn is a symmetry. What is compared is shape alone: labels and
//! colors are the business of whoever looks at pictures.
//!
//! Guarantees: the same answer whatever the yaw of the mesh, to within sampling; deterministic. A surface that was
//! coarsened or stretched by a few percent keeps its order. Cost: some 3,000 projections, about 10 ms for 5,000
//! triangles. Not for symmetric things with a detail that is small beside them (a wick, a stem): those count as
//! symmetric.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2, DVec3};
use parry3d_f64::query::{PointQuery, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, Triangle};
use serde::{Deserialize, Serialize};

use super::TexturedMesh;
use super::collide::convex_hull_2d;

/// Points that are turned.
const POINTS: usize = 320;

/// Orders that are tried, highest first; what bears one bears its divisors.
const ORDERS: [u32; 8] = [12, 10, 8, 6, 5, 4, 3, 2];

/// Turns, of a whole one, that no order above bears: a surface that bears them all bears any.
const ODD_TURNS: [f64; 3] = [0.0713, 0.1937, 0.4111];

/// Root mean square distance up to which turned points lie on the surface, as a share of the surface's largest radius.
const TOLERANCE: f64 = 0.025;

/// Distances, as shares of the radius, that differ by no more than this are as good as each other.
const AS_GOOD: f64 = 0.005;

/// How far from its own triangle a ray begins, meters.
const CLEAR_M: f64 = 1e-6;

/// How a shape repeats about the vertical.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RotationalSymmetry {
    /// 1 = not at all, n = every 360/n degrees, 0 = at any angle.
    pub order: u32,
    /// Where the axis meets the mesh's xy plane, meters.
    pub axis_m: DVec2,
}

impl RotationalSymmetry {
    /// The highest order that this shape and something of that order (its outline, its colors) have in common.
    pub fn order_with(&self, order: u32) -> u32 {
        let (mut a, mut b) = (self.order, order);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    }

    /// Of the mesh's surface; order 1 about the origin where there is none.
    pub fn of(mesh: &TexturedMesh) -> Self {
        let triangles: Vec<[u32; 3]> =
            mesh.groups.iter().flat_map(|group| &group.triangles).copied().collect();
        let none = Self { order: 1, axis_m: DVec2::ZERO };
        let Some(spots) = spread(&mesh.positions, &triangles) else { return none };
        let axis_m = middle_of_shadow(&mesh.positions);
        let Ok(surface) = TriMesh::new(mesh.positions.clone(), triangles) else { return none };
        let points = outer(&surface, spots);
        let radius_m = points.iter().map(|p| p.truncate().distance(axis_m)).fold(0.0, f64::max);
        let most_squares = points.len() as f64 * (TOLERANCE * radius_m).powi(2);
        // Root mean square distance from the surface after a turn, as a share of the radius; infinite where it is sure
        // to be beyond the tolerance.
        let off = |turn: f64| {
            let rotation = DMat2::from_angle(TAU * turn);
            let mut squares = 0.0;
            for p in &points {
                let turned = (rotation * (p.truncate() - axis_m) + axis_m).extend(p.z);
                squares += surface.project_local_point(turned, false).point.distance_squared(turned);
                if squares > most_squares {
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
fn middle_of_shadow(positions: &[DVec3]) -> DVec2 {
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
struct Spot {
    at: DVec3,
    /// Of its triangle, unit.
    normal: DVec3,
}

/// The spots that are not inside another part of the mesh (the foot of a badge in the thing that wears it); all where
/// hardly any is outside, as of a surface that is inside out.
fn outer(surface: &TriMesh, spots: Vec<Spot>) -> Vec<DVec3> {
    let is_outer = |spot: &&Spot| {
        let start = spot.at + CLEAR_M * spot.normal;
        let hit = surface.cast_local_ray_and_get_normal(&Ray::new(start, spot.normal), f64::MAX, false);
        let Some(hit) = hit else { return true };
        let Triangle { a, b, c } = surface.triangle(hit.subshape);
        (b - a).cross(c - a).dot(spot.normal) <= 0.0
    };
    let outer: Vec<DVec3> = spots.iter().filter(is_outer).map(|spot| spot.at).collect();
    if 2 * outer.len() >= spots.len() { outer } else { spots.iter().map(|spot| spot.at).collect() }
}

/// Points evenly over the triangles; `None` where they have no area.
fn spread(positions: &[DVec3], triangles: &[[u32; 3]]) -> Option<Vec<Spot>> {
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
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let normal = (b - a).cross(c - a).normalize_or_zero();
            points.push(Spot { at: a + u * (b - a) + v * (c - a), normal });
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
    fn shapes_repeat_as_often_as_they_do() {
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
    fn what_is_inside_another_part_does_not_count() {
        let badge = block(DVec3::new(0.08, 0.04, 0.0405)).translated(DVec3::new(0.0, 0.07, 0.0));
        let parts = mesh([block(DVec3::new(0.12, 0.2, 0.04)), badge]);
        assert_eq!(RotationalSymmetry::of(&parts).order, 2);
    }

    #[test]
    fn what_bears_any_turn_bears_those_of_the_other() {
        let with = |a: u32, b: u32| RotationalSymmetry { order: a, axis_m: DVec2::ZERO }.order_with(b);
        assert_eq!([with(0, 0), with(0, 6), with(4, 0), with(4, 6), with(1, 0)], [0, 6, 4, 2, 1]);
    }

    #[test]
    fn a_handle_ends_the_symmetry() {
        let handle = block(DVec3::new(0.02, 0.008, 0.05)).translated(DVec3::new(0.058, 0.0, 0.02));
        assert_eq!(RotationalSymmetry::of(&mesh([cylinder(0.05, 0.1, 0.002, 48), handle])).order, 1);
        assert_eq!(RotationalSymmetry::of(&TexturedMesh::default()).order, 1);
    }
}
