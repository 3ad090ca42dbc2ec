//! Tests that spheres contain primitives and stick out by no more than the tolerance.

use proptest::prelude::*;

use super::*;

fn primitives() -> impl Strategy<Value = Primitive> {
    let size = || 0.005..0.1f64;
    prop_oneof![
        (size(), size(), size()).prop_map(|(x, y, z)| Primitive::Box { half_size_m: Vector3::new(x, y, z) }),
        (size(), size()).prop_map(|(r, l)| Primitive::Cylinder { radius_m: r, half_length_m: l }),
        (size(), size()).prop_map(|(r, l)| Primitive::Capsule { radius_m: r, half_length_m: l }),
        size().prop_map(|radius_m| Primitive::Sphere { radius_m }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn spheres_contain_the_primitive(
        primitive in primitives(),
        tolerance in 0.008..0.04f64,
        points in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64), 400),
    ) {
        let spheres = cover(&primitive, tolerance);
        let half = primitive.half_extents_m();
        for (x, y, z) in points {
            let point = Point3::from(half.component_mul(&Vector3::new(x, y, z)));
            if primitive.signed_distance_m(&point) <= 0.0 {
                let covered = spheres.iter().any(|s| (s.center_m - point).norm() <= s.radius_m + 1e-12);
                prop_assert!(covered, "{point} of {primitive:?}");
            }
        }
    }

    #[test]
    fn spheres_stay_within_the_tolerance(primitive in primitives(), tolerance in 0.008..0.04f64) {
        for sphere in cover(&primitive, tolerance) {
            let out = primitive.signed_distance_m(&sphere.center_m) + sphere.radius_m;
            prop_assert!(out <= tolerance + 1e-12, "{sphere:?} sticks out of {primitive:?} by {out}");
        }
    }
}

#[test]
fn cube_needs_one_sphere_at_a_wide_tolerance_and_eight_at_half_of_it() {
    // A sphere around a cube of half size 1 sticks out by sqrt(3) - 1 = 0.732; around each of eight cells by half.
    let cube = Primitive::Box { half_size_m: Vector3::repeat(0.01) };
    assert_eq!(cover(&cube, 0.00733).len(), 1);
    assert_eq!(cover(&cube, 0.00367).len(), 8);
}

#[test]
fn spheres_of_a_wide_cylinder_stay_within_a_small_tolerance() {
    let primitive =
        Primitive::Cylinder { radius_m: 0.097_139_560_846_772_14, half_length_m: 0.072_138_458_860_482_22 };
    for sphere in cover(&primitive, 0.008) {
        assert!(primitive.signed_distance_m(&sphere.center_m) + sphere.radius_m <= 0.008, "{sphere:?}");
    }
}

#[test]
fn bounding_sphere_contains_all_and_is_tight_on_a_line() {
    let at = |x: f32| LinkSphere { link: 3, center_m: [x, 0.0, 0.0], radius_m: 0.1 };
    let bound = bounding_sphere(&[at(0.0), at(0.4), at(1.0)]).expect("three spheres");
    assert_eq!(bound.link, 3);
    assert!((bound.center_m[0] - 0.5).abs() < 1e-5, "{bound:?}");
    assert!((bound.radius_m - 0.6).abs() < 1e-5, "{bound:?}");
    assert_eq!(bounding_sphere(&[]), None);
}

#[test]
fn sphere_inside_another_one_is_left_out() {
    let robot = crate::model::Robot::built_in("panda", None).expect("panda");
    for (index, link) in robot.links().iter().enumerate() {
        let spheres = cover_link(link, index);
        for (i, a) in spheres.iter().enumerate() {
            for (j, b) in spheres.iter().enumerate() {
                let apart = Vector3::from(a.center_m) - Vector3::from(b.center_m);
                assert!(i == j || apart.norm() + a.radius_m > b.radius_m, "{} {i} {j}", link.name);
            }
        }
    }
}
