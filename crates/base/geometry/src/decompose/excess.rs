//! Excess of a hull: the largest distance of its surface outside the solid.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::field::Field;
use crate::ConvexHull;
use runtime::{CancelFlag, Cancelled};

/// The excess of a hull and its location.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Excess {
    pub distance_m: f64,
    pub at: DVec3,
}

/// Largest distance of the hull's surface outside the solid, by branch and bound. Distance is 1-Lipschitz, so the
/// triangle with the largest upper bound (its center is far outside, or it is large and unexplored) is halved next.
/// The search ends at a sample spacing of `spacing_m`, if no point can exceed the largest distance found or
/// `known_m`, after [`MAX_SAMPLES`] samples, or at the first sample beyond `enough_m`.
pub(super) fn excess(
    hull: &ConvexHull,
    solid: &Field,
    spacing_m: f64,
    known_m: f64,
    enough_m: f64,
    cancel: &CancelFlag,
) -> Result<Excess, Cancelled> {
    cancel.check()?;
    let mut worst = Excess { distance_m: 0.0, at: hull.points.first().copied().unwrap_or(DVec3::ZERO) };
    let mut open: BinaryHeap<Open> = BinaryHeap::with_capacity(2 * hull.triangles.len());
    // Corners of the triangles in the heap, which is faster if little is moved in it.
    let mut explored: Vec<[DVec3; 3]> = Vec::with_capacity(2 * hull.triangles.len());
    let mut fresh: Vec<[DVec3; 3]> =
        hull.triangles.iter().map(|t| t.map(|v| hull.points[v as usize])).collect();
    let highest = MAX_SAMPLES.max(2 * fresh.len());
    let mut taken = 0;
    let mut nearby = solid.nearby();
    loop {
        for corners in fresh.drain(..) {
            let [a, b, c] = corners;
            let center = (a + b + c) / 3.0;
            let radius = a
                .distance_squared(center)
                .max(b.distance_squared(center))
                .max(c.distance_squared(center))
                .sqrt();
            // The corners of a hull lie in the solid, which bounds the excess of small faces.
            if radius < 0.5 * spacing_m {
                continue;
            }
            taken += 1;
            if solid.outside_at_most_m(center, &mut nearby) + radius <= worst.distance_m.max(known_m) {
                continue;
            }
            let outside = solid.outside_m(center, &mut nearby);
            if outside > worst.distance_m {
                worst = Excess { distance_m: outside, at: center };
                if outside > enough_m {
                    return Ok(worst);
                }
            }
            open.push(Open { reach_m: outside + radius, triangle: explored.len() as u32 });
            explored.push(corners);
        }
        let Some(Open { reach_m, triangle }) = open.pop() else { break };
        if reach_m <= worst.distance_m.max(known_m) || taken >= highest {
            break;
        }
        let [a, b, c] = explored[triangle as usize];
        let (ab, bc, ca) = (a.distance_squared(b), b.distance_squared(c), c.distance_squared(a));
        if ab >= bc && ab >= ca {
            let m = 0.5 * (a + b);
            fresh.extend([[a, m, c], [m, b, c]]);
        } else if bc >= ca {
            let m = 0.5 * (b + c);
            fresh.extend([[a, b, m], [a, m, c]]);
        } else {
            let m = 0.5 * (c + a);
            fresh.extend([[a, b, m], [m, b, c]]);
        }
    }
    Ok(worst)
}

/// Maximum number of samples of a hull, unless it has more faces.
const MAX_SAMPLES: usize = 300;

/// A triangle to explore, with the upper bound of the excess of its points.
struct Open {
    reach_m: f64,
    /// Index among the explored triangles.
    triangle: u32,
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.reach_m.total_cmp(&other.reach_m).is_eq()
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        self.reach_m.total_cmp(&other.reach_m)
    }
}
