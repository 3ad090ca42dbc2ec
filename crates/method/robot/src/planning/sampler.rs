//! Configurations that fill the space of an arm evenly.

use rand::{Rng, RngExt};

use crate::collision::arm::MAX_JOINTS;
use crate::collision::lane_arm::Configuration;
use crate::model::limits::JointLimits;

/// The bases of the sequence. Two is left out: pairs with it are the least even at first.
const BASES: [u32; MAX_JOINTS] = [3, 5, 7, 11, 13, 17, 19, 23];

/// Sequence of configurations that a search tries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleOrder {
    /// The Halton sequence from its begin: every search tries the same configurations.
    Fixed,
    /// The same sequence, moved as a whole by a random offset that keeps it as even (Cranley and Patterson, 1976).
    /// Other random numbers give other paths.
    Shifted,
}

/// A Halton sequence over the ranges of the joints.
pub struct Sampler {
    digits: [HaltonDigits; MAX_JOINTS],
    offset: [f32; MAX_JOINTS],
    low: Configuration,
    range: Configuration,
}

impl Sampler {
    /// A sequence over `limits`; joints that the arm lacks stay at 0.
    pub fn new(limits: impl Iterator<Item = JointLimits>, order: SampleOrder, rng: &mut impl Rng) -> Self {
        let (mut low, mut range) = ([0.0; MAX_JOINTS], [0.0; MAX_JOINTS]);
        for (joint, limit) in limits.enumerate().take(MAX_JOINTS) {
            low[joint] = limit.min_position as f32;
            range[joint] = (limit.max_position - limit.min_position) as f32;
        }
        let offset = match order {
            SampleOrder::Fixed => [0.0; MAX_JOINTS],
            SampleOrder::Shifted => std::array::from_fn(|_| rng.random_range(0.0..1.0)),
        };
        Self { digits: BASES.map(HaltonDigits::new), offset, low, range }
    }

    /// The next configuration, within the limits.
    pub fn sample(&mut self) -> Configuration {
        std::array::from_fn(|joint| {
            if self.range[joint] == 0.0 {
                return self.low[joint];
            }
            let share = self.digits[joint].next() + self.offset[joint];
            self.low[joint] + self.range[joint] * (if share >= 1.0 { share - 1.0 } else { share })
        })
    }
}

/// The radical inverses of 1, 2, 3, ... in one base: the digits of the number, mirrored at the point.
#[derive(Clone, Copy)]
struct HaltonDigits {
    base: u32,
    /// The last digit of the number, and the number without it.
    last: u32,
    others: u32,
    /// Contribution of the other digits.
    rest: f64,
}

impl HaltonDigits {
    fn new(base: u32) -> Self {
        Self { base, last: 0, others: 0, rest: 0.0 }
    }

    fn next(&mut self) -> f32 {
        self.last += 1;
        if self.last == self.base {
            self.last = 0;
            self.others += 1;
            let (mut digits, mut place) = (self.others, 1.0 / f64::from(self.base));
            self.rest = 0.0;
            while digits > 0 {
                place /= f64::from(self.base);
                self.rest += place * f64::from(digits % self.base);
                digits /= self.base;
            }
        }
        (f64::from(self.last) / f64::from(self.base) + self.rest) as f32
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn digits_are_mirrored() {
        let mut digits = HaltonDigits::new(3);
        let first: Vec<f32> = (0..9).map(|_| digits.next()).collect();
        let ninths = [3, 6, 1, 4, 7, 2, 5, 8].map(|n| n as f32 / 9.0);
        assert_eq!(first[..8], ninths);
        assert_eq!(first[8], 1.0 / 27.0);
    }

    #[test]
    fn samples_fill_each_range() {
        let limits = |low, high| JointLimits {
            min_position: low,
            max_position: high,
            max_velocity: 1.0,
            max_acceleration: 1.0,
            max_jerk: 1.0,
            max_effort: 1.0,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut sampler =
            Sampler::new([limits(-1.0, 2.0), limits(0.0, 0.5)].into_iter(), SampleOrder::Shifted, &mut rng);
        let mut counts = [[0; 10]; 2];
        for _ in 0..1000 {
            let sample = sampler.sample();
            assert_eq!(sample[2..], [0.0; 6]);
            counts[0][((sample[0] + 1.0) / 0.3).floor() as usize] += 1;
            counts[1][(sample[1] / 0.05).floor() as usize] += 1;
        }
        for count in counts.iter().flatten() {
            assert!((95..=105).contains(count), "{counts:?}");
        }
    }
}
