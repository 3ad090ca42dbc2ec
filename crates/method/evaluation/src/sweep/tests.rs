//! Camera places by hand.

use super::*;
use geometry::{Material, Rgb, shapes};

/// A block of that size with its center at `center_m`.
fn block(size_m: DVec3, center_m: DVec3) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    mesh.add(shapes::block(size_m), &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    let (low, high) = mesh
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let offset = center_m - 0.5 * (low + high);
    mesh.positions.iter_mut().for_each(|p| *p += offset);
    mesh
}

/// A top of 1.2 x 0.8 m between z = -0.04 and 0, whose legs reach to -0.7, with a block of 0.1 m that ends at z = 0.46.
fn meshes() -> Vec<(TexturedMesh, Pose)> {
    let mut table = block(DVec3::new(1.2, 0.8, 0.04), DVec3::new(0.0, 0.0, -0.02));
    let leg = block(DVec3::new(0.05, 0.05, 0.6), DVec3::new(0.3, 0.2, -0.4));
    let first = table.positions.len() as u32;
    table.positions.extend(&leg.positions);
    table.normals.extend(&leg.normals);
    table.uvs.extend(&leg.uvs);
    let legs = leg.triangles().map(|triangle| triangle.map(|vertex| vertex + first));
    table.groups[0].triangles.extend(legs);
    let object = block(DVec3::splat(0.1), DVec3::ZERO);
    vec![(table, Pose::IDENTITY), (object, Pose::upright(DVec3::new(0.1, 0.0, 0.41), 0.0))]
}

/// A sphere of radius 2 about (1, 0, 0.5).
fn sweep() -> Sweep {
    Sweep { sphere: BoundingSphere { center_m: DVec3::new(1.0, 0.0, 0.5), radius_m: 2.0 } }
}

#[test]
fn sphere_contains_top_and_objects_but_no_legs() {
    let meshes = meshes();
    let scene = SweptScene::of(&meshes).expect("a table");
    assert_eq!((scene.table.id, scene.objects.len(), scene.objects[0].id), (1, 1, 2));
    let BoundingSphere { center_m, radius_m } = Sweep::around(&scene).expect("a sweep").sphere();
    // The box reaches from -0.6 to 0.6, -0.4 to 0.4, and -0.04 to 0.46; the farthest points are corners of the top.
    assert!(center_m.distance(DVec3::new(0.0, 0.0, 0.21)) < 1e-9, "{center_m}");
    assert!((radius_m - (0.36_f64 + 0.16 + 0.0625).sqrt()).abs() < 1e-9, "{radius_m}");
}

#[test]
fn sweep_has_the_160_places_of_the_paper() {
    let views: Vec<SweepView> = Sweep::views().collect();
    assert_eq!(views.len(), 160);
    let place = |index: usize| (views[index].elevation_deg, views[index].distance_radii);
    assert_eq!(place(0), (90, 1.0));
    assert_eq!(place(15), (90, 2.5));
    assert_eq!(place(16), (80, 1.0));
    assert_eq!(place(7 * 16 + 8), (20, 1.8), "the best view of a baseline in the paper");
    assert_eq!(place(159), (0, 2.5));
}

#[test]
fn cameras_stand_where_hand_computation_puts_them() {
    for (elevation_deg, distance_radii, eye_m) in [
        (90, 1.0, DVec3::new(1.0, 0.0, 2.5)),
        (90, 2.5, DVec3::new(1.0, 0.0, 5.5)),
        (60, 1.5, DVec3::new(1.0, -1.5, 0.5 + 1.5 * 3.0_f64.sqrt())),
        (30, 2.0, DVec3::new(1.0, -2.0 * 3.0_f64.sqrt(), 2.5)),
        (0, 1.0, DVec3::new(1.0, -2.0, 0.5)),
        (0, 2.5, DVec3::new(1.0, -5.0, 0.5)),
    ] {
        let view = SweepView { elevation_deg, distance_radii };
        let camera = sweep().camera(&view, [640, 480]);
        assert!(camera.world_from_camera.translation_m.distance(eye_m) < 1e-9, "{view:?}: {camera:?}");
        let (pixel, depth_m) = camera.project(DVec3::new(1.0, 0.0, 0.5)).expect("in front");
        assert!((pixel.x - 320.0).abs() < 1e-9 && (pixel.y - 240.0).abs() < 1e-9, "{view:?}: {pixel}");
        assert!((depth_m - 2.0 * distance_radii).abs() < 1e-9, "{view:?}: {depth_m}");
        // World +x is right in every image; +y is up from above, +z from the front.
        let (right, _) = camera.project(DVec3::new(1.2, 0.0, 0.5)).expect("in front");
        let (above, _) = camera.project(DVec3::new(1.0, 0.1, 0.6)).expect("in front");
        assert!(right.x > 320.0 && (right.y - 240.0).abs() < 1e-9 && above.y < 240.0, "{view:?}");
    }
}

#[test]
fn shorter_side_sees_60_degrees() {
    let view = SweepView { elevation_deg: 0, distance_radii: 1.0 };
    let focal = 240.0 * 3.0_f64.sqrt();
    for size_px in [[640, 480], [480, 640], [480, 480]] {
        let camera = sweep().camera(&view, size_px);
        assert!(
            (camera.fx - focal).abs() < 1e-9 && (camera.fy - focal).abs() < 1e-9,
            "{size_px:?}: {camera:?}"
        );
    }
}

#[test]
fn views_have_proportions_of_reference() {
    let size = |width: u32, height: u32| Sweep::size_px(&Image::filled(width, height, [0; 4]));
    assert_eq!(size(1024, 768), [512, 384]);
    assert_eq!(size(300, 400), [384, 512]);
    assert_eq!(size(4000, 10), [512, 32]);
}

#[test]
fn scene_without_extent_is_refused() {
    let nothing = [(TexturedMesh::default(), Pose::IDENTITY)];
    let error = Sweep::around(&SweptScene::of(&nothing).expect("a table")).expect_err("has no size");
    assert!(error.to_string().contains("have no extent"), "{error}");
    assert!(SweptScene::of(&[]).is_none());
}
