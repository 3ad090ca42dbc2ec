//! How concave the surface of a piece is, and how concave two halves of it would be.
//!
//! The depth of a surface point is the distance along its outward normal to the hull of its piece, that is,
//! how much air a hull would add above it. The hull is approximated from outside by its supporting
//! planes in the directions that matter for the piece (26 fixed ones and the piece's own normals), which
//! costs a hundredth of building it.

use std::collections::BTreeMap;

use glam::DVec3;
use wide::f64x4;

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

/// Directions in which hulls of a piece and of parts of it are supported, as x, y, z of four at a time; those
/// that fill up the last four are zero.
pub(super) struct Directions(Vec<[f64x4; 3]>);

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
        let four = |chunk: &[DVec3]| {
            let four = [0, 1, 2, 3].map(|k| chunk.get(k).copied().unwrap_or_default());
            [0, 1, 2].map(|axis| f64x4::from(four.map(|d| d[axis])))
        };
        Self(all.chunks(4).map(four).collect())
    }

    /// Reach of a point in each direction.
    fn reaches(&self, p: DVec3) -> impl Iterator<Item = f64x4> + '_ {
        let [px, py, pz] = p.to_array().map(f64x4::splat);
        self.0.iter().map(move |&[x, y, z]| x * px + y * py + z * pz)
    }
}

/// How far every point of a piece reaches in every direction, computed once for all cuts of the piece.
pub(super) struct Reaches {
    /// Fours of directions.
    fours: usize,
    /// Those of the first point, those of the second, and so on.
    reach_m: Vec<f64x4>,
}

impl Reaches {
    pub(super) fn of(piece: &Piece, directions: &Directions) -> Self {
        let reach_m = piece.points.iter().flat_map(|&p| directions.reaches(p)).collect();
        Self { fours: directions.0.len(), reach_m }
    }

    fn of_point(&self, point: u32) -> &[f64x4] {
        &self.reach_m[point as usize * self.fours..][..self.fours]
    }
}

/// Farthest reach of a set of points in each direction.
struct Support {
    reach_m: Vec<f64x4>,
}

impl Support {
    fn new(directions: &Directions) -> Self {
        Self { reach_m: vec![f64x4::splat(f64::NEG_INFINITY); directions.0.len()] }
    }

    fn add(&mut self, reaches_m: impl Iterator<Item = f64x4>) {
        for (reach, here) in self.reach_m.iter_mut().zip(reaches_m) {
            *reach = reach.fast_max(here);
        }
    }

    /// Distance from the point along the unit normal until it leaves all supporting planes.
    fn depth_m(&self, directions: &Directions, point: DVec3, normal: DVec3) -> f64 {
        let mut depth = f64::INFINITY;
        let fours = directions.reaches(normal).zip(directions.reaches(point));
        for (&reach, (along, at)) in self.reach_m.iter().zip(fours) {
            let below = reach - at;
            // Most directions are not the least: they are told without a division.
            let less = below.simd_lt(f64x4::splat(depth * (1.0 + 1e-12)) * along);
            let candidates = (less & along.simd_gt(f64x4::splat(0.05))).to_bitmask();
            if candidates != 0 {
                let (below, along) = (below.to_array(), along.to_array());
                for k in (0..4).filter(|k| (candidates >> k) & 1 == 1) {
                    depth = depth.min(below[k] / along[k]);
                }
            }
        }
        if depth.is_finite() { depth.max(0.0) } else { 0.0 }
    }
}

/// The surface of a piece, a sample each face.
pub(super) fn samples(piece: &Piece, directions: &Directions, reaches: &Reaches) -> Vec<Sample> {
    let mut support = Support::new(directions);
    (0..piece.points.len() as u32).for_each(|point| support.add(reaches.of_point(point).iter().copied()));
    piece.inner().iter().for_each(|&p| support.add(directions.reaches(p)));
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
    reaches: &Reaches,
    plane: &Plane,
    tolerance_m: f64,
    is_concave: &[bool],
) -> Option<f64> {
    let heights = piece.heights_m(plane);
    let stride = is_concave.iter().filter(|&&c| c).count().div_ceil(SAMPLES).max(1);
    let mut halves = [-1.0, 1.0].map(|sign| Half::new(sign, piece, &heights, directions, reaches));
    let mut met = 0;
    for (face, &concave) in piece.faces().zip(is_concave) {
        met += usize::from(concave);
        let sampled = concave && met % stride == 0;
        match side(&face, &heights, plane) {
            Side::Below => halves[0].add_whole(&face, sampled),
            Side::Above => halves[1].add_whole(&face, sampled),
            Side::Both => halves.iter_mut().for_each(|half| half.add_part(&face, sampled)),
        }
    }
    let both = halves.iter().all(|half| half.faces > 0);
    both.then(|| stride as f64 * halves.iter().map(|h| h.concavity(tolerance_m)).sum::<f64>())
}

/// Weight of a bit of surface in a concavity.
pub(super) fn weight(area_m2: f64, depth_m: f64, tolerance_m: f64) -> f64 {
    area_m2 * (depth_m / tolerance_m).ln_1p()
}

/// What is on one side of a plane.
struct Half<'a> {
    sign: f64,
    piece: &'a Piece,
    heights_m: &'a [f64],
    directions: &'a Directions,
    reaches: &'a Reaches,
    support: Support,
    seen: Vec<bool>,
    faces: usize,
    bits: Vec<(DVec3, DVec3, f64)>,
    corners: Vec<DVec3>,
}

impl<'a> Half<'a> {
    fn new(
        sign: f64,
        piece: &'a Piece,
        heights_m: &'a [f64],
        directions: &'a Directions,
        reaches: &'a Reaches,
    ) -> Self {
        Self {
            sign,
            piece,
            heights_m,
            directions,
            reaches,
            support: Support::new(directions),
            seen: vec![false; piece.points.len()],
            faces: 0,
            bits: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// Adds a face all of which is on this side.
    fn add_whole(&mut self, face: &Face, sampled: bool) {
        self.faces += 1;
        face.corners.iter().for_each(|&corner| self.reach_to(corner));
        if sampled {
            self.corners.clear();
            self.corners.extend(face.corners.iter().map(|&c| self.piece.points[c as usize]));
            self.sample(face.normal);
        }
    }

    /// Adds what of a face is on this side.
    fn add_part(&mut self, face: &Face, sampled: bool) {
        self.faces += 1;
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        clipped(face, self.heights_m, self.sign, |a, b| {
            let p = crossing(&self.piece.points, self.heights_m, a, b);
            corners.push(p);
            if a == b {
                self.reach_to(a);
            } else {
                self.support.add(self.directions.reaches(p));
            }
        });
        self.corners = corners;
        if sampled {
            self.sample(face.normal);
        }
    }

    fn reach_to(&mut self, corner: u32) {
        if !std::mem::replace(&mut self.seen[corner as usize], true) {
            self.support.add(self.reaches.of_point(corner).iter().copied());
        }
    }

    /// A sample of the polygon of `corners`.
    fn sample(&mut self, normal: DVec3) {
        if self.corners.len() > 2 {
            let middle = self.corners.iter().sum::<DVec3>() / self.corners.len() as f64;
            self.bits.push((middle, normal, area_of(&self.corners)));
        }
    }

    fn concavity(&self, tolerance_m: f64) -> f64 {
        let depth_m = |p, normal| self.support.depth_m(self.directions, p, normal);
        self.bits.iter().map(|&(p, normal, area)| weight(area, depth_m(p, normal), tolerance_m)).sum()
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
