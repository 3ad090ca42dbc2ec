//! Sampling from a seeded random stream: numbers, weighted choices, colors.

use rand::RngExt;

use super::Split;
use geometry::Rgb;
use runtime::seed::Rng;

/// Uniform in `low..high`; `low` where the range is empty.
pub(super) fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    if low < high { rng.random_range(low..high) } else { low }
}

/// Triangular distribution on `low..high`, with its peak at the center.
pub(super) fn triangular(rng: &mut Rng, low: f64, high: f64) -> f64 {
    0.5 * (uniform(rng, low, high) + uniform(rng, low, high))
}

/// A Bernoulli trial with that probability.
pub(super) fn chance(rng: &mut Rng, probability: f64) -> bool {
    rng.random_range(0.0..1.0) < probability
}

/// A uniformly chosen item; panics on an empty slice.
pub(super) fn pick<T: Copy>(rng: &mut Rng, items: &[T]) -> T {
    items[rng.random_range(0..items.len())]
}

/// An item with probability proportional to its weight; the slice must not be empty.
pub(super) fn weighted<T: Copy>(rng: &mut Rng, items: &[(T, f64)]) -> T {
    let total: f64 = items.iter().map(|(_, weight)| weight).sum();
    let mut left = uniform(rng, 0.0, total);
    for (item, weight) in items {
        left -= weight;
        if left < 0.0 {
            return *item;
        }
    }
    items[items.len() - 1].0
}

/// An item of the split with probability proportional to its weight; at least one must exist.
pub(super) fn of_split<T: Copy>(rng: &mut Rng, split: Split, items: &[(T, Split, f64)]) -> T {
    let own = items.iter().filter(|(_, of, _)| *of == split).map(|(item, _, weight)| (*item, *weight));
    weighted(rng, &own.collect::<Vec<_>>())
}

/// sRGB from hue 0..1, saturation 0..1 and value 0..1.
pub(super) fn hsv(hue: f64, saturation: f64, value: f64) -> Rgb {
    let channel = |shift: f64| {
        let k = (shift + 6.0 * hue.rem_euclid(1.0)).rem_euclid(6.0);
        (value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0)) as f32
    };
    Rgb([channel(5.0), channel(3.0), channel(1.0)])
}

/// A random color; grays and muted colors are more frequent than in a uniform distribution.
pub(super) fn any_color(rng: &mut Rng) -> Rgb {
    match weighted(rng, &[(0, 2.0), (1, 1.5), (2, 1.0), (3, 4.0)]) {
        0 => pale(rng),
        1 => hsv(uniform(rng, 0.0, 1.0), uniform(rng, 0.0, 0.15), uniform(rng, 0.04, 0.25)),
        2 => hsv(uniform(rng, 0.0, 1.0), uniform(rng, 0.0, 0.08), uniform(rng, 0.25, 0.8)),
        _ => {
            let saturation = uniform(rng, 0.15, 1.0);
            hsv(uniform(rng, 0.0, 1.0), saturation, uniform(rng, 0.2, 0.95))
        }
    }
}

/// A near-white color.
pub(super) fn pale(rng: &mut Rng) -> Rgb {
    hsv(uniform(rng, 0.02, 0.65), uniform(rng, 0.0, 0.07), uniform(rng, 0.84, 0.98))
}

/// A random wood color.
pub(super) fn wood_color(rng: &mut Rng) -> Rgb {
    let value = uniform(rng, 0.28, 0.96);
    hsv(uniform(rng, 0.035, 0.115), uniform(rng, 0.22, 0.62), value)
}

/// A color near the given one.
pub(super) fn near(rng: &mut Rng, color: Rgb, spread: f64) -> Rgb {
    let all = uniform(rng, -spread, spread);
    Rgb(color
        .0
        .map(|c| (f64::from(c) + all + uniform(rng, -0.4 * spread, 0.4 * spread)).clamp(0.02, 0.99) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_rng;

    #[test]
    fn weighted_picks_follow_their_weights() {
        let mut rng = child_rng(1, "draw");
        let count = (0..4000).filter(|_| weighted(&mut rng, &[(true, 3.0), (false, 1.0)])).count();
        assert!((2850..3150).contains(&count), "{count}");
    }

    #[test]
    fn hsv_returns_primary_colors() {
        assert_eq!(hsv(0.0, 1.0, 1.0), Rgb([1.0, 0.0, 0.0]));
        assert_eq!(hsv(1.0 / 3.0, 1.0, 1.0), Rgb([0.0, 1.0, 0.0]));
        assert_eq!(hsv(0.7, 0.0, 0.5), Rgb([0.5, 0.5, 0.5]));
    }
}
