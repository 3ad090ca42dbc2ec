//! The rotation optimizer: yaw of one object by either solver, and of all of a table one after the other.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use imaging::Mask;
use pose_estimation::dro::{DroSettings, DroSolver, RotationProblem, estimate_yaw};
use runtime::Interrupt;

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
            seat_height_m: 0.0,
            picture: Some(&scene.painting.picture),
        })
        .collect();
    let turn = |problem: &RotationProblem, settings| estimate_yaw(black_box(problem), settings, &interrupt);
    let golden = DroSettings { solver: DroSolver::Golden, ..scene.config.dro.clone() };
    let paper = DroSettings { solver: DroSolver::Paper, ..golden.clone() };
    criterion.bench_function("rotate/bowl", |b| b.iter(|| turn(&problems[0], &golden)));
    let outline_only = DroSettings { descriptor_weight: 0.0, ..paper.clone() };
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
