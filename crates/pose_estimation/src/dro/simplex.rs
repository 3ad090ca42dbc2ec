//! The least value of a function of a few numbers near a point: Nelder and Mead 1965, without derivatives.
//!
//! Inputs: a starting point, the size of the first simplex along each axis, how often the function may be
//! asked. Returns the best point that was asked for and its value, never worse than the start's. Local.

/// Reflect, expand, contract, shrink as published (1, 2, 1/2, 1/2).
pub fn least<const N: usize>(
    start: [f64; N],
    spread: [f64; N],
    looks: usize,
    mut value: impl FnMut([f64; N]) -> f64,
) -> ([f64; N], f64) {
    let mut corners: Vec<([f64; N], f64)> = vec![(start, value(start))];
    for axis in 0..N {
        let mut corner = start;
        corner[axis] += spread[axis];
        corners.push((corner, value(corner)));
    }
    let mut looked = N + 1;
    while looked < looks {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut middle = [0.0; N];
        for (corner, _) in &corners[..N] {
            (0..N).for_each(|axis| middle[axis] += corner[axis] / N as f64);
        }
        let (worst, second) = (corners[N], corners[N - 1]);
        let along = |t: f64| std::array::from_fn(|axis| middle[axis] + t * (worst.0[axis] - middle[axis]));
        let mut ask = |point: [f64; N]| {
            looked += 1;
            (point, value(point))
        };
        let reflected = ask(along(-1.0));
        if reflected.1 < corners[0].1 {
            let expanded = ask(along(-2.0));
            corners[N] = if expanded.1 < reflected.1 { expanded } else { reflected };
        } else if reflected.1 < second.1 {
            corners[N] = reflected;
        } else {
            let contracted = ask(along(if reflected.1 < worst.1 { -0.5 } else { 0.5 }));
            if contracted.1 < worst.1.min(reflected.1) {
                corners[N] = contracted;
            } else {
                let best = corners[0].0;
                for corner in &mut corners[1..] {
                    *corner = ask(std::array::from_fn(|axis| 0.5 * (best[axis] + corner.0[axis])));
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
    fn finds_the_bottom_of_a_tilted_valley() {
        let valley = |[x, y]: [f64; 2]| (x - 1.0).powi(2) + 10.0 * (y - x - 0.5).powi(2);
        let ([x, y], value) = least([0.0, 0.0], [0.5, 0.5], 120, valley);
        assert!((x - 1.0).abs() < 1e-3 && (y - 1.5).abs() < 1e-3 && value < 1e-5, "{x} {y} {value}");
    }

    #[test]
    fn never_returns_worse_than_the_start() {
        let (point, value) = least([0.0], [0.1], 30, |[x]| x.abs());
        assert_eq!((point, value), ([0.0], 0.0));
    }
}
