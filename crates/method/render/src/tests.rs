//! The renderer agrees with the reference renderer, and lighting has the expected effects.

use glam::{DVec2, DVec3};

use super::*;
use geometry::{Camera, Material, Rgb, TexturedMesh, shapes};

fn settings() -> RenderSettings {
    RenderSettings { supersampling: 1, shadow_map_px: 512, sky_directions: 8, sky_map_px: 128 }
}

fn dressed(solid: geometry::Solid, color: u32) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    mesh.add(solid, &Material::plain("paint", Rgb::hex(color), 0.5));
    mesh
}

fn scene_meshes() -> Vec<(TexturedMesh, Pose)> {
    let at = |x: f64, y: f64, yaw: f64| Pose::upright(DVec3::new(x, y, 0.0), yaw);
    let slab = shapes::block(DVec3::new(1.0, 0.7, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
    vec![
        (dressed(slab, 0xb08050), at(0.0, 0.0, 0.0)),
        (dressed(shapes::sphere(0.06, 40), 0xc03020), at(-0.2, 0.1, 0.0)),
        (dressed(shapes::block(DVec3::new(0.1, 0.2, 0.15)), 0x3060c0), at(0.15, 0.05, 0.5)),
        (dressed(shapes::cylinder(0.04, 0.12, 0.005, 36), 0x40a040), at(0.0, -0.15, 0.2)),
        (dressed(shapes::cone(0.05, 0.0, 0.13, 36), 0xd0c040), at(0.32, -0.2, 0.2)),
    ]
}

fn objects(meshes: &[(TexturedMesh, Pose)]) -> Vec<RenderObject<'_>> {
    meshes
        .iter()
        .enumerate()
        .map(|(k, (mesh, pose))| RenderObject { mesh, world_from_object: *pose, id: k as u32 + 1 })
        .collect()
}

fn views() -> Vec<View> {
    let camera = |az: f64, el: f64, d: f64| Camera::orbit(160, 120, 0.6, DVec3::ZERO, az, el, d);
    vec![
        View::Perspective(camera(0.0, 0.7, 1.6)),
        View::Perspective(camera(2.2, 0.2, 1.2)),
        View::Perspective(camera(0.4, 0.5, 0.3)), // inside the scene: near-plane clipping
        View::Orthographic(TopView {
            width_px: 160,
            height_px: 120,
            meters_per_px: 0.008,
            center_m: DVec2::new(0.05, 0.0),
            eye_z_m: 1.0,
        }),
    ]
}

#[test]
fn ids_and_depth_agree_with_reference() {
    let meshes = scene_meshes();
    let objects = objects(&meshes);
    for view in views() {
        let fast = render_geometry(&objects, &view);
        let slow = reference::render_geometry(&objects, &view);
        let count = fast.ids.len();
        let other_id = (0..count).filter(|&k| fast.ids[k] != slow.ids[k]).count();
        let other_depth = (0..count)
            .filter(|&k| fast.ids[k] == slow.ids[k] && fast.ids[k] != 0)
            .filter(|&k| (fast.depth_m[k] - slow.depth_m[k]).abs() > 2e-5 + 1e-4 * slow.depth_m[k])
            .count();
        assert!(other_id * 500 <= count, "{other_id} of {count} ids differ in {view:?}");
        assert!(other_depth * 500 <= count, "{other_depth} of {count} depths differ in {view:?}");
        assert!(slow.ids.iter().any(|&id| id > 1), "the view shows nothing");
    }
}

#[test]
fn color_and_geometry_passes_agree() {
    let meshes = scene_meshes();
    let scene = RenderScene {
        objects: objects(&meshes),
        lighting: Lighting::studio(-0.6, 0.9, 0.5),
        background: Background::light_with_floor(-0.7),
    };
    for view in views() {
        let frame = render(&scene, &view, &settings());
        let geometry = render_geometry(&scene.objects, &view);
        assert_eq!(frame.ids, geometry.ids);
        assert_eq!(frame.depth_m, geometry.depth_m);
        let finer = render(&scene, &view, &RenderSettings { supersampling: 2, ..settings() });
        assert_eq!(finer.ids, geometry.ids);
        for (id, normal) in frame.ids.iter().zip(frame.normals.as_ref().expect("asked for")) {
            let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
            assert!(if *id == 0 { length == 0.0 } else { (length - 1.0).abs() < 1e-3 });
        }
    }
}

#[test]
fn render_bytes_do_not_depend_on_thread_count() {
    let meshes = scene_meshes();
    let scene = RenderScene {
        objects: objects(&meshes),
        lighting: Lighting::studio(-0.6, 0.9, 0.5),
        background: Background::light_with_floor(-0.7),
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| render(&scene, &views()[0], &RenderSettings { supersampling: 2, ..settings() }))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn shadow_falls_away_from_light() {
    let meshes = scene_meshes();
    let table_and_block = [&meshes[0], &meshes[2]];
    let objects: Vec<RenderObject> = table_and_block
        .iter()
        .enumerate()
        .map(|(k, (mesh, pose))| RenderObject { mesh, world_from_object: *pose, id: k as u32 + 1 })
        .collect();
    let scene = RenderScene {
        objects,
        lighting: Lighting::studio(-std::f64::consts::FRAC_PI_2, 0.7, 0.1), // from -x
        background: Background::light(),
    };
    let top =
        TopView { width_px: 200, height_px: 140, meters_per_px: 0.005, center_m: DVec2::ZERO, eye_z_m: 1.0 };
    let frame = render(&scene, &View::Orthographic(top), &settings());
    let brightness = |x: f64, y: f64| {
        let p = top.pixel_from_world(DVec2::new(x, y));
        i32::from(frame.color.pixel(p.x as u32, p.y as u32)[1])
    };
    let (shadow, open) = (brightness(0.27, 0.05), brightness(-0.1, 0.05));
    assert!(shadow + 25 < open, "shadow {shadow}, open {open}");
}

#[test]
fn glass_transmits_background_color_and_keeps_its_id() {
    let table = dressed(shapes::block(DVec3::new(1.0, 1.0, 0.02)), 0xc02020);
    let mut pane = TexturedMesh::default();
    let glass = Material { opacity: 0.2, ..Material::plain("glass", Rgb::hex(0xf0f8ff), 0.1) };
    pane.add(shapes::block(DVec3::new(0.3, 0.3, 0.01)).translated(DVec3::new(0.0, 0.0, 0.2)), &glass);
    let objects = vec![
        RenderObject { mesh: &table, world_from_object: Pose::IDENTITY, id: 1 },
        RenderObject { mesh: &pane, world_from_object: Pose::IDENTITY, id: 2 },
    ];
    let scene =
        RenderScene { objects, lighting: Lighting::studio(0.0, 1.0, 0.3), background: Background::light() };
    let view = View::Orthographic(TopView {
        width_px: 64,
        height_px: 64,
        meters_per_px: 0.01,
        center_m: DVec2::ZERO,
        eye_z_m: 1.0,
    });
    let frame = render(&scene, &view, &settings());
    assert_eq!(frame.ids[32 * 64 + 32], 2);
    let [r, g, b, _] = frame.color.pixel(32, 32);
    assert!(r > g && r > b && r > 60, "the red table shows through: {r} {g} {b}");
}

/// A room about the meshes of [`scene_meshes`], whose table floats 0.7 m above the floor.
fn room_around(objects: &[RenderObject]) -> Room {
    let tabletop = Tabletop::of(&objects[0]);
    Room::around(DVec3::new(-0.5, -0.35, -0.7), DVec3::new(0.5, 0.35, 0.15), tabletop, 3)
}

fn brightness(frame: &Frame, x: u32, y: u32) -> i32 {
    frame.color.pixel(x, y)[..3].iter().map(|byte| i32::from(*byte)).sum()
}

#[test]
fn room_changes_colors_only_and_its_bytes_do_not_depend_on_thread_count() {
    let meshes = scene_meshes();
    let objects = objects(&meshes);
    let room = room_around(&objects);
    let lighting = Lighting::daylight(-0.6, 0.9).exposed_for(&room);
    let plain = Background::light_with_floor(-0.7);
    let in_room = RenderScene { objects, lighting, background: Background::in_room(room) };
    let outside = RenderScene { background: plain, ..in_room.clone() };
    for view in views() {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| render(&in_room, &view, &settings()))
        };
        let (one, three, plain) = (with(1), with(3), render(&outside, &view, &settings()));
        assert_eq!(one, three);
        assert_eq!((&one.ids, &one.depth_m, &one.normals), (&plain.ids, &plain.depth_m, &plain.normals));
        assert_ne!(one.color, plain.color);
    }
}

#[test]
fn floor_of_room_is_darker_under_the_table() {
    let meshes = scene_meshes();
    let objects = objects(&meshes);
    let room = room_around(&objects);
    let lighting = Lighting::daylight(-0.6, 0.9).exposed_for(&room);
    let scene = RenderScene { objects, lighting, background: Background::in_room(room) };
    let camera = Camera::orbit(160, 120, 0.6, DVec3::new(0.0, 0.0, -0.35), 0.0, 0.25, 3.0);
    let view = View::Perspective(camera);
    let frame = render(&scene, &view, &settings());
    let at = |x: f64, y: f64| {
        let p = view.project(DVec3::new(x, y, -0.7)).expect("in front of the eye");
        assert_eq!(frame.ids[p.y as usize * 160 + p.x as usize], 0, "the floor is hidden at {x} {y}");
        brightness(&frame, p.x as u32, p.y as u32)
    };
    let (under, beside) = (at(0.3, 0.3), at(-0.9, -0.5));
    assert!(4 * under < 3 * beside, "{under} under the table, {beside} beside it");
}

#[test]
fn tabletop_of_room_is_darker_beside_an_object() {
    let meshes = scene_meshes();
    let objects = objects(&meshes);
    let room = room_around(&objects);
    let dark = Lighting { key_color: glam::Vec3::ZERO, ..Lighting::daylight(-0.6, 0.9) };
    let scene =
        RenderScene { objects, lighting: dark.exposed_for(&room), background: Background::in_room(room) };
    let top =
        TopView { width_px: 200, height_px: 140, meters_per_px: 0.005, center_m: DVec2::ZERO, eye_z_m: 1.0 };
    let frame = render(&scene, &View::Orthographic(top), &settings());
    let at = |x: f64, y: f64| {
        let p = top.pixel_from_world(DVec2::new(x, y));
        brightness(&frame, p.x as u32, p.y as u32)
    };
    // The block's side is at about y = -0.06.
    let (near, far) = (at(0.17, -0.075), at(-0.4, -0.28));
    assert!(near + 20 < far, "{near} near the block, {far} far from it");
}
