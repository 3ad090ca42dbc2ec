//! The image generator: a whole reference rendering, and the arrangement alone.

mod breakfast;

use std::hint::black_box;
use std::sync::Arc;

use catalog::category;
use criterion::{Criterion, criterion_group, criterion_main};
use embedded::layout::{LayoutObject, arrange};
use runtime::CancelFlag;
use scene::InstanceId;

fn bench(criterion: &mut Criterion) {
    let scene = breakfast::Breakfast::new();
    let description = Arc::new(breakfast::describe(&scene.config));
    let index = |id: &InstanceId| description.objects.iter().position(|object| object.id == *id);
    let objects: Vec<LayoutObject> = description
        .objects
        .iter()
        .zip(&scene.meshes)
        .map(|(object, mesh)| LayoutObject {
            name: object.id.to_string(),
            category: category(&object.category).expect("a kind of the catalog"),
            mesh,
            relations: object
                .relations
                .iter()
                .map(|relation| (relation.kind, relation.target.as_ref().and_then(index)))
                .collect(),
        })
        .collect();
    let cancel = CancelFlag::default();
    criterion.bench_function("paint/arrange", |b| {
        b.iter(|| {
            arrange(black_box(&objects), &scene.outline, breakfast::SEED, &scene.config.layout, &cancel)
        })
    });
    let (image_generator, call) = (breakfast::image_generator(&scene.config), breakfast::call());
    criterion.bench_function("paint/whole", |b| {
        b.iter(|| breakfast::render(black_box(&image_generator), &call, &description))
    });
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
