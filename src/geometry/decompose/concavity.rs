//! How concave the surface of a piece is, and how concave two halves of it would be.
//!
//! The depth of a surface point is the distance along its outward normal to the hull of its piece, that is,
//! how much air a hull would add above it. The hull is approximated from outside by its supporting
//! planes in the directions that matter for the piece (26 fixed ones and the piece's own normals), which
//! costs a hundredth of building it.

use std::collections::BTreeMap;

use glam::DVec3;

use super::piece::{Face, Piece, Side, clipped, crossing, side};
use super::plane::Plane;

/// A bit of surface and how deep it lies.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub point: DVec3,
    pub normal: DVec3,
    pub area_m2: f64,
    pub depth_m: f64,
}

/// Directions in which hulls of a piece and of parts of it are supported.
pub(super) struct Directions {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

/// Most normals of the piece among the directions.
const OWN_NORMALS: usize = 38;
/// Most bits of surface a cut is judged by.
const SAMPLES: usize = 240;

impl Directions {
    pub(super) fn of(piece: &Piece) -> Self {
        let mut weight: BTreeMap<[i32; 3], (f64, DVec3)> = BTreeMap::new();
        for face in piece.faces() {
            let area = area_m2(&piece.points, face.corners);
            let cell = (face.normal * 5.0).round().as_ivec3().to_array();
            let entry = weight.entry(cell).or_insert((0.0, DVec3::ZERO));
            entry.0 += area;
            entry.1 += area * face.normal;
        }
        let mut own: Vec<(f64, DVec3)> = weight.into_values().collect();
        own.sort_by(|a, b| b.0.total_cmp(&a.0));
        let fixed = (0..27)
            .map(|k| DVec3::new(f64::from(k % 3) - 1.0, f64::from(k / 3 % 3) - 1.0, f64::from(k / 9) - 1.0));
        let cell = piece.cell().iter().map(|face| face.normal);
        let own = own.into_iter().take(OWN_NORMALS).map(|(_, normal)| normal);
        let all: Vec<DVec3> = fixed.chain(cell).chain(own).filter_map(DVec3::try_normalize).collect();
        let axis = |k: usize| all.iter().map(|d| d[k]).collect();
        Self { x: axis(0), y: axis(1), z: axis(2) }
    }
}

/// Farthest reach of a set of points in each direction.
struct Support {
    reach_m: Vec<f64>,
}

impl Support {
    fn new(directions: &Directions) -> Self {
        Self { reach_m: vec![f64::NEG_INFINITY; directions.x.len()] }
    }

    fn add(&mut self, directions: &Directions, p: DVec3) {
        let axes = directions.x.iter().zip(&directions.y).zip(&directions.z);
        for (reach, ((x, y), z)) in self.reach_m.iter_mut().zip(axes) {
            *reach = reach.max(x * p.x + y * p.y + z * p.z);
        }
    }

    /// Distance from the point along the unit normal until it leaves all supporting planes.
    fn depth_m(&self, directions: &Directions, point: DVec3, normal: DVec3) -> f64 {
        let axes = directions.x.iter().zip(&directions.y).zip(&directions.z);
        let mut depth = f64::INFINITY;
        for (reach, ((x, y), z)) in self.reach_m.iter().zip(axes) {
            let along = x * normal.x + y * normal.y + z * normal.z;
            if along > 0.05 {
                depth = depth.min((reach - (x * point.x + y * point.y + z * point.z)) / along);
            }
        }
        if depth.is_finite() { depth.max(0.0) } else { 0.0 }
    }
}

/// The surface of a piece, a sample each face.
pub(super) fn samples(piece: &Piece, directions: &Directions) -> Vec<Sample> {
    let mut support = Support::new(directions);
    piece.spanning_points().into_iter().for_each(|p| support.add(directions, p));
    piece
        .faces()
        .map(|face| {
            let area_m2 = area_m2(&piece.points, face.corners);
            let point = middle(&piece.points, face.corners);
            let depth_m = support.depth_m(directions, point, face.normal);
            Sample { point, normal: face.normal, area_m2, depth_m }
        })
        .collect()
}

/// Concavity of the two parts the plane would make of the piece: area times the logarithm of depth over
/// tolerance, summed, so that resolving a bit of surface counts far more than making it shallower. `None`
/// unless there is surface on both sides. `is_concave` says which faces of the piece are.
pub(super) fn concavity_after_cut(
    piece: &Piece,
    directions: &Directions,
    plane: &Plane,
    tolerance_m: f64,
    is_concave: &[bool],
) -> Option<f64> {
    let heights = piece.heights_m(plane);
    let stride = is_concave.iter().filter(|&&c| c).count().div_ceil(SAMPLES).max(1);
    let mut halves = [Half::new(-1.0, directions, &piece.points), Half::new(1.0, directions, &piece.points)];
    let mut met = 0;
    for (face, &concave) in piece.faces().zip(is_concave) {
        met += usize::from(concave);
        let sampled = concave && met % stride == 0;
        match side(&face, &heights, plane) {
            Side::Below => halves[0].add(piece, &face, &heights, directions, sampled),
            Side::Above => halves[1].add(piece, &face, &heights, directions, sampled),
            Side::Both => {
                halves.iter_mut().for_each(|half| half.add(piece, &face, &heights, directions, sampled));
            }
        }
    }
    let both = halves.iter().all(|half| half.faces > 0);
    both.then(|| stride as f64 * halves.iter().map(|h| h.concavity(directions, tolerance_m)).sum::<f64>())
}

/// Weight of a bit of surface in a concavity.
pub(super) fn weight(area_m2: f64, depth_m: f64, tolerance_m: f64) -> f64 {
    area_m2 * (depth_m / tolerance_m).ln_1p()
}

/// What is on one side of a plane.
struct Half {
    sign: f64,
    support: Support,
    seen: Vec<bool>,
    faces: usize,
    bits: Vec<(DVec3, DVec3, f64)>,
    corners: Vec<DVec3>,
}

impl Half {
    fn new(sign: f64, directions: &Directions, points: &[DVec3]) -> Self {
        let (faces, bits, corners) = (0, Vec::new(), Vec::new());
        Self {
            sign,
            support: Support::new(directions),
            seen: vec![false; points.len()],
            faces,
            bits,
            corners,
        }
    }

    fn add(&mut self, piece: &Piece, face: &Face, heights_m: &[f64], directions: &Directions, sampled: bool) {
        self.faces += 1;
        self.corners.clear();
        clipped(face, heights_m, self.sign, |a, b| {
            let p = crossing(&piece.points, heights_m, a, b);
            self.corners.push(p);
            if a != b || !std::mem::replace(&mut self.seen[a as usize], true) {
                self.support.add(directions, p);
            }
        });
        if sampled && self.corners.len() > 2 {
            let middle = self.corners.iter().sum::<DVec3>() / self.corners.len() as f64;
            self.bits.push((middle, face.normal, area_of(&self.corners)));
        }
    }

    fn concavity(&self, directions: &Directions, tolerance_m: f64) -> f64 {
        self.bits
            .iter()
            .map(|&(p, normal, area)| weight(area, self.support.depth_m(directions, p, normal), tolerance_m))
            .sum()
    }
}

/// Area of a plane polygon.
fn area_of(corners: &[DVec3]) -> f64 {
    let origin = corners[0];
    0.5 * corners.windows(2).map(|w| (w[0] - origin).cross(w[1] - origin)).sum::<DVec3>().length()
}

fn area_m2(points: &[DVec3], corners: &[u32]) -> f64 {
    let at = |k: usize| points[corners[k] as usize];
    0.5 * (2..corners.len()).map(|k| (at(k - 1) - at(0)).cross(at(k) - at(0))).sum::<DVec3>().length()
}

fn middle(points: &[DVec3], corners: &[u32]) -> DVec3 {
    corners.iter().map(|&c| points[c as usize]).sum::<DVec3>() / corners.len() as f64
}
