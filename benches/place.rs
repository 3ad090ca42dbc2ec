//! The metric layout: footprints of turned meshes, and reading the boxes of a top view.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec2;
use pose_estimation::top_view_layout::{TopViewInstance, TopViewProblem, align_top_view, footprint};

/// Scale of the imagined top view.
const PX_PER_M: f64 = 600.0;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let yaws: Vec<f64> = scene.poses.iter().map(|pose| pose.yaw_rad().unwrap_or_default()).collect();
    criterion.bench_function("place/footprints", |b| {
        b.iter(|| {
            scene
                .meshes
                .iter()
                .zip(&yaws)
                .map(|(mesh, yaw)| footprint(black_box(mesh), *yaw))
                .collect::<Vec<_>>()
        })
    });
    let table_size_m = scene.ground_truth().known.recognition.table.size_m.truncate();
    let corner = 0.5 * table_size_m;
    let box_px = |low: DVec2, high: DVec2| {
        let (low, high) = (PX_PER_M * (low + corner), PX_PER_M * (high + corner));
        [low.x, PX_PER_M * table_size_m.y - high.y, high.x, PX_PER_M * table_size_m.y - low.y]
    };
    let instances = scene.meshes.iter().zip(&scene.poses).zip(&yaws).map(|((mesh, pose), yaw)| {
        let footprint = footprint(mesh, *yaw);
        let at = pose.translation_m.truncate();
        TopViewInstance {
            box_px: box_px(footprint.low_m + at, footprint.high_m + at),
            footprint,
            may_anchor: true,
            seen_m: Some(at + 0.5 * (footprint.low_m + footprint.high_m)),
        }
    });
    let problem = TopViewProblem {
        table_box_px: box_px(-corner, corner),
        table_size_m,
        instances: instances.collect(),
        meters_per_px: None,
    };
    criterion
        .bench_function("place/boxes", |b| b.iter(|| align_top_view(black_box(&problem), &scene.config.tsa)));
}

criterion_group!(benches, bench);
criterion_main!(benches);
