//! Recognition of boxes, cylinders, spheres and capsules: what they are, what they are not, and roundings.

use glam::DQuat;

use super::*;
use crate::Solid;
use crate::shapes::{block, cone, cylinder, lathe, prism, regular_polygon, rounded_block, sphere};

fn placed() -> Pose {
    Pose {
        translation_m: DVec3::new(0.1, -0.2, 0.3),
        rotation: DQuat::from_xyzw(0.3, -0.5, 0.2, 0.7).normalize(),
    }
}

/// The hull of a solid, turned and moved.
fn hull(solid: Solid) -> ConvexHull {
    let points: Vec<DVec3> = solid.positions.iter().map(|p| placed().transform_point(*p)).collect();
    convex_hull(&points, usize::MAX, 0.0).expect("a solid")
}

fn kind(solid: Solid) -> Option<SimpleSolidKind> {
    SimpleSolid::of_hull(&hull(solid)).map(|found| found.kind)
}

/// Sorted half extents of a box.
fn halves_m(solid: &SimpleSolid) -> [f64; 3] {
    let SimpleSolidKind::Box { half_m } = solid.kind else { panic!("{solid:?} is no box") };
    let mut halves_m = half_m.to_array();
    halves_m.sort_by(f64::total_cmp);
    halves_m
}

fn capsule(radius_m: f64, length_m: f64) -> Solid {
    let half = |k: u32| f64::from(k).mul_add(PI / 32.0, -0.5 * PI);
    let at = |k: u32, z: f64| DVec2::new(radius_m * half(k).cos(), z + radius_m * half(k).sin());
    let lower = (0..=16).map(|k| at(k, radius_m));
    let upper = (16..=32).map(|k| at(k, radius_m + length_m));
    lathe(&lower.chain(upper).collect::<Vec<_>>(), 48)
}

#[test]
fn exact_solids_are_recognized_in_any_pose() {
    let found = SimpleSolid::of_hull(&hull(block(DVec3::new(0.03, 0.05, 0.002)))).expect("a box");
    for (found, wanted) in halves_m(&found).into_iter().zip([0.001, 0.015, 0.025]) {
        assert!((found - wanted).abs() < 1e-9);
    }
    assert!(
        found.object_from_solid.translation_m.distance(placed().transform_point(DVec3::Z * 0.001)) < 1e-9
    );
    for (radius_m, length_m) in [(0.012, 0.002), (0.033, 0.12), (0.0035, 0.18)] {
        let found = kind(cylinder(radius_m, length_m, 0.0, 32));
        let Some(SimpleSolidKind::Cylinder { radius_m: r, half_length_m }) = found else {
            panic!("{found:?}")
        };
        assert!((r - radius_m).abs() < 1e-9 && (half_length_m - 0.5 * length_m).abs() < 1e-9);
    }
    let found = kind(sphere(0.03, 64));
    assert!(matches!(found, Some(SimpleSolidKind::Sphere { radius_m }) if (radius_m - 0.03).abs() < 1e-6));
    let found = kind(capsule(0.01, 0.05));
    let Some(SimpleSolidKind::Capsule { radius_m, half_length_m }) = found else { panic!("{found:?}") };
    assert!((radius_m - 0.01).abs() < 1e-5 && (half_length_m - 0.025).abs() < 1e-5);
}

#[test]
fn what_only_resembles_a_solid_keeps_its_hull() {
    // A nut, a pencil, a tapered cup, a wedge, a ball that stands on a flat spot, a die with rounded corners.
    assert_eq!(kind(prism(&regular_polygon(0.01, 6), 0.006)), None);
    assert_eq!(kind(prism(&regular_polygon(0.0035, 8), 0.18)), None);
    assert_eq!(kind(cone(0.03, 0.029, 0.1, 48)), None);
    let mut wedge = block(DVec3::new(0.05, 0.03, 0.01));
    wedge.positions.iter_mut().for_each(|p| p.z *= 1.0 + p.x);
    assert_eq!(kind(wedge), None);
    let mut ball = sphere(0.0325, 48);
    ball.positions.iter_mut().for_each(|p| p.z = p.z.max(0.0011));
    assert_eq!(kind(ball), None);
    assert_eq!(kind(rounded_block(DVec3::splat(0.045), 0.0015, 0.0015)), None);
}

#[test]
fn a_polygon_is_round_by_its_sides_at_any_size_and_length() {
    for (radius_m, length_m) in [(0.01, 0.1), (0.002, 0.15), (0.012, 0.002), (0.04, 0.01)] {
        let found = |sides: usize| kind(prism(&regular_polygon(radius_m, sides), length_m));
        assert_eq!(found(12), None, "12 sides, radius {radius_m}, length {length_m}");
        let round = found(16);
        assert!(matches!(round, Some(SimpleSolidKind::Cylinder { .. })), "{round:?} of radius {radius_m}");
        let squared = SimpleSolid::rounding(&hull(prism(&regular_polygon(radius_m, 12), length_m)), 0.0015);
        assert_eq!(squared, None, "12 sides, radius {radius_m}, length {length_m}");
    }
}

#[test]
fn coins_whose_rims_are_rounded_by_a_quarter_are_cylinders() {
    for (radius_m, thickness_m) in [(0.014, 0.00275), (0.0118, 0.0024), (0.009, 0.002), (0.015, 0.003)] {
        let coin = hull(cylinder(radius_m, thickness_m, 0.25 * thickness_m, 48));
        let found = SimpleSolid::rounding(&coin, 0.0015).map(|solid| solid.kind);
        let Some(SimpleSolidKind::Cylinder { radius_m: r, half_length_m }) = found else {
            panic!("{found:?}")
        };
        assert!((r - radius_m).abs() < 1e-5 && (half_length_m - 0.5 * thickness_m).abs() < 1e-9);
    }
}

#[test]
fn rounded_edges_are_squared_within_the_excess() {
    let cube = hull(rounded_block(DVec3::splat(0.045), 0.0015, 0.0015));
    let found = SimpleSolid::rounding(&cube, 0.0015).expect("a box");
    assert!(halves_m(&found).into_iter().all(|half_m| (half_m - 0.0225).abs() < 1e-9));
    let squared = found.hull(32).expect("a hull");
    assert_eq!(squared.points.len(), 8);
    let again = SimpleSolid::of_hull(&squared).expect("a box");
    assert!(halves_m(&again).into_iter().all(|half_m| (half_m - 0.0225).abs() < 1e-9));
    assert_eq!(SimpleSolid::rounding(&cube, 0.0005), None);

    let coin = hull(cylinder(0.012, 0.0018, 0.0003, 48));
    let prism = SimpleSolid::rounding(&coin, 0.0015).and_then(|solid| solid.hull(32)).expect("a cylinder");
    assert_eq!(prism.points.len(), 64);
    let found = SimpleSolid::of_hull(&prism).map(|solid| solid.kind);
    let Some(SimpleSolidKind::Cylinder { radius_m, half_length_m }) = found else { panic!("{found:?}") };
    assert!((radius_m - 0.012).abs() < 1e-9 && (half_length_m - 0.0009).abs() < 1e-9);
}

#[test]
fn tapered_and_angular_hulls_are_not_squared() {
    let barrel: Vec<DVec2> = [(0.0, 0.0), (0.011, 0.0), (0.012, 0.015), (0.011, 0.03), (0.0, 0.03)]
        .map(|(radius, z)| DVec2::new(radius, z))
        .to_vec();
    let solids = [
        cone(0.03, 0.029, 0.1, 48),
        prism(&regular_polygon(0.01, 8), 0.1),
        sphere(0.002, 32),
        lathe(&barrel, 48),
        // A lens: round all along its rim.
        cylinder(0.02, 0.006, 0.003, 48),
    ];
    for solid in solids {
        assert_eq!(SimpleSolid::rounding(&hull(solid), 0.0015), None);
    }
}
