//! Statistics of a dataset: content, clutter, support, sizes, masses, tables, yield.
//!
//! `statistics.json` is this value; `statistics.html` shows it with plots.

pub mod distribution;
pub mod charts;
pub mod page;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use scene::SupportRelation;

use crate::facts::{ObjectFacts, SceneFacts};
use crate::licences;
use crate::selection::Selection;
use crate::splits::SplitPlan;

pub use distribution::Distribution;

/// Path of the numbers in a version's folder.
pub const JSON_PATH: &str = "statistics.json";

/// Path of the page in a version's folder.
pub const PAGE_PATH: &str = "statistics.html";

/// Edges of the bins of sizes, meters: about three per decade.
const SIZE_EDGES_M: [f64; 8] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0];

/// Edges of the bins of masses, kilograms: two per decade.
const MASS_EDGES_KG: [f64; 10] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];

/// Edges of the bins of table areas, square meters.
const AREA_EDGES_M2: [f64; 9] = [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0];

/// Statistics of the scenes of a dataset, and of the selection that they come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    pub format: String,
    pub scenes: usize,
    pub objects: usize,
    /// In the order of the plan.
    pub splits: Vec<SplitStatistics>,
    pub objects_per_scene: Distribution,
    /// The largest number of objects first, then by name.
    pub categories: Vec<CategoryCount>,
    /// Objects whose mesh is a plain shape, because the catalog does not have the object.
    pub stand_ins: usize,
    /// Clutter: share of the table top that objects cover, one value per scene.
    pub covered_share: Distribution,
    /// 1 on the table, 2 on or in an object on the table, and so on; one value per object.
    pub support_depth: Distribution,
    /// Objects by relation to their supporter: `on` or `in`.
    pub support_relations: BTreeMap<String, usize>,
    /// Largest extent, one value per object.
    pub largest_extent_m: Distribution,
    /// One value per object.
    pub mass_kg: Distribution,
    pub table_shapes: BTreeMap<String, usize>,
    pub table_models: BTreeMap<String, usize>,
    /// One value per scene.
    pub table_area_m2: Distribution,
    /// Objects by license.
    pub licences: BTreeMap<String, usize>,
    /// Of all scenes that were read, also those that the filter left out.
    pub selection: Selection,
    /// Passes over requested scenes.
    pub yield_share: Option<f64>,
}

/// One split.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SplitStatistics {
    pub name: String,
    /// As asked for.
    pub ratio: f64,
    pub scenes: usize,
    /// Of all scenes.
    pub share: f64,
    pub objects: usize,
}

/// Number of occurrences of a category.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CategoryCount {
    pub category: String,
    pub objects: usize,
    /// Scenes with one or more.
    pub scenes: usize,
}

impl Statistics {
    /// The statistics of scenes; `splits` are their splits.
    pub fn of(scenes: &[&SceneFacts], splits: &[String], selection: &Selection, plan: &SplitPlan) -> Self {
        let objects: Vec<&ObjectFacts> = scenes.iter().flat_map(|scene| &scene.objects).collect();
        let of_objects =
            |value: fn(&ObjectFacts) -> f64| objects.iter().map(|object| value(object)).collect();
        let of_scenes = |value: fn(&SceneFacts) -> f64| scenes.iter().map(|scene| value(scene)).collect();
        let tables =
            |name: fn(&SceneFacts) -> &String| tally(scenes.iter().map(|scene| name(scene).as_str()));
        let relation = |object: &&ObjectFacts| match object.support_relation {
            SupportRelation::On => "on",
            SupportRelation::In => "in",
        };
        let covered_edges: Vec<f64> = (0..=20).map(|k| f64::from(k) / 20.0).collect();
        let licences = licences::counts(scenes.iter().copied());
        Self {
            format: "tabletopgen-dataset-statistics/1".to_owned(),
            scenes: scenes.len(),
            objects: objects.len(),
            splits: split_statistics(scenes, splits, plan),
            objects_per_scene: Distribution::of_integers(
                "objects",
                scenes.iter().map(|s| s.objects.len()).collect(),
            ),
            categories: categories(scenes),
            stand_ins: objects.iter().filter(|object| object.stand_in).count(),
            covered_share: Distribution::of("1", &covered_edges, of_scenes(|scene| scene.covered_share)),
            support_depth: Distribution::of_integers(
                "levels",
                objects.iter().map(|object| object.support_depth).collect(),
            ),
            support_relations: tally(objects.iter().map(relation)),
            largest_extent_m: Distribution::of(
                "m",
                &SIZE_EDGES_M,
                of_objects(|object| object.largest_extent_m),
            ),
            mass_kg: Distribution::of("kg", &MASS_EDGES_KG, of_objects(|object| object.mass_kg)),
            table_shapes: tables(|scene| &scene.table_shape),
            table_models: tables(|scene| &scene.table_model),
            table_area_m2: Distribution::of("m^2", &AREA_EDGES_M2, of_scenes(|scene| scene.table_area_m2)),
            licences: licences.into_iter().map(|(licence, count)| (licence, count.objects)).collect(),
            selection: selection.clone(),
            yield_share: selection.yield_share(),
        }
    }

    /// The text of `statistics.json`.
    pub fn json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("numbers and texts have a JSON form");
        text.push('\n');
        text
    }
}

fn split_statistics(scenes: &[&SceneFacts], splits: &[String], plan: &SplitPlan) -> Vec<SplitStatistics> {
    let statistics = plan.ratios.iter().map(|split| {
        let inside = scenes.iter().zip(splits).filter(|(_, name)| **name == split.name);
        let sizes: Vec<usize> = inside.map(|(scene, _)| scene.objects.len()).collect();
        SplitStatistics {
            name: split.name.clone(),
            ratio: split.ratio,
            scenes: sizes.len(),
            share: sizes.len() as f64 / scenes.len().max(1) as f64,
            objects: sizes.iter().sum(),
        }
    });
    statistics.collect()
}

fn categories(scenes: &[&SceneFacts]) -> Vec<CategoryCount> {
    let mut counts: BTreeMap<&str, CategoryCount> = BTreeMap::new();
    for scene in scenes {
        let mut of_scene = BTreeSet::new();
        for object in &scene.objects {
            let count = counts.entry(&object.category).or_insert_with(|| CategoryCount {
                category: object.category.clone(),
                objects: 0,
                scenes: 0,
            });
            count.objects += 1;
            count.scenes += usize::from(of_scene.insert(object.category.as_str()));
        }
    }
    let mut counts: Vec<CategoryCount> = counts.into_values().collect();
    counts.sort_by(|a, b| b.objects.cmp(&a.objects).then_with(|| a.category.cmp(&b.category)));
    counts
}

fn tally<'a>(names: impl Iterator<Item = &'a str>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    names.for_each(|name| *counts.entry(name.to_owned()).or_default() += 1);
    counts
}
