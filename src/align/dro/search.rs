//! One-dimensional search: where to look closer, and golden sections.

use crate::geometry::Interrupted;

/// What a search of a whole turn found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// (yaw in radians, loss) of the coarse search, in the order of yaw from 0.
    pub curve: Vec<(f64, f64)>,
    /// (yaw in radians, loss) of the refined, best first; yaws not wrapped.
    pub top: Vec<(f64, f64)>,
}

/// The yaws at which to look closer: local minima of the closed curve, lowest first, then the lowest
/// others; `keep` in all.
pub fn candidates(curve: &[(f64, f64)], keep: usize) -> Vec<f64> {
    let n = curve.len();
    let is_minimum = |k: usize| {
        let here = curve[k].1;
        here <= curve[(k + n - 1) % n].1 && here < curve[(k + 1) % n].1
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| {
        is_minimum(b).cmp(&is_minimum(a)).then(curve[a].1.total_cmp(&curve[b].1)).then(a.cmp(&b))
    });
    order.into_iter().take(keep.max(1)).map(|k| curve[k].0).collect()
}

/// Place and value of a minimum of `f` between `low` and `high`, to within `tolerance` (Kiefer 1953).
/// Returns the lowest value seen.
pub fn golden_section(
    mut low: f64,
    mut high: f64,
    tolerance: f64,
    mut f: impl FnMut(f64) -> Result<f64, Interrupted>,
) -> Result<(f64, f64), Interrupted> {
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
    fn golden_section_finds_a_parabola_s_foot() {
        let found = golden_section(-1.0, 2.0, 1e-4, |x| Ok((x - 0.37).powi(2))).expect("not interrupted");
        assert!((found.0 - 0.37).abs() < 1e-4);
    }

    #[test]
    fn minima_come_before_mere_neighbors_of_the_lowest() {
        let losses = [0.5, 0.1, 0.2, 0.6, 0.4, 0.7];
        let curve: Vec<(f64, f64)> = losses.iter().enumerate().map(|(k, &l)| (k as f64, l)).collect();
        assert_eq!(candidates(&curve, 3), vec![1.0, 4.0, 2.0]);
    }
}
