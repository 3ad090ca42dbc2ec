//! Scores of the views of one scene against its reference image.
//!
//! As in the paper: every view is compared with the reference image by LPIPS, DINOv2 and CLIP. Each metric has its own
//! best view, the one with the lowest LPIPS or the highest cosine, and the mean over all views. The best view favors
//! scenes whose faults one camera hides, so tables give both.
//!
//! LPIPS compares at the size of the views ([`Sweep::size_px`]), to which the reference image is resized (bicubic,
//! antialiased). DINOv2 and CLIP resize both images themselves: DINOv2 sees all of them, padded to a square, CLIP the
//! square at their center, as its published preprocessing does.
//!
//! Cost: 160 renderings and 160 passes through each model. Views are computed in parallel, each whole.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use imaging::Image;
use runtime::{CancelFlag, Cancelled};
use vision::NetworkError;
use vision::dinov2::Dinov2Error;
use vision::lpips::{LpipsError, LpipsFeatures};

use crate::perceptual_models::{Metric, MissingWeights, Model, PerceptualModels};
use crate::sweep::{Sweep, SweepView};

/// Scores of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SceneScores {
    pub lpips: MetricOutcome,
    pub dinov2: MetricOutcome,
    pub clip: MetricOutcome,
}

/// Scores by one metric, or the reason why there are none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "status", rename_all = "snake_case")]
pub enum MetricOutcome {
    Measured(MetricScores),
    MissingWeights(MissingWeights),
}

/// Scores of all views by one metric.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MetricScores {
    pub best: BestView,
    /// Mean over all views.
    pub mean: f64,
    /// Score of each view, in the order of the sweep.
    #[schemars(length(min = 1))]
    pub views: Vec<f64>,
}

/// The view that is closest to the reference image; of equal ones the first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BestView {
    #[serde(flatten)]
    pub view: SweepView,
    pub score: f64,
}

/// Reason why a scene has no scores.
#[derive(Debug, thiserror::Error)]
pub enum ScoreError {
    #[error("scoring {image} by LPIPS failed: {source}")]
    Lpips { image: String, source: LpipsError },
    #[error("scoring {image} by DINOv2 failed: {source}")]
    Dinov2 { image: String, source: Dinov2Error },
    #[error("scoring {image} by CLIP failed: {source}")]
    Clip { image: String, source: NetworkError },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SceneScores {
    /// The scores by a metric.
    pub fn of(&self, metric: Metric) -> &MetricOutcome {
        match metric {
            Metric::Lpips => &self.lpips,
            Metric::Dinov2 => &self.dinov2,
            Metric::Clip => &self.clip,
        }
    }
}

impl MetricOutcome {
    /// The scores, if there are any.
    pub fn measured(&self) -> Option<&MetricScores> {
        match self {
            Self::Measured(scores) => Some(scores),
            Self::MissingWeights(_) => None,
        }
    }
}

impl MetricScores {
    /// Best view and mean of the scores of views; `None` without views.
    pub fn of(metric: Metric, scored: &[(SweepView, f64)]) -> Option<Self> {
        let better = |best: BestView, &(view, score): &(SweepView, f64)| {
            if metric.is_better(score, best.score) { BestView { view, score } } else { best }
        };
        let &(view, score) = scored.first()?;
        let best = scored.iter().fold(BestView { view, score }, better);
        let views: Vec<f64> = scored.iter().map(|(_, score)| *score).collect();
        Some(Self { best, mean: views.iter().sum::<f64>() / views.len() as f64, views })
    }
}

/// Scores of a scene of which `image_of` gives the views, at [`Sweep::size_px`] of the reference image. Without any
/// weights no view is rendered. Cancellation is polled at every view and within the models.
///
/// # Errors
///
/// A [`ScoreError`] that names the image and the metric.
pub fn score_views(
    models: &PerceptualModels,
    reference: &Image,
    image_of: impl Fn(&SweepView) -> Image + Sync,
    cancel: &CancelFlag,
) -> Result<SceneScores, ScoreError> {
    let against = Reference::new(models, reference, cancel)?;
    let views: Vec<SweepView> = Sweep::views().collect();
    let mut scores = vec![[None; Metric::ALL.len()]; views.len()];
    if against.is_anything() {
        let score = |view: &SweepView| {
            cancel.check()?;
            against.score(models, &image_of(view), &name_of(view), cancel)
        };
        scores = views.par_iter().map(score).collect::<Result<_, ScoreError>>()?;
    }
    let scores_by = |metric: Metric| {
        let column = Metric::ALL.iter().position(|other| *other == metric).unwrap_or_default();
        let scored = views.iter().zip(&scores).filter_map(|(view, row)| Some((*view, row[column]?)));
        MetricScores::of(metric, &scored.collect::<Vec<_>>())
    };
    Ok(SceneScores {
        lpips: outcome(&models.lpips, scores_by(Metric::Lpips)),
        dinov2: outcome(&models.dinov2, scores_by(Metric::Dinov2)),
        clip: outcome(&models.clip, scores_by(Metric::Clip)),
    })
}

fn outcome<M>(model: &Model<M>, scores: Option<MetricScores>) -> MetricOutcome {
    match (model, scores) {
        (Model::Missing(missing), _) => MetricOutcome::MissingWeights(missing.clone()),
        (Model::Loaded(_), Some(scores)) => MetricOutcome::Measured(scores),
        // A sweep has 160 views, each of which a loaded model scores.
        (Model::Loaded(_), None) => unreachable!("a loaded model scores every view"),
    }
}

/// Name of a view in messages.
fn name_of(view: &SweepView) -> String {
    format!("the view at {} degrees and {} radii", view.elevation_deg, view.distance_radii)
}

/// The reference image as the models see it.
struct Reference {
    lpips: Option<LpipsFeatures>,
    dinov2: Option<Vec<f32>>,
    clip: Option<Vec<f32>>,
}

impl Reference {
    fn new(models: &PerceptualModels, image: &Image, cancel: &CancelFlag) -> Result<Self, ScoreError> {
        let [width_px, height_px] = Sweep::size_px(image);
        let name = "the reference image";
        Ok(Self {
            lpips: match models.lpips.loaded() {
                Some(lpips) => {
                    let features = lpips.features(&vision::resized(image, width_px, height_px), cancel);
                    Some(features.map_err(|source| lpips_error(name, source))?)
                }
                None => None,
            },
            dinov2: dinov2_features(models, image, name, cancel)?,
            clip: clip_features(models, image, name, cancel)?,
        })
    }

    fn is_anything(&self) -> bool {
        self.lpips.is_some() || self.dinov2.is_some() || self.clip.is_some()
    }

    /// Scores of an image in the order of [`Metric::ALL`].
    fn score(
        &self,
        models: &PerceptualModels,
        image: &Image,
        name: &str,
        cancel: &CancelFlag,
    ) -> Result<[Option<f64>; 3], ScoreError> {
        let lpips = match (models.lpips.loaded(), &self.lpips) {
            (Some(lpips), Some(reference)) => {
                let distance = lpips.features(image, cancel).and_then(|own| lpips.distance(reference, &own));
                Some(distance.map_err(|source| lpips_error(name, source))?)
            }
            _ => None,
        };
        let dinov2 = dinov2_features(models, image, name, cancel)?;
        let clip = clip_features(models, image, name, cancel)?;
        let against =
            |reference: &Option<Vec<f32>>, own: Option<Vec<f32>>| Some(cosine(reference.as_deref()?, &own?));
        Ok([lpips, against(&self.dinov2, dinov2), against(&self.clip, clip)])
    }
}

fn dinov2_features(
    models: &PerceptualModels,
    image: &Image,
    name: &str,
    cancel: &CancelFlag,
) -> Result<Option<Vec<f32>>, ScoreError> {
    let features = models.dinov2.loaded().map(|dinov2| dinov2.features(image, cancel)).transpose();
    features.map_err(|source| match source {
        Dinov2Error::Cancelled(cancelled) => cancelled.into(),
        source => ScoreError::Dinov2 { image: name.to_owned(), source },
    })
}

fn clip_features(
    models: &PerceptualModels,
    image: &Image,
    name: &str,
    cancel: &CancelFlag,
) -> Result<Option<Vec<f32>>, ScoreError> {
    let features = models.clip.loaded().map(|clip| clip.features(image, cancel)).transpose();
    features.map_err(|source| match source {
        NetworkError::Cancelled(cancelled) => cancelled.into(),
        source => ScoreError::Clip { image: name.to_owned(), source },
    })
}

fn lpips_error(name: &str, source: LpipsError) -> ScoreError {
    match source {
        LpipsError::Cancelled(cancelled) => cancelled.into(),
        source => ScoreError::Lpips { image: name.to_owned(), source },
    }
}

/// Cosine of two vectors of length 1.
fn cosine(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

#[cfg(test)]
mod tests;
