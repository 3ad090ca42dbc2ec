//! The rotation optimizer: yaw of one object by either solver, and of all of a table one after the other.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use imaging::Mask;
use pose_estimation::yaw::{YawProblem, YawSettings, YawSolver, estimate_yaw};
use runtime::CancelFlag;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let (known, cancel) = (&scene.ground_truth().known, CancelFlag::default());
    let camera = &known.recognition.camera;
    let nothing_hides = Mask::empty(camera.width_px, camera.height_px);
    let problems: Vec<YawProblem> = scene
        .meshes
        .iter()
        .zip(&known.masks)
        .map(|(mesh, seen)| YawProblem {
            mesh,
            camera,
            mask: &seen.visible,
            unknown: &nothing_hides,
            support_height_m: 0.0,
            image: Some(&scene.generated.image),
            stated_yaw_rad: None,
        })
        .collect();
    let turn = |problem: &YawProblem, settings| estimate_yaw(black_box(problem), settings, &cancel);
    let golden = YawSettings { solver: YawSolver::Golden, ..scene.config.dro.clone() };
    let paper = YawSettings { solver: YawSolver::Paper, ..golden.clone() };
    criterion.bench_function("rotate/bowl", |b| b.iter(|| turn(&problems[0], &golden)));
    let outline_only = YawSettings { descriptor_weight: 0.0, ..paper.clone() };
    criterion.bench_function("rotate/bowl_as_the_paper", |b| b.iter(|| turn(&problems[0], &paper)));
    criterion.bench_function("rotate/bowl_as_the_paper_without_appearance", |b| {
        b.iter(|| turn(&problems[0], &outline_only))
    });
    criterion.bench_function("rotate/whole_table", |b| {
        b.iter(|| problems.iter().map(|problem| turn(problem, &golden)).filter(Result::is_ok).count())
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
