//! From evidence to names: one scale for the picture, and for each thing how likely each category is, or none of them.
//!
//! A candidate's score is a weighted sum of what was measured; that none of the candidates is right has a score too, which
//! grows where a simple solid does as well, where much is hidden, and where shapes of all kinds fit. Probabilities are
//! proportional to the exponentials of the scores. The picture's scale may be off, in the same way for all things: it is the
//! one under which everything together is most likely.
//!
//! The weights maximize the likelihood of what was painted in pictures of the training split, half of the time with
//! the thing's own category left out, a fit that was made once; the probability from which a name is given was chosen on
//! those of the validation split.

use super::{CategoryFitSettings, CategoryLook, ThingEvidence};

/// A thing that has a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    pub look: CategoryLook,
    /// Probability that this is its category, 0..1.
    pub confidence: f64,
}

/// Names of a picture's things.
#[derive(Clone, Debug, PartialEq)]
pub struct Naming {
    /// One for each thing; `None` where no category is likely enough.
    pub things: Vec<Option<Named>>,
    /// Factor that brings the picture's lengths to what the named things usually measure; `None` where they are too few or
    /// disagree.
    pub scale: Option<f64>,
}

/// Weights of a candidate's score.
struct Weights {
    /// Of the logarithm of the share of the outlines that does not overlap.
    apart: f64,
    first_apart: f64,
    stray: f64,
    /// Of the logarithm of the share of the colors' variance that the mesh leaves, against that of a ramp.
    unexplained: f64,
    off_palette: f64,
    /// Of the squared logarithm of a size out of the usual.
    odd_size: f64,
    /// Score of none: a constant, and what the solid's lack, the hidden rim, the size in the picture, and the lack of the
    /// candidates after the best add.
    none: [f64; 5],
}

const WEIGHTS: Weights = Weights {
    apart: -5.88,
    first_apart: -0.68,
    stray: -0.88,
    unexplained: -6.94,
    off_palette: -0.07,
    odd_size: -4.12,
    none: [4.97, -0.29, 2.47, 0.02, -5.04],
};

/// Scales that are tried, natural logarithm, and how far off a scale usually is.
const SCALES: [f64; 3] = [-0.8, 0.8, 0.05];
const SCALE_SIGMA: f64 = 0.35;

/// Named things that must agree on a scale, and within how much (natural logarithm).
const LEAST_VOTES: usize = 3;
const VOTES_WITHIN: f64 = 0.15;

/// Names what is likely enough. `allowed` leaves categories out: it is asked with the index of a thing and a category.
pub fn names(
    evidence: &[ThingEvidence],
    settings: &CategoryFitSettings,
    allowed: impl Fn(usize, &str) -> bool,
) -> Naming {
    let candidates: Vec<Vec<&CategoryLook>> = evidence
        .iter()
        .enumerate()
        .map(|(thing, found)| found.looks.iter().filter(|look| allowed(thing, look.category)).collect())
        .collect();
    let likelihood = |log_scale: f64| {
        let all = evidence.iter().zip(&candidates).map(|(found, looks)| log_sum(found, looks, log_scale));
        all.sum::<f64>() - 0.5 * (log_scale / SCALE_SIGMA).powi(2)
    };
    let [from, to, step] = SCALES;
    let steps = ((to - from) / step).round() as u32;
    let tried = (0..=steps).map(|k| from + f64::from(k) * step).map(|scale| (likelihood(scale), scale));
    let log_scale = tried.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, scale)| scale);
    let things: Vec<Option<Named>> = evidence
        .iter()
        .zip(&candidates)
        .map(|(found, looks)| {
            let sum = log_sum(found, looks, log_scale);
            let best = looks
                .iter()
                .map(|look| (score(look, log_scale), *look))
                .max_by(|a, b| a.0.total_cmp(&b.0))?;
            let confidence = (best.0 - sum).exp();
            (confidence >= settings.least_confidence).then(|| Named { look: best.1.clone(), confidence })
        })
        .collect();
    let scale = vote(&things);
    Naming { things, scale }
}

/// The median of what the named things say of the scale, if they agree.
fn vote(things: &[Option<Named>]) -> Option<f64> {
    let mut votes: Vec<f64> = things.iter().flatten().map(|named| named.look.oversize).collect();
    votes.sort_by(f64::total_cmp);
    let median = *votes.get(votes.len() / 2)?;
    let near = votes.iter().filter(|vote| (**vote - median).abs() <= VOTES_WITHIN).count();
    (near >= LEAST_VOTES && 3 * near >= 2 * votes.len()).then(|| (-median).exp())
}

/// Logarithm of the sum of the exponentials of all scores, that of none among them.
fn log_sum(found: &ThingEvidence, looks: &[&CategoryLook], log_scale: f64) -> f64 {
    let none = none_score(found, looks);
    let scores: Vec<f64> = looks.iter().map(|look| score(look, log_scale)).collect();
    let most = scores.iter().copied().fold(none, f64::max);
    most + (scores.iter().map(|score| (score - most).exp()).sum::<f64>() + (none - most).exp()).ln()
}

/// Logarithm of what is missing to a full overlap.
fn apart(overlap: f64) -> f64 {
    ((1.0 - overlap).max(0.0) + 0.02).ln()
}

fn score(look: &CategoryLook, log_scale: f64) -> f64 {
    let unexplained = ((1.0 - look.by_mesh + 0.05) / (1.0 - look.by_ramp + 0.05)).ln();
    let odd = ((look.oversize - log_scale).abs() - look.usual_spread).max(0.0);
    WEIGHTS.apart * apart(look.overlap)
        + WEIGHTS.first_apart * apart(look.first_overlap)
        + WEIGHTS.stray * look.stray
        + WEIGHTS.unexplained * unexplained
        + WEIGHTS.off_palette * look.off_palette
        + WEIGHTS.odd_size * odd.powi(2)
}

fn none_score(found: &ThingEvidence, looks: &[&CategoryLook]) -> f64 {
    let mut others: Vec<f64> = looks.iter().map(|look| look.overlap).collect();
    others.sort_by(|a, b| b.total_cmp(a));
    let others: Vec<f64> = others.into_iter().skip(1).take(5).collect();
    let others_apart = apart(others.iter().sum::<f64>() / others.len().max(1) as f64);
    let size = (found.area_cells * found.cell_px.powi(2)).max(1.0).ln();
    let [constant, solid, hidden, large, crowd] = WEIGHTS.none;
    constant
        + solid * apart(found.solid_overlap)
        + hidden * found.hidden_rim
        + large * size
        + crowd * others_apart
}
