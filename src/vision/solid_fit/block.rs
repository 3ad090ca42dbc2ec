//! Boxes.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use super::{Seen, SolidFit, SolidKind, projected_hull};
use crate::geometry::Camera;
use crate::geometry::sobel::sobel;
use crate::vision::minimize::climb;
use crate::vision::pixels::Pixels;
use crate::vision::silhouette::Silhouette;

/// Strength of the lightness edges of a picture.
pub(in crate::vision) struct InnerEdges {
    width: usize,
    height: usize,
    strength: Vec<f32>,
}

impl InnerEdges {
    pub fn new(pixels: &Pixels) -> Self {
        let lightness: Vec<f32> = pixels.lab.iter().map(|lab| lab[0]).collect();
        let (dx, dy) = sobel(&lightness, pixels.width, pixels.height);
        // Edges of a fifth of full contrast count fully.
        let strength = dx.iter().zip(&dy).map(|(x, y)| (x.hypot(*y) / 10.0).min(1.0)).collect();
        Self { width: pixels.width, height: pixels.height, strength }
    }

    /// Mean strength along a segment, the strongest within a pixel of each point.
    fn along(&self, a: DVec2, b: DVec2) -> f64 {
        let steps = ((b - a).length() / 2.0).ceil().clamp(2.0, 200.0) as usize;
        let normal = (b - a).perp().normalize_or_zero();
        let sum: f32 = (0..steps)
            .map(|k| {
                let p = a + (b - a) * ((k as f64 + 0.5) / steps as f64);
                [-1.0, 0.0, 1.0].map(|d| self.at(p + d * normal)).into_iter().fold(0.0, f32::max)
            })
            .sum();
        f64::from(sum) / steps as f64
    }

    fn at(&self, p: DVec2) -> f32 {
        let inside = p.x >= 0.0 && p.y >= 0.0 && p.x < self.width as f64 && p.y < self.height as f64;
        if inside { self.strength[p.y as usize * self.width + p.x as usize] } else { 0.0 }
    }
}

/// Parameters of a box: center x, y, width, depth, height, yaw.
type Parameters = [f64; 6];

pub(super) fn fit(
    seen: &Seen,
    silhouette: &Silhouette,
    camera: &Camera,
    edges: Option<&InnerEdges>,
) -> Option<SolidFit> {
    let across = ((seen.high_px.x - seen.low_px.x) * seen.unit_per_px).max(1e-4);
    let view_yaw = (-seen.away.x).atan2(seen.away.y);
    let score = |q: &Parameters| {
        if q[2] <= 2e-3 * across || q[3] <= 2e-3 * across || q[4] <= 5e-4 {
            return -1.0;
        }
        silhouette.overlap(&[projected_hull(camera, corners(q).into_iter())])
    };
    let mut best: Option<(Parameters, f64)> = None;
    for turn in [0.0, 0.45, -0.45] {
        for (slim, flatness) in [(0.5, 1.0), (0.8, 0.1)] {
            let (width, depth) = (0.85 * across, slim * across);
            let center = seen.contact + 0.5 * depth * seen.away;
            let height =
                (flatness * seen.height_over(seen.contact + depth * seen.away, camera)).max(0.03 * across);
            let start = [center.x, center.y, width, depth, height, view_yaw + turn];
            let step = 0.25 * across;
            let found = climb(start, [step, step, step, step, 0.25 * height.max(across), 0.3], 5, score);
            if best.is_none_or(|b| found.1 > b.1) {
                best = Some(found);
            }
        }
    }
    let (mut found, overlap) = best?;
    if let Some(edges) = edges {
        found = settled_by_edges(found, overlap, across, camera, edges, score);
    }
    let overlap = score(&found);
    let [x, y, width, depth, height, yaw] = found;
    // The same box with its width across the view as nearly as its sides allow.
    let quarter = ((yaw - view_yaw) / FRAC_PI_2).round();
    let size = if quarter.rem_euclid(2.0) > 0.5 { (depth, width) } else { (width, depth) };
    Some(SolidFit {
        kind: SolidKind::Block,
        center: DVec2::new(x, y),
        yaw_rad: yaw - quarter * FRAC_PI_2,
        size: DVec3::new(size.0, size.1, height),
        overlap,
    })
}

/// Depth against height: among boxes with nearly the same outline the one whose inner edges show.
fn settled_by_edges(
    found: Parameters,
    overlap: f64,
    across: f64,
    camera: &Camera,
    edges: &InnerEdges,
    score: impl Fn(&Parameters) -> f64,
) -> Parameters {
    let support = |q: &Parameters| {
        let c = corners(q);
        let eye = camera.world_from_camera.translation_m;
        // Upper edges of the walls that face the camera, and the upright edge between two such walls.
        let faces: Vec<bool> = (0..4)
            .map(|k| {
                let (a, b) = (c[k], c[(k + 1) % 4]);
                let outward = -(b - a).truncate().perp();
                outward.dot((eye - a).truncate()) > 0.0
            })
            .collect();
        let mut total = (0.0, 0.0);
        let mut add = |a: DVec3, b: DVec3| {
            if let (Some((a, _)), Some((b, _))) = (camera.project(a), camera.project(b)) {
                let length = (b - a).length();
                total = (total.0 + length * edges.along(a, b), total.1 + length);
            }
        };
        for k in 0..4 {
            if faces[k] {
                add(c[k + 4], c[(k + 1) % 4 + 4]);
                if faces[(k + 1) % 4] {
                    add(c[(k + 1) % 4], c[(k + 1) % 4 + 4]);
                }
            }
        }
        if total.1 > 0.0 { total.0 / total.1 } else { 0.0 }
    };
    let tallest = found[4] + found[3].max(found[2]);
    let mut best = (found, overlap + 0.15 * support(&found));
    for k in 0..9 {
        let height = tallest * (0.01 + 0.99 * (f64::from(k) / 8.0).powi(2));
        let mut start = found;
        start[4] = height;
        let fixed = |q: &[f64; 5]| score(&[q[0], q[1], q[2], q[3], height, q[4]]);
        let step = 0.2 * across;
        let begin = [start[0], start[1], start[2], start[3], start[5]];
        let (q, there) = climb(begin, [step, step, step, step, 0.1], 4, fixed);
        let candidate = [q[0], q[1], q[2], q[3], height, q[4]];
        let value = there + 0.15 * support(&candidate);
        if there > overlap - 0.03 && value > best.1 {
            best = (candidate, value);
        }
    }
    best.0
}

/// Base corners counter-clockwise, then those above them.
fn corners(q: &Parameters) -> [DVec3; 8] {
    let turn = DVec2::from_angle(q[5]);
    std::array::from_fn(|k| {
        let (sx, sy) = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)][k % 4];
        let p = DVec2::new(q[0], q[1]) + turn.rotate(DVec2::new(sx * q[2], sy * q[3]));
        p.extend(if k < 4 { 0.0 } else { q[4] })
    })
}
