//! Cubic convolution (Keys, 1981) along one axis, as in PyTorch and Pillow.

/// Weights of one output sample: inputs from `first` on, each with its weight; the weights add up to 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Taps<T = f32> {
    pub first: usize,
    pub weights: Vec<T>,
}

/// Interpolation at the new centers, from four neighbors each; the ends repeat. Sharpness -0.75.
pub(crate) fn interpolating(from: usize, to: usize) -> Vec<Taps> {
    let step = from as f64 / to as f64;
    let taps = |index: usize| {
        let center = (index as f64 + 0.5) * step - 0.5;
        let base = center.floor();
        let inside = |offset: i64| (base as i64 + offset).clamp(0, from as i64 - 1) as usize;
        let (first, last) = (inside(-1), inside(2));
        let mut weights = vec![0.0; last - first + 1];
        for offset in -1..=2 {
            weights[inside(offset) - first] += kernel(center - base - offset as f64, -0.75) as f32;
        }
        Taps { first, weights }
    };
    (0..to).map(taps).collect()
}

/// Antialiased resampling: widened by the reduction factor so that no input is skipped, and cut off at the ends.
/// Sharpness -0.5.
pub(crate) fn antialiased(from: usize, to: usize) -> Vec<Taps> {
    let single = |taps: Taps<f64>| Taps {
        first: taps.first,
        weights: taps.weights.into_iter().map(|weight| weight as f32).collect(),
    };
    antialiased_exactly(from, to).into_iter().map(single).collect()
}

/// As [`antialiased`], with weights that are not rounded to single precision.
pub(crate) fn antialiased_exactly(from: usize, to: usize) -> Vec<Taps<f64>> {
    let step = from as f64 / to as f64;
    let widening = step.max(1.0);
    let taps = |index: usize| {
        let center = (index as f64 + 0.5) * step;
        let first = (center - 2.0 * widening + 0.5).max(0.0) as usize;
        let end = ((center + 2.0 * widening + 0.5) as usize).min(from);
        let weights = (first..end).map(|k| kernel((k as f64 - center + 0.5) / widening, -0.5));
        let weights: Vec<f64> = weights.collect();
        let sum: f64 = weights.iter().sum();
        Taps { first, weights: weights.iter().map(|weight| weight / sum).collect() }
    };
    (0..to).map(taps).collect()
}

fn kernel(offset: f64, sharpness: f64) -> f64 {
    let (a, x) = (sharpness, offset.abs());
    if x < 1.0 {
        ((a + 2.0) * x - (a + 3.0)) * x * x + 1.0
    } else if x < 2.0 {
        (((x - 5.0) * x + 8.0) * x - 4.0) * a
    } else {
        0.0
    }
}
