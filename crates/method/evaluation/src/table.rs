//! The result of an evaluation: a row per scene and the means over scenes, as a document, as CSV and as a page.
//!
//! The columns are those of the paper's tables, without ratings: best and mean view by LPIPS, DINOv2 and CLIP, and
//! Col_O, Col_S, SS and DSS. Numbers that do not exist are empty cells, and a sentence below the
//! table of the page names the missing file.

mod csv;
mod page;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use vision::lpips::LpipsNetwork;

use crate::perceptual_models::Metric;
use crate::physical::{PhysicalRates, ScenePhysics};
use crate::scores::{MetricOutcome, SceneScores};
use crate::sweep::Sweep;

/// Results of all scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EvaluationTable {
    /// `tabletopgen-evaluation/1`.
    #[schemars(extend("const" = Self::FORMAT))]
    pub format: String,
    pub protocol: Protocol,
    pub scenes: Vec<SceneRow>,
    pub means: Means,
}

/// Choices that the paper leaves open. Scores with different ones are not comparable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Protocol {
    /// Number of views of each scene.
    pub views: usize,
    /// Along the shorter side of a view, degrees.
    pub field_of_view_deg: f64,
    /// Longest side of a view, pixels.
    pub longest_side_px: u32,
    /// Network of LPIPS, as torchvision names it.
    pub lpips_network: String,
    /// Files of weights that were there, in the order in which they were read.
    pub weights: Vec<UsedWeights>,
}

/// A file of weights.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct UsedWeights {
    /// Path below the folder of weights.
    #[schemars(length(min = 1))]
    pub file: String,
    /// SHA-256 of its content, hexadecimal.
    pub sha256: String,
}

/// Results of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SceneRow {
    /// Name of the scene, unique in the table.
    #[schemars(length(min = 1))]
    pub scene: String,
    /// null for a scene without a reference image of its own, as one that was made from a text.
    pub scores: Option<SceneScores>,
    pub physics: ScenePhysics,
}

/// Means over scenes, each over those that have the number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Means {
    pub lpips: Option<MetricMeans>,
    pub dinov2: Option<MetricMeans>,
    pub clip: Option<MetricMeans>,
    /// null without scenes.
    pub physics: Option<PhysicalRates>,
}

/// Means of one metric over scenes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MetricMeans {
    /// Number of scenes that have scores.
    #[schemars(range(min = 1))]
    pub scenes: usize,
    /// Mean of the best views' scores, column "B" of the paper.
    pub best: f64,
    /// Mean of the means over views, column "M" of the paper.
    pub mean: f64,
}

impl EvaluationTable {
    /// Name of the format and its version.
    pub const FORMAT: &str = "tabletopgen-evaluation/1";

    /// The table of these rows, whose LPIPS is that of the network, by these weights.
    pub fn new(scenes: Vec<SceneRow>, network: LpipsNetwork, weights: Vec<UsedWeights>) -> Self {
        let means = Means {
            lpips: MetricMeans::over(&scenes, Metric::Lpips),
            dinov2: MetricMeans::over(&scenes, Metric::Dinov2),
            clip: MetricMeans::over(&scenes, Metric::Clip),
            physics: PhysicalRates::over(scenes.iter().map(|row| &row.physics)),
        };
        let protocol = Protocol {
            views: Sweep::views().count(),
            field_of_view_deg: Sweep::FIELD_OF_VIEW_DEG,
            longest_side_px: Sweep::LONGEST_SIDE_PX,
            lpips_network: network.name().to_owned(),
            weights,
        };
        Self { format: Self::FORMAT.to_owned(), protocol, scenes, means }
    }

    /// The table as CSV (RFC 4180): a header, a line per scene, and a last line `mean`.
    pub fn csv(&self) -> String {
        csv::text(self)
    }

    /// The table as a self-contained page without scripts.
    pub fn html(&self) -> String {
        page::text(self)
    }

    /// Metrics without scores for lack of weights, each with the missing file.
    pub fn missing(&self) -> Vec<(Metric, &str)> {
        let mut missing = Vec::new();
        for metric in Metric::ALL {
            let file = self.scenes.iter().find_map(|row| match row.scores.as_ref()?.of(metric) {
                MetricOutcome::MissingWeights(missing) => Some(missing.file.as_str()),
                MetricOutcome::Measured(_) => None,
            });
            missing.extend(file.map(|file| (metric, file)));
        }
        missing
    }
}

impl Means {
    /// Means by a metric; `None` if no scene has scores by it.
    pub fn of(&self, metric: Metric) -> Option<&MetricMeans> {
        match metric {
            Metric::Lpips => self.lpips.as_ref(),
            Metric::Dinov2 => self.dinov2.as_ref(),
            Metric::Clip => self.clip.as_ref(),
        }
    }
}

impl MetricMeans {
    /// Means over the rows that have scores; `None` if none has.
    fn over(rows: &[SceneRow], metric: Metric) -> Option<Self> {
        let scores: Vec<_> =
            rows.iter().filter_map(|row| row.scores.as_ref()?.of(metric).measured()).collect();
        let scenes = scores.len();
        let mean = |total: f64| total / scenes as f64;
        (scenes > 0).then(|| Self {
            scenes,
            best: mean(scores.iter().map(|scores| scores.best.score).sum()),
            mean: mean(scores.iter().map(|scores| scores.mean).sum()),
        })
    }
}

#[cfg(test)]
mod tests;
