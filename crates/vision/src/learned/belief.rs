//! How much a region is believed to be one whole thing: logistic regression on ten measures of it.
//!
//! `training/belief.py` fits it to regions of painted pictures of the validation split (`tabletopgen evaluate --set
//! regions`), of which it is known whether they overlap a thing by more than one half.

/// What is measured of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// Logarithm of its share of the map.
    pub log_area: f64,
    /// Mean probability of a thing, 0..1.
    pub object: f64,
    /// How far its mean vote lies from its middle, in roots of its area.
    pub vote_off: f64,
    /// Share of its rim along which other regions are.
    pub rim_shared: f64,
    /// Mean border along which its two parts were joined, 0 where it has none.
    pub joined_at: f64,
    /// Mean border along which it is joined with the next, [`NEVER_JOINED`] where it is not.
    pub joins_at: f64,
    /// Share of the box around it.
    pub fill: f64,
    /// How much its mean vote is the middle of a thing, about 0..1.
    pub center_at_vote: f64,
    /// Length of its rim, in roots of its area.
    pub rim_length: f64,
    /// Share it has of the places that vote for the middle that most of its own vote for.
    pub complete: f64,
}

/// A border that nothing is joined across.
pub(crate) const NEVER_JOINED: f64 = 1.5;

/// Of a measure: its mean and spread over the regions that were fitted, and what the number of spreads above the mean, and
/// its square, add to the logarithm of the odds.
struct Term {
    mean: f64,
    spread: f64,
    first: f64,
    second: f64,
}

const fn term(mean: f64, spread: f64, first: f64, second: f64) -> Term {
    Term { mean, spread, first, second }
}

/// Measures farther out count as if they were this many spreads off.
const FARTHEST: f64 = 4.0;

const AT_THE_MEANS: f64 = -4.1771;
#[allow(clippy::approx_constant, reason = "a fitted number may come close to any")]
const TERMS: [Term; Measures::COUNT] = [
    term(-5.8997, 1.7912, 2.0507, -0.5379),
    term(0.8648, 0.0979, 0.5668, -0.1415),
    term(1.3540, 2.0523, -3.3843, 1.1036),
    term(0.5092, 0.3089, -0.8978, 0.1221),
    term(0.2261, 0.2504, 0.3389, -0.1525),
    term(0.3652, 0.3411, -0.5532, 0.1727),
    term(0.6178, 0.1717, 0.1223, 0.1249),
    term(0.3927, 0.2604, 0.6252, 0.1269),
    term(6.0374, 1.6377, -0.1624, -0.0834),
    term(0.4505, 0.3877, 0.6726, -0.0697),
];

impl Measures {
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

    /// Probability that the region overlaps a thing by more than one half.
    pub fn belief(&self) -> f64 {
        let add = |log_odds: f64, (value, term): (f64, &Term)| {
            let off = ((value - term.mean) / term.spread).clamp(-FARTHEST, FARTHEST);
            log_odds + term.first * off + term.second * off * off
        };
        let log_odds = self.values().into_iter().zip(&TERMS).fold(AT_THE_MEANS, add);
        1.0 / (1.0 + (-log_odds).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A compact region of 400 of 46,080 places with the middle that all of it vote for.
    const CLEAR: Measures = Measures {
        log_area: -4.75,
        object: 0.97,
        vote_off: 0.05,
        rim_shared: 0.1,
        joined_at: 0.05,
        joins_at: NEVER_JOINED,
        fill: 0.75,
        center_at_vote: 0.9,
        rim_length: 4.5,
        complete: 1.0,
    };

    #[test]
    fn what_speaks_against_a_region_lessens_the_belief_in_it() {
        let clear = CLEAR.belief();
        assert!(clear > 0.95, "{clear}");
        let worse = [
            ("small", Measures { log_area: -7.5, ..CLEAR }),
            ("hardly a thing", Measures { object: 0.6, ..CLEAR }),
            ("votes for elsewhere", Measures { vote_off: 1.0, ..CLEAR }),
            ("surrounded", Measures { rim_shared: 0.9, ..CLEAR }),
            ("no middle there", Measures { center_at_vote: 0.05, ..CLEAR }),
            ("part of what votes so", Measures { complete: 0.2, ..CLEAR }),
        ];
        for (what, measures) in worse {
            assert!(measures.belief() < clear - 0.005, "{what}: {} for {clear}", measures.belief());
        }
        let sliver = Measures { log_area: -7.5, vote_off: 2.5, rim_shared: 0.8, complete: 0.1, ..CLEAR };
        assert!(sliver.belief() < 0.05, "{}", sliver.belief());
    }

    #[test]
    fn every_measure_has_its_name_and_its_term() {
        assert_eq!(
            CLEAR.values()[Measures::NAMES.iter().position(|name| *name == "fill").expect("named")],
            0.75
        );
        assert!(TERMS.iter().all(|term| term.spread > 0.0));
    }
}
