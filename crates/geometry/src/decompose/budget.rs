//! Fewer hulls: joining on when the tolerance asks for more hulls than there may be.
//!
//! Always the two hulls are joined whose common hull encloses the least that neither of them did (what few corners
//! lose counted in), as long as it does not stick out too far: else a small hole of a handle would be closed first.
//! Hulls of pieces cut by planes do not overlap, so the sum of what is added is what the union of all hulls grows by.

use glam::DVec3;
use rayon::prelude::*;

use super::DecomposeSettings;
use super::excess::excess;
use super::field::Field;
use super::fitted::Fitted;
use crate::ConvexHull;
use crate::convex_hull::{convex_hull, loss_of_corners_m3, planes};
use runtime::{Interrupt, Interrupted};

/// A hull with its faces and its box.
struct Part {
    hull: ConvexHull,
    volume_m3: f64,
    /// About what it loses when it is left with few corners.
    missed_m3: f64,
    faces: Vec<(DVec3, f64)>,
    low: DVec3,
    high: DVec3,
    /// How far it sticks out; `None` for one joined here.
    excess_m: Option<f64>,
}

/// What is known of two parts.
#[derive(Clone)]
enum Pair {
    /// Their boxes are too far from each other.
    Apart,
    /// Their common hull sticks out by at least this, meters.
    Beyond(f64),
    Joint(Joint),
}

/// What joining two parts would give.
#[derive(Clone)]
struct Joint {
    hull: ConvexHull,
    added_m3: f64,
    /// It sticks out by at least this, meters.
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

/// At most `max_hulls` hulls, each with how far it sticks out.
pub(super) fn fewer(
    hulls: Vec<Fitted>,
    solid: &Field,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Fitted>, Interrupted> {
    let most = settings.max_hulls as usize;
    if hulls.len() <= most {
        return Ok(hulls);
    }
    let corners = settings.max_vertices as usize;
    let parts: Vec<Part> = hulls.into_iter().map(|f| Part::new(f.hull, Some(f.excess_m), corners)).collect();
    let mut pool = Pool::new(parts, solid, settings, interrupt);
    let mut allowed_m = settings.joined_excess_m;
    pool.look_at_all(TOUCHING_M, allowed_m);
    while pool.parts.len() > most && allowed_m < NO_LIMIT_M {
        pool.join_down_to(most, TOUCHING_M, allowed_m)?;
        allowed_m *= RELAX;
    }
    pool.join_down_to(most, TOUCHING_M, f64::INFINITY)?;
    if pool.parts.len() > most {
        pool.look_at_all(f64::INFINITY, f64::INFINITY);
        pool.join_down_to(most, f64::INFINITY, f64::INFINITY)?;
    }
    pool.parts
        .into_par_iter()
        .map(|part| {
            let excess_m = match part.excess_m {
                Some(known) => known,
                None => {
                    let spacing_m = settings.excess_spacing_m;
                    excess(&part.hull, solid, spacing_m, 0.0, f64::INFINITY, interrupt)?.distance_m
                }
            };
            Ok(Fitted { hull: part.hull, excess_m })
        })
        .collect()
}

struct Pool<'a> {
    parts: Vec<Part>,
    /// `pairs[a][b]` for b < a.
    pairs: Vec<Vec<Pair>>,
    solid: &'a Field<'a>,
    settings: &'a DecomposeSettings,
    interrupt: &'a Interrupt,
}

impl<'a> Pool<'a> {
    fn new(
        parts: Vec<Part>,
        solid: &'a Field<'a>,
        settings: &'a DecomposeSettings,
        interrupt: &'a Interrupt,
    ) -> Self {
        Self { parts, pairs: Vec::new(), solid, settings, interrupt }
    }

    /// Looks at the pairs whose boxes are within `reach_m`; those known to stick out by more than `allowed_m` wait.
    fn look_at_all(&mut self, reach_m: f64, allowed_m: f64) {
        self.pairs = (0..self.parts.len())
            .into_par_iter()
            .map(|a| (0..a).map(|b| self.pair(a, b, 0.0, reach_m, allowed_m)).collect())
            .collect();
    }

    /// The pair, whose common hull is known to stick out by at least `at_least_m`.
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

    /// Joins parts whose boxes are within `reach_m` and whose common hull sticks out by at most `allowed_m`.
    fn join_down_to(&mut self, most: usize, reach_m: f64, allowed_m: f64) -> Result<(), Interrupted> {
        if self.parts.len() <= most {
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
        while self.parts.len() > most {
            self.interrupt.check()?;
            let Some((a, b)) = self.best(allowed_m) else { return Ok(()) };
            let Pair::Joint(mut joint) = std::mem::replace(&mut self.pairs[a][b], Pair::Apart) else {
                return Ok(());
            };
            // Only now, as most joints are never the best.
            let excess_m = if allowed_m.is_finite() {
                let (spacing_m, known_m) = (self.settings.excess_spacing_m, self.settings.tolerance_m);
                let found = excess(&joint.hull, self.solid, spacing_m, known_m, allowed_m, self.interrupt)?;
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

    /// The pair whose joint adds the least.
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

    /// Replaces b by the common hull, and drops a and what else lies in that.
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
        // What sticks out too far with one of the two does so with both.
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

/// More than any gap on a table: then nothing keeps two hulls apart.
const NO_LIMIT_M: f64 = 1.0;
/// By how much hulls may stick out more where too many are left.
const RELAX: f64 = 1.5;
/// Hulls whose boxes are this close touch, meters.
const TOUCHING_M: f64 = 1e-4;

/// The common hull, and by what it encloses more than the two.
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
