//! Expected grasps of common shapes, with a check of reachability that shares nothing with the search: points of the
//! closed hand are tested against the solid.

use glam::{DQuat, DVec2};

use super::*;
use crate::shapes::{block, lathe, ring, shell_of_revolution};
use crate::{Material, Rgb, Solid, TexturedMesh};

fn meshed(solids: impl IntoIterator<Item = Solid>) -> MeshSolid {
    let mut mesh = TexturedMesh::default();
    for solid in solids {
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    }
    MeshSolid::new(&mesh).expect("closed")
}

fn grasp(solids: impl IntoIterator<Item = Solid>, center_of_mass_m: DVec3) -> Option<ParallelGrasp> {
    parallel_grasp(&meshed(solids), center_of_mass_m, 0.4, Gripper::COMMON)
}

fn profile(points: &[(f64, f64)]) -> Vec<DVec2> {
    points.iter().map(|&(radius, height)| DVec2::new(radius, height)).collect()
}

/// A cup of 84 mm, too wide for the opening, with a handle.
fn mug() -> Vec<Solid> {
    let handle = ring(0.025, 0.005, 24, 8)
        .rotated(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2))
        .translated(DVec3::new(0.068, 0.0, 0.05));
    vec![shell_of_revolution(&profile(&[(0.042, 0.0), (0.042, 0.095)]), 0.004, 0.005, 48), handle]
}

fn tall_glass() -> Vec<Solid> {
    vec![shell_of_revolution(&profile(&[(0.033, 0.0), (0.033, 0.15)]), 0.002, 0.006, 48)]
}

fn bowl() -> Vec<Solid> {
    let outside = [(0.03, 0.0), (0.06, 0.012), (0.074, 0.03), (0.08, 0.065)];
    vec![shell_of_revolution(&profile(&outside), 0.004, 0.005, 48)]
}

fn pot() -> Vec<Solid> {
    vec![shell_of_revolution(&profile(&[(0.11, 0.0), (0.11, 0.23)]), 0.004, 0.005, 48)]
}

fn bottle() -> Vec<Solid> {
    let outside = [(0.0, 0.0), (0.037, 0.0), (0.037, 0.15), (0.014, 0.19), (0.014, 0.25), (0.0, 0.25)];
    vec![lathe(&profile(&outside), 48)]
}

fn plate() -> Vec<Solid> {
    vec![shell_of_revolution(&profile(&[(0.06, 0.0), (0.09, 0.006), (0.12, 0.022)]), 0.004, 0.004, 48)]
}

fn carton() -> Vec<Solid> {
    vec![block(DVec3::new(0.06, 0.12, 0.18))]
}

/// Whether the closed hand, its palm in the direction `back`, is free: both fingers from tip to palm, and 10 cm of
/// hand behind them.
fn hand_is_free(solid: &MeshSolid, [a, b]: [DVec3; 2], back: DVec3) -> bool {
    const FINGER_M: [f64; 3] = [0.01, 0.02, 0.045];
    let along = (b - a).normalize();
    let across = back.cross(along);
    let free = |from: DVec3, thickness_m: f64, low_m: f64, high_m: f64| {
        let steps = [0.05, 0.3, 0.5, 0.7, 0.95];
        steps.iter().all(|x| {
            steps.iter().all(|z| {
                let depth = low_m + z * (high_m - low_m);
                solid.depth_m(from + x * thickness_m * along + depth * back) < 1e-4
                    && solid
                        .depth_m(from + x * thickness_m * along + depth * back + 0.2 * FINGER_M[1] * across)
                        < 2e-3
            })
        })
    };
    let width_m = a.distance(b) + 2.0 * FINGER_M[0];
    free(a - FINGER_M[0] * along, FINGER_M[0], 0.0, FINGER_M[2])
        && free(b, FINGER_M[0], 0.0, FINGER_M[2])
        && free(a - FINGER_M[0] * along, width_m, FINGER_M[2] + 1e-4, FINGER_M[2] + 0.1)
}

fn is_within_reach(solid: &MeshSolid, contacts: [DVec3; 2]) -> bool {
    let aside = DVec3::Z.cross((contacts[1] - contacts[0]).normalize());
    contacts[0].distance(contacts[1]) <= 0.08
        && [DVec3::Z, aside, -aside].into_iter().any(|back| hand_is_free(solid, contacts, back))
}

#[test]
fn common_shapes_are_grasped_within_reach_of_the_hand() {
    for (name, solids, center_m, expected) in [
        ("mug", mug(), DVec3::new(0.005, 0.0, 0.045), Some([0.003, 0.011])),
        ("tall glass", tall_glass(), DVec3::new(0.0, 0.0, 0.07), Some([0.06, 0.067])),
        ("bowl", bowl(), DVec3::new(0.0, 0.0, 0.025), Some([0.003, 0.006])),
        ("pot", pot(), DVec3::new(0.0, 0.0, 0.1), Some([0.003, 0.005])),
        ("bottle", bottle(), DVec3::new(0.0, 0.0, 0.1), Some([0.07, 0.0745])),
        ("carton", carton(), DVec3::new(0.0, 0.0, 0.09), Some([0.0599, 0.0601])),
        // Its rim is too flat for a horizontal line.
        ("plate", plate(), DVec3::new(0.0, 0.0, 0.008), None),
    ] {
        let solid = meshed(solids);
        let found = parallel_grasp(&solid, center_m, 0.4, Gripper::COMMON);
        match (found, expected) {
            (Some(found), Some([low_m, high_m])) => {
                let [a, b] = found.contacts_m;
                assert!((low_m..=high_m).contains(&a.distance(b)), "{name}: {a} {b}");
                assert!(is_within_reach(&solid, found.contacts_m), "{name}: {a} {b}");
            }
            (found, expected) => assert_eq!(found.is_some(), expected.is_some(), "{name}: {found:?}"),
        }
    }
}

/// Regression: lines lay 48 to 182 mm below the rim, inside the wall.
#[test]
fn walls_of_vessels_are_grasped_at_most_a_finger_below_the_rim() {
    for (name, solids, rim_m) in
        [("cup", mug()[..1].to_vec(), 0.095), ("bowl", bowl(), 0.065), ("pot", pot(), 0.23)]
    {
        let found = grasp(solids, DVec3::new(0.0, 0.0, 0.4 * rim_m)).expect(name);
        let [a, b] = found.contacts_m;
        assert!(a.z >= rim_m - 0.045 - 1e-9 && a.z < rim_m && (a.z - b.z).abs() < 1e-9, "{name}: {a} {b}");
    }
}

#[test]
fn parallel_grasp_takes_a_block_across_its_narrow_side() {
    let found = grasp([block(DVec3::new(0.2, 0.05, 0.1))], DVec3::new(0.0, 0.0, 0.05)).expect("narrow");
    let [a, b] = found.contacts_m;
    assert!((a.distance(b) - 0.05).abs() < 1e-6, "{a} {b}");
    assert!((a - b).x.abs() < 0.01 && (0.5 * (a + b)).with_z(0.0).length() < 0.02, "{a} {b}");
    assert!(a.z >= 0.055 - 1e-9, "{a}");
}

#[test]
fn parallel_grasp_rejects_solids_wider_than_the_opening() {
    assert_eq!(grasp([block(DVec3::new(0.2, 0.15, 0.1))], DVec3::new(0.0, 0.0, 0.05)), None);
}

#[test]
fn parallel_grasp_rejects_candidates_under_a_lid() {
    let under_lid = |height_m: f64| {
        let mast = block(DVec3::new(0.02, 0.02, height_m));
        let lid = block(DVec3::new(0.3, 0.3, 0.02)).translated(DVec3::new(0.0, 0.0, height_m));
        grasp([mast, lid], DVec3::new(0.0, 0.0, 0.8 * height_m))
    };
    assert_eq!(under_lid(0.05), None);
    // Below a high lid there is room for a hand from the side.
    let [a, b] = under_lid(0.2).expect("from the side").contacts_m;
    assert!((a.distance(b) - 0.02).abs() < 1e-6 && a.z < 0.17, "{a} {b}");
}
