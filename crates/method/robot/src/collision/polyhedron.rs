//! Convex polyhedra: half-spaces for quick answers, triangles for exact distances.

use nalgebra::{Point3, Vector3};

/// Maximum distance of a corner outside the plane of a face, as a share of the polyhedron's size.
const CONVEX_SHARE: f64 = 1e-6;
/// A triangle is left out if its doubled area is less than this share of the square of the polyhedron's size.
const SLIVER_SHARE: f64 = 1e-12;

/// A convex polyhedron with its corners and its faces as triangles, in the frame it is given in.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPolyhedron {
    points_m: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    planes: Vec<Plane>,
}

/// A plane with its outward unit normal: `normal · p = offset_m` on the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    pub normal: Vector3<f64>,
    pub offset_m: f64,
}

impl Plane {
    /// Signed distance of a point from the plane, meters; negative inside.
    pub fn height_m(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset_m
    }
}

/// Reason why corners and triangles are not a convex polyhedron.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PolyhedronError {
    #[error("a convex polyhedron needs at least 4 corners and 4 triangles, not {points} and {triangles}")]
    TooSmall { points: usize, triangles: usize },
    #[error("triangle {triangle} of the polyhedron names a corner that does not exist")]
    NoSuchCorner { triangle: usize },
    #[error("corner {point} of the polyhedron is not a finite position")]
    NotFinite { point: usize },
    #[error(
        "corner {point} lies {outside_m} m outside the face {triangle}: not convex, or its faces point inward"
    )]
    NotConvex { point: usize, triangle: usize, outside_m: f64 },
    #[error("the polyhedron is flat")]
    Flat,
}

impl ConvexPolyhedron {
    /// A polyhedron from corners and triangles that are counter-clockwise as seen from outside.
    pub fn new(points_m: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self, PolyhedronError> {
        if points_m.len() < 4 || triangles.len() < 4 {
            return Err(PolyhedronError::TooSmall { points: points_m.len(), triangles: triangles.len() });
        }
        if let Some(point) = points_m.iter().position(|p| !p.coords.iter().all(|c| c.is_finite())) {
            return Err(PolyhedronError::NotFinite { point });
        }
        let exists = |triangle: &[u32; 3]| triangle.iter().all(|&corner| (corner as usize) < points_m.len());
        if let Some(triangle) = triangles.iter().position(|t| !exists(t)) {
            return Err(PolyhedronError::NoSuchCorner { triangle });
        }
        let size_m = points_m.iter().map(|p| (p - points_m[0]).norm()).fold(0.0, f64::max);
        let mut planes: Vec<Plane> = Vec::new();
        for (index, triangle) in triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|corner| points_m[corner as usize]);
            let across = (b - a).cross(&(c - a));
            if across.norm() <= SLIVER_SHARE * size_m * size_m {
                continue;
            }
            let normal = across.normalize();
            let plane = Plane { normal, offset_m: normal.dot(&a.coords) };
            for (point, position) in points_m.iter().enumerate() {
                let outside_m = plane.height_m(position);
                if outside_m > CONVEX_SHARE * size_m {
                    return Err(PolyhedronError::NotConvex { point, triangle: index, outside_m });
                }
            }
            // Triangles of one face share its plane.
            let known = |other: &Plane| {
                (other.normal - normal).norm() < 1e-9
                    && (other.offset_m - plane.offset_m).abs() < 1e-9 * size_m
            };
            if !planes.iter().any(known) {
                planes.push(plane);
            }
        }
        let deepest = |plane: &Plane| points_m.iter().map(|p| plane.height_m(p)).fold(0.0, f64::min);
        if planes.len() < 4 || planes.iter().any(|plane| deepest(plane) > -CONVEX_SHARE * size_m) {
            return Err(PolyhedronError::Flat);
        }
        Ok(Self { points_m, triangles, planes })
    }

    pub fn points_m(&self) -> &[Point3<f64>] {
        &self.points_m
    }

    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// The distance from a point to the surface, negative inside.
    pub fn signed_distance_m(&self, point: &Point3<f64>) -> f64 {
        let highest_m =
            self.planes.iter().map(|plane| plane.height_m(point)).fold(f64::NEG_INFINITY, f64::max);
        if highest_m <= 0.0 {
            return highest_m;
        }
        let corners = |triangle: &[u32; 3]| triangle.map(|corner| self.points_m[corner as usize]);
        self.triangles.iter().map(|t| distance_to_triangle_m(point, corners(t))).fold(f64::INFINITY, f64::min)
    }
}

/// The distance from a point to a triangle, which may be as thin as a line.
fn distance_to_triangle_m(point: &Point3<f64>, [a, b, c]: [Point3<f64>; 3]) -> f64 {
    let edges = [(a, b), (b, c), (c, a)];
    let to_edges =
        || edges.iter().map(|(p, q)| distance_to_segment_m(point, p, q)).fold(f64::INFINITY, f64::min);
    let across = (b - a).cross(&(c - a));
    let area = across.norm();
    if area == 0.0 {
        return to_edges();
    }
    let normal = across / area;
    let above_face = edges.iter().all(|(p, q)| (q - p).cross(&(point - p)).dot(&normal) >= 0.0);
    if above_face { normal.dot(&(point - a)).abs() } else { to_edges() }
}

/// The distance from a point to the segment between two points.
fn distance_to_segment_m(point: &Point3<f64>, from: &Point3<f64>, to: &Point3<f64>) -> f64 {
    let along = to - from;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((point - from).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (point - (from + share * along)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corner of a unit cube that is cut off: right angles at the origin.
    fn corner() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        (points.map(Point3::from).to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    #[test]
    fn distances_to_faces_edges_corners_and_from_inside() {
        let (points, triangles) = corner();
        let solid = ConvexPolyhedron::new(points, triangles).expect("a tetrahedron");
        let root3 = 3.0_f64.sqrt();
        for (point, expected_m) in [
            ([0.2, 0.2, -0.5], 0.5),
            ([1.0, 1.0, 1.0], 2.0 / root3),
            ([-3.0, -4.0, 0.5], 5.0),
            ([-1.0, -2.0, -2.0], 3.0),
            ([1.5, 0.0, 0.0], 0.5),
            ([0.1, 0.2, 0.3], -0.1),
            ([0.3, 0.3, 0.3], -0.1 / root3),
        ] {
            let distance_m = solid.signed_distance_m(&Point3::from(point));
            assert!((distance_m - expected_m).abs() < 1e-12, "{point:?}: {distance_m} is not {expected_m}");
        }
    }

    #[test]
    fn what_is_not_convex_or_not_solid_is_refused() {
        let (points, triangles) = corner();
        let inward = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!(matches!(
            ConvexPolyhedron::new(points.clone(), inward),
            Err(PolyhedronError::NotConvex { .. })
        ));
        let flat: Vec<_> = points.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
        assert!(ConvexPolyhedron::new(flat, triangles.clone()).is_err());
        let missing = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4]];
        assert_eq!(
            ConvexPolyhedron::new(points, missing),
            Err(PolyhedronError::NoSuchCorner { triangle: 3 })
        );
    }
}
