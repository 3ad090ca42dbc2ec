//! Grasps of simple solids, and fingers that touch nothing else.

use glam::{DVec2, Vec2};

use super::*;
use crate::convex_hull::{convex_hull, distance_above, planes};
use crate::decompose::{DecomposeSettings, decompose};
use crate::shapes::{block, cylinder, shell_of_revolution, tube};
use crate::{Material, Rgb, Solid, TexturedMesh};
use runtime::CancelFlag;

fn hulls(mesh: &TexturedMesh) -> Vec<ConvexHull> {
    let settings = DecomposeSettings {
        tolerance_m: 0.0015,
        max_hulls: 32,
        joined_excess_m: 0.003,
        max_pieces: 48,
        max_vertices: 64,
        min_thickness_m: 0.001,
        excess_spacing_m: 0.004,
    };
    decompose(mesh, &settings, &CancelFlag::default()).expect("hulls").hulls
}

fn grasp(solids: impl IntoIterator<Item = Solid>, center_of_mass_m: DVec3) -> Option<[DVec3; 2]> {
    let mut mesh = TexturedMesh::default();
    for solid in solids {
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    }
    let solid = MeshSolid::new(&mesh).expect("closed");
    let found = parallel_grasp(&solid, &hulls(&mesh), center_of_mass_m, 0.4, Gripper::COMMON)?;
    Some(found.contacts_m)
}

#[test]
fn parallel_grasp_takes_a_block_across_its_narrow_side() {
    let [a, b] = grasp([block(DVec3::new(0.2, 0.05, 0.06))], DVec3::new(0.0, 0.0, 0.03)).expect("narrow");
    assert!((a.distance(b) - 0.05).abs() < 1e-6, "{a} {b}");
    assert!((a - b).x.abs() < 0.01 && (0.5 * (a + b)).distance(DVec3::new(0.0, 0.0, 0.03)) < 0.01);
}

#[test]
fn parallel_grasp_rejects_solids_wider_than_the_opening() {
    assert_eq!(grasp([block(DVec3::new(0.2, 0.15, 0.1))], DVec3::new(0.0, 0.0, 0.05)), None);
    // It would fit between the fingers, but they would not open any farther.
    assert_eq!(grasp([block(DVec3::new(0.2, 0.079, 0.1))], DVec3::new(0.0, 0.0, 0.05)), None);
}

/// Regression: contacts lay 48 to 182 mm below the rim, where neither fingers of 45 mm nor the palm have room.
#[test]
fn parallel_grasp_takes_deep_vessels_by_the_wall_near_the_rim() {
    for (radius_m, height_m) in [(0.08, 0.06), (0.06, 0.12), (0.05, 0.25), (0.12, 0.3)] {
        let profile = [(radius_m, 0.0), (radius_m, height_m)].map(|(x, y)| DVec2::new(x, y));
        let center = DVec3::new(0.0, 0.0, 0.3 * height_m);
        let found = grasp([shell_of_revolution(&profile, 0.004, 0.004, 48)], center);
        let [a, b] = found.unwrap_or_else(|| panic!("the wall of a vessel of {radius_m} x {height_m}"));
        assert!(a.distance(b) < 0.012, "{a} {b}");
        for contact in [a, b] {
            let depth_m = height_m - contact.z;
            assert!(depth_m > 0.0 && depth_m < 0.0375, "{depth_m} below a rim at {height_m}");
        }
    }
}

#[test]
fn parallel_grasp_tilts_the_hand_along_the_flared_wall_of_a_bowl() {
    let profile = [(0.03, 0.0), (0.09, 0.07)].map(|(x, y)| DVec2::new(x, y));
    let found = grasp([shell_of_revolution(&profile, 0.004, 0.004, 48)], DVec3::new(0.0, 0.0, 0.03));
    let [a, b] = found.expect("a wall");
    let line = (a - b).normalize();
    assert!(line.z.abs() > 0.4 && a.distance(b) < 0.012, "{a} {b}");
    assert!(0.5 * (a.z + b.z) > 0.03, "{a} {b}");
}

#[test]
fn parallel_grasp_takes_a_tall_can_near_its_top() {
    let [a, b] = grasp([cylinder(0.033, 0.12, 0.0, 64)], DVec3::new(0.0, 0.0, 0.06)).expect("a can");
    assert!((a.distance(b) - 0.066).abs() < 1e-3, "{a} {b}");
    assert!(a.z > 0.12 - 0.0375 && a.z < 0.12, "{a}");
}

#[test]
fn parallel_grasp_comes_from_the_side_under_a_lid() {
    let mast = block(DVec3::new(0.02, 0.02, 0.1));
    let lid = block(DVec3::new(0.3, 0.3, 0.1)).translated(DVec3::new(0.0, 0.0, 0.1));
    // The lid ends farther away than a hand is long, so nothing comes from above or past its edge.
    let [a, b] = grasp([mast, lid], DVec3::new(0.0, 0.0, 0.05)).expect("the mast");
    assert!((a.distance(b) - 0.02).abs() < 1e-6 && a.z < 0.09, "{a} {b}");
    // In a box that is open above alone, the mast cannot be reached from a side.
    let foot = block(DVec3::new(0.02, 0.02, 0.02));
    let low = block(DVec3::new(0.3, 0.3, 0.1)).translated(DVec3::new(0.0, 0.0, 0.015));
    assert_eq!(grasp([foot, low], DVec3::new(0.0, 0.0, 0.01)), None);
}

/// Whether a box about a point lies outside all hulls, by samples of it.
fn is_free(hulls: &[ConvexHull], center: DVec3, axes: [DVec3; 3], half: [f64; 3]) -> bool {
    let share = |k: u32, count: u32| 2.0 * f64::from(k) / f64::from(count - 1) - 1.0;
    let faces: Vec<_> = hulls.iter().map(planes).collect();
    (0..5).all(|x| {
        (0..9).all(|y| {
            (0..15).all(|z| {
                let p = center
                    + share(x, 5) * half[0] * axes[0]
                    + share(y, 9) * half[1] * axes[1]
                    + share(z, 15) * half[2] * axes[2];
                faces.iter().all(|faces| distance_above(faces, p) > -1e-6)
            })
        })
    })
}

#[test]
fn fingers_of_a_grasp_at_a_handle_touch_the_handle_alone() {
    let profile = [(0.045, 0.0), (0.045, 0.1)].map(|(x, y)| DVec2::new(x, y));
    let path: Vec<DVec3> = (0..=16)
        .map(|k| std::f64::consts::PI * (0.5 - f64::from(k) / 16.0))
        .map(|angle| DVec3::new(0.044 + 0.05 * angle.cos(), 0.0, 0.055 + 0.035 * angle.sin()))
        .collect();
    let mut mesh = TexturedMesh::default();
    for solid in [shell_of_revolution(&profile, 0.004, 0.004, 48), tube(&path, 0.006, 12)] {
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    }
    let (solid, hulls) = (MeshSolid::new(&mesh).expect("closed"), hulls(&mesh));
    // As if it were filled with lead on the handle's side.
    let center = DVec3::new(0.09, 0.0, 0.055);
    let found = parallel_grasp(&solid, &hulls, center, 0.4, Gripper::COMMON).expect("a handle");
    let [a, b] = found.contacts_m;
    assert!(a.x > 0.05 && b.x > 0.05 && a.distance(b) < 0.02, "{a} {b}");
    let closing = (b - a).normalize();
    let up = (DVec3::Z - closing.z * closing).normalize();
    let axes = [closing, up.cross(closing), up];
    for (pad, away) in [(a, -closing), (b, closing)] {
        let center = pad + 0.0051 * away + 0.0145 * up;
        assert!(is_free(&hulls, center, axes, [0.005, 0.01, 0.0225]), "{a} {b}");
    }
}

#[test]
fn grasps_need_friction_between_slanted_sides() {
    // A wedge whose sides lean by 31 degrees: no closing line is within 22 degrees of both normals.
    let corners: Vec<DVec3> = [-0.05, 0.05]
        .into_iter()
        .flat_map(|y| [(-0.03, 0.0), (0.03, 0.0), (0.0, 0.05)].map(|(x, z)| DVec3::new(x, y, z)))
        .collect();
    let hull = convex_hull(&corners, 64, 0.0).expect("a wedge");
    let uvs = vec![Vec2::ZERO; hull.points.len()];
    let solid = Solid::from_corners(&hull.points, &uvs, &hull.triangles);
    let mut mesh = TexturedMesh::default();
    mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    let solid = MeshSolid::new(&mesh).expect("closed");
    let with = |friction: f64| {
        parallel_grasp(
            &solid,
            std::slice::from_ref(&hull),
            DVec3::new(0.0, 0.0, 0.017),
            friction,
            Gripper::COMMON,
        )
    };
    assert_eq!(with(0.2), None);
    assert!(with(0.9).is_some());
}
