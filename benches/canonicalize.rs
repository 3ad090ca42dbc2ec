//! Standing raw meshes up: one object, and all of a table one after the other.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use pose_estimation::canonicalize::{UprightProblem, upright};
use runtime::Interrupt;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let (aside, interrupt) = (scene.aside(), Interrupt::default());
    let problems: Vec<UprightProblem> = scene
        .objects()
        .iter()
        .zip(&scene.meshes)
        .zip(&aside.alone)
        .map(|((object, raw_mesh), alone)| UprightProblem {
            raw_mesh,
            camera: &aside.known.recognition.camera,
            mask: &alone.completion.silhouette,
            picture: Some((&alone.completion.picture, alone.completion.shown_px)),
            size_m: object.size_m,
            example: None,
            told: &[],
        })
        .collect();
    let stand_up = |problem: &UprightProblem| {
        upright(black_box(problem), &scene.config.canonicalize, &scene.config.dro, &interrupt)
    };
    criterion.bench_function("canonicalize/bowl", |b| b.iter(|| stand_up(&problems[0])));
    criterion.bench_function("canonicalize/whole_table", |b| {
        b.iter(|| problems.iter().map(stand_up).filter(Result::is_ok).count())
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
