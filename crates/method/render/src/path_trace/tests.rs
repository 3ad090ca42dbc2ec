//! The path tracer has the values that are known without it.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::{DVec2, DVec3};

use super::bvh::{Bvh, FAR};
use super::lobes::Lobes;
use super::*;
use crate::{Background, Lighting, RenderObject, RenderSettings, Room, Tabletop, TopView};
use geometry::{Camera, Material, Pose, Rgb, TexturedMesh, shapes};

fn quality(samples_per_pixel: u32, seed: u64) -> PathTraceSettings {
    PathTraceSettings { samples_per_pixel, max_bounces: 64, seed }
}

fn made_of(solid: geometry::Solid, material: &Material) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    mesh.add(solid, material);
    mesh
}

fn matte(gray: f32) -> Material {
    Material::plain("matte", Rgb([gray; 3]), 1.0)
}

fn clear() -> Material {
    Material { opacity: 0.0, ..Material::plain("clear", Rgb([1.0; 3]), 0.05) }
}

fn scene<'a>(meshes: &[&'a TexturedMesh], lighting: Lighting) -> RenderScene<'a> {
    let object =
        |(mesh, id): (&&'a TexturedMesh, u32)| RenderObject { mesh, world_from_object: Pose::IDENTITY, id };
    RenderScene {
        objects: meshes.iter().zip(1..).map(object).collect(),
        lighting,
        background: Background::light(),
    }
}

/// A sphere about the origin.
fn ball(radius_m: f64, segments: usize, material: &Material) -> TexturedMesh {
    made_of(shapes::sphere(radius_m, segments).translated(DVec3::new(0.0, 0.0, -radius_m)), material)
}

fn dark() -> Lighting {
    Lighting {
        toward_key: DVec3::Z,
        key_color: Vec3::ZERO,
        key_radius_rad: 0.0,
        sky_color: Vec3::ZERO,
        ground_color: Vec3::ZERO,
        exposure: 1.0,
    }
}

/// Straight down at the center, from a height.
fn from_above(side_px: u32, side_m: f64, eye_z_m: f64) -> View {
    View::Orthographic(TopView {
        width_px: side_px,
        height_px: side_px,
        meters_per_px: side_m / f64::from(side_px),
        center_m: DVec2::ZERO,
        eye_z_m,
    })
}

fn mean(image: &TracedImage) -> Vec3 {
    image.light.iter().sum::<Vec3>() / image.light.len() as f32
}

#[test]
fn white_bodies_in_even_light_return_it() {
    let light = Vec3::new(0.7, 0.5, 0.3);
    let lighting = Lighting { sky_color: light, ground_color: light, ..dark() };
    let white = Rgb([1.0; 3]);
    for material in [
        matte(1.0),
        Material::plain("gloss", white, 0.15),
        Material::metal("mirror", white, 0.05),
        Material::metal("brushed", white, 0.5),
        clear(),
    ] {
        let sphere = ball(0.1, 32, &material);
        let camera = Camera::look_at(12, 12, 0.15, DVec3::new(0.0, -1.0, 0.2), DVec3::ZERO);
        let mut scene = scene(&[&sphere], lighting);
        (scene.background.top_color, scene.background.bottom_color) = (light, light);
        let image = path_trace(&scene, &View::Perspective(camera), &quality(64, 1));
        let ratio = mean(&image) / light;
        assert!(ratio.abs_diff_eq(Vec3::ONE, 0.015), "{}: {ratio}", material.name);
    }
}

#[test]
fn a_plane_under_the_key_light_has_the_analytic_radiance() {
    let plane = made_of(shapes::block(DVec3::new(2.0, 2.0, 0.1)), &matte(0.5));
    for key_radius_rad in [0.0, 0.1] {
        for elevation_rad in [0.5, 1.0, 1.5] {
            let key = Lighting::studio(0.0, elevation_rad, 0.0);
            let lighting =
                Lighting { sky_color: Vec3::ZERO, ground_color: Vec3::ZERO, key_radius_rad, ..key };
            let image = path_trace(&scene(&[&plane], lighting), &from_above(4, 0.1, 1.0), &quality(64, 1));
            let l = Vec3A::new(elevation_rad.cos() as f32, 0.0, elevation_rad.sin() as f32);
            let (reflected, _) = Lobes::new(Vec3A::Z, Rgb([0.5; 3]).to_linear().into(), 1.0, 0.0).toward(l);
            let expected = PI as f32 * reflected * lighting.key_color;
            let seen = mean(&image);
            assert!(seen.abs_diff_eq(expected, 0.01 * expected.x), "{seen} for {expected}");
            // Close to Lambert's law, of which the glossy layer takes a little and to which it adds a little.
            let lambert = Rgb([0.5; 3]).to_linear()[0] * l.z * lighting.key_color.x;
            assert!((seen.x / lambert - 1.0).abs() < 0.12, "{} for {lambert}", seen.x);
        }
    }
}

#[test]
fn penumbras_are_as_wide_as_the_light_makes_them() {
    let plane = made_of(shapes::block(DVec3::new(2.0, 2.0, 0.1)), &matte(0.5));
    let roof = shapes::block(DVec3::new(1.0, 2.0, 0.01)).translated(DVec3::new(-0.5, 0.0, 0.6));
    let roof = made_of(roof, &matte(0.0));
    for key_radius_rad in [0.0, 0.05, 0.2] {
        let lighting = Lighting { key_color: Vec3::ONE, key_radius_rad, ..dark() };
        // From below the roof, which is 0.5 above the plane and ends over the center of the image.
        let view = from_above(40, 0.4, 0.3);
        let open = mean(&path_trace(&scene(&[&plane], lighting), &view, &quality(16, 1))).x;
        let image = path_trace(&scene(&[&plane, &roof], lighting), &view, &quality(64, 1));
        for column in 0..40 {
            let x_m = (column as f64 + 0.5 - 20.0) * 0.01;
            let share = (0..40).map(|row| image.light[row * 40 + column].x).sum::<f32>() / (40.0 * open);
            let t = (x_m / (0.5 * key_radius_rad.tan())).clamp(-1.0, 1.0);
            let expected = 0.5 + FRAC_1_PI * (t * (1.0 - t * t).sqrt() + t.asin());
            assert!(
                (f64::from(share) - expected).abs() < 0.02,
                "{share} for {expected} at {x_m} m, radius {key_radius_rad}"
            );
        }
    }
}

#[test]
fn rays_meet_what_brute_force_finds() {
    let mut mesh = made_of(shapes::sphere(0.3, 24), &matte(0.5));
    mesh.add(shapes::block(DVec3::new(0.5, 0.1, 0.4)), &matte(0.2));
    mesh.add(shapes::cone(0.2, 0.0, 0.5, 30).translated(DVec3::new(0.3, 0.3, -0.2)), &matte(0.3));
    let triangles: Vec<[Vec3A; 3]> =
        mesh.triangles().map(|t| t.map(|v| mesh.positions[v as usize].as_vec3a())).collect();
    let bvh = Bvh::new(&triangles);
    let (mut hits, mut differing) = (0, 0);
    for k in 0..4000 {
        let mut samples = Samples::new(5, 0, k);
        let [a, b, c] = [samples.pair(), samples.pair(), samples.pair()];
        let origin = Vec3A::new(a.x, a.y, b.x) * 2.0 - 1.0;
        let aim = Vec3A::new(b.y, c.x, c.y) - 0.5;
        let direction = (aim - origin).normalize_or(Vec3A::X);
        let all: Vec<f32> =
            triangles.iter().filter_map(|corners| met_in_f64(origin, direction, corners)).collect();
        let expected = all.iter().copied().fold(f32::INFINITY, f32::min);
        let found = bvh.nearest(origin, direction, FAR).map_or(f32::INFINITY, |met| met.t);
        hits += usize::from(expected.is_finite());
        differing += usize::from(!(expected == found || (expected - found).abs() < 1e-4));
        let mut visited = 0_usize;
        bvh.visit(origin, direction, FAR, |_| {
            visited += 1;
            FAR
        });
        // A ray through an edge meets both its triangles or either.
        differing += usize::from(visited.abs_diff(all.len()) > 1);
        if expected.is_finite() {
            assert!(bvh.nearest(origin, direction, 0.99 * expected).is_none(), "something is nearer");
        }
    }
    assert!(hits > 500, "{hits} rays meet something");
    assert!(differing <= 4, "{differing} rays differ");
}

/// Moeller and Trumbore in double precision.
fn met_in_f64(origin: Vec3A, direction: Vec3A, corners: &[Vec3A; 3]) -> Option<f32> {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
    let (e1, e2) = (b - a, c - a);
    let across = direction.cross(e2);
    let determinant = e1.dot(across);
    let u = (origin - a).dot(across) / determinant;
    let q = (origin - a).cross(e1);
    let v = direction.dot(q) / determinant;
    let t = e2.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t as f32)
}

#[test]
fn equal_triangles_do_not_break_the_tree() {
    let same = [Vec3A::ZERO, Vec3A::X, Vec3A::Y];
    let bvh = Bvh::new(&[same; 100]);
    let mut met = 0;
    bvh.visit(Vec3A::new(0.2, 0.2, 1.0), Vec3A::NEG_Z, FAR, |_| {
        met += 1;
        FAR
    });
    assert_eq!(met, 100);
    assert!(Bvh::new(&[]).nearest(Vec3A::ZERO, Vec3A::X, FAR).is_none());
}

/// A table with a metal can, a glass and a matte block in a room.
fn laid_table() -> Vec<TexturedMesh> {
    let at = |solid: geometry::Solid, x: f64, y: f64| solid.translated(DVec3::new(x, y, 0.0));
    let slab = shapes::block(DVec3::new(0.8, 0.6, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
    let glass = Material { opacity: 0.3, ..Material::plain("glass", Rgb([0.8, 0.9, 0.9]), 0.05) };
    vec![
        made_of(slab, &Material::plain("wood", Rgb([0.6, 0.45, 0.3]), 0.5)),
        made_of(
            at(shapes::cylinder(0.04, 0.12, 0.0, 24), -0.1, 0.0),
            &Material::metal("can", Rgb([0.8; 3]), 0.3),
        ),
        made_of(at(shapes::cylinder(0.03, 0.1, 0.0, 24), 0.02, -0.1), &glass),
        made_of(at(shapes::block(DVec3::new(0.1, 0.06, 0.05)), 0.1, 0.05), &matte(0.6)),
    ]
}

fn in_room(meshes: &[TexturedMesh]) -> RenderScene<'_> {
    let meshes: Vec<&TexturedMesh> = meshes.iter().collect();
    let mut made = scene(&meshes, Lighting::daylight(-0.3, 0.95));
    let tabletop = Tabletop::of(&made.objects[0]);
    let room = Room::around(DVec3::new(-0.4, -0.3, -0.7), DVec3::new(0.4, 0.3, 0.2), tabletop, 1);
    made.background = Background::in_room(room);
    made.lighting = made.lighting.exposed_for(&room);
    made
}

fn hero(width_px: u32, height_px: u32) -> View {
    View::Perspective(Camera::orbit(width_px, height_px, 0.5, DVec3::ZERO, 0.4, 0.6, 1.0))
}

#[test]
fn light_does_not_depend_on_thread_count() {
    let meshes = laid_table();
    let scene = in_room(&meshes);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| path_trace(&scene, &hero(50, 37), &quality(4, 3)))
    };
    assert_eq!(with(1), with(3));
    let other = path_trace(&scene, &hero(50, 37), &quality(4, 4));
    assert_ne!(with(2).light, other.light);
}

#[test]
fn a_glass_slab_passes_what_its_two_faces_do_not_reflect() {
    let slab = made_of(shapes::block(DVec3::new(0.5, 0.5, 0.02)), &clear());
    let view = from_above(4, 0.1, 1.0);
    // Seen through: what is reflected is dark, the backdrop ahead is not.
    let behind = mean(&path_trace(&scene(&[], dark()), &view, &quality(16, 1)));
    let through = mean(&path_trace(&scene(&[&slab], dark()), &view, &quality(4096, 1)));
    let share = through / behind;
    assert!(share.abs_diff_eq(Vec3::splat(0.96 * 0.96), 0.005), "{share}");
    // Lit through.
    let plane = shapes::block(DVec3::new(2.0, 2.0, 0.1)).translated(DVec3::new(0.0, 0.0, -0.5));
    let plane = made_of(plane, &matte(0.5));
    let view = from_above(4, 0.1, -0.1);
    let lighting = Lighting { key_color: Vec3::ONE, ..dark() };
    let open = mean(&path_trace(&scene(&[&plane], lighting), &view, &quality(16, 1)));
    let under = mean(&path_trace(&scene(&[&plane, &slab], lighting), &view, &quality(256, 1)));
    assert!((under / open).abs_diff_eq(Vec3::splat(0.96 * 0.96), 0.01), "{}", under / open);
}

#[test]
fn few_samples_have_the_mean_of_many() {
    let meshes = laid_table();
    let scene = in_room(&meshes);
    let tracer = PathTracer::new(&scene);
    let view = hero(24, 18);
    let mean_of =
        |samples: u32, seed: u64| f64::from(mean(&tracer.image(&view, &quality(samples, seed), |_, _| ())).y);
    let few: Vec<f64> = (0..16).map(|seed| mean_of(64, seed)).collect();
    let of_few = few.iter().sum::<f64>() / 16.0;
    let variance = few.iter().map(|one| (one - of_few).powi(2)).sum::<f64>() / 15.0;
    let of_many = mean_of(1024, 99);
    let error = (2.0 * variance / 16.0).sqrt().max(1e-4);
    assert!((of_few - of_many).abs() < 4.0 * error, "{of_few} and {of_many}, error {error}");
    assert!(variance.sqrt() < 0.02 * of_few, "noise of an image's mean: {}", variance.sqrt());
}

#[test]
fn backdrops_are_those_of_the_forward_renderer() {
    // A pebble far below the view, so that there is a scene and nothing of it is seen.
    let pebble = made_of(shapes::sphere(0.001, 8).translated(DVec3::new(0.0, 0.0, -0.69)), &matte(0.5));
    let quick = RenderSettings { supersampling: 1, shadow_map_px: 64, sky_directions: 8, sky_map_px: 32 };
    let mut room = in_room(std::slice::from_ref(&pebble));
    let mut plain = room.clone();
    plain.background = Background::light_with_floor(-0.7);
    let view = View::Perspective(Camera::orbit(32, 24, 0.9, DVec3::ZERO, 0.4, 0.3, 1.0));
    for scene in [&mut room, &mut plain] {
        let forward = crate::render(scene, &view, &quick).color;
        let traced = path_trace(scene, &view, &quality(64, 1)).color;
        let difference: f64 = forward
            .as_rgba()
            .iter()
            .zip(traced.as_rgba())
            .map(|(a, b)| f64::from(*b) - f64::from(*a))
            .sum::<f64>()
            / f64::from(32 * 24 * 3);
        assert!(difference.abs() < 1.0, "{difference} of 255");
    }
}

#[test]
fn round_bodies_are_shaded_smoothly_where_light_grazes_them() {
    let coarse = ball(0.1, 16, &matte(0.5));
    let lighting = Lighting { key_color: Vec3::ONE, toward_key: DVec3::X, ..dark() };
    let camera = Camera::look_at(64, 64, 0.2, DVec3::new(0.0, -1.0, 0.0), DVec3::ZERO);
    let image = path_trace(&scene(&[&coarse], lighting), &View::Perspective(camera), &quality(16, 1));
    // Along the equator the light falls to zero with the cosine, without a step to black.
    let row: Vec<f32> = (32..60).map(|x| image.light[32 * 64 + x].x).collect();
    let steps = row.windows(2).map(|pair| pair[1] - pair[0]);
    let peak = row.iter().copied().fold(0.0, f32::max);
    assert!(steps.fold(0.0, f32::max) < 0.12 * peak, "{row:?}");
    assert!(row[2] > 0.0, "{row:?}");
}
