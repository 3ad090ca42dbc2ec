//! Selection of cutting planes for a concave piece.
//!
//! Candidates are planes that continue large faces with air above them (the floor of a tray, a wall of a box: such cuts
//! give exact slabs), planes through the deepest point that contain its normal (across a bent bar, along the crease
//! between two bulges), and planes that halve the piece. The best candidate leaves the smallest concavity (see
//! `concavity`).

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use parry3d_f64::math::MatExt;

use super::concavity::{CutEvaluator, Sample, weight};
use super::piece::Piece;
use super::plane::Plane;

/// Maximum number of continued faces that are tried.
const FACE_PLANES: usize = 7;
/// Number of orientations that are tried of a plane that contains the normal at a notch.
const TURNS: usize = 4;
/// Concave samples shallower than this share of the tolerance are ignored.
const SHALLOW: f64 = 0.1;
/// Lower bound of the tolerance in weights, meters: differences between smaller depths count little.
const SHALLOWEST_M: f64 = 0.0003;
/// Penalty of the most unbalanced cut, share of the concavity, against slivers.
const LOPSIDED: f64 = 0.1;

/// Cutting planes, the best first, each with the share of the concavity that it leaves. Each has surface on both sides.
pub(super) fn ranked_cuts(piece: &Piece, worst_at: DVec3, tolerance_m: f64) -> Vec<(f64, Plane)> {
    let tolerance_m = tolerance_m.max(SHALLOWEST_M);
    let evaluator = CutEvaluator::of(piece, tolerance_m, SHALLOW * tolerance_m);
    let concave: Vec<Sample> = evaluator.concave().copied().collect();
    let before = evaluator.concavity();
    let (low, high) = bounds(&piece.points);
    let mut ranked: Vec<(f64, Plane)> = Vec::new();
    for plane in candidates(&evaluator.samples, &concave, worst_at, tolerance_m, low, high) {
        let Some(after) = evaluator.concavity_after_cut(&plane) else { continue };
        let along = plane.normal.abs();
        let center = plane.height_m(0.5 * (low + high)).abs() / (0.5 * (high - low)).dot(along).max(1e-9);
        ranked.push((after + LOPSIDED * before * center.min(1.0), plane));
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.into_iter().map(|(left, plane)| (left / before.max(1e-30), plane)).collect()
}

fn candidates(
    all: &[Sample],
    concave: &[Sample],
    worst_at: DVec3,
    tolerance_m: f64,
    low: DVec3,
    high: DVec3,
) -> Vec<Plane> {
    let mut planes = continued_faces(concave, tolerance_m, (high - low).max_element());
    let deepest = concave.iter().max_by(|a, b| a.depth_m.total_cmp(&b.depth_m));
    let nearest = concave
        .iter()
        .min_by(|a, b| a.point.distance_squared(worst_at).total_cmp(&b.point.distance_squared(worst_at)));
    for sample in deepest.into_iter().chain(nearest) {
        let side =
            if sample.normal.z.abs() > 0.99 { DVec3::X } else { DVec3::Z.cross(sample.normal).normalize() };
        let up = sample.normal.cross(side);
        planes.extend((0..TURNS).map(|k| {
            let angle = PI * k as f64 / TURNS as f64;
            Plane::through(sample.point, angle.cos() * side + angle.sin() * up)
        }));
    }
    let center = 0.5 * (low + high);
    planes.extend([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| Plane::through(center, axis)));
    planes.extend([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| Plane::through(worst_at, axis)));
    planes.extend(across_principal_axes(all));
    planes
}

/// Planes through the center of the surface, across each of its principal axes.
fn across_principal_axes(all: &[Sample]) -> Vec<Plane> {
    let area: f64 = all.iter().map(|s| s.area_m2).sum();
    let center = all.iter().map(|s| s.area_m2 * s.point).sum::<DVec3>() / area.max(1e-30);
    let outer = |d: DVec3| DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    let spread = all.iter().map(|s| outer(s.point - center) * s.area_m2).fold(DMat3::ZERO, |a, b| a + b);
    let axes = spread.symmetric_eigen().eigenvectors;
    [axes.x_axis, axes.y_axis, axes.z_axis]
        .into_iter()
        .filter_map(DVec3::try_normalize)
        .map(|axis| Plane::through(center, axis))
        .collect()
}

/// Planes of the faces with the most concavity in them.
fn continued_faces(concave: &[Sample], tolerance_m: f64, size_m: f64) -> Vec<Plane> {
    let cell_m = (0.02 * size_m).max(1e-4);
    let mut weights: BTreeMap<[i64; 4], (f64, Plane)> = BTreeMap::new();
    for sample in concave {
        let plane = Plane::through(sample.point, sample.normal);
        let normal = (sample.normal * 12.0).round();
        let offset = (plane.offset_m / cell_m).round();
        let key = [normal.x, normal.y, normal.z, offset].map(|x| x as i64);
        weights.entry(key).or_insert((0.0, plane)).0 += weight(sample.area_m2, sample.depth_m, tolerance_m);
    }
    let mut planes: Vec<(f64, Plane)> = weights.into_values().collect();
    planes.sort_by(|a, b| b.0.total_cmp(&a.0));
    planes.into_iter().take(FACE_PLANES).map(|(_, plane)| plane).collect()
}

fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
}
