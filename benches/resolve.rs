//! Physics: sorting out a layout that is a little wrong, and letting one settle.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::solid_query::MeshSolid;
use glam::DVec3;
use physics::{ResolveProblem, resolve, settle};
use runtime::CancelFlag;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let (mut bodies, solids) = scene.bodies();
    let (supports, cancel) = (scene.supports(), CancelFlag::default());
    criterion.bench_function("resolve/settle", |b| {
        b.iter(|| settle(black_box(&bodies), &scene.config.settle, &cancel))
    });
    // Alignment errs by about this much.
    for (k, body) in bodies.iter_mut().enumerate().skip(1) {
        let angle = k as f64;
        body.world_from_object.translation_m += 0.008 * DVec3::new(angle.cos(), angle.sin(), 0.0);
    }
    let solids: Vec<&MeshSolid> = solids.iter().collect();
    let problem =
        ResolveProblem { bodies: &bodies, solids: &solids, supports: &supports, outline: &scene.outline };
    criterion.bench_function("resolve/off_by_8_mm", |b| {
        let config = &scene.config;
        b.iter(|| resolve(black_box(problem), &config.resolve, &config.settle, &config.certify, &cancel))
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
