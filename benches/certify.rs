//! The measurements of the certificate: collisions, support, stability.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::collide::PlacedSolid;
use physics::{carriers, collisions, stability, support};
use runtime::CancelFlag;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let (bodies, solids) = scene.bodies();
    let (config, cancel) = (&scene.config, CancelFlag::default());
    let placed: Vec<PlacedSolid> = solids
        .iter()
        .zip(&bodies)
        .map(|(solid, body)| PlacedSolid { solid, world_from_object: body.world_from_object })
        .collect();
    criterion.bench_function("certify/collisions", |b| {
        b.iter(|| collisions(black_box(&placed), &config.certify, &cancel))
    });
    let supports = scene.supports();
    let carriers: Vec<Vec<usize>> = (0..bodies.len()).map(|body| carriers(&supports, body)).collect();
    criterion.bench_function("certify/support", |b| {
        b.iter(|| {
            let found = (1..placed.len()).filter(|&k| {
                support(black_box(&placed), &bodies, k, &carriers[k], &config.certify, &cancel)
                    .is_ok_and(|finding| finding.is_supported())
            });
            found.count()
        })
    });
    criterion.bench_function("certify/stability", |b| {
        b.iter(|| stability(black_box(&bodies), &config.certify, &config.settle, &cancel))
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
