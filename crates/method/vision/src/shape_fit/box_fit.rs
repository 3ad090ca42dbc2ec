//! Box fit.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use super::{PosedPrimitive, PrimitiveKind, ShapePrior, SilhouetteMeasures, projected_hull};
use crate::pixels::Pixels;
use crate::silhouette::Silhouette;
use geometry::Camera;
use geometry::optimize::pattern_search;
use imaging::sobel::sobel;

/// Strength of the lightness edges of an image.
pub(crate) struct InnerEdges {
    width: usize,
    height: usize,
    strength: Vec<f32>,
}

impl InnerEdges {
    pub fn new(pixels: &Pixels) -> Self {
        let lightness: Vec<f32> = pixels.lab.iter().map(|lab| lab[0]).collect();
        let (dx, dy) = sobel(&lightness, pixels.width, pixels.height);
        // An edge of a fifth of full contrast has full strength.
        let strength = dx.iter().zip(&dy).map(|(x, y)| (x.hypot(*y) / 10.0).min(1.0)).collect();
        Self { width: pixels.width, height: pixels.height, strength }
    }

    /// Mean strength along a segment; each point takes the maximum within a pixel.
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
    seen: &SilhouetteMeasures,
    silhouette: &Silhouette,
    camera: &Camera,
    edges: Option<&InnerEdges>,
    expected: Option<&ShapePrior>,
) -> Option<PosedPrimitive> {
    let across = ((seen.high_px.x - seen.low_px.x) * seen.unit_per_px).max(1e-4);
    let view_yaw = (-seen.away.x).atan2(seen.away.y);
    // As in the revolution fit, each parameter moves one side of the outline. A measured height is one of them.
    let is_measured = expected.is_some_and(ShapePrior::has_measured_height);
    let half_beyond = |width: f64, depth: f64, yaw: f64| {
        let turn = yaw - view_yaw;
        0.5 * (width * turn.sin()).abs() + 0.5 * (depth * turn.cos()).abs()
    };
    let boxed = |q: &[f64; 6]| {
        let [side, beyond, width, depth, rise, yaw] = *q;
        let half = half_beyond(width, depth, yaw);
        let center = seen.place(side, beyond + half);
        let height = if is_measured { rise } else { rise - (beyond + 2.0 * half) * seen.steepness };
        [center.x, center.y, width, depth, height, yaw]
    };
    let score = |q: &Parameters| {
        if q[2] <= 0.01 * across || q[3] <= 0.01 * across || q[4] <= 0.01 * across {
            return -1.0;
        }
        let doubt = expected.map_or(0.0, |e| e.disagreement(DVec2::new(q[0], q[1]), q[4], camera));
        silhouette.overlap(&[projected_hull(camera, corners(q).into_iter())]) - doubt
    };
    let mut best: Option<([f64; 6], f64)> = None;
    let deepest = 0.97 * seen.rise / seen.steepness;
    let base = expected.and_then(|e| e.base(camera)).map(|base| seen.beside_contact(base));
    // Extent of the box beyond the contact: given by the prior, or so that its top face reaches these shares of
    // the outline's height.
    let reaches = match base {
        Some(base) => vec![2.0 * base.y],
        None => vec![0.35 * deepest, 0.9 * deepest],
    };
    for turn in [0.0, 0.45, -0.45] {
        for &reach in &reaches {
            let width = 0.85 * across;
            let spread = (width * f64::sin(turn)).abs();
            let depth = ((reach - spread) / f64::cos(turn)).max(0.05 * across);
            let yaw = view_yaw + turn;
            let high = expected.map_or(0.02 * across, |expected| expected.height);
            let up = 2.0 * half_beyond(width, depth, yaw) * seen.steepness + high;
            let rise = match expected {
                Some(expected) if is_measured => expected.height,
                Some(_) => up,
                None => seen.rise.max(up),
            };
            let side = 0.5 * (seen.low_px.x + seen.high_px.x);
            let side = base.map_or((side - seen.contact_px_x) * seen.unit_per_px, |base| base.x);
            let step = 0.12 * across;
            let start = [side, 0.0, width, depth, rise, yaw];
            let found = pattern_search(start, [step, step, step, step, step, 0.2], 5, |q| score(&boxed(q)));
            if best.is_none_or(|b| found.1 > b.1) {
                best = Some(found);
            }
        }
    }
    let (parameters, overlap) = best?;
    let mut found = boxed(&parameters);
    if let Some(edges) = edges {
        let [side, beyond, width, _, rise, yaw] = parameters;
        let mut value = overlap + 0.15 * support(&found, camera, edges);
        for k in 0..8 {
            // The same outline with the upper front edge at another height.
            let share = 0.08 + 0.9 * f64::from(k) / 7.0;
            let turn = yaw - view_yaw;
            let other = (share * deepest - (width * turn.sin()).abs()) / turn.cos().abs().max(0.2);
            if other <= 0.02 * across {
                continue;
            }
            let free = |q: &[f64; 4]| score(&boxed(&[q[0], q[1], q[2], other, q[3], yaw]));
            let step = 0.06 * across;
            let (q, there) = pattern_search([side, beyond, width, rise], [step; 4], 3, free);
            let candidate = boxed(&[q[0], q[1], q[2], other, q[3], yaw]);
            let merit = there + 0.15 * support(&candidate, camera, edges);
            if there > overlap - 0.03 && merit > value {
                (found, value) = (candidate, merit);
            }
        }
    }
    let overlap = silhouette.overlap(&[projected_hull(camera, corners(&found).into_iter())]);
    let [x, y, width, depth, height, yaw] = found;
    // The same box, with its width as nearly across the view as possible.
    let quarter = ((yaw - view_yaw) / FRAC_PI_2).round();
    let size = if quarter.rem_euclid(2.0) > 0.5 { (depth, width) } else { (width, depth) };
    Some(PosedPrimitive {
        kind: PrimitiveKind::Block,
        center: DVec2::new(x, y),
        yaw_rad: yaw - quarter * FRAC_PI_2,
        size: DVec3::new(size.0, size.1, height),
        overlap,
    })
}

/// Strength of the image edges along the visible edges of the box.
fn support(q: &Parameters, camera: &Camera, edges: &InnerEdges) -> f64 {
    let c = corners(q);
    let eye = camera.world_from_camera.translation_m;
    // Upper edges of the faces toward the camera, and the upright edge between two such faces.
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
