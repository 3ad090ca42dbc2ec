//! Nonlinear least squares with numerical derivatives (Levenberg-Marquardt, Marquardt 1963).

/// Minimizes the sum of the squared residuals near `start` and returns the parameters and that sum.
///
/// `steps` are the increments of the central differences. At most 40 iterations of two evaluations per parameter,
/// plus up to eight trial steps each. `None` if `residuals` returns `None` at `start` or at a point of a central
/// difference.
pub fn least_squares<const N: usize>(
    start: [f64; N],
    steps: [f64; N],
    residuals: impl Fn(&[f64; N]) -> Option<Vec<f64>>,
) -> Option<([f64; N], f64)> {
    let cost = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>();
    let mut at = start;
    let mut here = residuals(&at)?;
    let mut best = cost(&here);
    let mut damping = 1e-3;
    for _ in 0..40 {
        let mut slopes = Vec::with_capacity(N);
        for k in 0..N {
            let (mut low, mut high) = (at, at);
            low[k] -= steps[k];
            high[k] += steps[k];
            let (a, b) = (residuals(&low)?, residuals(&high)?);
            slopes.push(a.iter().zip(&b).map(|(a, b)| (b - a) / (2.0 * steps[k])).collect::<Vec<f64>>());
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut improved = false;
        for _ in 0..8 {
            let mut system = [[0.0; N]; N];
            let mut right = [0.0; N];
            for (i, row) in system.iter_mut().enumerate() {
                for (j, cell) in row.iter_mut().enumerate() {
                    *cell = dot(&slopes[i], &slopes[j]);
                }
                // Marquardt's scaling: in proportion to each parameter's curvature the damping is independent of
                // units. The bound keeps the system regular where a parameter has no effect.
                row[i] += damping * row[i].max(1e-12);
                right[i] = -dot(&slopes[i], &here);
            }
            let Some(step) = solve(system, right) else {
                damping *= 10.0;
                continue;
            };
            let mut next = at;
            (0..N).for_each(|k| next[k] += step[k]);
            match residuals(&next) {
                Some(there) if cost(&there) < best => {
                    let gain = best - cost(&there);
                    (at, here) = (next, there);
                    best -= gain;
                    damping = (0.3 * damping).max(1e-12);
                    // A gain in the last digits only is the end.
                    improved = gain > 1e-12 * best;
                    break;
                }
                _ => damping *= 10.0,
            }
        }
        if !improved {
            break;
        }
    }
    Some((at, best))
}

/// Gaussian elimination with row pivoting; `None` if singular.
fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> Option<[f64; N]> {
    for k in 0..N {
        let pivot = (k..N).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        if a[pivot][k].abs() < 1e-14 {
            return None;
        }
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..N {
            let factor = a[i][k] / a[k][k];
            let upper = a[k];
            a[i].iter_mut().zip(upper).skip(k).for_each(|(cell, above)| *cell -= factor * above);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..N).rev() {
        b[k] = (b[k] - (k + 1..N).map(|j| a[k][j] * b[j]).sum::<f64>()) / a[k][k];
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_finds_minimum_of_rosenbrock_function() {
        let rosenbrock = |p: &[f64; 2]| Some(vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]);
        let (at, cost) = least_squares([-1.2, 1.0], [1e-6; 2], rosenbrock).expect("finite");
        assert!((at[0] - 1.0).abs() < 1e-4 && (at[1] - 1.0).abs() < 1e-4 && cost < 1e-8);
    }
}
