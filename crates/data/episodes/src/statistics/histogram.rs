//! Counts of each of the 256 values of an image's channels: enough for exact statistics.

use imaging::Image;

use crate::statistics::moments::Moments;
use crate::statistics::{FeatureStatistics, QUANTILES, interpolated};

/// Values of a channel.
pub const LEVELS: usize = 256;

/// Counts by channel (red, green, blue) and value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageHistogram {
    counts: Vec<u64>,
}

impl Default for ImageHistogram {
    fn default() -> Self {
        Self { counts: vec![0; 3 * LEVELS] }
    }
}

impl ImageHistogram {
    /// From the counts of red, green and blue; `None` for another number of counts.
    pub fn from_counts(counts: Vec<u64>) -> Option<Self> {
        (counts.len() == 3 * LEVELS).then_some(Self { counts })
    }

    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Adds every pixel.
    pub fn add(&mut self, image: &Image) {
        let (red, rest) = self.counts.split_at_mut(LEVELS);
        let (green, blue) = rest.split_at_mut(LEVELS);
        for pixel in image.as_rgba().chunks_exact(4) {
            red[usize::from(pixel[0])] += 1;
            green[usize::from(pixel[1])] += 1;
            blue[usize::from(pixel[2])] += 1;
        }
    }

    pub fn merge(&mut self, other: &Self) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(count, more)| *count += more);
    }

    /// Statistics of the channels as numbers from 0 to 1, red first. At least one pixel was added.
    pub fn statistics(&self) -> FeatureStatistics {
        let channels: Vec<_> = self.counts.chunks_exact(LEVELS).map(channel_statistics).collect();
        FeatureStatistics::of_dimensions(&channels)
    }
}

fn value(level: usize) -> f64 {
    level as f64 / 255.0
}

fn channel_statistics(counts: &[u64]) -> (Moments, [f64; 5]) {
    let total: u64 = counts.iter().sum();
    let weighted = |of: &dyn Fn(f64) -> f64| -> f64 {
        counts.iter().enumerate().map(|(level, count)| *count as f64 * of(value(level))).sum()
    };
    let mean = weighted(&|value| value) / total as f64;
    let present = |level: &usize| counts[*level] > 0;
    let moments = Moments {
        count: total,
        mean,
        sum_of_squares: weighted(&|value| (value - mean).powi(2)),
        min: (0..LEVELS).find(present).map_or(0.0, value),
        max: (0..LEVELS).rev().find(present).map_or(0.0, value),
    };
    let at_rank = |rank: u64| {
        let mut below = 0;
        let level = counts.iter().position(|count| {
            below += count;
            below > rank
        });
        level.map_or(1.0, value)
    };
    (moments, QUANTILES.map(|(_, share)| interpolated(share, total, at_rank)))
}
