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
use crate::geometry::convex_hull::{convex_hull, loss_of_corners_m3, planes};
use crate::geometry::{ConvexHull, Interrupt, Interrupted};

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

/// What joining two parts would give.
#[derive(Clone)]
struct Joint {
    hull: ConvexHull,
    added_m3: f64,
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
    let mut pool = Pool { parts, solid, settings, interrupt };
    let mut allowed_m = settings.joined_excess_m;
    while pool.parts.len() > most && allowed_m < NO_LIMIT_M {
        pool.join_down_to(most, TOUCHING_M, allowed_m)?;
        allowed_m *= RELAX;
    }
    pool.join_down_to(most, TOUCHING_M, f64::INFINITY)?;
    pool.join_down_to(most, f64::INFINITY, f64::INFINITY)?;
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
    solid: &'a Field<'a>,
    settings: &'a DecomposeSettings,
    interrupt: &'a Interrupt,
}

impl Pool<'_> {
    /// Joins parts whose boxes are within `reach_m` and whose common hull sticks out by at most `allowed_m`.
    fn join_down_to(&mut self, most: usize, reach_m: f64, allowed_m: f64) -> Result<(), Interrupted> {
        if self.parts.len() <= most {
            return Ok(());
        }
        let corners = self.settings.max_vertices as usize;
        // `joints[a][b]` for b < a.
        let mut joints: Vec<Vec<Option<Joint>>> = (0..self.parts.len())
            .into_par_iter()
            .map(|a| (0..a).map(|b| joint(&self.parts[a], &self.parts[b], reach_m, corners)).collect())
            .collect();
        while self.parts.len() > most {
            self.interrupt.check()?;
            let best = (0..self.parts.len())
                .flat_map(|a| (0..a).map(move |b| (a, b)))
                .filter_map(|(a, b)| joints[a][b].as_ref().map(|joint| (a, b, joint.added_m3)))
                .min_by(|x, y| x.2.total_cmp(&y.2));
            let Some((a, mut b, _)) = best else { return Ok(()) };
            let Some(of_both) = joints[a][b].take() else { return Ok(()) };
            // Only now, as most joints are never the best.
            let excess_m = if allowed_m.is_finite() {
                let (spacing_m, known_m) = (self.settings.excess_spacing_m, self.settings.tolerance_m);
                let found = excess(&of_both.hull, self.solid, spacing_m, known_m, allowed_m, self.interrupt)?;
                if found.distance_m > allowed_m {
                    continue;
                }
                let known_m = [a, b].map(|k| self.parts[k].excess_m.unwrap_or(0.0));
                Some(found.distance_m.max(known_m[0]).max(known_m[1]))
            } else {
                None
            };
            let joined = Part::new(of_both.hull, excess_m, corners);
            let mut gone: Vec<usize> = (0..self.parts.len())
                .filter(|&c| c == a || (c != b && joined.encloses(&self.parts[c])))
                .collect();
            self.parts[b] = joined;
            while let Some(c) = gone.pop() {
                self.parts.remove(c);
                joints.remove(c);
                joints.iter_mut().skip(c).for_each(|row| drop(row.remove(c)));
                b -= usize::from(c < b);
            }
            let parts = &self.parts;
            let fresh: Vec<Option<Joint>> = (0..parts.len())
                .into_par_iter()
                .map(|c| if c == b { None } else { joint(&parts[b], &parts[c], reach_m, corners) })
                .collect();
            for (c, joint) in fresh.into_iter().enumerate().filter(|(c, _)| *c != b) {
                joints[b.max(c)][b.min(c)] = joint;
            }
        }
        Ok(())
    }
}

/// More than any gap on a table: then nothing keeps two hulls apart.
const NO_LIMIT_M: f64 = 1.0;
/// By how much hulls may stick out more where too many are left.
const RELAX: f64 = 1.5;
/// Hulls whose boxes are this close touch, meters.
const TOUCHING_M: f64 = 1e-4;

fn joint(one: &Part, other: &Part, reach_m: f64, corners: usize) -> Option<Joint> {
    if (one.low - other.high).max(other.low - one.high).max_element() > reach_m {
        return None;
    }
    let points: Vec<DVec3> = one.hull.points.iter().chain(&other.hull.points).copied().collect();
    let hull = convex_hull(&points, usize::MAX, 0.0)?;
    let missed_m3 = loss_of_corners_m3(&hull, corners) - one.missed_m3 - other.missed_m3;
    let added_m3 = hull.volume_m3() - one.volume_m3 - other.volume_m3 + missed_m3;
    Some(Joint { hull, added_m3 })
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
