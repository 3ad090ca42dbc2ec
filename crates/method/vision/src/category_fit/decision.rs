//! Decision: one scale for the image, and for each object the probability of each category, or of none.
//!
//! The score of a candidate is a weighted sum of its evidence. The null hypothesis has a score too; it grows with
//! the fit of the primitive, with the occluded share, and with the number of fitting shapes. Probabilities are the
//! softmax of the scores. The scale of the image may be off, equally for all objects; it is the one of maximum
//! joint likelihood.
//!
//! The weights maximize the likelihood on synthetic training images, with the object's own category left out half
//! of the time. The threshold of a name was chosen on validation images.

use super::{CategoryFitSettings, CategoryMatch, ObjectEvidence};

/// The category assigned to an object.
#[derive(Clone, Debug, PartialEq)]
pub struct CategoryAssignment {
    pub category_match: CategoryMatch,
    /// Probability of the category, 0..1.
    pub confidence: f64,
}

/// Category assignments of an image's objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Naming {
    /// One for each object; `None` if no category is likely enough.
    pub objects: Vec<Option<CategoryAssignment>>,
    /// Factor from the image's lengths to typical sizes of the named objects; `None` if they are too few or
    /// disagree.
    pub scale: Option<f64>,
}

/// Weights of a candidate's score.
struct Weights {
    /// Weight of the logarithm of the outlines' non-overlapping share.
    mismatch: f64,
    first_mismatch: f64,
    stray: f64,
    /// Weight of the logarithm of the color variance that the mesh leaves, relative to the ramp.
    unexplained: f64,
    off_palette: f64,
    /// Weight of the squared logarithm of an atypical size.
    odd_size: f64,
    /// Score of the null hypothesis: a constant, and the weights of the primitive's misfit, the occluded outline,
    /// the size in the image, and the misfit of the runners-up.
    none: [f64; 5],
}

const WEIGHTS: Weights = Weights {
    mismatch: -5.88,
    first_mismatch: -0.68,
    stray: -0.88,
    unexplained: -6.94,
    off_palette: -0.07,
    odd_size: -4.12,
    none: [4.97, -0.29, 2.47, 0.02, -5.04],
};

/// Range and step of the scales, natural logarithm, and the standard deviation of a scale.
const SCALES: [f64; 3] = [-0.8, 0.8, 0.05];
const SCALE_SIGMA: f64 = 0.35;

/// Minimum number of named objects that agree on a scale, and their tolerance (natural logarithm).
const MIN_VOTES: usize = 3;
const VOTES_WITHIN: f64 = 0.15;

/// Assigns the likely categories. `allowed` filters candidates by object index and category name.
pub fn assign_categories(
    evidence: &[ObjectEvidence],
    settings: &CategoryFitSettings,
    allowed: impl Fn(usize, &str) -> bool,
) -> Naming {
    let candidates: Vec<Vec<&CategoryMatch>> = evidence
        .iter()
        .enumerate()
        .map(|(object, found)| {
            found.matches.iter().filter(|candidate| allowed(object, candidate.category)).collect()
        })
        .collect();
    let likelihood = |log_scale: f64| {
        let all = evidence.iter().zip(&candidates).map(|(found, matches)| log_sum(found, matches, log_scale));
        all.sum::<f64>()
    };
    let tried = scales().map(|(scale, prior)| (likelihood(scale) + prior, scale));
    let log_scale = tried.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, scale)| scale);
    let objects: Vec<Option<CategoryAssignment>> = evidence
        .iter()
        .zip(&candidates)
        .map(|(found, matches)| {
            let sum = log_sum(found, matches, log_scale);
            let best = matches
                .iter()
                .map(|candidate| (score(candidate, log_scale), *candidate))
                .max_by(|a, b| a.0.total_cmp(&b.0))?;
            let confidence = (best.0 - sum).exp();
            (confidence >= settings.min_confidence)
                .then(|| CategoryAssignment { category_match: best.1.clone(), confidence })
        })
        .collect();
    let scale = vote(&objects);
    Naming { objects, scale }
}

/// The logarithms of the tried scales, and of their prior probabilities.
pub(super) fn scales() -> impl Iterator<Item = (f64, f64)> {
    let [from, to, step] = SCALES;
    let steps = ((to - from) / step).round() as u32;
    (0..=steps).map(move |k| {
        let log_scale = from + f64::from(k) * step;
        (log_scale, -0.5 * (log_scale / SCALE_SIGMA).powi(2))
    })
}

/// Factor from the image's lengths to typical sizes of the named objects: that of their median, if they agree.
pub fn vote(objects: &[Option<CategoryAssignment>]) -> Option<f64> {
    let mut votes: Vec<f64> = objects.iter().flatten().map(|named| named.category_match.oversize).collect();
    votes.sort_by(f64::total_cmp);
    let median = *votes.get(votes.len() / 2)?;
    let near = votes.iter().filter(|vote| (**vote - median).abs() <= VOTES_WITHIN).count();
    (near >= MIN_VOTES && 3 * near >= 2 * votes.len()).then(|| (-median).exp())
}

/// Log-sum-exp of all scores, including the null hypothesis.
pub(super) fn log_sum(found: &ObjectEvidence, matches: &[&CategoryMatch], log_scale: f64) -> f64 {
    let none = none_score(found, matches);
    let scores: Vec<f64> = matches.iter().map(|candidate| score(candidate, log_scale)).collect();
    let highest = scores.iter().copied().fold(none, f64::max);
    highest + (scores.iter().map(|score| (score - highest).exp()).sum::<f64>() + (none - highest).exp()).ln()
}

/// Logarithm of the deficit to a full overlap.
fn mismatch(overlap: f64) -> f64 {
    ((1.0 - overlap).max(0.0) + 0.02).ln()
}

pub(super) fn score(candidate: &CategoryMatch, log_scale: f64) -> f64 {
    let unexplained = ((1.0 - candidate.by_mesh + 0.05) / (1.0 - candidate.by_ramp + 0.05)).ln();
    let odd = ((candidate.oversize - log_scale).abs() - candidate.usual_spread).max(0.0);
    WEIGHTS.mismatch * mismatch(candidate.overlap)
        + WEIGHTS.first_mismatch * mismatch(candidate.first_overlap)
        + WEIGHTS.stray * candidate.stray
        + WEIGHTS.unexplained * unexplained
        + WEIGHTS.off_palette * candidate.off_palette
        + WEIGHTS.odd_size * odd.powi(2)
}

fn none_score(found: &ObjectEvidence, matches: &[&CategoryMatch]) -> f64 {
    let mut others: Vec<f64> = matches.iter().map(|candidate| candidate.overlap).collect();
    others.sort_by(|a, b| b.total_cmp(a));
    let others: Vec<f64> = others.into_iter().skip(1).take(5).collect();
    let others_mismatch = mismatch(others.iter().sum::<f64>() / others.len().max(1) as f64);
    let size = (found.area_cells * found.cell_px.powi(2)).max(1.0).ln();
    let [constant, solid, hidden, large, crowd] = WEIGHTS.none;
    constant
        + solid * mismatch(found.solid_overlap)
        + hidden * found.hidden_rim
        + large * size
        + crowd * others_mismatch
}
