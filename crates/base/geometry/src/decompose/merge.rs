//! Merging of hulls whose common hull stays within the tolerance.

use glam::DVec3;
use rayon::prelude::*;

use super::DecomposeSettings;
use super::budget::fewer;
use super::excess::excess;
use super::field::Field;
use super::fitted_hull::FittedHull;
use crate::ConvexHull;
use crate::convex_hull::convex_hull;
use runtime::{CancelFlag, Cancelled};

/// Known result for a pair of hulls.
#[derive(Clone)]
enum Pair {
    /// Too far from each other to be merged.
    Apart,
    /// The excess of their common hull is too large; lower bound, meters.
    Refused(f64),
    Good(Joint),
}

/// Result of merging a pair.
#[derive(Clone)]
struct Joint {
    fitted_hull: FittedHull,
    /// Volume that it adds to its two parts, m^3.
    added_m3: f64,
}

/// Sticking out by this much more than allowed is no error of measurement.
const SURELY: f64 = 1.5;

/// Greedy merging: the pair whose common hull has the smallest excess is merged, until every pair would exceed the
/// tolerance. Merging continues beyond it while there are more than `max_hulls`.
pub(super) fn merged(
    hulls: Vec<FittedHull>,
    solid: &Field,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Vec<FittedHull>, Cancelled> {
    let mut pool = Pool::new(hulls, solid, settings, cancel);
    let allowed_m = settings.tolerance_m;
    pool.consider_all(allowed_m)?;
    pool.join_while(allowed_m, 1)?;
    fewer(pool.hulls, solid, settings, cancel)
}

struct Pool<'a> {
    hulls: Vec<FittedHull>,
    boxes: Vec<(DVec3, DVec3)>,
    volumes_m3: Vec<f64>,
    /// `pairs[a][b]` for b < a.
    pairs: Vec<Vec<Pair>>,
    solid: &'a Field<'a>,
    settings: &'a DecomposeSettings,
    cancel: &'a CancelFlag,
}

impl<'a> Pool<'a> {
    fn new(
        hulls: Vec<FittedHull>,
        solid: &'a Field<'a>,
        settings: &'a DecomposeSettings,
        cancel: &'a CancelFlag,
    ) -> Self {
        let boxes = hulls.iter().map(|h| boxed(&h.hull)).collect();
        let volumes_m3 = hulls.iter().map(|h| h.hull.volume_m3()).collect();
        let pairs = (0..hulls.len()).map(|a| vec![Pair::Apart; a]).collect();
        Self { hulls, boxes, volumes_m3, pairs, solid, settings, cancel }
    }

    fn consider_all(&mut self, allowed_m: f64) -> Result<(), Cancelled> {
        self.pairs = (0..self.hulls.len())
            .into_par_iter()
            .map(|a| (0..a).map(|b| self.pair(a, b, allowed_m)).collect())
            .collect::<Result<_, Cancelled>>()?;
        Ok(())
    }

    /// The common hull of a and b, if they are close and its excess is at most `allowed_m`.
    fn pair(&self, a: usize, b: usize, allowed_m: f64) -> Result<Pair, Cancelled> {
        let apart = (self.boxes[a].0 - self.boxes[b].1).max(self.boxes[b].0 - self.boxes[a].1).max_element();
        if apart > 2.0 * allowed_m {
            return Ok(Pair::Apart);
        }
        let air_m = self.air_between_m(a, b);
        if air_m > allowed_m {
            return Ok(Pair::Refused(air_m));
        }
        let (one, other) = (&self.hulls[a], &self.hulls[b]);
        let points: Vec<DVec3> = one.hull.points.iter().chain(&other.hull.points).copied().collect();
        let Some(hull) = convex_hull(&points, usize::MAX, 0.0) else { return Ok(Pair::Apart) };
        let known_m = one.excess_m.max(other.excess_m).max(0.25 * self.settings.tolerance_m);
        let spacing_m = self.settings.excess_spacing_m;
        let found = excess(&hull, self.solid, spacing_m, known_m, allowed_m, self.cancel)?;
        if found.distance_m > allowed_m {
            return Ok(Pair::Refused(found.distance_m));
        }
        let added_m3 = hull.volume_m3() - self.volumes_m3[a] - self.volumes_m3[b];
        let excess_m = found.distance_m.max(one.excess_m).max(other.excess_m);
        Ok(Pair::Good(Joint { fitted_hull: FittedHull { hull, excess_m }, added_m3 }))
    }

    /// Fast estimate of the excess of the common hull: the largest distance outside of midpoints between corners of
    /// both.
    fn air_between_m(&self, a: usize, b: usize) -> f64 {
        const MAX_CORNERS: usize = 5;
        let some = |k: usize| {
            let points = &self.hulls[k].hull.points;
            let stride = points.len().div_ceil(MAX_CORNERS).max(1);
            points.iter().step_by(stride).copied()
        };
        let mut nearby = self.solid.nearby();
        let halfway = some(a).flat_map(|p| some(b).map(move |q| 0.5 * (p + q)));
        halfway.map(|p| self.solid.outside_m(p, &mut nearby)).fold(0.0, f64::max)
    }

    /// Merges the best pair while one is allowed and more than `min_hulls` hulls are left.
    fn join_while(&mut self, allowed_m: f64, min_hulls: usize) -> Result<(), Cancelled> {
        while self.hulls.len() > min_hulls {
            self.cancel.check()?;
            let best = (0..self.hulls.len())
                .flat_map(|a| (0..a).map(move |b| (a, b)))
                .filter_map(|(a, b)| match &self.pairs[a][b] {
                    Pair::Good(joint) => Some(((a, b), joint)),
                    Pair::Apart | Pair::Refused(_) => None,
                })
                .min_by(|(_, x), (_, y)| {
                    let key = |j: &Joint| ((j.fitted_hull.excess_m / 1e-4).round(), j.added_m3);
                    let ((xe, xv), (ye, yv)) = (key(x), key(y));
                    xe.total_cmp(&ye).then(xv.total_cmp(&yv))
                })
                .map(|(pair, _)| pair);
            let Some((a, b)) = best else { return Ok(()) };
            self.join(a, b, allowed_m)?;
        }
        Ok(())
    }

    fn join(&mut self, a: usize, b: usize, allowed_m: f64) -> Result<(), Cancelled> {
        let Pair::Good(joint) = std::mem::replace(&mut self.pairs[a][b], Pair::Apart) else { return Ok(()) };
        // A common hull with both exceeds the mesh at least as much as one with either, except for sampling errors.
        let at_least_m = |c: usize, k: usize| match self.pairs[c.max(k)][c.min(k)] {
            Pair::Refused(at_least_m) => at_least_m,
            _ => 0.0,
        };
        let mut refused_m: Vec<f64> = (0..self.hulls.len())
            .map(|c| if c == a || c == b { 0.0 } else { at_least_m(c, a).max(at_least_m(c, b)) })
            .collect();
        refused_m.remove(a);
        self.boxes[b] = boxed(&joint.fitted_hull.hull);
        self.volumes_m3[b] = joint.fitted_hull.hull.volume_m3();
        self.hulls[b] = joint.fitted_hull;
        self.hulls.remove(a);
        self.boxes.remove(a);
        self.volumes_m3.remove(a);
        self.pairs.remove(a);
        self.pairs.iter_mut().skip(a).for_each(|row| drop(row.remove(a)));
        let fresh: Vec<Pair> = (0..self.hulls.len())
            .into_par_iter()
            .map(|other| match refused_m[other] {
                _ if other == b => Ok(Pair::Apart),
                at_least_m if at_least_m > SURELY * allowed_m => Ok(Pair::Refused(at_least_m)),
                _ => self.pair(b.max(other), b.min(other), allowed_m),
            })
            .collect::<Result<_, Cancelled>>()?;
        for (other, pair) in fresh.into_iter().enumerate() {
            if other != b {
                self.pairs[b.max(other)][b.min(other)] = pair;
            }
        }
        Ok(())
    }
}

fn boxed(hull: &ConvexHull) -> (DVec3, DVec3) {
    hull.points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
}
