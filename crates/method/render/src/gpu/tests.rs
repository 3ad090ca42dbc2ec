//! GPU images agree with the CPU's. Runs on every available adapter, including software adapters; without an adapter
//! it reports that on standard error, or fails where `TABLETOPGEN_GPU_TESTS` is `require`.

use std::io::Write;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::scene_cache::Capacity;
use super::*;
use crate::room::FloorFinish;
use crate::{
    Background, Frame, Lighting, RenderObject, RenderSettings, Room, SceneCache, Tabletop, TopView, View,
};
use catalog::{Recipe, build, build_table, category};
use geometry::{Camera, Material, Pose, Rgb, TexturedMesh, shapes};
use gpu::test_devices::devices;

type Placed = (TexturedMesh, Pose);

fn lighting() -> Lighting {
    Lighting::studio(-0.3, 0.95, 0.6)
}

fn background() -> Background {
    Background::light_with_floor(-0.74)
}

/// Light and backdrop of each floor finish's first room about the table of [`laid_table`].
fn rooms(table: &RenderObject) -> Vec<(Lighting, Background)> {
    let tabletop = Tabletop::of(table);
    let (low, high) = table.mesh.bounds();
    let mut finishes: Vec<FloorFinish> = Vec::new();
    let rooms = (0..8).map(|seed| Room::around(low, high, tabletop, seed)).filter(|room| {
        let is_new = !finishes.contains(&room.decor.floor);
        finishes.push(room.decor.floor);
        is_new
    });
    let lit = |room: Room| (Lighting::daylight(-0.3, 0.95).exposed_for(&room), Background::in_room(room));
    rooms.map(lit).collect()
}

fn settings(supersampling: u32) -> RenderSettings {
    RenderSettings { supersampling, shadow_map_px: 512, sky_directions: 12, sky_map_px: 128 }
}

/// Objects of the catalog on a table: textured, metallic, of glass; and plain shapes.
fn laid_table() -> Vec<Placed> {
    let mut placed = Vec::new();
    let size_m = DVec3::new(0.9, 0.7, 0.74);
    let table = build_table("dining_table", size_m, None, Some("oak"), 4).expect("a known table");
    placed.push((table.mesh, Pose::IDENTITY));
    let objects = [
        ("wine_glass", -0.15, -0.1),
        ("drinking_glass", -0.08, -0.17),
        ("saucepan", 0.2, 0.12),
        ("fork", 0.05, -0.2),
        ("mug", -0.25, 0.1),
        ("book", 0.22, -0.12),
    ];
    for (k, (name, x, y)) in objects.into_iter().enumerate() {
        let size = &category(name).expect("a known category").size;
        let size_m = 0.5 * (size.low_m + size.high_m);
        let recipe = Recipe { category: name.into(), size_m, color: None, material: None, seed: k as u64 };
        let mesh = build(&recipe).expect("a mesh");
        placed.push((mesh, Pose::upright(DVec3::new(x, y, 0.0), 0.7 * k as f64)));
    }
    let plain = |solid, color, x: f64, y: f64| {
        let mut mesh = TexturedMesh::default();
        mesh.add(solid, &Material::plain("paint", Rgb::hex(color), 0.4));
        (mesh, Pose::upright(DVec3::new(x, y, 0.0), 0.3))
    };
    placed.push(plain(shapes::sphere(0.04, 32), 0xc03020, 0.02, 0.0));
    placed.push(plain(shapes::block(DVec3::new(0.08, 0.05, 0.1)), 0x3060c0, 0.05, 0.2));
    placed.push(plain(shapes::cone(0.04, 0.0, 0.1, 28), 0xd0c040, -0.05, 0.12));
    let metals = placed.iter().flat_map(|(mesh, _)| &mesh.materials);
    assert!(metals.clone().any(|m| m.metalness > 0.5) && metals.clone().any(|m| m.opacity < 0.9));
    assert!(metals.clone().any(|m| m.base_color_texture.is_some()));
    placed
}

fn objects<'a>(placed: &'a [Placed]) -> Vec<RenderObject<'a>> {
    let object = |(k, placed): (usize, &'a Placed)| RenderObject {
        mesh: &placed.0,
        world_from_object: placed.1,
        id: k as u32 + 1,
    };
    placed.iter().enumerate().map(object).collect()
}

/// From afar, from near over the table, with parts behind the near plane, and from above.
fn views() -> [View; 4] {
    let camera = |az: f64, el: f64, d: f64| Camera::orbit(192, 144, 0.6, DVec3::ZERO, az, el, d);
    [
        View::Perspective(camera(0.42, 0.52, 2.4)),
        View::Perspective(camera(2.2, 0.25, 0.9)),
        View::Perspective(camera(0.4, 0.3, 0.12)),
        View::Orthographic(TopView {
            width_px: 191,
            height_px: 143,
            meters_per_px: 0.006,
            center_m: DVec2::new(0.03, 0.0),
            eye_z_m: 0.6,
        }),
    ]
}

/// Differences between an image and the expected one.
#[derive(Debug, Default)]
struct Apart {
    pixels: usize,
    ids: usize,
    /// Of those, where no pixel beside it shows that id on the CPU.
    ids_off_edges: usize,
    /// Among pixels with equal ids: more than 1e-4 of the depth; more than a degree.
    depths: usize,
    normals: usize,
    /// Bytes: sum, and number of each difference.
    color_bytes: usize,
    color_differences: Vec<usize>,
}

impl Apart {
    fn add(&mut self, found: &Frame, expected: &Frame) {
        let (width, height) = (expected.width_px() as usize, expected.height_px() as usize);
        assert_eq!((found.width_px(), found.height_px()), (expected.width_px(), expected.height_px()));
        let (found_normals, normals) = (found.normals.as_ref(), expected.normals.as_ref());
        let (found_normals, normals) = (found_normals.expect("asked for"), normals.expect("asked for"));
        for k in 0..width * height {
            self.pixels += 1;
            if found.ids[k] != expected.ids[k] {
                self.ids += 1;
                let (x, y) = (k % width, k / width);
                let around = (y.saturating_sub(1)..(y + 2).min(height))
                    .flat_map(|v| (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| v * width + u));
                let mut around = around;
                self.ids_off_edges += usize::from(!around.any(|k| expected.ids[k] == found.ids[k]));
                continue;
            }
            if expected.ids[k] == 0 {
                assert_eq!((found.depth_m[k], found_normals[k]), (f32::INFINITY, [0.0; 3]));
                continue;
            }
            let depth_m = expected.depth_m[k];
            self.depths += usize::from((found.depth_m[k] - depth_m).abs() > 1e-4 * depth_m);
            let cosine: f32 = found_normals[k].iter().zip(normals[k]).map(|(a, b)| a * b).sum();
            self.normals += usize::from(cosine < 0.99985);
        }
        self.color_differences.resize(256, 0);
        for (a, b) in found.color.as_rgba().iter().zip(expected.color.as_rgba()) {
            self.color_differences[usize::from(a.abs_diff(*b))] += 1;
            self.color_bytes += usize::from(a.abs_diff(*b));
        }
    }

    fn share(&self, count: usize) -> f64 {
        count as f64 / self.pixels as f64
    }

    /// Of the bytes of red, green and blue.
    fn color_mean(&self) -> f64 {
        self.color_bytes as f64 / (3 * self.pixels) as f64
    }

    /// The difference that all but one in `of` bytes of red, green and blue stay within.
    fn color_within(&self, of: usize) -> usize {
        let mut left = 3 * self.pixels / of;
        for (difference, count) in self.color_differences.iter().enumerate().rev() {
            if *count > left {
                return difference;
            }
            left -= count;
        }
        0
    }
}

/// One device after the other, because compiling for software adapters takes longer than drawing.
#[test]
fn gpu_images_agree_with_cpu() {
    let placed = laid_table();
    let dioramas: Vec<_> = [1, 2]
        .map(|samples| Arc::new(SceneCache::new(objects(&placed), &settings(samples)).for_rooms()))
        .into();
    for gpu in devices() {
        for scene_cache in &dioramas {
            let mut drawn = GpuSceneCache::new(gpu.clone(), scene_cache.clone()).expect("uploaded");
            let mut apart = Apart::default();
            let mut lights = rooms(&scene_cache.scene_buffers.objects[0]);
            lights.push((lighting(), background()));
            for ((lighting, background), view) in
                lights.into_iter().flat_map(|light| views().map(move |view| (light, view)))
            {
                let found = drawn.render_with_normals(lighting, background, &view).expect("rendered");
                apart.add(&found, &scene_cache.render_with_normals(lighting, background, &view));
                let geometry = drawn.measure(&view).expect("measured");
                assert!(geometry.ids == found.ids && geometry.depth_m == found.depth_m);
            }
            let [ids, depths, normals] =
                [apart.ids, apart.depths, apart.normals].map(|count| apart.share(count));
            let (mean, p99, p999) = (apart.color_mean(), apart.color_within(100), apart.color_within(1000));
            let message = format!(
                "{}: ids {ids:.6} ({} off edges), depths {depths:.6}, normals {normals:.6}, bytes {mean:.4} on \
                 average, {p99} in 99 of 100, {p999} in 999 of 1000",
                gpu.name(),
                apart.ids_off_edges
            );
            writeln!(std::io::stderr().lock(), "pictures compared on {message}").expect("standard error");
            // Measured: none, none, 9e-6, 9e-6, 0.0034, 0, 0.
            assert!(ids < 1e-3 && apart.ids_off_edges == 0, "{message}");
            assert!(depths < 2e-4 && normals < 2e-4, "{message}");
            assert!(mean < 0.02 && p99 <= 1 && p999 <= 4, "{message}");
            image_bytes_do_not_depend_on_strips(&mut drawn);
        }
        empty_scene_renders_backdrop(&gpu);
    }
}

/// Strips, layer buffers that are too small at first, and concurrent threads.
fn image_bytes_do_not_depend_on_strips(drawn: &mut GpuSceneCache) {
    let view = views()[1];
    let whole = drawn.render_with_normals(lighting(), background(), &view).expect("painted");
    drawn.capacity =
        Capacity { pixels: 192 * 50, layers_of_a_pixel: 0, fewest_layers: 3000, ..drawn.capacity };
    let cut = || drawn.render_with_normals(lighting(), background(), &view).expect("painted");
    let (one, other) = std::thread::scope(|scope| {
        let (one, other) = (scope.spawn(cut), scope.spawn(cut));
        (one.join().expect("no panic"), other.join().expect("no panic"))
    });
    assert!(one == whole && other == whole, "{}", drawn.gpu().name());
    drawn.capacity.fewest_layers = 5;
    let refused = drawn.color(lighting(), background(), &view).expect_err("there is more glass than that");
    assert!(matches!(refused, GpuError::TooManyLayers { highest: 5, .. }), "{refused}");
    assert!(!refused.is_device_failure() && drawn.gpu().given_up().is_none());
}

fn empty_scene_renders_backdrop(gpu: &Arc<Gpu>) {
    let (view, scene_cache) = (views()[0], Arc::new(SceneCache::new(Vec::new(), &settings(1))));
    let expected = scene_cache.render_with_normals(lighting(), background(), &view);
    let drawn = GpuSceneCache::new(gpu.clone(), scene_cache).expect("uploaded");
    let mut apart = Apart::default();
    apart.add(&drawn.render_with_normals(lighting(), background(), &view).expect("painted"), &expected);
    assert!(apart.ids == 0 && apart.color_within(1000) <= 1, "{apart:?}");
}

#[test]
fn oversized_image_is_error_and_lost_device_is_reported() {
    let top =
        TopView { width_px: 1 << 30, height_px: 2, meters_per_px: 1e-9, center_m: DVec2::ZERO, eye_z_m: 1.0 };
    for gpu in devices() {
        let scene_cache = Arc::new(SceneCache::new(Vec::new(), &settings(1)));
        let drawn = GpuSceneCache::new(gpu.clone(), scene_cache.clone()).expect("uploaded");
        let refused = drawn.measure(&View::Orthographic(top)).expect_err("no device holds that");
        assert!(matches!(refused, GpuError::DoesNotFit { .. }), "{refused}");
        assert!(!refused.is_device_failure() && gpu.given_up().is_none());
        gpu.give_up("asked to by a test");
        let failed = drawn.measure(&views()[0]).expect_err("it was given up");
        assert!(failed.is_device_failure() && failed.to_string().contains("asked to by a test"), "{failed}");
        assert!(GpuSceneCache::new(gpu, scene_cache).is_err_and(|error| error.is_device_failure()));
    }
}
