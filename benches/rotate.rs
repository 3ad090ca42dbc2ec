//! The rotation optimizer: yaw of one object, and of all of a table one after the other.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use tabletopgen::align::dro::{RotationProblem, estimate_yaw};
use tabletopgen::geometry::{Interrupt, Mask};

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let (known, interrupt) = (&scene.aside().known, Interrupt::default());
    let camera = &known.recognition.camera;
    let nothing_hides = Mask::empty(camera.width_px, camera.height_px);
    let problems: Vec<RotationProblem> = scene
        .meshes
        .iter()
        .zip(&known.masks)
        .map(|(mesh, seen)| RotationProblem {
            mesh,
            camera,
            mask: &seen.visible,
            unknown: &nothing_hides,
            picture: Some(&scene.painting.picture),
        })
        .collect();
    let turn = |problem: &RotationProblem| estimate_yaw(black_box(problem), &scene.config.dro, &interrupt);
    criterion.bench_function("rotate/bowl", |b| b.iter(|| turn(&problems[0])));
    criterion.bench_function("rotate/whole_table", |b| {
        b.iter(|| problems.iter().map(turn).filter(Result::is_ok).count())
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
