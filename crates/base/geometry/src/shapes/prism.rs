//! Extrusions of outlines.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{inset, loft, rectangle, rounded_rectangle};
use crate::Solid;

fn lifted(outline: &[DVec2], z_m: f64) -> Vec<DVec3> {
    outline.iter().map(|p| p.extend(z_m)).collect()
}

/// The counter-clockwise `outline` (may be concave) raised from z = 0 to `height_m`, sharp edges.
pub fn prism(outline: &[DVec2], height_m: f64) -> Solid {
    loft(&[lifted(outline, 0.0), lifted(outline, height_m)])
}

/// As [`prism`], upper and lower edges rounded by `edge_m`. For outlines [`inset`] can handle.
pub fn slab(outline: &[DVec2], height_m: f64, edge_m: f64) -> Solid {
    let e = edge_m.min(0.499 * height_m);
    if e <= 0.0 {
        return prism(outline, height_m);
    }
    let steps = 3;
    let quarter = |k: i32| 0.5 * PI * f64::from(k) / f64::from(steps);
    let lower = (0..=steps).map(|k| (e * (1.0 - quarter(k).sin()), e * (1.0 - quarter(k).cos())));
    let upper =
        (0..=steps).rev().map(|k| (e * (1.0 - quarter(k).sin()), height_m - e * (1.0 - quarter(k).cos())));
    let rings: Vec<_> = lower.chain(upper).map(|(by, z)| lifted(&inset(outline, by), z)).collect();
    loft(&rings)
}

/// Box of `size_m` with sharp edges, standing on z = 0.
pub fn block(size_m: DVec3) -> Solid {
    prism(&rectangle(size_m.x, size_m.y), size_m.z)
}

/// Box of `size_m` with vertical corners rounded by `corner_m` and the other edges by `edge_m`.
pub fn rounded_block(size_m: DVec3, corner_m: f64, edge_m: f64) -> Solid {
    slab(&rounded_rectangle(size_m.x, size_m.y, corner_m.max(edge_m * 1.05), 4), size_m.z, edge_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prisms_are_closed_with_outward_faces() {
        let sharp = block(DVec3::new(0.2, 0.1, 0.05));
        assert!(sharp.is_watertight() && (sharp.volume_m3() - 1e-3).abs() < 1e-12);
        let round = rounded_block(DVec3::new(0.2, 0.1, 0.05), 0.01, 0.004);
        assert!(round.is_watertight());
        assert!(round.volume_m3() < 1e-3 && round.volume_m3() > 0.9e-3);
        let star: Vec<DVec2> = (0..10)
            .map(|k| DVec2::from_angle(f64::from(k) * PI / 5.0) * if k % 2 == 0 { 0.1 } else { 0.05 })
            .collect();
        let prism = prism(&star, 0.02);
        assert!(prism.is_watertight() && prism.volume_m3() > 0.0);
    }
}
