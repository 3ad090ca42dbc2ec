//! One-dimensional minimization: local minima of a sampled closed curve, and golden sections.

use runtime::Cancelled;

/// Arguments of the local minima of a closed curve of (argument, value), lowest value first, at most `keep`. A flat
/// curve gives its last sample.
pub fn local_minima(curve: &[(f64, f64)], keep: usize) -> Vec<f64> {
    let n = curve.len();
    let is_minimum = |k: usize| {
        let here = curve[k].1;
        here <= curve[(k + n - 1) % n].1 && here < curve[(k + 1) % n].1
    };
    let mut minima: Vec<usize> = (0..n).filter(|&k| is_minimum(k)).collect();
    if minima.is_empty() {
        // A flat curve.
        minima.extend(n.checked_sub(1));
    }
    minima.sort_by(|&a, &b| curve[a].1.total_cmp(&curve[b].1).then(a.cmp(&b)));
    minima.into_iter().take(keep.max(1)).map(|k| curve[k].0).collect()
}

/// Argument and value of a minimum of `f` between `low` and `high`, to within `tolerance` (Kiefer 1953). Of the last
/// two evaluations the lower one is returned.
///
/// # Errors
///
/// [`Cancelled`] if an evaluation returns it.
pub fn golden_section(
    mut low: f64,
    mut high: f64,
    tolerance: f64,
    mut f: impl FnMut(f64) -> Result<f64, Cancelled>,
) -> Result<(f64, f64), Cancelled> {
    // The inverse golden ratio: of the two inner points one is an inner point of the next interval, so that a step
    // costs one evaluation.
    const SHARE: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (high - SHARE * (high - low), low + SHARE * (high - low));
    let (mut f_a, mut f_b) = (f(a)?, f(b)?);
    while high - low > tolerance.max(1e-6) {
        if f_a <= f_b {
            (high, b, f_b) = (b, a, f_a);
            a = high - SHARE * (high - low);
            f_a = f(a)?;
        } else {
            (low, a, f_a) = (a, b, f_b);
            b = low + SHARE * (high - low);
            f_b = f(b)?;
        }
    }
    Ok(if f_a <= f_b { (a, f_a) } else { (b, f_b) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_section_finds_minimum_of_parabola() {
        let found = golden_section(-1.0, 2.0, 1e-4, |x| Ok((x - 0.37).powi(2))).expect("not cancelled");
        assert!((found.0 - 0.37).abs() < 1e-4);
    }

    #[test]
    fn local_minima_skip_neighbors_and_keep_one_of_flat_curve() {
        let losses = [0.5, 0.1, 0.2, 0.6, 0.4, 0.7];
        let curve: Vec<(f64, f64)> = losses.iter().enumerate().map(|(k, &l)| (k as f64, l)).collect();
        assert_eq!(local_minima(&curve, 3), vec![1.0, 4.0]);
        assert_eq!(local_minima(&[(0.0, 0.3); 4], 3).len(), 1);
    }
}
