//! Object placement: beside, touching, on and in each other.
//!
//! Rejection sampling draws random positions for each object. Footprint hulls keep a gap on a shared support. On
//! another object, enough of the underside must touch the support around its center. Objects without a valid
//! position are dropped.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::height_map::HeightMap;
use super::object::Object;
use super::sampling::{chance, uniform};
use geometry::polygon::convex_hull_2d;
use geometry::{Outline, Pose};
use runtime::seed::Rng;

/// Sampled positions per object.
const TRIES: usize = 40;
/// Maximum distance between an underside and its support that counts as contact, meters.
const CONTACT_M: f64 = 0.003;

/// An object in its world pose.
pub(super) struct Placed {
    pub object: Object,
    pub world_from_object: Pose,
    /// Index of the supporting object; `None` = the table.
    pub stands_on: Option<usize>,
    /// Whether the object stands inside a hollow of its support instead of on its top.
    pub inside: bool,
    /// Convex hull of the vertical projection, world frame.
    pub footprint: Vec<DVec2>,
}

/// Distribution parameters of one image's arrangement.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArrangementStyle {
    /// Typical gap between neighbors, meters.
    pub gap_m: f64,
    /// Probability that an object is placed on another one.
    pub stacked_share: f64,
    /// Probability that an object is placed near another one.
    pub huddled_share: f64,
    /// Minimum distance to the table edge, meters.
    pub margin_m: f64,
}

impl ArrangementStyle {
    pub(super) fn draw(rng: &mut Rng) -> Self {
        Self {
            gap_m: if chance(rng, 0.3) { 0.001 } else { uniform(rng, 0.003, 0.05) },
            stacked_share: if chance(rng, 0.5) { uniform(rng, 0.05, 0.5) } else { 0.05 },
            huddled_share: if chance(rng, 0.4) { uniform(rng, 0.3, 0.9) } else { 0.15 },
            margin_m: uniform(rng, 0.002, 0.04),
        }
    }
}

/// Places the objects one after the other, larger ones first.
pub(super) fn arrange(
    mut objects: Vec<Object>,
    outline: &Outline,
    style: ArrangementStyle,
    rng: &mut Rng,
) -> Vec<Placed> {
    let area =
        |object: &Object| Outline::new(object.footprint.clone()).map_or(0.0, |outline| outline.area_m2());
    objects.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let mut placed: Vec<Placed> = Vec::new();
    for object in objects {
        let upward = chance(rng, style.stacked_share);
        let found = upward.then(|| on_another(&object, &placed, rng)).flatten();
        placed.extend(found.or_else(|| on_table(&object, outline, &placed, style, rng)));
    }
    placed
}

fn yaw(object: &Object, rng: &mut Rng) -> f64 {
    if object.faces_viewer && chance(rng, 0.6) {
        uniform(rng, -0.5, 0.5) * uniform(rng, 0.0, 1.0)
    } else if chance(rng, 0.25) {
        FRAC_PI_2 * f64::from(rng.random_range(0..4)) + uniform(rng, -0.06, 0.06)
    } else {
        uniform(rng, -PI, PI)
    }
}

fn on_table(
    object: &Object,
    outline: &Outline,
    placed: &[Placed],
    style: ArrangementStyle,
    rng: &mut Rng,
) -> Option<Placed> {
    let (low, high) = outline.bounds();
    let neighbors: Vec<&Placed> = placed.iter().filter(|other| other.stands_on.is_none()).collect();
    for _ in 0..TRIES {
        let yaw_rad = yaw(object, rng);
        let at = if !neighbors.is_empty() && chance(rng, style.huddled_share) {
            let near = neighbors[rng.random_range(0..neighbors.len())];
            let reach = radius(&near.footprint) + radius(&object.footprint);
            near.world_from_object.translation_m.truncate()
                + DVec2::from_angle(uniform(rng, -PI, PI)) * reach * uniform(rng, 0.6, 1.2)
        } else {
            DVec2::new(uniform(rng, low.x, high.x), uniform(rng, low.y, high.y))
        };
        let pose = Pose::upright(at.extend(0.0), yaw_rad);
        let footprint = object.footprint_in(&pose);
        let gap_m = style.gap_m * uniform(rng, 0.3, 1.0);
        let inside = footprint.iter().all(|p| outline.depth_inside_m(*p) >= style.margin_m);
        if inside && neighbors.iter().all(|other| separation(&footprint, &other.footprint) >= gap_m) {
            return Some(Placed {
                object: object.clone(),
                world_from_object: pose,
                stands_on: None,
                inside: false,
                footprint,
            });
        }
    }
    None
}

fn on_another(object: &Object, placed: &[Placed], rng: &mut Rng) -> Option<Placed> {
    let size = radius(&object.footprint);
    let fits = |other: &Placed| {
        (other.object.carries || other.object.contains)
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
        let yaw_rad = if chance(rng, 0.4) { carrier_yaw + uniform(rng, -0.1, 0.1) } else { yaw(object, rng) };
        let tops = HeightMap::above(&below.object.mesh, carrier_yaw);
        let soles = HeightMap::below(&object.mesh, yaw_rad);
        let spread = (radius(&below.footprint) - 0.6 * size).max(0.01);
        let origin = below.world_from_object.translation_m;
        for _ in 0..5 {
            let off = DVec2::from_angle(uniform(rng, -PI, PI)) * spread * uniform(rng, 0.0, 0.9);
            let Some(rise_m) = rest(&soles, &tops, off) else { continue };
            let pose = Pose::upright(origin + off.extend(rise_m), yaw_rad);
            let footprint = object.footprint_in(&pose);
            let alone = placed
                .iter()
                .filter(|other| other.stands_on == Some(carrier))
                .all(|sibling| separation(&footprint, &sibling.footprint) > 0.001);
            // Parts that overhang the support must not intersect the support's neighbors.
            let clear = placed.iter().enumerate().all(|(k, other)| {
                k == carrier
                    || other.stands_on.is_some()
                    || separation(&footprint, &other.footprint) > 0.0
                    || holds(placed, carrier, k)
            });
            if alone && clear {
                let inside = below.object.contains && rise_m < 0.7 * below.object.mesh.size_m().z;
                return Some(Placed {
                    object: object.clone(),
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

/// Rest height of the object's base above the base of its support; `None` where the object would tip.
fn rest(soles: &HeightMap, tops: &HeightMap, off: DVec2) -> Option<f64> {
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
    let center = gaps.iter().map(|(place, _)| *place).sum::<DVec2>() / gaps.len().max(1) as f64;
    let hull = convex_hull_2d(&met);
    let carried = hull.len() >= 3 && Outline::new(hull).is_ok_and(|hull| hull.depth_inside_m(center) > 0.002);
    (rise_m.is_finite() && carried).then_some(rise_m)
}

/// Number of supporting objects below it.
fn depth(placed: &[Placed], of: &Placed) -> usize {
    of.stands_on.map_or(0, |carrier| 1 + depth(placed, &placed[carrier]))
}

/// Whether `carrier` stands on object `k`, directly or indirectly.
fn holds(placed: &[Placed], carrier: usize, k: usize) -> bool {
    placed[carrier].stands_on.is_some_and(|next| next == k || holds(placed, next, k))
}

/// Largest distance of a corner from the mean of the corners.
fn radius(footprint: &[DVec2]) -> f64 {
    let center = footprint.iter().sum::<DVec2>() / footprint.len().max(1) as f64;
    footprint.iter().map(|p| (*p - center).length()).fold(0.0, f64::max)
}

/// Shortest side of a footprint that separates it from another, meters.
const MIN_SIDE_M: f64 = 1e-6;

/// Distance between two counter-clockwise convex polygons along the best of their side normals: a lower bound of
/// the true distance, negative where they overlap.
fn separation(a: &[DVec2], b: &[DVec2]) -> f64 {
    let along = |a: &[DVec2], b: &[DVec2]| {
        (0..a.len())
            .map(|k| (k, a[(k + 1) % a.len()] - a[k]))
            // The direction of a shorter side is that of rounding.
            .filter(|(_, side)| side.length() > MIN_SIDE_M)
            .map(|(k, side)| {
                let outward = -side.perp().normalize_or_zero();
                b.iter().map(|p| outward.dot(*p - a[k])).fold(f64::INFINITY, f64::min)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    along(a, b).max(along(b, a))
}

/// Contact patch: hull of the vertices within [`CONTACT_M`] of the lowest one, and their height, world frame.
pub(super) fn contact(placed: &Placed) -> (Vec<DVec2>, f64) {
    let corners: Vec<DVec3> =
        placed.object.mesh.positions.iter().map(|p| placed.world_from_object.transform_point(*p)).collect();
    let low_m = corners.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let met: Vec<DVec2> = corners.iter().filter(|p| p.z < low_m + CONTACT_M).map(|p| p.truncate()).collect();
    (convex_hull_2d(&met), low_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separation_equals_gap_between_boxes() {
        let square =
            |x: f64| [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| DVec2::new(u + x, v));
        assert!((separation(&square(0.0), &square(1.5)) - 0.5).abs() < 1e-12);
        assert!((separation(&square(0.0), &square(0.75)) + 0.25).abs() < 1e-12);
        // A side as long as a rounding error points anywhere.
        let mut rounded = square(0.0).to_vec();
        rounded.insert(2, DVec2::new(1.0 - 1e-13, 1.0 + 1e-13));
        assert!((separation(&rounded, &square(0.75)) + 0.25).abs() < 1e-9);
    }
}
