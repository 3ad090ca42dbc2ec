//! Candidate grasp points on the surface, those nearest to the center of mass first.
//!
//! First hits of horizontal rays toward the vertical through the center of mass, at shares of the height and a few
//! depths below the top, where a hand reaches the wall of a vessel; and triangles of the mesh, which find handles.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Candidate, hit};
use crate::solid_query::MeshSolid;

/// Closing lines tried about the vertical through the center of mass.
const DIRECTIONS: usize = 24;
/// Heights along it, as shares.
const HEIGHTS: [f64; 5] = [0.5, 0.35, 0.65, 0.2, 0.85];
/// Depths of candidates below the top, meters: within the reach of fingers of 45 mm.
const DEPTHS_M: [f64; 5] = [0.006, 0.01, 0.015, 0.02, 0.03];
/// Number of triangles of the mesh that are tried besides those lines.
const MAX_TRIANGLES: usize = 240;

pub(super) fn candidates(solid: &MeshSolid, center_of_mass_m: DVec3) -> Vec<Candidate> {
    let mut candidates = around(solid, center_of_mass_m);
    candidates.extend(on_triangles(solid));
    candidates.sort_by(|a, b| {
        let [a, b] = [a, b].map(|candidate| candidate.point_m.distance_squared(center_of_mass_m));
        a.total_cmp(&b)
    });
    candidates
}

fn around(solid: &MeshSolid, center_of_mass_m: DVec3) -> Vec<Candidate> {
    let (low, high) = solid.bounds();
    let far_m = (high - low).length();
    let mut candidates = Vec::new();
    let shares = HEIGHTS.into_iter().map(|share| low.z + share * (high.z - low.z));
    let below_top = DEPTHS_M.into_iter().map(|depth_m| high.z - depth_m).filter(|height_m| *height_m > low.z);
    for height_m in shares.chain(below_top) {
        let center = center_of_mass_m.with_z(height_m);
        for k in 0..DIRECTIONS {
            let (sine, cosine) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
            let outward = DVec3::new(cosine, sine, 0.0);
            if let Some((distance_m, normal)) = hit(solid, center + far_m * outward, -outward, far_m) {
                candidates.push(Candidate { point_m: center + (far_m - distance_m) * outward, normal });
            }
        }
    }
    candidates
}

/// Centers of triangles, evenly sampled from the mesh's list.
fn on_triangles(solid: &MeshSolid) -> impl Iterator<Item = Candidate> + '_ {
    let step = solid.triangles().count().div_ceil(MAX_TRIANGLES).max(1);
    solid.triangles().step_by(step).filter_map(|[a, b, c]| {
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(Candidate { point_m: (a + b + c) / 3.0, normal })
    })
}
