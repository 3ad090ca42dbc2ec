//! Statistics against slow references: sorting, and sums in two passes.

use episodes::statistics::histogram::ImageHistogram;
use episodes::statistics::spool::Spool;
use episodes::statistics::{FeatureStatistics, QUANTILES, of_consecutive, of_vectors};
use imaging::Image;
use proptest::prelude::*;

/// As numpy: mean and deviation in two passes, quantiles by sorting and linear interpolation.
fn reference(values: &[f64]) -> FeatureStatistics {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
    let quantile = |share: f64| {
        let position = share * (count - 1.0);
        let (low, high) = (sorted[position.floor() as usize], sorted[position.ceil() as usize]);
        vec![low + (high - low) * position.fract()]
    };
    FeatureStatistics {
        count: values.len() as u64,
        min: vec![sorted[0]],
        max: vec![sorted[sorted.len() - 1]],
        mean: vec![mean],
        std: vec![variance.sqrt()],
        quantiles: QUANTILES.map(|(_, share)| quantile(share)),
    }
}

fn assert_close(actual: &FeatureStatistics, dimension: usize, expected: &FeatureStatistics) {
    assert_eq!(actual.count, expected.count);
    for ((name, numbers), (_, references)) in actual.named().into_iter().zip(expected.named()) {
        let (number, reference) = (numbers[dimension], references[0]);
        let scale = 1.0 + expected.max[0].abs().max(expected.min[0].abs());
        assert!((number - reference).abs() <= 1e-7 * scale, "{name}: {number}, not {reference}");
        // What is selected and not computed is exact.
        if matches!(name, "min" | "max") {
            assert_eq!(number, reference, "{name}");
        }
    }
}

/// Numbers of all sizes and signs, with repetitions.
fn value() -> impl Strategy<Value = f32> {
    prop_oneof![-1e6_f32..1e6, -1.0_f32..1.0, Just(0.0), Just(-0.0), Just(1.0), -1e-30_f32..1e-30]
}

proptest! {
    #[test]
    fn spooled_quantiles_are_those_of_sorting(
        episodes in prop::collection::vec(prop::collection::vec([value(), value(), value()], 1..40), 1..12),
        width in 1_usize..=3,
    ) {
        let folder = tempfile::TempDir::new().expect("a folder");
        let mut spool = Spool::create(folder.path().join("spool"), width).expect("a spool");
        for rows in &episodes {
            let flat: Vec<f32> = rows.iter().flat_map(|row| row[..width].to_vec()).collect();
            let of_episode = spool.add(&flat).expect("added");
            prop_assert_eq!(&of_episode, &of_vectors(&flat, width));
        }
        let statistics = spool.finish().expect("finished");
        for dimension in 0..width {
            let column: Vec<f64> = episodes.iter().flatten().map(|row| f64::from(row[dimension])).collect();
            assert_close(&statistics, dimension, &reference(&column));
        }
        prop_assert!(folder.path().read_dir().expect("a folder").next().is_none(), "the spool is gone");
    }

    #[test]
    fn counts_of_images_give_the_statistics_of_their_pixels(
        pixels in prop::collection::vec(any::<[u8; 3]>(), 12..=12),
        more in prop::collection::vec(any::<[u8; 3]>(), 12..=12),
    ) {
        let image = |pixels: &[[u8; 3]]| {
            let rgba = pixels.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
            Image::from_rgba(4, 3, rgba).expect("an image")
        };
        let (mut first, mut second) = (ImageHistogram::default(), ImageHistogram::default());
        first.add(&image(&pixels));
        second.add(&image(&more));
        first.merge(&second);
        let statistics = first.statistics();
        for channel in 0..3 {
            let values: Vec<f64> =
                pixels.iter().chain(&more).map(|pixel| f64::from(pixel[channel]) / 255.0).collect();
            assert_close(&statistics, channel, &reference(&values));
        }
    }

    #[test]
    fn consecutive_numbers_need_no_list(first in 0_u64..1000, count in 1_u64..300) {
        let values: Vec<f64> = (first..first + count).map(|value| value as f64).collect();
        assert_close(&of_consecutive(first, count), 0, &reference(&values));
    }
}

#[test]
fn more_dimensions_than_a_pass_takes_stay_apart() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let mut spool = Spool::create(folder.path().join("spool"), 9).expect("a spool");
    // Dimension d has the numbers d, d + 1, ..., d + 100.
    for step in 0..=100 {
        let row: Vec<f32> = (0..9).map(|d| (d + step) as f32).collect();
        spool.add(&row).expect("added");
    }
    let statistics = spool.finish().expect("finished");
    for d in 0..9 {
        let expected = [1.0, 10.0, 50.0, 90.0, 99.0].map(|rank| rank + d as f64);
        assert_eq!(statistics.quantiles.each_ref().map(|quantile| quantile[d]), expected);
        assert_eq!((statistics.mean[d], statistics.min[d]), (50.0 + d as f64, d as f64));
    }
}
