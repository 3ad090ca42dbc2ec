//! The renderer: the reference image in color, and depth and ids alone.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::Pose;
use render::{Background, Lighting, RenderObject, RenderScene, View, render, render_geometry};

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let recognition = &scene.ground_truth().known.recognition;
    let view = View::Perspective(recognition.camera);
    let mut objects = vec![RenderObject { mesh: &scene.table, world_from_object: Pose::IDENTITY, id: 1 }];
    objects.extend(scene.meshes.iter().zip(&scene.poses).zip(2..).map(|((mesh, pose), id)| RenderObject {
        mesh,
        world_from_object: *pose,
        id,
    }));
    let rendered = RenderScene {
        objects: objects.clone(),
        lighting: Lighting::studio(-0.7, 0.95, 0.6),
        background: Background::light_with_floor(-recognition.table.size_m.z),
    };
    criterion.bench_function("render/color", |b| {
        b.iter(|| render(black_box(&rendered), &view, &scene.config.render))
    });
    criterion.bench_function("render/geometry", |b| b.iter(|| render_geometry(black_box(&objects), &view)));
}

criterion_group! { name = benches; config = Criterion::default().sample_size(20); targets = bench }
criterion_main!(benches);
