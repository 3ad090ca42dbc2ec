//! Candidate regions compared with the true objects: evaluates the region score, and provides the data to fit it
//! (`training/region_score.py`).

use std::fmt::Write as _;

use serde::Serialize;

use super::score::{DETECTION_IOU, MIN_SHARE_OF_IMAGE};
use crate::synthetic_images::{Labels, Split, SyntheticImage};
use vision::{CandidateRegions, RegionFeatures};

/// Candidate regions of one image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImageRegions {
    pub number: u64,
    pub regions: Vec<RegionResult>,
}

/// One region and its best overlap with a true object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RegionResult {
    pub measures: [f64; RegionFeatures::COUNT],
    pub score: f64,
    /// Intersection over union at the map positions, 0..1; objects too small to count are ignored.
    pub overlap: f64,
}

/// Compares candidate regions with the ground truth.
pub fn compare(sample: &SyntheticImage, candidates: &CandidateRegions) -> ImageRegions {
    let Labels { width_px, height_px, values, .. } = &sample.labels;
    let label = |place: usize| {
        let p = candidates.cells_px[place];
        let x = (p.x.max(0.0) as usize).min(*width_px as usize - 1);
        let y = (p.y.max(0.0) as usize).min(*height_px as usize - 1);
        usize::from(values[y * *width_px as usize + x])
    };
    let labels: Vec<usize> = (0..candidates.cells_px.len()).map(label).collect();
    let count = |places: &mut dyn Iterator<Item = usize>| {
        let mut counts = vec![0.0; usize::from(u8::MAX) + 1];
        places.for_each(|place| counts[labels[place]] += 1.0);
        counts
    };
    let rendered = count(&mut (0..labels.len()));
    let min_px = MIN_SHARE_OF_IMAGE * f64::from(*width_px) * f64::from(*height_px);
    let counts = |object: usize| sample.truth.objects[object].visible_px as f64 >= min_px;
    let first = usize::from(Labels::FIRST_OBJECT);
    let regions = candidates.regions.iter().map(|region| {
        let own = count(&mut region.cells.iter().copied());
        let size = region.cells.len() as f64;
        let overlap = |object: usize| {
            let both = own[first + object];
            both / (size + rendered[first + object] - both).max(1.0)
        };
        let best = (0..sample.truth.objects.len()).filter(|&k| counts(k)).map(overlap);
        RegionResult {
            measures: region.features.values(),
            score: region.features.score(),
            overlap: best.fold(0.0, f64::max),
        }
    });
    ImageRegions { number: sample.truth.number, regions: regions.collect() }
}

/// Result of a run.
#[derive(Clone, Debug, Serialize)]
pub struct RegionsReport {
    pub split: Split,
    /// Feature names, in order.
    pub names: [&'static str; RegionFeatures::COUNT],
    pub images: Vec<ImageRegions>,
}

/// Score bins of the table.
const STEPS: usize = 10;

impl RegionsReport {
    pub fn new(split: Split, images: Vec<ImageRegions>) -> Self {
        Self { split, names: RegionFeatures::NAMES, images }
    }

    /// Markdown table: share of correct regions per score bin.
    pub fn markdown(&self) -> String {
        let regions: Vec<&RegionResult> = self.images.iter().flat_map(|image| &image.regions).collect();
        let mut table = format!(
            "{} regions of {} images.\n\n| score | regions | mean score | objects |\n| --- | ---: | ---: | ---: |\n",
            regions.len(),
            self.images.len()
        );
        for step in 0..STEPS {
            let at = |score: f64| ((STEPS as f64 * score) as usize).min(STEPS - 1) == step;
            let here: Vec<&&RegionResult> = regions.iter().filter(|region| at(region.score)).collect();
            let count = here.len() as f64;
            let score_sum = here.iter().map(|region| region.score).sum::<f64>();
            let right = here.iter().filter(|region| region.overlap > DETECTION_IOU).count() as f64;
            let percent =
                |sum: f64| if count > 0.0 { format!("{:.1} %", 100.0 * sum / count) } else { "-".into() };
            let [low, high] = [step, step + 1].map(|k| 100 * k / STEPS);
            // Writing to a string cannot fail.
            let _ = writeln!(
                table,
                "| {low} to {high} % | {} | {} | {} |",
                here.len(),
                percent(score_sum),
                percent(right)
            );
        }
        table
    }
}
