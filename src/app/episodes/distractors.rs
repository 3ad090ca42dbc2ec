//! Other objects of the catalog, of which some stand on the table of a demonstration.

use rand::RngExt as _;

use crate::config::Resolved;
use crate::pipeline::catalog_body::catalog_body;
use crate::pipeline::task_scene::BundleScene;
use catalog::{Affordance, Category, Recipe, categories};
use demonstrations::{Distractor, Randomization};
use runtime::seed::{child_rng, child_seed};

/// Objects to choose from, for each that there is at most.
const CHOICES: usize = 3;
/// Largest extent, meters: nothing that fills the table.
const MAX_SIZE_M: f64 = 0.2;
/// Smallest extent, meters: nothing that no camera shows.
const MIN_SIZE_M: f64 = 0.02;

/// The objects to choose from: none of a kind that the scene has, so that words of a task keep their meaning. They
/// follow from the seed. Takes some tenths of a second for each.
pub fn distractors(
    bundle: &BundleScene,
    randomization: &Randomization,
    seed: u64,
    resolved: &Resolved,
) -> Vec<Distractor> {
    let count = CHOICES * randomization.added_distractors.ceil() as usize;
    let known = &bundle.stored.composition.recognition.objects;
    let is_new = |category: &Category| known.iter().all(|object| object.category != category.name);
    let mut candidates: Vec<&Category> =
        categories().iter().filter(|category| is_small(category) && is_new(category)).collect();
    let mut rng = child_rng(seed, "distractors");
    let mut found = Vec::with_capacity(count);
    while found.len() < count && !candidates.is_empty() {
        let category = candidates.swap_remove(rng.random_range(0..candidates.len()));
        let number = found.len() + 1;
        let recipe = Recipe {
            category: category.name.clone(),
            size_m: category.size.sample(&mut rng),
            color: None,
            material: None,
            seed: child_seed(seed, &format!("distractor {}", category.name)),
        };
        // One that cannot be built is no loss: there are hundreds of others.
        let name = format!("distractor_{number}_{}", category.name);
        let built = catalog_body(&name, &recipe, &resolved.config.decompose);
        found.extend(built.ok().map(|(body, mesh)| Distractor { body, mesh }));
    }
    found
}

fn is_small(category: &Category) -> bool {
    let size_m = category.size;
    category.group != "stand_in"
        && category.affords(Affordance::Graspable)
        && size_m.high_m.max_element() <= MAX_SIZE_M
        && size_m.low_m.max_element() >= MIN_SIZE_M
}
