//! Joining hulls that are as good as one.

use glam::DVec3;
use rayon::prelude::*;

use super::DecomposeSettings;
use super::budget::fewer;
use super::excess::excess;
use super::field::Field;
use super::fitted::Fitted;
use crate::geometry::convex_hull::convex_hull;
use crate::geometry::{ConvexHull, Interrupt, Interrupted};

/// What joining a pair would give.
#[derive(Clone)]
struct Joint {
    fitted: Fitted,
    /// Volume it has more than its two parts, m^3.
    added_m3: f64,
}

/// Joins, always the pair whose common hull sticks out the least, until every pair would exceed the tolerance;
/// and goes on beyond it while there are more than `max_hulls`.
pub(super) fn merged(
    hulls: Vec<Fitted>,
    solid: &Field,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Fitted>, Interrupted> {
    let mut pool = Pool::new(hulls, solid, settings, interrupt);
    let allowed_m = settings.tolerance_m;
    pool.consider_all(allowed_m)?;
    pool.join_while(allowed_m, 1)?;
    fewer(pool.hulls, solid, settings, interrupt)
}

struct Pool<'a> {
    hulls: Vec<Fitted>,
    boxes: Vec<(DVec3, DVec3)>,
    volumes_m3: Vec<f64>,
    /// `joints[a][b]` for b < a.
    joints: Vec<Vec<Option<Joint>>>,
    solid: &'a Field<'a>,
    settings: &'a DecomposeSettings,
    interrupt: &'a Interrupt,
}

impl<'a> Pool<'a> {
    fn new(
        hulls: Vec<Fitted>,
        solid: &'a Field<'a>,
        settings: &'a DecomposeSettings,
        interrupt: &'a Interrupt,
    ) -> Self {
        let boxes = hulls.iter().map(|h| boxed(&h.hull)).collect();
        let volumes_m3 = hulls.iter().map(|h| h.hull.volume_m3()).collect();
        let joints = (0..hulls.len()).map(|a| vec![None; a]).collect();
        Self { hulls, boxes, volumes_m3, joints, solid, settings, interrupt }
    }

    fn consider_all(&mut self, allowed_m: f64) -> Result<(), Interrupted> {
        let rows: Vec<Vec<Option<Joint>>> = (0..self.hulls.len())
            .into_par_iter()
            .map(|a| (0..a).map(|b| self.joint(a, b, allowed_m)).collect())
            .collect::<Result<_, Interrupted>>()?;
        self.joints = rows;
        Ok(())
    }

    /// The common hull of a and b, if they are close and it sticks out by at most `allowed_m`.
    fn joint(&self, a: usize, b: usize, allowed_m: f64) -> Result<Option<Joint>, Interrupted> {
        let apart = (self.boxes[a].0 - self.boxes[b].1).max(self.boxes[b].0 - self.boxes[a].1).max_element();
        if apart > 2.0 * allowed_m || self.has_air_between(a, b, allowed_m) {
            return Ok(None);
        }
        let (one, other) = (&self.hulls[a], &self.hulls[b]);
        let points: Vec<DVec3> = one.hull.points.iter().chain(&other.hull.points).copied().collect();
        let Some(hull) = convex_hull(&points, usize::MAX, 0.0) else { return Ok(None) };
        let known_m = one.excess_m.max(other.excess_m).max(0.25 * self.settings.tolerance_m);
        let spacing_m = self.settings.excess_spacing_m;
        let found = excess(&hull, self.solid, spacing_m, known_m, allowed_m, self.interrupt)?;
        let added_m3 = hull.volume_m3() - self.volumes_m3[a] - self.volumes_m3[b];
        let excess_m = found.distance_m.max(one.excess_m).max(other.excess_m);
        let good = found.distance_m <= allowed_m;
        Ok(good.then_some(Joint { fitted: Fitted { hull, excess_m }, added_m3 }))
    }

    /// A quick look for air that the common hull would fill: halfway between corners of the two.
    fn has_air_between(&self, a: usize, b: usize, allowed_m: f64) -> bool {
        const LOOKS: usize = 5;
        let some = |k: usize| {
            let points = &self.hulls[k].hull.points;
            let stride = points.len().div_ceil(LOOKS).max(1);
            points.iter().step_by(stride).copied()
        };
        let mut nearby = self.solid.nearby();
        some(a).any(|p| some(b).any(|q| self.solid.outside_m(0.5 * (p + q), &mut nearby) > allowed_m))
    }

    /// Joins the best pair as long as one is allowed and more than `least` hulls are left.
    fn join_while(&mut self, allowed_m: f64, least: usize) -> Result<(), Interrupted> {
        while self.hulls.len() > least {
            self.interrupt.check()?;
            let best = (0..self.hulls.len())
                .flat_map(|a| (0..a).map(move |b| (a, b)))
                .filter_map(|(a, b)| self.joints[a][b].as_ref().map(|j| ((a, b), j)))
                .min_by(|(_, x), (_, y)| {
                    let key = |j: &Joint| ((j.fitted.excess_m / 1e-4).round(), j.added_m3);
                    let ((xe, xv), (ye, yv)) = (key(x), key(y));
                    xe.total_cmp(&ye).then(xv.total_cmp(&yv))
                })
                .map(|(pair, _)| pair);
            let Some((a, b)) = best else { return Ok(()) };
            self.join(a, b, allowed_m)?;
        }
        Ok(())
    }

    fn join(&mut self, a: usize, b: usize, allowed_m: f64) -> Result<(), Interrupted> {
        let Some(joint) = self.joints[a][b].take() else { return Ok(()) };
        self.boxes[b] = boxed(&joint.fitted.hull);
        self.volumes_m3[b] = joint.fitted.hull.volume_m3();
        self.hulls[b] = joint.fitted;
        self.hulls.remove(a);
        self.boxes.remove(a);
        self.volumes_m3.remove(a);
        self.joints.remove(a);
        self.joints.iter_mut().skip(a).for_each(|row| drop(row.remove(a)));
        let fresh: Vec<Option<Joint>> = (0..self.hulls.len())
            .into_par_iter()
            .map(
                |other| if other == b { Ok(None) } else { self.joint(b.max(other), b.min(other), allowed_m) },
            )
            .collect::<Result<_, Interrupted>>()?;
        for (other, joint) in fresh.into_iter().enumerate() {
            if other != b {
                self.joints[b.max(other)][b.min(other)] = joint;
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
