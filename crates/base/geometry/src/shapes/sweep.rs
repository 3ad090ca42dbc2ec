//! Sweeps of a cross-section along a path: handles, cables, rings, wire.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use super::{circle, loft, loft_closed};
use crate::Solid;

/// Sweeps `section` (counter-clockwise, x = the frame's side, y = its up) along `path` (at least two
/// points) with a rotation-minimizing frame that starts with its up direction nearest to `up`.
/// `scale` gives the section's size at each path fraction 0..1.
pub fn sweep(path: &[DVec3], section: &[DVec2], up: DVec3, scale: impl Fn(f64) -> f64) -> Solid {
    loft(&rings(path, section, up, scale, false))
}

/// As [`sweep`] along a closed path (the last point joins the first; do not repeat it).
pub fn sweep_closed(path: &[DVec3], section: &[DVec2], up: DVec3) -> Solid {
    loft_closed(&rings(path, section, up, |_| 1.0, true))
}

/// A round bar of `radius_m` along `path`.
pub fn tube(path: &[DVec3], radius_m: f64, segments: usize) -> Solid {
    let direction = (path[1] - path[0]).normalize_or_zero();
    let up = if direction.z.abs() < 0.8 { DVec3::Z } else { DVec3::X };
    sweep(path, &circle(radius_m, segments), up, |_| 1.0)
}

/// A torus about +z lying on z = 0: `radius_m` to the center of a bar of `bar_radius_m`.
pub fn ring(radius_m: f64, bar_radius_m: f64, segments: usize, bar_segments: usize) -> Solid {
    let path: Vec<DVec3> = (0..segments)
        .map(|k| (radius_m * DVec2::from_angle(TAU * k as f64 / segments as f64)).extend(bar_radius_m))
        .collect();
    sweep_closed(&path, &circle(bar_radius_m, bar_segments), DVec3::Z)
}

fn rings(
    path: &[DVec3],
    section: &[DVec2],
    up: DVec3,
    scale: impl Fn(f64) -> f64,
    closed: bool,
) -> Vec<Vec<DVec3>> {
    let n = path.len();
    let tangent = |k: usize| {
        let (before, after) = if closed {
            (path[(k + n - 1) % n], path[(k + 1) % n])
        } else {
            (path[k.saturating_sub(1)], path[(k + 1).min(n - 1)])
        };
        (after - before).normalize_or_zero()
    };
    let mut forward = tangent(0);
    let mut frame_up = (up - up.dot(forward) * forward).normalize_or(forward.any_orthonormal_vector());
    (0..n)
        .map(|k| {
            let next = tangent(k);
            frame_up = DQuat::from_rotation_arc(forward, next) * frame_up;
            frame_up = (frame_up - frame_up.dot(next) * next).normalize_or_zero();
            forward = next;
            let side = frame_up.cross(forward);
            let size = scale(k as f64 / (n - 1).max(1) as f64);
            section.iter().map(|p| path[k] + size * (p.x * side + p.y * frame_up)).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_are_closed_with_outward_faces() {
        let bar = tube(&[DVec3::ZERO, DVec3::Z, DVec3::new(0.0, 1.0, 1.5)], 0.1, 16);
        assert!(bar.is_watertight() && bar.volume_m3() > 0.0);
        let torus = ring(0.1, 0.01, 64, 24);
        assert!(torus.is_watertight());
        let expected = TAU * 0.1 * std::f64::consts::PI * 1e-4;
        assert!((torus.volume_m3() / expected - 1.0).abs() < 0.02, "{}", torus.volume_m3() / expected);
    }
}
