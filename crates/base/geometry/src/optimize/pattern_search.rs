//! Derivative-free local maximization along the coordinate axes (pattern search, Hooke and Jeeves 1961).

/// Maximizes `score` near `start`, one parameter after the other, and returns the parameters and their score.
///
/// An iteration without a gain halves all steps. The search ends when the steps are below `1/2^halvings` of `steps`, or
/// after 60 iterations. A gain counts from 1e-5.
pub fn pattern_search<const N: usize>(
    start: [f64; N],
    steps: [f64; N],
    halvings: u32,
    score: impl Fn(&[f64; N]) -> f64,
) -> ([f64; N], f64) {
    let (mut at, mut best) = (start, score(&start));
    let mut directions = [1.0; N];
    let mut scale = 1.0;
    for _ in 0..60 {
        let mut gained = false;
        for k in 0..N {
            // The direction of the last gain comes first.
            for sign in [directions[k], -directions[k]] {
                let mut next = at;
                next[k] += sign * scale * steps[k];
                let there = score(&next);
                if there > best + 1e-5 {
                    (at, best, gained) = (next, there, true);
                    directions[k] = sign;
                    break;
                }
            }
        }
        if !gained {
            scale *= 0.5;
            if scale < 1.0 / f64::from(1_u32 << halvings) {
                break;
            }
        }
    }
    (at, best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pattern_search_finds_maximum_of_paraboloid() {
        let (top, score) =
            pattern_search([0.0, 0.0], [0.5, 0.5], 12, |p| -(p[0] - 3.0).powi(2) - (p[1] + 1.0).powi(2));
        assert!((top[0] - 3.0).abs() < 5e-3 && (top[1] + 1.0).abs() < 5e-3 && score > -5e-5);
    }
}
