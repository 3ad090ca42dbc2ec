//! The paper's yaw search: evenly spaced yaws by their loss, then gradient descent from the best.
//!
//! Method: TabletopGen, section "Implementation details": 72 yaws, the 8 lowest refined with Adam (Kingma and Ba 2015,
//! algorithm 1) at a learning rate of 3e-2 for 140 steps, the best kept. The paper does not specify the unit, here
//! radians, nor the kept value of a run, here the best one. Adam's steps are about as long as the learning rate
//! however small the derivative, 1.7 degrees, and shrink only as it changes sign.
//!
//! The loss is a closure, for many yaws `yaw_rad -> (loss, d loss / d yaw_rad)`, so the search is independent of
//! images; its failures (a cancellation) end the search. Cost: `coarse_yaws + keep * steps` losses, 1192 as in the
//! paper, in `1 + steps` calls: descents take their steps together, so that a GPU can batch them. The golden sections
//! of yaw.rs take a seventh of the losses.

use std::f64::consts::TAU;

use super::search::{PoseCandidate, YawSearchResult};

/// Effort and step size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescentSettings {
    /// Yaws of the coarse search, evenly spaced over a turn from 0, 1..
    pub coarse_yaws: u32,
    /// Coarse yaws that are refined, 1..
    pub keep: u32,
    /// Adam steps of each refinement.
    pub steps: u32,
    /// Adam's learning rate, radians; more moves farther and settles less.
    pub learning_rate_rad: f64,
}

impl DescentSettings {
    /// As published.
    pub const PUBLISHED: Self = Self { coarse_yaws: 72, keep: 8, steps: 140, learning_rate_rad: 3e-2 };
}

/// Decay of Adam's averages, and what keeps its division finite; Kingma and Ba's defaults.
const BETA_1: f64 = 0.9;
const BETA_2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// Searches a whole turn.
pub fn search<E>(
    settings: &DescentSettings,
    mut losses: impl FnMut(&[f64]) -> Result<Vec<(f64, f64)>, E>,
) -> Result<YawSearchResult, E> {
    let yaws = settings.coarse_yaws.max(1);
    let yaws_rad: Vec<f64> = (0..yaws).map(|k| TAU * f64::from(k) / f64::from(yaws)).collect();
    let found = losses(&yaws_rad)?;
    let curve: Vec<(f64, f64)> = yaws_rad.into_iter().zip(found).map(|(yaw, loss)| (yaw, loss.0)).collect();
    let mut descents: Vec<Adam> =
        lowest(&curve, settings.keep as usize).into_iter().map(Adam::from).collect();
    for _ in 0..settings.steps.max(1) {
        let yaws_rad: Vec<f64> = descents.iter().map(|descent| descent.yaw_rad).collect();
        for (descent, (value, slope)) in descents.iter_mut().zip(losses(&yaws_rad)?) {
            descent.step(settings.learning_rate_rad, value, slope);
        }
    }
    descents.sort_by(|a, b| a.best.1.total_cmp(&b.best.1));
    let best = |descent: Adam| PoseCandidate { yaw_rad: descent.best.0, loss: descent.best.1, place: None };
    Ok(YawSearchResult { curve, top: descents.into_iter().map(best).collect() })
}

/// The yaws with the lowest losses, lowest first; `keep` of them, at least one.
pub fn lowest(curve: &[(f64, f64)], keep: usize) -> Vec<f64> {
    let mut order = curve.to_vec();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    order.into_iter().take(keep.max(1)).map(|c| c.0).collect()
}

/// A descent under way.
struct Adam {
    yaw_rad: f64,
    /// The lowest (yaw, loss) so far, the start included; the end of the last step is not evaluated.
    best: (f64, f64),
    /// Decaying averages of the derivative and of its square.
    mean: f64,
    square: f64,
    /// Remaining weight of the averages' initial 0.
    decay_1: f64,
    decay_2: f64,
}

impl Adam {
    fn from(yaw_rad: f64) -> Self {
        let best = (yaw_rad, f64::INFINITY);
        Self { yaw_rad, best, mean: 0.0, square: 0.0, decay_1: 1.0, decay_2: 1.0 }
    }

    /// Takes a step for this loss and derivative.
    fn step(&mut self, learning_rate_rad: f64, value: f64, slope: f64) {
        if value < self.best.1 {
            self.best = (self.yaw_rad, value);
        }
        self.mean = BETA_1 * self.mean + (1.0 - BETA_1) * slope;
        self.square = BETA_2 * self.square + (1.0 - BETA_2) * slope * slope;
        // Bias correction: both averages began at 0.
        self.decay_1 *= BETA_1;
        self.decay_2 *= BETA_2;
        let (mean, square) = (self.mean / (1.0 - self.decay_1), self.square / (1.0 - self.decay_2));
        self.yaw_rad -= learning_rate_rad * mean / (square.sqrt() + EPSILON);
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    /// A dip at 1.234 among shallower ones, smooth and periodic.
    fn dips(yaw_rad: &f64) -> (f64, f64) {
        let x = yaw_rad - 1.234;
        let value = 1.0 - 0.5 * x.cos() - 0.3 * (4.0 * x).cos();
        (value, 0.5 * x.sin() + 1.2 * (4.0 * x).sin())
    }

    #[test]
    fn descent_finds_global_minimum_in_1192_losses() {
        let (mut losses, mut calls) = (0, 0);
        let found = search(&DescentSettings::PUBLISHED, |yaws_rad| {
            (losses, calls) = (losses + yaws_rad.len(), calls + 1);
            Ok::<_, Infallible>(yaws_rad.iter().map(dips).collect())
        })
        .expect("cannot fail");
        let PoseCandidate { yaw_rad, loss, .. } = found.top[0];
        assert!((yaw_rad - 1.234).abs() < 1e-3, "{yaw_rad}");
        assert!((loss - 0.2).abs() < 1e-5, "{loss}");
        assert_eq!((losses, calls, found.curve.len(), found.top.len()), (1192, 141, 72, 8));
        assert!(found.top.is_sorted_by(|a, b| a.loss <= b.loss));
    }

    #[test]
    fn first_adam_step_equals_learning_rate() {
        let mut descent = Adam::from(0.5);
        descent.step(3e-2, 0.5, 7.0);
        assert!((descent.yaw_rad - (0.5 - 3e-2)).abs() < 1e-9, "{}", descent.yaw_rad);
        let there = descent.yaw_rad;
        descent.step(3e-2, 0.4, 7.0);
        assert_eq!(descent.best, (there, 0.4));
    }

    #[test]
    fn descent_keeps_best_value_when_loss_rises() {
        // A wrong derivative: every step increases the loss.
        let mut descent = Adam::from(0.1);
        (0..140).for_each(|_| descent.step(3e-2, descent.yaw_rad.abs(), -1.0));
        assert_eq!(descent.best, (0.1, 0.1));
    }

    #[test]
    fn loss_failure_ends_search() {
        let mut calls = 0;
        let found = search(&DescentSettings::PUBLISHED, |yaws_rad| {
            calls += 1;
            if calls > 3 { Err("interrupted") } else { Ok(vec![(0.0, 1.0); yaws_rad.len()]) }
        });
        assert_eq!((found, calls), (Err("interrupted"), 4));
    }
}
