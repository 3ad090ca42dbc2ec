//! Objectness score of a candidate region: logistic regression on ten region features, P(IoU > 0.5).
//!
//! `training/region_score.py` fits the coefficients to candidate regions of synthetic validation images, whose overlap
//! with the true objects is known (`tabletopgen-lab evaluate --set regions`).

/// Features of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionFeatures {
    /// Logarithm of its share of the map.
    pub log_area: f64,
    /// Mean object probability, 0..1.
    pub object: f64,
    /// Distance of its mean center vote from its centroid, in square roots of its area.
    pub vote_off: f64,
    /// Share of its boundary that other regions adjoin.
    pub rim_shared: f64,
    /// Mean border strength along which its two parts were merged; 0 for a superpixel.
    pub joined_at: f64,
    /// Mean border strength along which it was merged into its parent; [`NEVER_MERGED`] for a root.
    pub joins_at: f64,
    /// Share of its bounding box.
    pub fill: f64,
    /// Center score at its mean vote, about 0..1.
    pub center_at_vote: f64,
    /// Length of its boundary, in square roots of its area.
    pub rim_length: f64,
    /// Share of its majority group's cells that it holds.
    pub complete: f64,
}

/// Border strength of a region without a parent.
pub(crate) const NEVER_MERGED: f64 = 1.5;

/// Term of a feature: mean and standard deviation over the fitted regions, and the coefficients of the
/// standardized feature and of its square.
struct Term {
    mean: f64,
    std_dev: f64,
    linear: f64,
    quadratic: f64,
}

const fn term(mean: f64, std_dev: f64, linear: f64, quadratic: f64) -> Term {
    Term { mean, std_dev, linear, quadratic }
}

/// Standardized features are clamped to this magnitude: beyond the fitted range the quadratic terms would decide alone.
const MAX_Z_SCORE: f64 = 4.0;

const INTERCEPT: f64 = -4.2046;
#[allow(clippy::approx_constant, reason = "a fitted number may come close to any")]
const TERMS: [Term; RegionFeatures::COUNT] = [
    term(-5.8526, 1.9176, 1.8546, -0.5159),
    term(0.8369, 0.1046, 0.9929, -0.1133),
    term(1.5419, 2.3370, -3.8274, 1.1542),
    term(0.4597, 0.2978, -0.7931, 0.0139),
    term(0.1973, 0.2358, 0.1200, -0.1427),
    term(0.3332, 0.3427, -0.1132, 0.0039),
    term(0.6187, 0.1732, 0.1097, 0.1808),
    term(0.4007, 0.2592, 0.4431, 0.1338),
    term(6.0413, 1.7259, -0.1641, -0.0437),
    term(0.4455, 0.3962, 0.5117, 0.3723),
];

impl RegionFeatures {
    pub const COUNT: usize = 10;
    /// In the order of [`Self::values`].
    pub const NAMES: [&str; Self::COUNT] = [
        "log_area",
        "object",
        "vote_off",
        "rim_shared",
        "joined_at",
        "joins_at",
        "fill",
        "center_at_vote",
        "rim_length",
        "complete",
    ];

    pub fn values(&self) -> [f64; Self::COUNT] {
        [
            self.log_area,
            self.object,
            self.vote_off,
            self.rim_shared,
            self.joined_at,
            self.joins_at,
            self.fill,
            self.center_at_vote,
            self.rim_length,
            self.complete,
        ]
    }

    /// Probability that the region overlaps an object by more than one half.
    pub fn score(&self) -> f64 {
        let add = |log_odds: f64, (value, term): (f64, &Term)| {
            let off = ((value - term.mean) / term.std_dev).clamp(-MAX_Z_SCORE, MAX_Z_SCORE);
            log_odds + term.linear * off + term.quadratic * off * off
        };
        let log_odds = self.values().into_iter().zip(&TERMS).fold(INTERCEPT, add);
        1.0 / (1.0 + (-log_odds).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A compact region of 400 of 46,080 cells with one common center vote.
    const CLEAR: RegionFeatures = RegionFeatures {
        log_area: -4.75,
        object: 0.97,
        vote_off: 0.05,
        rim_shared: 0.1,
        joined_at: 0.05,
        joins_at: NEVER_MERGED,
        fill: 0.75,
        center_at_vote: 0.9,
        rim_length: 4.5,
        complete: 1.0,
    };

    #[test]
    fn unfavorable_features_lower_score() {
        let clear = CLEAR.score();
        assert!(clear > 0.95, "{clear}");
        let worse = [
            ("small", RegionFeatures { log_area: -7.5, ..CLEAR }),
            ("hardly a thing", RegionFeatures { object: 0.6, ..CLEAR }),
            ("votes for elsewhere", RegionFeatures { vote_off: 1.0, ..CLEAR }),
            ("surrounded", RegionFeatures { rim_shared: 0.9, ..CLEAR }),
            ("no middle there", RegionFeatures { center_at_vote: 0.05, ..CLEAR }),
            ("part of what votes so", RegionFeatures { complete: 0.2, ..CLEAR }),
        ];
        for (what, features) in worse {
            assert!(features.score() < clear - 0.005, "{what}: {} for {clear}", features.score());
        }
        let sliver =
            RegionFeatures { log_area: -7.5, vote_off: 2.5, rim_shared: 0.8, complete: 0.1, ..CLEAR };
        assert!(sliver.score() < 0.05, "{}", sliver.score());
    }

    #[test]
    fn every_feature_has_name_and_term() {
        assert_eq!(
            CLEAR.values()[RegionFeatures::NAMES.iter().position(|name| *name == "fill").expect("named")],
            0.75
        );
        assert!(TERMS.iter().all(|term| term.std_dev > 0.0));
    }
}
