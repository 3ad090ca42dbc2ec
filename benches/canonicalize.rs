//! Standing raw meshes up: one object, and all of a table one after the other.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use pose_estimation::upright::{UprightProblem, upright};
use runtime::CancelFlag;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let (ground_truth, cancel) = (scene.ground_truth(), CancelFlag::default());
    let problems: Vec<UprightProblem> = scene
        .objects()
        .iter()
        .zip(&scene.meshes)
        .zip(&ground_truth.alone)
        .map(|((object, raw_mesh), alone)| UprightProblem {
            raw_mesh,
            camera: &ground_truth.known.recognition.camera,
            mask: &alone.completion.silhouette,
            image: Some((&alone.completion.image, alone.completion.crop_px)),
            size_m: object.size_m,
            example: None,
            hints: &[],
        })
        .collect();
    let stand_up = |problem: &UprightProblem| {
        upright(black_box(problem), &scene.config.canonicalize, &scene.config.dro, &cancel)
    };
    criterion.bench_function("canonicalize/bowl", |b| b.iter(|| stand_up(&problems[0])));
    criterion.bench_function("canonicalize/whole_table", |b| {
        b.iter(|| problems.iter().map(stand_up).filter(Result::is_ok).count())
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
