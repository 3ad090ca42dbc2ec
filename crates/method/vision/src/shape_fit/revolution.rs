//! Revolution fit: a frustum first, then a profile of rings.

use std::f64::consts::TAU;

use glam::DVec2;

use super::{PosedPrimitive, PrimitiveKind, ShapePrior, SilhouetteMeasures, projected_hull};
use crate::silhouette::Silhouette;
use geometry::Camera;
use geometry::optimize::pattern_search;

/// Corners of a projected ring.
const AROUND: u32 = 20;
/// Rings of the profile.
const RINGS: usize = 12;

pub(super) fn fit(
    seen: &SilhouetteMeasures,
    silhouette: &Silhouette,
    camera: &Camera,
    expected: Option<&ShapePrior>,
) -> Option<PosedPrimitive> {
    let radius = (0.5 * (seen.high_px.x - seen.low_px.x) * seen.unit_per_px).max(1e-4);
    // Parameters that each move one side of the outline: the front of the foot (across, beyond), the radii, and
    // the height at which the vertical over that front meets the top row, or the height where it is measured.
    let is_measured = expected.is_some_and(ShapePrior::has_measured_height);
    let frustum = |q: &[f64; 5]| {
        let [across, beyond, bottom, top, rise] = *q;
        let height = if is_measured { rise } else { rise - (beyond + bottom + top) * seen.steepness };
        (seen.place(across, beyond + bottom), DVec2::new(bottom, 0.0), DVec2::new(top, height))
    };
    let doubt = |center: DVec2, height: f64| expected.map_or(0.0, |e| e.disagreement(center, height, camera));
    let score = |q: &[f64; 5]| {
        let (center, bottom, top) = frustum(q);
        if bottom.x <= 0.02 * radius || top.x <= 0.02 * radius || top.y <= 0.03 * radius {
            return -1.0;
        }
        silhouette.overlap(&outlines(center, &[bottom, top], camera)) - doubt(center, top.y)
    };
    let base = expected.and_then(|e| e.base(camera)).map(|base| seen.beside_contact(base));
    let mut best: Option<([f64; 5], f64)> = None;
    for (foot, mouth) in [(1.0, 1.0), (0.55, 1.0), (1.0, 0.5)] {
        let (bottom, top) = (foot * radius, mouth * radius);
        let place = base.map_or(DVec2::ZERO, |base| base - DVec2::new(0.0, bottom));
        let rise = match expected {
            Some(expected) if is_measured => expected.height,
            Some(expected) => expected.height + (place.y + bottom + top) * seen.steepness,
            None => seen.rise.max((bottom + top) * seen.steepness + 0.06 * radius),
        };
        let step = 0.15 * radius;
        let found = pattern_search([place.x, place.y, bottom, top, rise], [step; 5], 6, score);
        if best.is_none_or(|b| found.1 > b.1) {
            best = Some(found);
        }
    }
    let (parameters, _) = best?;
    let (first_center, foot, mouth) = frustum(&parameters);
    let frustum_overlap = silhouette.overlap(&outlines(first_center, &[foot, mouth], camera));
    let (bottom, top, frustum_height) = (foot.x, mouth.x, mouth.y);
    let (mut center, mut height) = (first_center, frustum_height);
    // The profile is refined only if the frustum leaves a gain and the outline is mirror-symmetric.
    let mut profile = vec![DVec2::new(bottom, 0.0), DVec2::new(top, frustum_height)];
    let mut overlap = frustum_overlap;
    if frustum_overlap < 0.93 && seen.mirror_symmetry > 0.6 {
        let start: [f64; RINGS] = std::array::from_fn(|k| {
            let t = k as f64 / (RINGS - 1) as f64;
            bottom + t * (top - bottom)
        });
        let rings = |radii: &[f64; RINGS], height: f64| -> Vec<DVec2> {
            let z = |k: usize| height * k as f64 / (RINGS - 1) as f64;
            radii.iter().enumerate().map(|(k, r)| DVec2::new(*r, z(k))).collect()
        };
        let mut radii = start;
        for _ in 0..2 {
            let body = |radii: &[f64; RINGS]| {
                if radii.iter().any(|r| *r < 0.02 * radius) {
                    return -1.0;
                }
                // Rough profiles are unlikely.
                let bends: f64 = radii.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).sum();
                silhouette.overlap(&outlines(center, &rings(radii, height), camera)) - 0.01 * bends / radius
            };
            radii = pattern_search(radii, [0.25 * radius; RINGS], 4, body).0;
            let placed = |q: &[f64; 3]| {
                if q[2] <= 1e-4 {
                    return -1.0;
                }
                let at = DVec2::new(q[0], q[1]);
                silhouette.overlap(&outlines(at, &rings(&radii, q[2]), camera)) - doubt(at, q[2])
            };
            let step = 0.1 * radius;
            let [x, y, taller] =
                pattern_search([center.x, center.y, height], [step, step, 0.1 * height], 5, placed).0;
            (center, height) = (DVec2::new(x, y), taller);
        }
        let found = rings(&radii, height);
        let gained = silhouette.overlap(&outlines(center, &found, camera));
        if gained > frustum_overlap + 0.02 {
            (profile, overlap) = (found, gained);
        } else {
            center = first_center;
        }
    }
    let widest = profile.iter().map(|p| p.x).fold(0.0, f64::max);
    let height = profile.last()?.y;
    Some(PosedPrimitive {
        kind: PrimitiveKind::Turned { profile },
        center,
        yaw_rad: 0.0,
        size: DVec2::splat(2.0 * widest).extend(height),
        overlap,
    })
}

/// Outlines whose union is the silhouette: one per pair of neighboring rings.
fn outlines(center: DVec2, rings: &[DVec2], camera: &Camera) -> Vec<Vec<DVec2>> {
    let ring = |p: DVec2| {
        (0..AROUND).map(move |k| {
            let angle = TAU * f64::from(k) / f64::from(AROUND);
            (center + p.x * DVec2::from_angle(angle)).extend(p.y)
        })
    };
    rings.windows(2).map(|pair| projected_hull(camera, ring(pair[0]).chain(ring(pair[1])))).collect()
}
