//! `describe`: a sentence becomes a description.

mod breakfast;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use embedded::text_parser::{DescribeOptions, describe};

fn bench(criterion: &mut Criterion) {
    let config = breakfast::config();
    let options = DescribeOptions { max_objects: 64, table: None, on_unknown: Default::default() };
    criterion.bench_function("describe/breakfast", |b| {
        b.iter(|| describe(black_box(breakfast::TEXT), breakfast::SEED, &options, &config.analyst))
    });
    criterion.bench_function("describe/theme_only", |b| {
        b.iter(|| describe(black_box("a hobby desk"), breakfast::SEED, &options, &config.analyst))
    });
}

criterion_group!(benches, bench);
criterion_main!(benches);
