//! Derivative-free local minimization by the simplex method (Nelder and Mead 1965).

/// Minimizes `value` near `start`. The coefficients are the published ones: reflection 1, expansion 2, contraction 1/2,
/// shrinkage 1/2.
///
/// `spread` is the size of the first simplex along each axis. The search stops after `max_evaluations` evaluations,
/// or at the end of the iteration that reaches them. It returns the best evaluated point and its value, which is never
/// above the value at `start`.
pub fn nelder_mead<const N: usize>(
    start: [f64; N],
    spread: [f64; N],
    max_evaluations: usize,
    mut value: impl FnMut([f64; N]) -> f64,
) -> ([f64; N], f64) {
    let mut corners: Vec<([f64; N], f64)> = vec![(start, value(start))];
    for axis in 0..N {
        let mut corner = start;
        corner[axis] += spread[axis];
        corners.push((corner, value(corner)));
    }
    let mut evaluations = N + 1;
    while evaluations < max_evaluations {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut center = [0.0; N];
        for (corner, _) in &corners[..N] {
            (0..N).for_each(|axis| center[axis] += corner[axis] / N as f64);
        }
        let (worst, second) = (corners[N], corners[N - 1]);
        let along = |t: f64| std::array::from_fn(|axis| center[axis] + t * (worst.0[axis] - center[axis]));
        let mut evaluate = |point: [f64; N]| {
            evaluations += 1;
            (point, value(point))
        };
        let reflected = evaluate(along(-1.0));
        if reflected.1 < corners[0].1 {
            let expanded = evaluate(along(-2.0));
            corners[N] = if expanded.1 < reflected.1 { expanded } else { reflected };
        } else if reflected.1 < second.1 {
            corners[N] = reflected;
        } else {
            let contracted = evaluate(along(if reflected.1 < worst.1 { -0.5 } else { 0.5 }));
            if contracted.1 < worst.1.min(reflected.1) {
                corners[N] = contracted;
            } else {
                let best = corners[0].0;
                for corner in &mut corners[1..] {
                    *corner = evaluate(std::array::from_fn(|axis| 0.5 * (best[axis] + corner.0[axis])));
                }
            }
        }
    }
    corners.into_iter().fold((start, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nelder_mead_finds_minimum_of_tilted_valley() {
        let valley = |[x, y]: [f64; 2]| (x - 1.0).powi(2) + 10.0 * (y - x - 0.5).powi(2);
        let ([x, y], value) = nelder_mead([0.0, 0.0], [0.5, 0.5], 120, valley);
        assert!((x - 1.0).abs() < 1e-3 && (y - 1.5).abs() < 1e-3 && value < 1e-5, "{x} {y} {value}");
    }

    #[test]
    fn nelder_mead_is_never_worse_than_start() {
        let (point, value) = nelder_mead([0.0], [0.1], 30, |[x]| x.abs());
        assert_eq!((point, value), ([0.0], 0.0));
    }
}
