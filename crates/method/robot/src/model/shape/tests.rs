//! Tests of volume, inertia and distance against sampled points and cases by hand.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const PRIMITIVES: [Primitive; 4] = [
    Primitive::Box { half_size_m: Vector3::new(0.03, 0.05, 0.08) },
    Primitive::Cylinder { radius_m: 0.04, half_length_m: 0.07 },
    Primitive::Capsule { radius_m: 0.04, half_length_m: 0.05 },
    Primitive::Sphere { radius_m: 0.06 },
];

/// Uniform points in the box around a primitive, and those of them that are inside.
fn sampled(primitive: &Primitive) -> (f64, Vec<Point3<f64>>) {
    const POINTS: usize = 400_000;
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let half = primitive.half_extents_m();
    let inside: Vec<_> = (0..POINTS)
        .map(|_| Point3::from(half.map(|h| random.random_range(-h..h))))
        .filter(|point| primitive.signed_distance_m(point) <= 0.0)
        .collect();
    (8.0 * half.product() * inside.len() as f64 / POINTS as f64, inside)
}

#[test]
fn volume_and_inertia_equal_those_of_sampled_points() {
    for primitive in PRIMITIVES {
        let (volume, inside) = sampled(&primitive);
        assert!((volume / primitive.volume_m3() - 1.0).abs() < 0.01, "{primitive:?}: {volume}");
        let mean =
            |value: fn(&Point3<f64>) -> f64| inside.iter().map(value).sum::<f64>() / inside.len() as f64;
        let [x, y, z] = [mean(|p| p.x * p.x), mean(|p| p.y * p.y), mean(|p| p.z * p.z)];
        let expected = Vector3::new(y + z, x + z, x + y);
        let ratio = primitive.inertia_per_kg_m2().component_div(&expected);
        assert!((ratio - Vector3::repeat(1.0)).amax() < 0.01, "{primitive:?}: {ratio}");
    }
}

#[test]
fn signed_distances_of_known_points() {
    let [cuboid, cylinder, capsule, sphere] = PRIMITIVES;
    for (primitive, point, expected) in [
        (cuboid, [0.0, 0.0, 0.0], -0.03),
        (cuboid, [0.06, 0.09, 0.0], 0.05),
        (cylinder, [0.0, 0.0, 0.06], -0.01),
        (cylinder, [0.07, 0.0, 0.11], 0.05),
        (capsule, [0.0, 0.0, 0.1], 0.01),
        (capsule, [0.05, 0.0, 0.0], 0.01),
        (sphere, [0.0, 0.05, 0.0], -0.01),
    ] {
        let distance = primitive.signed_distance_m(&Point3::from(point));
        assert!((distance - expected).abs() < 1e-12, "{primitive:?} {point:?}: {distance}");
    }
}

#[test]
fn two_balls_have_the_inertia_of_a_dumbbell() {
    let ball = |x: f64| Shape {
        primitive: Primitive::Sphere { radius_m: 0.1 },
        link_from_shape: Isometry3::translation(x, 0.0, 0.0),
        material: 0,
        role: ShapeRole::Both,
        is_pad: false,
    };
    let (center, tensor) = solid_inertia([ball(0.0), ball(1.0)].iter(), 2.0).expect("two solids");
    assert!((center - Vector3::new(0.5, 0.0, 0.0)).norm() < 1e-12);
    let own = 2.0 * 0.4 * 0.01;
    let expected = Matrix3::from_diagonal(&Vector3::new(own, own + 0.5, own + 0.5));
    assert!((tensor - expected).norm() < 1e-12, "{tensor}");
}

#[test]
fn frame_of_a_capsule_lies_along_its_ends() {
    for to in [Vector3::new(0.0, 0.0, -0.4), Vector3::new(0.3, -0.2, 0.1), Vector3::new(0.0, 0.5, 0.0)] {
        let from = Vector3::new(0.1, 0.0, 0.0);
        let (frame, half) = frame_along(from, to);
        let end = frame * Point3::new(0.0, 0.0, half);
        assert!((end.coords - to).norm() < 1e-12, "{end} {to}");
    }
}
