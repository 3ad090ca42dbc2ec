//! The paper's search for a yaw: evenly spaced yaws by their loss, then gradient descent from the best.
//!
//! Method: TabletopGen, section "Implementation details": 72 yaws, the 8 lowest refined with Adam (Kingma and
//! Ba 2015, algorithm 1) at a learning rate of 3e-2 for 140 steps, the best kept. The paper is silent on the
//! unit, here radians, and on what is kept of a run, here the best value seen. Adam's steps are about as
//! long as the learning rate however small the derivative, 1.7 degrees, and shrink only as it changes sign.
//!
//! The loss is a closure, `yaw_rad -> (loss, d loss / d yaw_rad)`, so the search knows no pictures; its
//! failures (an interrupt) end the search. Cost: `coarse_yaws + keep * steps` calls, 1192 as in the paper.
//! Yaws and descents run side by side; the same answer with any number of threads. Not where speed matters:
//! the golden sections of search.rs take a seventh of the calls.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::search::{Candidate, Found};

/// Effort and step size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperSearch {
    /// Yaws of the coarse search, evenly spaced over a turn from 0, 1..
    pub coarse_yaws: u32,
    /// Coarse yaws that are refined, 1..
    pub keep: u32,
    /// Adam steps of each refinement.
    pub steps: u32,
    /// Adam's learning rate, radians; more moves farther and settles less.
    pub learning_rate_rad: f64,
}

impl PaperSearch {
    /// As published.
    pub const PUBLISHED: Self = Self { coarse_yaws: 72, keep: 8, steps: 140, learning_rate_rad: 3e-2 };
}

/// Decay of Adam's averages, and what keeps its division finite; Kingma and Ba's defaults.
const BETA_1: f64 = 0.9;
const BETA_2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// Searches a whole turn.
pub fn search<E: Send>(
    settings: &PaperSearch,
    loss: impl Fn(f64) -> Result<(f64, f64), E> + Sync,
) -> Result<Found, E> {
    let yaws = settings.coarse_yaws.max(1);
    let curve = (0..yaws)
        .into_par_iter()
        .map(|k| {
            let yaw_rad = TAU * f64::from(k) / f64::from(yaws);
            loss(yaw_rad).map(|(value, _)| (yaw_rad, value))
        })
        .collect::<Result<Vec<_>, E>>()?;
    let mut top = lowest(&curve, settings.keep as usize)
        .into_par_iter()
        .map(|yaw_rad| adam(settings, yaw_rad, &loss))
        .collect::<Result<Vec<_>, E>>()?;
    top.sort_by(|a, b| a.1.total_cmp(&b.1));
    let top = top.into_iter().map(|(yaw_rad, loss)| Candidate { yaw_rad, loss, place: None }).collect();
    Ok(Found { curve, top })
}

/// The yaws with the lowest losses, lowest first; `keep` of them, at least one.
pub fn lowest(curve: &[(f64, f64)], keep: usize) -> Vec<f64> {
    let mut order = curve.to_vec();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    order.into_iter().take(keep.max(1)).map(|c| c.0).collect()
}

/// Descends from a yaw; the lowest (yaw, loss) seen, the start included. `steps` calls: the last step's end
/// is not looked at.
pub fn adam<E>(
    settings: &PaperSearch,
    from_rad: f64,
    mut loss: impl FnMut(f64) -> Result<(f64, f64), E>,
) -> Result<(f64, f64), E> {
    let (mut yaw_rad, mut best) = (from_rad, (from_rad, f64::INFINITY));
    let (mut mean, mut square) = (0.0, 0.0);
    let (mut decay_1, mut decay_2) = (1.0, 1.0);
    for _ in 0..settings.steps.max(1) {
        let (value, slope) = loss(yaw_rad)?;
        if value < best.1 {
            best = (yaw_rad, value);
        }
        mean = BETA_1 * mean + (1.0 - BETA_1) * slope;
        square = BETA_2 * square + (1.0 - BETA_2) * slope * slope;
        // Both averages began at 0; dividing by what they have seen of their weights corrects that.
        decay_1 *= BETA_1;
        decay_2 *= BETA_2;
        let (mean, square) = (mean / (1.0 - decay_1), square / (1.0 - decay_2));
        yaw_rad -= settings.learning_rate_rad * mean / (square.sqrt() + EPSILON);
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// A dip at 1.234 among shallower ones, smooth and periodic.
    fn dips(yaw_rad: f64) -> (f64, f64) {
        let x = yaw_rad - 1.234;
        let value = 1.0 - 0.5 * x.cos() - 0.3 * (4.0 * x).cos();
        (value, 0.5 * x.sin() + 1.2 * (4.0 * x).sin())
    }

    #[test]
    fn finds_the_lowest_dip_in_as_many_calls_as_the_paper() {
        let calls = AtomicUsize::new(0);
        let found = search(&PaperSearch::PUBLISHED, |yaw_rad| {
            calls.fetch_add(1, Ordering::Relaxed);
            Ok::<_, Infallible>(dips(yaw_rad))
        })
        .expect("cannot fail");
        let Candidate { yaw_rad, loss, .. } = found.top[0];
        assert!((yaw_rad - 1.234).abs() < 1e-3, "{yaw_rad}");
        assert!((loss - 0.2).abs() < 1e-5, "{loss}");
        assert_eq!((calls.into_inner(), found.curve.len(), found.top.len()), (1192, 72, 8));
        assert!(found.top.is_sorted_by(|a, b| a.loss <= b.loss));
    }

    #[test]
    fn the_first_step_is_as_long_as_the_learning_rate() {
        let mut seen = Vec::new();
        let settings = PaperSearch { steps: 2, ..PaperSearch::PUBLISHED };
        let best = adam(&settings, 0.5, |yaw_rad| {
            seen.push(yaw_rad);
            Ok::<_, Infallible>((yaw_rad, 7.0))
        });
        assert!((seen[1] - (0.5 - 3e-2)).abs() < 1e-9, "{seen:?}");
        assert_eq!(best, Ok((seen[1], seen[1])));
    }

    #[test]
    fn keeps_the_best_seen_where_descent_climbs() {
        // The derivative lies: every step leads uphill.
        let best = adam(&PaperSearch::PUBLISHED, 0.1, |yaw_rad| Ok::<_, Infallible>((yaw_rad.abs(), -1.0)));
        assert_eq!(best, Ok((0.1, 0.1)));
    }

    #[test]
    fn a_failure_ends_the_search() {
        let calls = AtomicUsize::new(0);
        let found = search(&PaperSearch::PUBLISHED, |_| {
            let earlier = calls.fetch_add(1, Ordering::Relaxed);
            if earlier >= 80 { Err("interrupted") } else { Ok((0.0, 1.0)) }
        });
        assert_eq!(found, Err("interrupted"));
        // Each of the eight descents fails at its next call.
        assert!(calls.into_inner() <= 80 + 8);
    }
}
