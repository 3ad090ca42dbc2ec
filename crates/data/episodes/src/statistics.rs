//! Statistics of features: smallest, largest, mean, standard deviation, and five quantiles, all exact.
//!
//! An episode's numbers are sorted in memory ([`of_vectors`]). A dataset's numbers are spooled to a file and selected
//! by their bits, in memory that does not depend on how many there are ([`spool`]). Images have 256 values a channel,
//! so their counts are enough ([`histogram`]).

pub mod histogram;
pub mod moments;
pub mod spool;

use serde_json::{Value, json};

use crate::statistics::moments::Moments;

/// The quantiles that are always given, with the names that LeRobot uses.
pub const QUANTILES: [(&str, f64); 5] =
    [("q01", 0.01), ("q10", 0.10), ("q50", 0.50), ("q90", 0.90), ("q99", 0.99)];

/// The statistics of a feature: one number a dimension.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureStatistics {
    pub count: u64,
    pub min: Vec<f64>,
    pub max: Vec<f64>,
    pub mean: Vec<f64>,
    /// Of the population: over `count`, not `count - 1`.
    pub std: Vec<f64>,
    /// As [`QUANTILES`]; between two ranks by linear interpolation, as numpy does.
    pub quantiles: [Vec<f64>; 5],
}

impl FeatureStatistics {
    /// From moments and quantiles of each dimension.
    pub(crate) fn of_dimensions(dimensions: &[(Moments, [f64; 5])]) -> Self {
        let each = |value: &dyn Fn(&Moments) -> f64| dimensions.iter().map(|(m, _)| value(m)).collect();
        Self {
            count: dimensions.first().map_or(0, |(moments, _)| moments.count),
            min: each(&|moments| moments.min),
            max: each(&|moments| moments.max),
            mean: each(&|moments| moments.mean),
            std: each(&Moments::standard_deviation),
            quantiles: std::array::from_fn(|q| {
                dimensions.iter().map(|(_, quantiles)| quantiles[q]).collect()
            }),
        }
    }

    /// Statistic names with their numbers, in the order of LeRobot.
    pub fn named(&self) -> Vec<(&'static str, &[f64])> {
        let mut named: Vec<(&'static str, &[f64])> =
            vec![("min", &self.min), ("max", &self.max), ("mean", &self.mean), ("std", &self.std)];
        named.extend(
            QUANTILES.iter().zip(&self.quantiles).map(|((name, _), values)| (*name, values.as_slice())),
        );
        named
    }

    /// The statistics as LeRobot's JSON has them; for images, each number is a list in a list, shape (3, 1, 1).
    pub fn to_json(&self, is_image: bool) -> Value {
        let shaped = |values: &[f64]| -> Value {
            values.iter().map(|value| if is_image { json!([[value]]) } else { json!(value) }).collect()
        };
        let mut object: serde_json::Map<String, Value> =
            self.named().into_iter().map(|(name, values)| (name.to_owned(), shaped(values))).collect();
        object.insert("count".to_owned(), json!([self.count]));
        Value::Object(object)
    }
}

/// Statistics of rows with `width` numbers each; at least one row.
pub fn of_vectors(rows: &[f32], width: usize) -> FeatureStatistics {
    let dimension = |d: usize| {
        let mut values: Vec<f32> = rows.iter().skip(d).step_by(width).copied().collect();
        let moments = Moments::of(values.iter().map(|value| f64::from(*value)));
        values.sort_unstable_by(f32::total_cmp);
        let quantile = |(_, share): (&str, f64)| {
            interpolated(share, values.len() as u64, |rank| f64::from(values[rank as usize]))
        };
        (moments, QUANTILES.map(quantile))
    };
    FeatureStatistics::of_dimensions(&(0..width).map(dimension).collect::<Vec<_>>())
}

/// Statistics of the whole numbers from `first` on, `count` of them.
pub fn of_consecutive(first: u64, count: u64) -> FeatureStatistics {
    let (first, n) = (first as f64, count as f64);
    let moments = Moments {
        count,
        mean: first + (n - 1.0) / 2.0,
        sum_of_squares: n * (n * n - 1.0) / 12.0,
        min: first,
        max: first + n - 1.0,
    };
    let quantiles = QUANTILES.map(|(_, share)| first + share * (n - 1.0));
    FeatureStatistics::of_dimensions(&[(moments, quantiles)])
}

/// The quantile of `count` numbers, of which `at_rank` gives the one with a rank in ascending order.
pub(crate) fn interpolated(share: f64, count: u64, at_rank: impl Fn(u64) -> f64) -> f64 {
    let [low, high] = ranks(share, count);
    let weight = share * (count - 1) as f64 - low as f64;
    let (below, above) = (at_rank(low), at_rank(high));
    below + (above - below) * weight
}

/// The two ranks beside a quantile.
pub(crate) fn ranks(share: f64, count: u64) -> [u64; 2] {
    let low = (share * (count - 1) as f64).floor() as u64;
    [low, (low + 1).min(count - 1)]
}
