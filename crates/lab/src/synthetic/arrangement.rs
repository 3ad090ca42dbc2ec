//! Where things stand: side by side, touching, on and in each other.
//!
//! Things are dropped at random places until they fit: their hulls seen from above keep a gap on the same support, and
//! on a carrier enough of the underside must meet it around the middle. What finds no place is left out.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::draw::{chance, uniform};
use super::relief::Relief;
use super::thing::Thing;
use geometry::collide::convex_hull_2d;
use geometry::{Outline, Pose};
use runtime::seed::Rng;

/// Places tried for each thing.
const TRIES: usize = 40;
/// An underside meets what is below where it comes this near, meters.
const CONTACT_M: f64 = 0.003;

/// A thing in its place.
pub(super) struct Placed {
    pub thing: Thing,
    pub world_from_object: Pose,
    /// Index of what carries it; `None` = the table.
    pub stands_on: Option<usize>,
    /// Whether it stands in a hollow of its carrier rather than on top of it.
    pub inside: bool,
    /// Hull seen from above, world.
    pub footprint: Vec<DVec2>,
}

/// How a picture's things are spread.
#[derive(Clone, Copy, Debug)]
pub(super) struct Habits {
    /// Usual gap between neighbors, meters.
    pub gap_m: f64,
    /// Share of things that try to stand on another.
    pub stacked_share: f64,
    /// Share of things that seek the neighborhood of another.
    pub huddled_share: f64,
    /// Distance kept from the edge, meters.
    pub margin_m: f64,
}

impl Habits {
    pub(super) fn draw(rng: &mut Rng) -> Self {
        Self {
            gap_m: if chance(rng, 0.3) { 0.001 } else { uniform(rng, 0.003, 0.05) },
            stacked_share: if chance(rng, 0.5) { uniform(rng, 0.05, 0.5) } else { 0.05 },
            huddled_share: if chance(rng, 0.4) { uniform(rng, 0.3, 0.9) } else { 0.15 },
            margin_m: uniform(rng, 0.002, 0.04),
        }
    }
}

/// Puts the things down one after the other; larger ones first.
pub(super) fn arrange(
    mut things: Vec<Thing>,
    outline: &Outline,
    habits: Habits,
    rng: &mut Rng,
) -> Vec<Placed> {
    let area = |thing: &Thing| Outline::new(thing.footprint.clone()).map_or(0.0, |outline| outline.area_m2());
    things.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let mut placed: Vec<Placed> = Vec::new();
    for thing in things {
        let upward = chance(rng, habits.stacked_share);
        let found = upward.then(|| on_another(&thing, &placed, rng)).flatten();
        placed.extend(found.or_else(|| on_table(&thing, outline, &placed, habits, rng)));
    }
    placed
}

fn yaw(thing: &Thing, rng: &mut Rng) -> f64 {
    if thing.faces_viewer && chance(rng, 0.6) {
        uniform(rng, -0.5, 0.5) * uniform(rng, 0.0, 1.0)
    } else if chance(rng, 0.25) {
        FRAC_PI_2 * f64::from(rng.random_range(0..4)) + uniform(rng, -0.06, 0.06)
    } else {
        uniform(rng, -PI, PI)
    }
}

fn on_table(
    thing: &Thing,
    outline: &Outline,
    placed: &[Placed],
    habits: Habits,
    rng: &mut Rng,
) -> Option<Placed> {
    let (low, high) = outline.bounds();
    let neighbors: Vec<&Placed> = placed.iter().filter(|other| other.stands_on.is_none()).collect();
    for _ in 0..TRIES {
        let yaw_rad = yaw(thing, rng);
        let at = if !neighbors.is_empty() && chance(rng, habits.huddled_share) {
            let near = neighbors[rng.random_range(0..neighbors.len())];
            let reach = radius(&near.footprint) + radius(&thing.footprint);
            near.world_from_object.translation_m.truncate()
                + DVec2::from_angle(uniform(rng, -PI, PI)) * reach * uniform(rng, 0.6, 1.2)
        } else {
            DVec2::new(uniform(rng, low.x, high.x), uniform(rng, low.y, high.y))
        };
        let pose = Pose::upright(at.extend(0.0), yaw_rad);
        let footprint = thing.footprint_in(&pose);
        let gap_m = habits.gap_m * uniform(rng, 0.3, 1.0);
        let inside = footprint.iter().all(|p| outline.depth_inside_m(*p) >= habits.margin_m);
        if inside && neighbors.iter().all(|other| separation(&footprint, &other.footprint) >= gap_m) {
            return Some(Placed {
                thing: thing.clone(),
                world_from_object: pose,
                stands_on: None,
                inside: false,
                footprint,
            });
        }
    }
    None
}

fn on_another(thing: &Thing, placed: &[Placed], rng: &mut Rng) -> Option<Placed> {
    let size = radius(&thing.footprint);
    let fits = |other: &Placed| {
        (other.thing.carries || other.thing.contains)
            && depth(placed, other) < 2
            && radius(&other.footprint) > 0.75 * size
    };
    let carriers: Vec<usize> = (0..placed.len()).filter(|&k| fits(&placed[k])).collect();
    for _ in 0..6 {
        if carriers.is_empty() {
            return None;
        }
        let carrier = carriers[rng.random_range(0..carriers.len())];
        let below = &placed[carrier];
        let carrier_yaw = below.world_from_object.yaw_rad().unwrap_or(0.0);
        let yaw_rad = if chance(rng, 0.4) { carrier_yaw + uniform(rng, -0.1, 0.1) } else { yaw(thing, rng) };
        let tops = Relief::above(&below.thing.mesh, carrier_yaw);
        let soles = Relief::below(&thing.mesh, yaw_rad);
        let spread = (radius(&below.footprint) - 0.6 * size).max(0.01);
        let origin = below.world_from_object.translation_m;
        for _ in 0..5 {
            let off = DVec2::from_angle(uniform(rng, -PI, PI)) * spread * uniform(rng, 0.0, 0.9);
            let Some(rise_m) = rest(&soles, &tops, off) else { continue };
            let pose = Pose::upright(origin + off.extend(rise_m), yaw_rad);
            let footprint = thing.footprint_in(&pose);
            let alone = placed
                .iter()
                .filter(|other| other.stands_on == Some(carrier))
                .all(|sibling| separation(&footprint, &sibling.footprint) > 0.001);
            // What reaches out beyond its carrier must not run into what stands beside that.
            let clear = placed.iter().enumerate().all(|(k, other)| {
                k == carrier
                    || other.stands_on.is_some()
                    || separation(&footprint, &other.footprint) > 0.0
                    || holds(placed, carrier, k)
            });
            if alone && clear {
                let inside = below.thing.contains && rise_m < 0.7 * below.thing.mesh.size_m().z;
                return Some(Placed {
                    thing: thing.clone(),
                    world_from_object: pose,
                    stands_on: Some(carrier),
                    inside,
                    footprint,
                });
            }
        }
    }
    None
}

/// Height of the thing's base above the carrier's where it comes to rest; `None` where it would tip.
fn rest(soles: &Relief, tops: &Relief, off: DVec2) -> Option<f64> {
    let gaps: Vec<(DVec2, Option<f64>)> = soles
        .cells()
        .map(|(place, sole_m)| (place, tops.at(place + off).map(|top_m| top_m - sole_m)))
        .collect();
    let rise_m = gaps.iter().filter_map(|(_, gap)| *gap).fold(f64::NEG_INFINITY, f64::max);
    let met: Vec<DVec2> = gaps
        .iter()
        .filter(|(_, gap)| gap.is_some_and(|gap| gap > rise_m - CONTACT_M))
        .map(|(place, _)| *place)
        .collect();
    let middle = gaps.iter().map(|(place, _)| *place).sum::<DVec2>() / gaps.len().max(1) as f64;
    let hull = convex_hull_2d(&met);
    let carried = hull.len() >= 3 && Outline::new(hull).is_ok_and(|hull| hull.depth_inside_m(middle) > 0.002);
    (rise_m.is_finite() && carried).then_some(rise_m)
}

/// How many carriers are below it.
fn depth(placed: &[Placed], of: &Placed) -> usize {
    of.stands_on.map_or(0, |carrier| 1 + depth(placed, &placed[carrier]))
}

/// Whether `carrier` stands on number `k`, directly or not.
fn holds(placed: &[Placed], carrier: usize, k: usize) -> bool {
    placed[carrier].stands_on.is_some_and(|next| next == k || holds(placed, next, k))
}

/// Half the largest extent from the middle.
fn radius(footprint: &[DVec2]) -> f64 {
    let middle = footprint.iter().sum::<DVec2>() / footprint.len().max(1) as f64;
    footprint.iter().map(|p| (*p - middle).length()).fold(0.0, f64::max)
}

/// Distance between two counter-clockwise convex polygons along the best of their sides' normals: at most the true
/// distance, negative where they overlap.
fn separation(a: &[DVec2], b: &[DVec2]) -> f64 {
    let along = |a: &[DVec2], b: &[DVec2]| {
        (0..a.len())
            .map(|k| {
                let outward = -(a[(k + 1) % a.len()] - a[k]).perp().normalize_or_zero();
                b.iter().map(|p| outward.dot(*p - a[k])).fold(f64::INFINITY, f64::min)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    along(a, b).max(along(b, a))
}

/// Hull of the corners within [`CONTACT_M`] of the lowest, and their height: what it stands on, world.
pub(super) fn contact(placed: &Placed) -> (Vec<DVec2>, f64) {
    let corners: Vec<DVec3> =
        placed.thing.mesh.positions.iter().map(|p| placed.world_from_object.transform_point(*p)).collect();
    let low_m = corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let met: Vec<DVec2> = corners.iter().filter(|p| p.z < low_m + CONTACT_M).map(|p| p.truncate()).collect();
    (convex_hull_2d(&met), low_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separation_is_the_gap_between_boxes() {
        let square =
            |x: f64| [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| DVec2::new(u + x, v));
        assert!((separation(&square(0.0), &square(1.5)) - 0.5).abs() < 1e-12);
        assert!((separation(&square(0.0), &square(0.75)) + 0.25).abs() < 1e-12);
    }
}
