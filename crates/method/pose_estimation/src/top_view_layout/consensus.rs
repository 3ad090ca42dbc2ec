//! One scale from many objects that contradict each other.
//!
//! Each object that may, votes: `ln sqrt(w h / A_px)`, the logarithm of the scale at which its commonsense
//! size fills its box. Votes scatter because sizes are guesses (`size_spread`) and because boxes and meshes
//! are inexact (`box_spread`). The aspect ratios tell these apart: a wrong size leaves a box's shape as it
//! is, a wrong box does not. With `a_i = ln r_phys - ln r_img` and independent errors of the sides,
//! `std(a_i) = sqrt(2) std(side)` and a vote moves by `std(side) / sqrt(2) = std(a_i) / 2`.
//!
//! The scale is Huber's M-estimate of location (Huber 1964, `k = 1.5`) started at the weighted median, with
//! votes weighted by the paper's believability of their shape, `1 / (1 + (e / tau)^2)`. Scatter is measured
//! by the median absolute deviation. Beyond the paper, which takes one vote: with `n` votes of one object's
//! scatter `s`, the error is about `s / sqrt(n)` instead of `s`, and one wrong size does no harm.
//!
//! Exact where votes agree; up to half of the votes may be arbitrarily wrong. Not for one or two votes: with
//! fewer than three nothing tells how far they scatter, and the spreads are what the settings expect.

use serde::{Deserialize, Serialize};

/// The vote of one object on the scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vote {
    /// `ln` of meters per pixel.
    pub log_alpha: f64,
    /// `ln r_phys - ln r_img`.
    pub log_aspect_error: f64,
    /// Share of a full vote, above 0.
    pub weight: f64,
}

/// The consensus of the votes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Consensus {
    /// `ln` of meters per pixel.
    pub log_alpha: f64,
    /// Standard error of `log_alpha`.
    pub log_alpha_error: f64,
    /// Standard deviation of the logarithm of a commonsense size about the true one.
    pub size_spread: f64,
    /// Standard deviation of a vote by its box's and mesh's shape alone.
    pub box_spread: f64,
}

/// Votes further off than this many standard deviations pull no harder.
const HUBER_K: f64 = 1.5;
/// Standard deviation of a normal distribution over its median absolute deviation.
const NORMAL_OVER_MAD: f64 = 1.4826;
/// Minimum number of votes from which scatter is measured.
const TELLING_VOTES: usize = 3;
/// Rounds of reweighting; a handful settles.
const ROUNDS: usize = 30;

/// The votes' consensus, `None` without votes. `expected_size_spread` is used if too few votes determine the spread of
/// sizes.
pub fn consensus(votes: &[Vote], expected_size_spread: f64) -> Option<Consensus> {
    let weighted = |of: &dyn Fn(&Vote) -> f64| -> Vec<(f64, f64)> {
        votes.iter().map(|vote| (of(vote), vote.weight)).collect()
    };
    let start = weighted_median(weighted(&|vote| vote.log_alpha))?;
    let telling = votes.len() >= TELLING_VOTES;
    let box_spread = match telling {
        // A vote moves by half of the deviation of the aspect errors (module documentation).
        true => 0.5 * NORMAL_OVER_MAD * weighted_median(weighted(&|vote| vote.log_aspect_error.abs()))?,
        false => 0.0,
    };
    let scatter = match telling {
        true => NORMAL_OVER_MAD * weighted_median(weighted(&|vote| (vote.log_alpha - start).abs()))?,
        false => expected_size_spread,
    };
    let size_spread = (scatter * scatter - box_spread * box_spread).max(0.0).sqrt();
    let mut log_alpha = start;
    let mut total = 0.0;
    for _ in 0..ROUNDS {
        let pull = |vote: &Vote| {
            let off = (vote.log_alpha - log_alpha).abs();
            vote.weight * if off > HUBER_K * scatter { HUBER_K * scatter / off } else { 1.0 }
        };
        total = votes.iter().map(pull).sum();
        if total <= 0.0 {
            // All votes but the median's scatter count for nothing: they agree to the bit or not at all.
            break;
        }
        log_alpha = votes.iter().map(|vote| pull(vote) * vote.log_alpha).sum::<f64>() / total;
    }
    let log_alpha_error = scatter / total.max(1.0).sqrt();
    Some(Consensus { log_alpha, log_alpha_error, size_spread, box_spread })
}

/// Weighted median: the value below and above which lies half of the weight; the midpoint of two if they share it.
fn weighted_median(mut values: Vec<(f64, f64)>) -> Option<f64> {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * values.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut below = 0.0;
    for (index, (value, weight)) in values.iter().enumerate() {
        below += weight;
        if below > half {
            return Some(*value);
        }
        if below == half {
            return Some(values.get(index + 1).map_or(*value, |(next, _)| 0.5 * (value + next)));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vote(log_alpha: f64, log_aspect_error: f64) -> Vote {
        Vote { log_alpha, log_aspect_error, weight: 1.0 }
    }

    #[test]
    fn weighted_median_matches_manual_values() {
        assert_eq!(weighted_median(vec![(3.0, 1.0), (1.0, 1.0), (2.0, 1.0)]), Some(2.0));
        assert_eq!(weighted_median(vec![(4.0, 1.0), (1.0, 1.0)]), Some(2.5));
        assert_eq!(weighted_median(vec![(1.0, 1.0), (2.0, 1.0), (9.0, 5.0)]), Some(9.0));
        assert_eq!(weighted_median(Vec::new()), None);
    }

    #[test]
    fn consensus_of_no_vote_and_of_one_vote() {
        assert_eq!(consensus(&[], 0.1), None);
        let alone = consensus(&[vote(-6.0, 0.3)], 0.1).expect("a vote");
        assert_eq!((alone.log_alpha, alone.log_alpha_error, alone.size_spread), (-6.0, 0.1, 0.1));
    }

    #[test]
    fn consensus_ignores_one_wrong_vote() {
        let mut votes = vec![vote(-6.5, 0.0); 6];
        votes.push(vote(-5.5, 0.0));
        let agreed = consensus(&votes, 0.1).expect("votes");
        assert!((agreed.log_alpha + 6.5).abs() < 1e-9 && agreed.size_spread < 1e-9, "{agreed:?}");
    }

    proptest! {
        /// A third of the votes may be anywhere; the others hold the scale within their own scatter.
        #[test]
        fn consensus_tolerates_a_third_of_outliers(
            honest in proptest::collection::vec(-0.05..0.05_f64, 8..20),
            liars in proptest::collection::vec(-3.0..3.0_f64, 0..4),
        ) {
            let votes: Vec<Vote> = honest.iter().chain(&liars).map(|off| vote(-6.0 + off, 0.0)).collect();
            let agreed = consensus(&votes, 0.1).expect("votes");
            prop_assert!((agreed.log_alpha + 6.0).abs() < 0.08, "{agreed:?}");
        }
    }
}
