//! Decision: one scale for the image, and for each object the probability of each category, or of none.
//!
//! The score of a candidate is a weighted sum of its evidence: the recognizer's guess, the fit of the mesh, its
//! colors, and its size. The null hypothesis has a score too; it grows with the probability that the recognizer
//! leaves to other categories, with the fit of the primitive, and with the occluded share. Probabilities are the
//! softmax of the scores. The scale of the image may be off, equally for all objects; it is the one of maximum
//! joint likelihood.
//!
//! The weights maximize the likelihood on synthetic images. The threshold of a name was chosen on others.

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
    /// Weight of the recognizer's guess, a logarithm.
    guess: f64,
    /// Weight of the logarithm of the outlines' non-overlapping share.
    mismatch: f64,
    stray: f64,
    /// Weight of the logarithm of the color variance that the mesh leaves, relative to the ramp.
    unexplained: f64,
    off_palette: f64,
    /// Weight of the squared logarithm of an atypical size.
    odd_size: f64,
    /// Score of the null hypothesis: a constant, and the weights of what the recognizer leaves to others, of the
    /// primitive's misfit, of the occluded outline, and of the size in the image.
    none: [f64; 5],
}

const WEIGHTS: Weights = Weights {
    guess: 0.78,
    mismatch: -1.17,
    stray: -0.32,
    unexplained: -2.68,
    off_palette: -0.05,
    odd_size: -0.5,
    none: [0.67, 0.83, -0.17, 0.73, 0.11],
};

/// Range and step of the scales, natural logarithm, and the standard deviation of a scale.
const SCALES: [f64; 3] = [-0.8, 0.8, 0.05];
const SCALE_SIGMA: f64 = 0.35;

/// Minimum number of named objects that agree on a scale, and their tolerance (natural logarithm).
const MIN_VOTES: usize = 3;
const VOTES_WITHIN: f64 = 0.15;

/// Assigns the likely categories. `allowed` filters them by object index and category name.
pub fn assign_categories(
    evidence: &[ObjectEvidence],
    settings: &CategoryFitSettings,
    allowed: impl Fn(usize, &str) -> bool,
) -> Naming {
    let likelihood = |log_scale: f64| evidence.iter().map(|found| log_sum(found, log_scale)).sum::<f64>();
    let tried = scales().map(|(scale, prior)| (likelihood(scale) + prior, scale));
    let log_scale = tried.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, scale)| scale);
    let objects: Vec<Option<CategoryAssignment>> = evidence
        .iter()
        .enumerate()
        .map(|(object, found)| {
            let scored = found.matches.iter().map(|candidate| (score(candidate, log_scale), candidate));
            let (best, candidate) = scored.max_by(|a, b| a.0.total_cmp(&b.0))?;
            let confidence = (best - log_sum(found, log_scale)).exp();
            // An object that is most likely what it cannot be stays without a name.
            let is_named = confidence >= settings.min_confidence && allowed(object, candidate.category);
            is_named.then(|| CategoryAssignment { category_match: candidate.clone(), confidence })
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
pub(super) fn log_sum(found: &ObjectEvidence, log_scale: f64) -> f64 {
    let none = none_score(found);
    let scores: Vec<f64> = found.matches.iter().map(|candidate| score(candidate, log_scale)).collect();
    let highest = scores.iter().copied().fold(none, f64::max);
    highest + (scores.iter().map(|score| (score - highest).exp()).sum::<f64>() + (none - highest).exp()).ln()
}

/// Logarithm of the deficit to a full overlap.
fn mismatch(overlap: f64) -> f64 {
    ((1.0 - overlap).max(0.0) + 0.02).ln()
}

/// The score of a guess of the recognizer.
pub(super) fn score(candidate: &CategoryMatch, log_scale: f64) -> f64 {
    WEIGHTS.guess * candidate.log_guess + score_of_fit(candidate, log_scale)
}

/// The part of the score that shape, colors and size give.
pub(super) fn score_of_fit(candidate: &CategoryMatch, log_scale: f64) -> f64 {
    let odd = ((candidate.oversize - log_scale).abs() - candidate.usual_spread).max(0.0);
    let unexplained = ((1.0 - candidate.by_mesh + 0.05) / (1.0 - candidate.by_ramp + 0.05)).ln();
    let by_shape = if candidate.is_fitted {
        WEIGHTS.mismatch * mismatch(candidate.overlap)
            + WEIGHTS.stray * candidate.stray
            + WEIGHTS.unexplained * unexplained
            + WEIGHTS.off_palette * candidate.off_palette
    } else {
        // The fitted weight of a missing fit was 0.1 of a logarithm.
        0.0
    };
    by_shape + WEIGHTS.odd_size * odd.powi(2)
}

fn none_score(found: &ObjectEvidence) -> f64 {
    let size = (found.area_cells * found.cell_px.powi(2)).max(1.0).ln();
    let [constant, other, solid, hidden, large] = WEIGHTS.none;
    constant
        + other * found.log_other
        + solid * mismatch(found.solid_overlap)
        + hidden * found.hidden_rim
        + large * size
}
