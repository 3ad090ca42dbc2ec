//! Merging down to the hull budget, if the tolerance requires more hulls than `max_hulls`.
//!
//! The two hulls whose common hull adds the least volume are merged first, including the volume lost by limiting its
//! corners. The excess of the common hull is bounded; otherwise the small hole of a handle would be closed first.
//! Hulls of pieces cut by planes do not overlap, so the sum of the added volumes is the growth of the union of all
//! hulls.

use glam::DVec3;
use rayon::prelude::*;

use super::DecomposeSettings;
use super::excess::excess;
use super::field::Field;
use super::fitted_hull::FittedHull;
use crate::ConvexHull;
use crate::convex_hull::{convex_hull, loss_of_corners_m3, planes};
use runtime::{CancelFlag, Cancelled};

/// A hull with its faces and its bounding box.
struct Part {
    hull: ConvexHull,
    volume_m3: f64,
    /// Approximate volume lost by limiting its corners.
    missed_m3: f64,
    faces: Vec<(DVec3, f64)>,
    low: DVec3,
    high: DVec3,
    /// Excess volume over the solid; `None` for a hull merged here.
    excess_m: Option<f64>,
}

/// Known result for a pair of parts.
#[derive(Clone)]
enum Pair {
    /// No merge: the boxes of the two parts are too far from each other.
    Apart,
    /// Lower bound of the excess of their common hull, meters.
    Beyond(f64),
    Joint(Joint),
}

/// Result of merging two parts.
#[derive(Clone)]
struct Joint {
    hull: ConvexHull,
    added_m3: f64,
    /// Lower bound of its excess, meters.
    at_least_m: f64,
}

impl Pair {
    fn at_least_m(&self) -> f64 {
        match self {
            Self::Apart => 0.0,
            Self::Beyond(at_least_m) => *at_least_m,
            Self::Joint(joint) => joint.at_least_m,
        }
    }
}

/// At most `max_hulls` hulls, each with its excess.
pub(super) fn fewer(
    hulls: Vec<FittedHull>,
    solid: &Field,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Vec<FittedHull>, Cancelled> {
    let highest = settings.max_hulls as usize;
    if hulls.len() <= highest {
        return Ok(hulls);
    }
    let corners = settings.max_vertices as usize;
    let parts: Vec<Part> = hulls.into_iter().map(|f| Part::new(f.hull, Some(f.excess_m), corners)).collect();
    let mut pool = Pool::new(parts, solid, settings, cancel);
    let mut allowed_m = settings.joined_excess_m;
    pool.evaluate_all(TOUCHING_M, allowed_m);
    while pool.parts.len() > highest && allowed_m < NO_LIMIT_M {
        pool.join_down_to(highest, TOUCHING_M, allowed_m)?;
        allowed_m *= RELAX;
    }
    pool.join_down_to(highest, TOUCHING_M, f64::INFINITY)?;
    if pool.parts.len() > highest {
        pool.evaluate_all(f64::INFINITY, f64::INFINITY);
        pool.join_down_to(highest, f64::INFINITY, f64::INFINITY)?;
    }
    pool.parts
        .into_par_iter()
        .map(|part| {
            let excess_m = match part.excess_m {
                Some(known) => known,
                None => {
                    let spacing_m = settings.excess_spacing_m;
                    excess(&part.hull, solid, spacing_m, 0.0, f64::INFINITY, cancel)?.distance_m
                }
            };
            Ok(FittedHull { hull: part.hull, excess_m })
        })
        .collect()
}

struct Pool<'a> {
    parts: Vec<Part>,
    /// `pairs[a][b]` for b < a.
    pairs: Vec<Vec<Pair>>,
    solid: &'a Field<'a>,
    settings: &'a DecomposeSettings,
    cancel: &'a CancelFlag,
}

impl<'a> Pool<'a> {
    fn new(
        parts: Vec<Part>,
        solid: &'a Field<'a>,
        settings: &'a DecomposeSettings,
        cancel: &'a CancelFlag,
    ) -> Self {
        Self { parts, pairs: Vec::new(), solid, settings, cancel }
    }

    /// Evaluates the pairs whose boxes are within `reach_m`, except those whose known excess is above `allowed_m`.
    fn evaluate_all(&mut self, reach_m: f64, allowed_m: f64) {
        self.pairs = (0..self.parts.len())
            .into_par_iter()
            .map(|a| (0..a).map(|b| self.pair(a, b, 0.0, reach_m, allowed_m)).collect())
            .collect();
    }

    /// Evaluates a pair; `at_least_m` is a known lower bound of the excess of its common hull.
    fn pair(&self, a: usize, b: usize, at_least_m: f64, reach_m: f64, allowed_m: f64) -> Pair {
        let (one, other) = (&self.parts[a], &self.parts[b]);
        if (one.low - other.high).max(other.low - one.high).max_element() > reach_m {
            return Pair::Apart;
        }
        let at_least_m = [one, other].iter().filter_map(|part| part.excess_m).fold(at_least_m, f64::max);
        if at_least_m > allowed_m {
            return Pair::Beyond(at_least_m);
        }
        let corners = self.settings.max_vertices as usize;
        joint(one, other, corners)
            .map_or(Pair::Apart, |(hull, added_m3)| Pair::Joint(Joint { hull, added_m3, at_least_m }))
    }

    /// Merges parts whose boxes are within `reach_m` and whose common hull has an excess of at most `allowed_m`.
    fn join_down_to(&mut self, highest: usize, reach_m: f64, allowed_m: f64) -> Result<(), Cancelled> {
        if self.parts.len() <= highest {
            return Ok(());
        }
        let mut pairs = std::mem::take(&mut self.pairs);
        pairs.par_iter_mut().enumerate().for_each(|(a, row)| {
            for (b, pair) in row.iter_mut().enumerate() {
                if let Pair::Beyond(at_least_m) = *pair {
                    *pair = self.pair(a, b, at_least_m, reach_m, allowed_m);
                }
            }
        });
        self.pairs = pairs;
        while self.parts.len() > highest {
            self.cancel.check()?;
            let Some((a, b)) = self.best(allowed_m) else { return Ok(()) };
            let Pair::Joint(mut joint) = std::mem::replace(&mut self.pairs[a][b], Pair::Apart) else {
                return Ok(());
            };
            // Computed late, because most candidates are never the best.
            let excess_m = if allowed_m.is_finite() {
                let (spacing_m, known_m) = (self.settings.excess_spacing_m, self.settings.tolerance_m);
                let found = excess(&joint.hull, self.solid, spacing_m, known_m, allowed_m, self.cancel)?;
                if found.distance_m > allowed_m {
                    joint.at_least_m = found.distance_m;
                    self.pairs[a][b] = Pair::Joint(joint);
                    continue;
                }
                Some(found.distance_m.max(joint.at_least_m))
            } else {
                None
            };
            self.join(a, b, joint.hull, excess_m, reach_m, allowed_m);
        }
        Ok(())
    }

    /// The pair whose merged hull adds the least volume.
    fn best(&self, allowed_m: f64) -> Option<(usize, usize)> {
        let joints =
            (0..self.parts.len()).flat_map(|a| (0..a).map(move |b| (a, b))).filter_map(|(a, b)| match &self
                .pairs[a][b]
            {
                Pair::Joint(joint) if joint.at_least_m <= allowed_m => Some((a, b, joint.added_m3)),
                _ => None,
            });
        joints.min_by(|x, y| x.2.total_cmp(&y.2)).map(|(a, b, _)| (a, b))
    }

    /// Replaces b by the common hull and drops a and all other parts inside it.
    fn join(
        &mut self,
        a: usize,
        mut b: usize,
        hull: ConvexHull,
        excess_m: Option<f64>,
        reach_m: f64,
        allowed_m: f64,
    ) {
        let joined = Part::new(hull, excess_m, self.settings.max_vertices as usize);
        // A common hull with both exceeds the mesh by at least as much as one with either.
        let of = |c: usize, k: usize| if c == k { 0.0 } else { self.pairs[c.max(k)][c.min(k)].at_least_m() };
        let mut at_least_m: Vec<f64> = (0..self.parts.len()).map(|c| of(c, a).max(of(c, b))).collect();
        let mut gone: Vec<usize> = (0..self.parts.len())
            .filter(|&c| c == a || (c != b && joined.encloses(&self.parts[c])))
            .collect();
        self.parts[b] = joined;
        while let Some(c) = gone.pop() {
            self.parts.remove(c);
            at_least_m.remove(c);
            self.pairs.remove(c);
            self.pairs.iter_mut().skip(c).for_each(|row| drop(row.remove(c)));
            b -= usize::from(c < b);
        }
        let fresh: Vec<Pair> = (0..self.parts.len())
            .into_par_iter()
            .map(|c| if c == b { Pair::Apart } else { self.pair(b, c, at_least_m[c], reach_m, allowed_m) })
            .collect();
        for (c, pair) in fresh.into_iter().enumerate().filter(|(c, _)| *c != b) {
            self.pairs[b.max(c)][b.min(c)] = pair;
        }
    }
}

/// Allowed excess above which it is no longer limited, meters; larger than any gap on a table.
const NO_LIMIT_M: f64 = 1.0;
/// Factor by which the allowed excess is raised if too many hulls are left.
const RELAX: f64 = 1.5;
/// Distance of boxes up to which hulls count as touching, meters.
const TOUCHING_M: f64 = 1e-4;

/// The common hull and the volume that it adds to the two.
fn joint(one: &Part, other: &Part, corners: usize) -> Option<(ConvexHull, f64)> {
    let points: Vec<DVec3> = one.hull.points.iter().chain(&other.hull.points).copied().collect();
    let hull = convex_hull(&points, usize::MAX, 0.0)?;
    let missed_m3 = loss_of_corners_m3(&hull, corners) - one.missed_m3 - other.missed_m3;
    let added_m3 = hull.volume_m3() - one.volume_m3 - other.volume_m3 + missed_m3;
    Some((hull, added_m3))
}

impl Part {
    fn new(hull: ConvexHull, excess_m: Option<f64>, corners: usize) -> Self {
        let (low, high) = hull
            .points
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        Self {
            volume_m3: hull.volume_m3(),
            missed_m3: loss_of_corners_m3(&hull, corners),
            faces: planes(&hull),
            hull,
            low,
            high,
            excess_m,
        }
    }

    fn encloses(&self, other: &Part) -> bool {
        other.volume_m3 <= self.volume_m3
            && other.low.cmpge(self.low - ROUNDING_M).all()
            && other.high.cmple(self.high + ROUNDING_M).all()
            && other.hull.points.iter().all(|&p| self.has(p))
    }

    fn has(&self, point: DVec3) -> bool {
        self.faces.iter().all(|(normal, offset_m)| normal.dot(point) <= offset_m + ROUNDING_M)
    }
}

const ROUNDING_M: f64 = 1e-9;
