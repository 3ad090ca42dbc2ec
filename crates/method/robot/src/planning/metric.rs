//! Distances and straight lines in joint space.

use crate::collision::lane_arm::Configuration;

/// The Euclidean distance of two configurations.
pub fn distance(from: &Configuration, to: &Configuration) -> f32 {
    from.iter().zip(to).map(|(a, b)| (b - a) * (b - a)).sum::<f32>().sqrt()
}

/// The configuration at a share of the way from one to another.
pub fn toward(from: &Configuration, to: &Configuration, share: f32) -> Configuration {
    std::array::from_fn(|joint| from[joint] + share * (to[joint] - from[joint]))
}
