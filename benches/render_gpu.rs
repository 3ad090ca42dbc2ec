//! The hero image of the previews in color, and depth and ids alone: on the CPU and on each adapter there is.

mod breakfast;

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::{Camera, Pose};
use glam::DVec3;
use gpu::{DeviceChoice, Gpu};
use render::gpu::GpuSceneCache;
use render::{Background, Lighting, RenderObject, SceneCache, View};
use wgpu::Backends;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let table_height_m = scene.ground_truth().known.recognition.table.size_m.z;
    let mut objects = vec![RenderObject { mesh: &scene.table, world_from_object: Pose::IDENTITY, id: 1 }];
    objects.extend(scene.meshes.iter().zip(&scene.poses).zip(2..).map(|((mesh, pose), id)| RenderObject {
        mesh,
        world_from_object: *pose,
        id,
    }));
    let width_px = scene.config.preview.hero_width_px;
    let camera = Camera::orbit(width_px, width_px * 3 / 4, 0.52, DVec3::ZERO, 0.42, 0.52, 3.0);
    let view = View::Perspective(camera);
    let (lighting, background) =
        (Lighting::studio(-0.3, 0.95, 0.6), Background::light_with_floor(-table_height_m));
    let scene_cache = Arc::new(SceneCache::new(objects, &scene.config.render));
    criterion.bench_function("render_gpu/color_on_the_cpu", |b| {
        b.iter(|| scene_cache.color(lighting, background, black_box(&view)))
    });
    criterion.bench_function("render_gpu/geometry_on_the_cpu", |b| {
        b.iter(|| scene_cache.measure(black_box(&view)))
    });
    for (name, backend) in [("vulkan", Backends::VULKAN), ("gl", Backends::GL)] {
        let Ok(gpu) = Gpu::open_among(backend, DeviceChoice::Gpu) else { continue };
        let drawn = GpuSceneCache::new(gpu, scene_cache.clone()).expect("the scene fits");
        criterion.bench_function(&format!("render_gpu/color_on_{name}"), |b| {
            b.iter(|| drawn.color(lighting, background, black_box(&view)).expect("painted"))
        });
        criterion.bench_function(&format!("render_gpu/geometry_on_{name}"), |b| {
            b.iter(|| drawn.measure(black_box(&view)).expect("measured"))
        });
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
