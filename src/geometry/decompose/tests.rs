//! Known shapes and properties of decompositions.

use super::*;
use crate::geometry::shapes::{block, ring, shell_of_revolution, sphere, tube};
use crate::geometry::{Material, Rgb, Solid};
use glam::{DVec2, DVec3};

pub(super) fn settings() -> DecomposeSettings {
    DecomposeSettings {
        tolerance_m: 0.0015,
        max_hulls: 32,
        max_pieces: 48,
        max_vertices: 64,
        min_thickness_m: 0.001,
        excess_spacing_m: 0.004,
    }
}

fn mesh(solids: impl IntoIterator<Item = Solid>) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    for solid in solids {
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    }
    mesh
}

fn mug() -> TexturedMesh {
    let profile = [DVec2::new(0.035, 0.0), DVec2::new(0.04, 0.05), DVec2::new(0.04, 0.1)];
    let path: Vec<DVec3> = (0..=12)
        .map(|k| {
            let angle = std::f64::consts::PI * (f64::from(k) / 12.0 - 0.5);
            DVec3::new(0.038 + 0.028 * angle.cos(), 0.0, 0.055 + 0.032 * angle.sin())
        })
        .collect();
    mesh([shell_of_revolution(&profile, 0.004, 0.006, 64), tube(&path, 0.005, 12)])
}

fn is_in_a_hull(d: &Decomposition, p: DVec3) -> bool {
    d.hulls.iter().any(|h| distance_above(&planes(h), p) < 1e-6)
}

#[test]
fn convex_parts_are_their_own_hulls() {
    let blocks = [block(DVec3::splat(0.1)), sphere(0.03, 32).translated(DVec3::new(0.0, 0.0, 0.1))];
    let d = decompose(&mesh(blocks), &settings(), &Interrupt::default()).expect("two convex parts");
    assert_eq!(d.hulls.len(), 2);
    assert!(d.watertight && d.max_excess_m < 0.0011, "{}", d.max_excess_m);
    assert!((d.hull_volume_m3 / d.mesh_volume_m3 - 1.0).abs() < 0.02);
}

#[test]
fn a_mug_stays_open_and_its_handle_too() {
    let d = decompose(&mug(), &settings(), &Interrupt::default()).expect("a mug");
    assert!(d.hulls.len() > 8 && d.hulls.iter().all(|h| h.points.len() <= 64));
    for z in [0.012, 0.05, 0.099] {
        assert!(!is_in_a_hull(&d, DVec3::new(0.0, 0.0, z)), "the cavity is filled at {z}");
        assert!(!is_in_a_hull(&d, DVec3::new(0.02, 0.01, z)), "the cavity is filled at {z}");
    }
    assert!(!is_in_a_hull(&d, DVec3::new(0.05, 0.0, 0.055)), "the handle is filled");
    assert!(is_in_a_hull(&d, DVec3::new(0.066, 0.0, 0.055)), "the handle is missing");
    assert!(is_in_a_hull(&d, DVec3::new(-0.038, 0.0, 0.08)), "the wall is missing");
    assert!(is_in_a_hull(&d, DVec3::new(0.0, 0.0, 0.003)), "the floor is missing");
    assert!(d.max_excess_m < 0.004, "hulls stick out by {}", d.max_excess_m);
    let lowest = d.hulls.iter().flat_map(|h| &h.points).map(|p| p.z).fold(1.0, f64::min);
    assert!(lowest.abs() < 1e-9);
}

#[test]
fn hulls_cover_the_surface() {
    for shape in [mug(), mesh([ring(0.05, 0.01, 48, 16)])] {
        let d = decompose(&shape, &settings(), &Interrupt::default()).expect("a shape");
        let faces: Vec<_> = d.hulls.iter().map(planes).collect();
        for t in shape.triangles() {
            let middle = t.map(|v| shape.positions[v as usize]).iter().sum::<DVec3>() / 3.0;
            let outside = faces.iter().map(|f| distance_above(f, middle)).fold(f64::INFINITY, f64::min);
            assert!(outside < 0.0008, "{middle} sticks out by {outside}");
        }
    }
}

#[test]
fn the_same_bytes_with_one_thread_and_with_two() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| decompose(&mug(), &settings(), &Interrupt::default())).expect("a mug")
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn it_stops_when_asked_and_refuses_nothing() {
    let interrupt = Interrupt::default();
    interrupt.raise();
    assert_eq!(decompose(&mug(), &settings(), &interrupt), Err(DecomposeError::Interrupted(Interrupted)));
    let nothing = decompose(&TexturedMesh::default(), &settings(), &Interrupt::default());
    assert_eq!(nothing, Err(DecomposeError::NoHull));
}
