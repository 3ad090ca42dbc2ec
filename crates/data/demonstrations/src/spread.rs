//! Random numbers about zero, and factors about one.

use rand::{Rng, RngExt as _};

/// From `-amplitude` to `amplitude`.
pub(crate) fn spread(rng: &mut impl Rng, amplitude: f64) -> f64 {
    amplitude * rng.random_range(-1.0..=1.0)
}

/// From `1 - share` to `1 + share`.
pub(crate) fn factor(rng: &mut impl Rng, share: f64) -> f64 {
    1.0 + spread(rng, share)
}

/// A factor of each color channel.
pub(crate) fn tint(rng: &mut impl Rng, share: f64) -> [f32; 3] {
    [(); 3].map(|()| factor(rng, share) as f32)
}
