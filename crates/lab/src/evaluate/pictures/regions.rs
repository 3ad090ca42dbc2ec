//! The regions among which things are chosen, beside the painted things: whether what is believed of them holds, and what
//! that belief is fitted to (`training/belief.py`).

use std::fmt::Write as _;

use serde::Serialize;

use super::score::{FOUND_IOU, LEAST_SHARE_OF_PICTURE};
use crate::synthetic::{Labels, Painting, Split};
use vision::{CandidateRegions, Measures};

/// Regions of one picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureRegions {
    pub number: u64,
    pub regions: Vec<JudgedRegion>,
}

/// One region, and how well it overlaps the painted thing that it overlaps best.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JudgedRegion {
    pub measures: [f64; Measures::COUNT],
    pub belief: f64,
    /// Intersection over union at the places of the maps, 0..1; things too small to count do not.
    pub overlap: f64,
}

/// Compares regions with what was painted.
pub fn judged(painting: &Painting, candidates: &CandidateRegions) -> PictureRegions {
    let Labels { width_px, height_px, values, .. } = &painting.labels;
    let label = |place: usize| {
        let p = candidates.places_px[place];
        let x = (p.x.max(0.0) as usize).min(*width_px as usize - 1);
        let y = (p.y.max(0.0) as usize).min(*height_px as usize - 1);
        usize::from(values[y * *width_px as usize + x])
    };
    let labels: Vec<usize> = (0..candidates.places_px.len()).map(label).collect();
    let count = |places: &mut dyn Iterator<Item = usize>| {
        let mut counts = vec![0.0; usize::from(u8::MAX) + 1];
        places.for_each(|place| counts[labels[place]] += 1.0);
        counts
    };
    let painted = count(&mut (0..labels.len()));
    let fewest_px = LEAST_SHARE_OF_PICTURE * f64::from(*width_px) * f64::from(*height_px);
    let counts = |object: usize| painting.truth.objects[object].visible_px as f64 >= fewest_px;
    let first = usize::from(Labels::FIRST_OBJECT);
    let regions = candidates.regions.iter().map(|region| {
        let own = count(&mut region.places.iter().copied());
        let size = region.places.len() as f64;
        let overlap = |object: usize| {
            let both = own[first + object];
            both / (size + painted[first + object] - both).max(1.0)
        };
        let best = (0..painting.truth.objects.len()).filter(|&k| counts(k)).map(overlap);
        JudgedRegion {
            measures: region.measures.values(),
            belief: region.measures.belief(),
            overlap: best.fold(0.0, f64::max),
        }
    });
    PictureRegions { number: painting.truth.number, regions: regions.collect() }
}

/// Everything a run found.
#[derive(Clone, Debug, Serialize)]
pub struct RegionsReport {
    pub split: Split,
    /// Names of the measures, in their order.
    pub names: [&'static str; Measures::COUNT],
    pub pictures: Vec<PictureRegions>,
}

/// Steps of belief in the table.
const STEPS: usize = 10;

impl RegionsReport {
    pub fn new(split: Split, pictures: Vec<PictureRegions>) -> Self {
        Self { split, names: Measures::NAMES, pictures }
    }

    /// How many of the regions that are believed so much are things.
    pub fn markdown(&self) -> String {
        let regions: Vec<&JudgedRegion> = self.pictures.iter().flat_map(|picture| &picture.regions).collect();
        let mut table = format!(
            "{} regions of {} pictures.\n\n| believed | regions | mean belief | things |\n| --- | ---: | ---: | ---: |\n",
            regions.len(),
            self.pictures.len()
        );
        for step in 0..STEPS {
            let at = |belief: f64| ((STEPS as f64 * belief) as usize).min(STEPS - 1) == step;
            let here: Vec<&&JudgedRegion> = regions.iter().filter(|region| at(region.belief)).collect();
            let count = here.len() as f64;
            let believed = here.iter().map(|region| region.belief).sum::<f64>();
            let right = here.iter().filter(|region| region.overlap > FOUND_IOU).count() as f64;
            let percent =
                |sum: f64| if count > 0.0 { format!("{:.1} %", 100.0 * sum / count) } else { "-".into() };
            let [low, high] = [step, step + 1].map(|k| 100 * k / STEPS);
            // Writing to a string cannot fail.
            let _ = writeln!(
                table,
                "| {low} to {high} % | {} | {} | {} |",
                here.len(),
                percent(believed),
                percent(right)
            );
        }
        table
    }
}
