//! Top-down grasps of a solid with a parallel gripper.
//!
//! Two flat fingers close along a horizontal line on opposite sides of the surface (an antipodal grasp: Nguyen,
//! "Constructing force-closure grasps", 1988). A grasp is valid if both normals lie within the friction cone about that
//! line, both fingers have room beside the solid before they close, and nothing is above them. Candidates are tried in
//! order of distance from the center of mass, which minimizes torque; the first valid one is returned. Object frame,
//! meters. The model is limited to the two finger tips: reachability by an arm and neighboring objects are ignored.
//! Costs a few rays per candidate, mostly well below a millisecond in total.

use std::f64::consts::TAU;

use glam::DVec3;
use parry3d_f64::query::{Ray, RayCast};

use super::solid_query::MeshSolid;

/// Dimensions of the fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gripper {
    /// Widest distance between the fingers, meters.
    pub opening_m: f64,
    /// Of one finger along the closing line, meters.
    pub finger_thickness_m: f64,
}

impl Gripper {
    /// A common gripper: 80 mm of opening, finger tips of 10 mm.
    pub const COMMON: Self = Self { opening_m: 0.08, finger_thickness_m: 0.01 };

    /// The same gripper with its fingers almost closed beforehand, for walls and handles.
    const ALMOST_CLOSED_M: f64 = 0.02;
}

/// The two points of the surface that the fingers touch, object frame, meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelGrasp {
    pub contacts_m: [DVec3; 2],
}

/// Closing lines tried about the vertical through the center of mass, and heights along it, as shares.
const DIRECTIONS: usize = 24;
const HEIGHTS: [f64; 5] = [0.5, 0.35, 0.65, 0.2, 0.85];

/// Number of triangles of the mesh that are tried besides those lines.
const MAX_TRIANGLES: usize = 200;

/// Smallest thickness between the fingers, meters.
const THINNEST_M: f64 = 0.0005;

/// Offset of ray origins from the surface, so that rays do not hit it, meters.
const CLEAR_M: f64 = 1e-5;

/// A grasp of the solid, if one of the candidates is valid. `friction` is the coefficient between finger and solid.
pub fn parallel_grasp(
    solid: &MeshSolid,
    center_of_mass_m: DVec3,
    friction: f64,
    gripper: Gripper,
) -> Option<ParallelGrasp> {
    let min_cosine = friction.atan().cos();
    let mut candidates = around(solid, center_of_mass_m);
    candidates.extend(on_triangles(solid));
    candidates.sort_by(|a, b| {
        let [a, b] = [a, b].map(|candidate| candidate.point_m.distance_squared(center_of_mass_m));
        a.total_cmp(&b)
    });
    let openings = [gripper.opening_m, Gripper::ALMOST_CLOSED_M.min(gripper.opening_m)];
    candidates.iter().find_map(|candidate| {
        let inward = -candidate.normal.with_z(0.0).try_normalize()?;
        if -inward.dot(candidate.normal) < min_cosine {
            return None;
        }
        openings.iter().find_map(|opening_m| {
            let gripper = Gripper { opening_m: *opening_m, ..gripper };
            closed(solid, candidate.point_m, inward, min_cosine, gripper)
        })
    })
}

/// A point of the surface and the direction away from the solid there.
struct Candidate {
    point_m: DVec3,
    normal: DVec3,
}

/// First hits of horizontal rays toward the vertical through the center of mass.
fn around(solid: &MeshSolid, center_of_mass_m: DVec3) -> Vec<Candidate> {
    let (low, high) = solid.bounds();
    let far_m = (high - low).length();
    let mut candidates = Vec::new();
    for share in HEIGHTS {
        let center = center_of_mass_m.with_z(low.z + share * (high.z - low.z));
        for k in 0..DIRECTIONS {
            let (sine, cosine) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
            let outward = DVec3::new(cosine, sine, 0.0);
            if let Some((distance_m, normal)) = first_hit(solid, center + far_m * outward, -outward, far_m) {
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

/// The grasp with one finger at a point, closing along `inward`.
fn closed(
    solid: &MeshSolid,
    point_m: DVec3,
    inward: DVec3,
    min_cosine: f64,
    gripper: Gripper,
) -> Option<ParallelGrasp> {
    let thickness_m = gripper.finger_thickness_m;
    // The other finger closes from its position in the open hand.
    let open_at = point_m + gripper.opening_m * inward;
    let (distance_m, normal) = first_hit(solid, open_at, -inward, gripper.opening_m - THINNEST_M)?;
    let other_m = open_at - distance_m * inward;
    let fingers = [(point_m, -inward), (open_at, inward)];
    let free = fingers.iter().all(|(tip, away)| {
        let [near, center, far] = [CLEAR_M, 0.5 * thickness_m, thickness_m].map(|along| *tip + along * *away);
        first_hit(solid, near, *away, thickness_m).is_none()
            && solid.depth_m(far) < 0.0
            && first_hit(solid, center, DVec3::Z, f64::MAX).is_none()
    });
    (normal.dot(inward) >= min_cosine && free).then_some(ParallelGrasp { contacts_m: [point_m, other_m] })
}

/// Distance to the first surface along a ray, and its normal on the ray's side.
fn first_hit(solid: &MeshSolid, origin: DVec3, direction: DVec3, max_m: f64) -> Option<(f64, DVec3)> {
    let ray = Ray::new(origin, direction);
    let hits = solid.shells().iter().filter_map(|shell| {
        let hit = shell.surface.cast_local_ray_and_get_normal(&ray, max_m, false)?;
        Some((hit.time_of_impact, hit.normal))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::shapes::{block, shell_of_revolution};
    use crate::{Material, Rgb, Solid, TexturedMesh};

    fn grasp(solids: impl IntoIterator<Item = Solid>, center_of_mass_m: DVec3) -> Option<ParallelGrasp> {
        let mut mesh = TexturedMesh::default();
        for solid in solids {
            mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
        }
        let solid = MeshSolid::new(&mesh).expect("closed");
        parallel_grasp(&solid, center_of_mass_m, 0.4, Gripper::COMMON)
    }

    #[test]
    fn parallel_grasp_takes_a_block_across_its_narrow_side() {
        let found = grasp([block(DVec3::new(0.2, 0.05, 0.1))], DVec3::new(0.0, 0.0, 0.05)).expect("narrow");
        let [a, b] = found.contacts_m;
        assert!((a.distance(b) - 0.05).abs() < 1e-6, "{a} {b}");
        assert!((a - b).x.abs() < 0.01 && (0.5 * (a + b)).distance(DVec3::new(0.0, 0.0, 0.05)) < 0.01);
    }

    #[test]
    fn parallel_grasp_rejects_solids_wider_than_the_opening() {
        assert_eq!(grasp([block(DVec3::new(0.2, 0.15, 0.1))], DVec3::new(0.0, 0.0, 0.05)), None);
    }

    #[test]
    fn parallel_grasp_takes_a_wide_bowl_at_its_wall() {
        let profile = [(0.08, 0.0), (0.08, 0.06)].map(|(x, y)| DVec2::new(x, y));
        let wall_m = 0.004;
        let found = grasp([shell_of_revolution(&profile, wall_m, wall_m, 48)], DVec3::new(0.0, 0.0, 0.02));
        let [a, b] = found.expect("a wall").contacts_m;
        assert!((a.distance(b) - wall_m).abs() < 1e-3, "{a} {b}");
    }

    #[test]
    fn parallel_grasp_rejects_candidates_under_a_lid() {
        let mast = block(DVec3::new(0.02, 0.02, 0.1));
        let lid = block(DVec3::new(0.3, 0.3, 0.02)).translated(DVec3::new(0.0, 0.0, 0.1));
        assert_eq!(grasp([mast, lid], DVec3::new(0.0, 0.0, 0.08)), None);
    }
}
