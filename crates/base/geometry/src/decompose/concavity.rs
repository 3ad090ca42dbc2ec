//! Concavity of the surface of a piece, and of the two halves of a candidate cut.
//!
//! The depth of a surface point is the distance along its outward normal to the hull of its piece: the thickness of
//! the air that a hull adds above it. The hull is approximated from outside by its supporting planes in 26 fixed
//! directions and along the piece's own normals, which costs a hundredth of building it. Cuts are only compared with
//! each other, so single precision suffices. Values that do not depend on the cut (reach of points in each direction,
//! ray origins on whole faces) are computed once per piece.

use std::collections::BTreeMap;

use glam::DVec3;
use wide::f32x8;

use super::piece::{Face, Piece, Side, clipped, crossing, side};
use super::plane::Plane;

/// A surface sample with its area and depth.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub point: DVec3,
    pub normal: DVec3,
    pub area_m2: f64,
    pub depth_m: f64,
}

/// Maximum number of normals of the piece among the directions.
const OWN_NORMALS: usize = 38;
/// Maximum number of surface samples for the evaluation of a cut.
const SAMPLES: usize = 240;
/// Smallest cosine between a ray and the normal of a plane through which it can leave.
const MIN_ALONG: f32 = 0.05;

/// Support directions for hulls of a piece and of its parts, as x, y, z in groups of eight; padding of the last group
/// is zero.
struct Directions(Vec<[f32x8; 3]>);

impl Directions {
    fn of(piece: &Piece) -> Self {
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
        let eight = |chunk: &[DVec3]| {
            let eight: [DVec3; 8] = std::array::from_fn(|k| chunk.get(k).copied().unwrap_or_default());
            [0, 1, 2].map(|axis| f32x8::from(eight.map(|d| d[axis] as f32)))
        };
        Self(all.chunks(8).map(eight).collect())
    }

    /// Support value of a point in each direction.
    fn reaches(&self, p: DVec3) -> impl Iterator<Item = f32x8> + '_ {
        let [px, py, pz] = p.as_vec3().to_array().map(f32x8::splat);
        self.0.iter().map(move |&[x, y, z]| x * px + y * py + z * pz)
    }

    /// A ray from a point along a unit normal: for each direction its start, and its length per height gained. For a
    /// plane through which the ray cannot leave, the start is infinitely far below it.
    fn ray(&self, point: DVec3, normal: DVec3) -> impl Iterator<Item = (f32x8, f32x8)> + '_ {
        self.reaches(point).zip(self.reaches(normal)).map(|(at, along)| {
            let leaves = along.simd_gt(f32x8::splat(MIN_ALONG));
            let never = f32x8::splat(f32::NEG_INFINITY);
            (leaves.select(at, never), leaves.select(f32x8::ONE / along, f32x8::ONE))
        })
    }
}

/// Rows of values in groups of eight directions, one row per point or face.
struct Table {
    eights: usize,
    values: Vec<f32x8>,
}

impl Table {
    fn row(&self, index: usize) -> &[f32x8] {
        &self.values[index * self.eights..][..self.eights]
    }
}

/// Support function of a point set in each direction.
struct Support {
    reach_m: Vec<f32x8>,
}

impl Support {
    fn new(directions: &Directions) -> Self {
        Self { reach_m: vec![f32x8::splat(f32::NEG_INFINITY); directions.0.len()] }
    }

    fn add(&mut self, reaches_m: impl Iterator<Item = f32x8>) {
        for (reach, here) in self.reach_m.iter_mut().zip(reaches_m) {
            *reach = reach.fast_max(here);
        }
    }

    /// Length of a ray until it leaves all supporting planes.
    fn depth_m(&self, ray: impl Iterator<Item = (f32x8, f32x8)>) -> f32 {
        let mut lowest = f32x8::splat(f32::INFINITY);
        for (&reach, (at, way_by_height)) in self.reach_m.iter().zip(ray) {
            lowest = lowest.fast_min((reach - at) * way_by_height);
        }
        let depth = lowest.to_array().into_iter().fold(f32::INFINITY, f32::min);
        if depth.is_finite() { depth.max(0.0) } else { 0.0 }
    }
}

/// Evaluates the cuts of a piece.
pub(super) struct CutEvaluator<'a> {
    piece: &'a Piece,
    directions: Directions,
    /// Support values of every point of the piece.
    reaches: Table,
    /// The surface of the piece, a sample each face.
    pub samples: Vec<Sample>,
    /// Concave samples shallower than this are ignored, meters.
    shallow_m: f64,
    tolerance_m: f64,
    /// For each face, its index among the sampled faces.
    sampled: Vec<Option<u32>>,
    /// Number of faces per sampled face.
    stride: usize,
    /// Rays from the centers of the sampled faces.
    starts: Table,
    ways_by_height: Table,
    areas_m2: Vec<f32>,
}

impl<'a> CutEvaluator<'a> {
    pub(super) fn of(piece: &'a Piece, tolerance_m: f64, shallow_m: f64) -> Self {
        let directions = Directions::of(piece);
        let eights = directions.0.len();
        let values = piece.points.iter().flat_map(|&p| directions.reaches(p)).collect();
        let reaches = Table { eights, values };
        let mut support = Support::new(&directions);
        (0..piece.points.len()).for_each(|point| support.add(reaches.row(point).iter().copied()));
        piece.inner().iter().for_each(|&p| support.add(directions.reaches(p)));
        let sample = |face: Face<'_>| {
            let point = center(&piece.points, face.corners);
            Sample {
                point,
                normal: face.normal,
                area_m2: area_m2(&piece.points, face.corners),
                depth_m: f64::from(support.depth_m(directions.ray(point, face.normal))),
            }
        };
        let samples: Vec<Sample> = piece.faces().map(sample).collect();
        let empty = || Table { eights, values: Vec::new() };
        let mut evaluator = Self {
            piece,
            reaches,
            shallow_m,
            tolerance_m,
            sampled: vec![None; samples.len()],
            stride: 1,
            starts: empty(),
            ways_by_height: empty(),
            areas_m2: Vec::new(),
            directions,
            samples,
        };
        evaluator.choose();
        evaluator
    }

    /// The concave samples.
    pub(super) fn concave(&self) -> impl Iterator<Item = &Sample> + '_ {
        self.samples.iter().filter(|s| s.depth_m > self.shallow_m)
    }

    /// Concavity of the piece.
    pub(super) fn concavity(&self) -> f64 {
        self.concave().map(|s| weight(s.area_m2, s.depth_m, self.tolerance_m)).sum()
    }

    /// Chooses the sampled faces.
    fn choose(&mut self) {
        self.stride = self.concave().count().div_ceil(SAMPLES).max(1);
        let mut met = 0;
        for (face, sample) in self.samples.iter().enumerate().filter(|(_, s)| s.depth_m > self.shallow_m) {
            met += 1;
            if met % self.stride != 0 {
                continue;
            }
            self.sampled[face] = Some(self.areas_m2.len() as u32);
            self.areas_m2.push(sample.area_m2 as f32);
            for (at, way_by_height) in self.directions.ray(sample.point, sample.normal) {
                self.starts.values.push(at);
                self.ways_by_height.values.push(way_by_height);
            }
        }
    }

    /// Concavity of the two parts into which the plane cuts the piece: the sum of area times the logarithm of depth
    /// over tolerance, so that resolving a concave region counts far more than making it shallower. `None` unless
    /// there is surface on both sides.
    pub(super) fn concavity_after_cut(&self, plane: &Plane) -> Option<f64> {
        let heights = self.piece.heights_m(plane);
        let mut halves = [-1.0, 1.0].map(|sign| Half::new(sign, self, &heights));
        for (face, &sampled) in self.piece.faces().zip(&self.sampled) {
            match side(&face, &heights, plane) {
                Side::Below => halves[0].add_whole(&face, sampled),
                Side::Above => halves[1].add_whole(&face, sampled),
                Side::Both => halves.iter_mut().for_each(|half| half.add_part(&face, sampled.is_some())),
            }
        }
        let both = halves.iter().all(|half| half.faces > 0);
        both.then(|| self.stride as f64 * halves.iter().map(Half::concavity).sum::<f64>())
    }
}

/// Weight of a surface sample in the concavity.
pub(super) fn weight(area_m2: f64, depth_m: f64, tolerance_m: f64) -> f64 {
    area_m2 * (depth_m / tolerance_m).ln_1p()
}

/// The part of a piece on one side of a plane.
struct Half<'a> {
    sign: f64,
    evaluator: &'a CutEvaluator<'a>,
    heights_m: &'a [f64],
    support: Support,
    seen: Vec<bool>,
    faces: usize,
    /// Sampled faces that are entirely on this side.
    whole: Vec<u32>,
    /// Parts of cut faces on this side: center, normal, area.
    bits: Vec<(DVec3, DVec3, f32)>,
    corners: Vec<DVec3>,
}

impl<'a> Half<'a> {
    fn new(sign: f64, evaluator: &'a CutEvaluator<'a>, heights_m: &'a [f64]) -> Self {
        Self {
            sign,
            evaluator,
            heights_m,
            support: Support::new(&evaluator.directions),
            seen: vec![false; evaluator.piece.points.len()],
            faces: 0,
            whole: Vec::new(),
            bits: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// Adds a face that is entirely on this side.
    fn add_whole(&mut self, face: &Face, sampled: Option<u32>) {
        self.faces += 1;
        face.corners.iter().for_each(|&corner| self.reach_to(corner));
        self.whole.extend(sampled);
    }

    /// Adds the part of a face on this side.
    fn add_part(&mut self, face: &Face, sampled: bool) {
        self.faces += 1;
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        clipped(face, self.heights_m, self.sign, |a, b| {
            let p = crossing(&self.evaluator.piece.points, self.heights_m, a, b);
            corners.push(p);
            if a == b {
                self.reach_to(a);
            } else {
                self.support.add(self.evaluator.directions.reaches(p));
            }
        });
        self.corners = corners;
        if sampled && self.corners.len() > 2 {
            let center = self.corners.iter().sum::<DVec3>() / self.corners.len() as f64;
            self.bits.push((center, face.normal, area_of(&self.corners) as f32));
        }
    }

    fn reach_to(&mut self, corner: u32) {
        if !std::mem::replace(&mut self.seen[corner as usize], true) {
            self.support.add(self.evaluator.reaches.row(corner as usize).iter().copied());
        }
    }

    fn concavity(&self) -> f64 {
        let evaluator = self.evaluator;
        let whole = self.whole.iter().map(|&k| {
            let (at, way_by_height) =
                (evaluator.starts.row(k as usize), evaluator.ways_by_height.row(k as usize));
            let ray = at.iter().copied().zip(way_by_height.iter().copied());
            (evaluator.areas_m2[k as usize], self.support.depth_m(ray))
        });
        let cut = self.bits.iter().map(|&(p, normal, area_m2)| {
            (area_m2, self.support.depth_m(evaluator.directions.ray(p, normal)))
        });
        let all: Vec<(f32, f32)> = whole.chain(cut).collect();
        let by_tolerance = f32x8::splat(1.0 / evaluator.tolerance_m as f32);
        let mut sum = f32x8::ZERO;
        for eight in all.chunks(8) {
            let of = |part: fn(&(f32, f32)) -> f32| {
                f32x8::from(std::array::from_fn::<f32, 8, _>(|k| eight.get(k).map_or(0.0, part)))
            };
            sum += of(|bit| bit.0) * (f32x8::ONE + of(|bit| bit.1) * by_tolerance).ln();
        }
        sum.to_array().into_iter().map(f64::from).sum()
    }
}

/// Area of a planar polygon.
fn area_of(corners: &[DVec3]) -> f64 {
    let origin = corners[0];
    0.5 * corners.windows(2).map(|w| (w[0] - origin).cross(w[1] - origin)).sum::<DVec3>().length()
}

fn area_m2(points: &[DVec3], corners: &[u32]) -> f64 {
    let at = |k: usize| points[corners[k] as usize];
    0.5 * (2..corners.len()).map(|k| (at(k - 1) - at(0)).cross(at(k) - at(0))).sum::<DVec3>().length()
}

fn center(points: &[DVec3], corners: &[u32]) -> DVec3 {
    corners.iter().map(|&c| points[c as usize]).sum::<DVec3>() / corners.len() as f64
}
