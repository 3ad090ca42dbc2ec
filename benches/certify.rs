//! The measurements of the certificate: collisions, support, stability.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use tabletopgen::geometry::Interrupt;
use tabletopgen::geometry::collide::PlacedSolid;
use tabletopgen::physics::{collisions, stability, support};

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let (bodies, solids) = scene.bodies();
    let (config, interrupt) = (&scene.config, Interrupt::default());
    let placed: Vec<PlacedSolid> = solids
        .iter()
        .zip(&bodies)
        .map(|(solid, body)| PlacedSolid { solid, world_from_object: body.world_from_object })
        .collect();
    criterion.bench_function("certify/collisions", |b| {
        b.iter(|| collisions(black_box(&placed), &config.certify, &interrupt))
    });
    let carriers: Vec<Option<usize>> = scene.supports().iter().map(|s| s.map(|s| s.parent)).collect();
    criterion.bench_function("certify/support", |b| {
        b.iter(|| {
            let found = (1..placed.len()).filter(|&k| {
                support(black_box(&placed), &bodies, k, carriers[k], &config.certify, &interrupt)
                    .is_ok_and(|finding| finding.is_supported())
            });
            found.count()
        })
    });
    criterion.bench_function("certify/stability", |b| {
        b.iter(|| stability(black_box(&bodies), &config.certify, &config.settle, &interrupt))
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
