//! Convex decomposition: hulls of the bowl, and of everything on the table one after the other.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::TexturedMesh;
use geometry::decompose::decompose;
use runtime::CancelFlag;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let cancel = CancelFlag::default();
    let cut = |mesh: &TexturedMesh| decompose(black_box(mesh), &scene.config.decompose, &cancel);
    criterion.bench_function("decompose/bowl", |b| b.iter(|| cut(&scene.meshes[0])));
    criterion.bench_function("decompose/whole_table", |b| {
        b.iter(|| scene.meshes.iter().map(cut).filter(Result::is_ok).count())
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
