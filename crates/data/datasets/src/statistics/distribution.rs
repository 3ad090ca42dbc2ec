//! The distribution of a quantity: summary and histogram.

use serde::{Deserialize, Serialize};

/// Summary and histogram of values. Without values the summary is absent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// `1` for fractions.
    pub unit: String,
    pub count: usize,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub mean: Option<f64>,
    /// Of an even number of values, the mean of the two central ones.
    pub median: Option<f64>,
    /// Bin `k` holds values from `edges[k]` up to, not including, `edges[k + 1]`. Smaller values are in the first bin,
    /// larger ones in the last.
    pub edges: Vec<f64>,
    pub counts: Vec<usize>,
}

impl Distribution {
    /// The distribution over bins with these edges.
    pub fn of(unit: &str, edges: &[f64], mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let bins = edges.len().saturating_sub(1);
        let mut counts = vec![0; bins];
        for value in &values {
            let bin = edges.partition_point(|edge| edge <= value).saturating_sub(1);
            if let Some(last) = bins.checked_sub(1) {
                counts[bin.min(last)] += 1;
            }
        }
        let count = values.len();
        let median = match count {
            0 => None,
            _ if count % 2 == 1 => Some(values[count / 2]),
            _ => Some((values[count / 2 - 1] + values[count / 2]) / 2.0),
        };
        Self {
            unit: unit.to_owned(),
            count,
            min: values.first().copied(),
            max: values.last().copied(),
            mean: (count > 0).then(|| values.iter().sum::<f64>() / count as f64),
            median,
            edges: edges.to_vec(),
            counts,
        }
    }

    /// The distribution of whole numbers, one bin for each from the smallest to the largest.
    pub fn of_integers(unit: &str, values: Vec<usize>) -> Self {
        let edges: Vec<f64> = match (values.iter().min(), values.iter().max()) {
            (Some(min), Some(max)) => (*min..=max + 1).map(|edge| edge as f64).collect(),
            _ => Vec::new(),
        };
        Self::of(unit, &edges, values.into_iter().map(|value| value as f64).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_counted_in_half_open_bins_and_outliers_in_the_outer_ones() {
        let distribution = Distribution::of("m", &[1.0, 2.0, 4.0], vec![4.0, 0.5, 2.0, 1.0, 9.0]);
        assert_eq!(distribution.counts, [2, 3]);
        assert_eq!((distribution.min, distribution.max), (Some(0.5), Some(9.0)));
        assert_eq!((distribution.mean, distribution.median), (Some(3.3), Some(2.0)));
    }

    #[test]
    fn whole_numbers_have_a_bin_each() {
        let distribution = Distribution::of_integers("objects", vec![2, 5, 2, 3]);
        assert_eq!(distribution.edges, [2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(distribution.counts, [2, 1, 0, 1]);
        assert_eq!(distribution.median, Some(2.5));
    }

    #[test]
    fn no_values_give_no_summary() {
        let empty = Distribution::of_integers("objects", Vec::new());
        assert_eq!((empty.count, empty.mean, empty.median), (0, None, None));
        assert_eq!(Distribution::of("m", &[0.0, 1.0], Vec::new()).counts, [0]);
    }
}
