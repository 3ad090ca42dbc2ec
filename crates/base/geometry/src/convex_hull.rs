//! The convex hull of a cloud of points, with a bound on its corners and a least thickness.
//!
//! Physics engines want few corners (a GPU rigid-body engine takes 64) and no hull without volume. Corners are left out
//! greedily, always those whose loss costs the least volume; the outlines of flat faces along the axes stay, so that
//! what stands on four corners goes on doing so. Then the hull grows until it has the volume it had, and
//! misses no corner by much, but never beyond the cloud's box: flat bottoms stay where they are. Meters, any
//! frame. Milliseconds for a thousand points.

mod halves;
mod slivers;

use std::borrow::Cow;
use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use parry3d_f64::math::MatExt;
use parry3d_f64::transformation::try_convex_hull;
use wide::f64x4;

pub use self::halves::convex_hulls;
pub use self::slivers::without_slivers;
use super::ConvexHull;

/// Hull of `points` with at most `max_vertices` corners, at least `min_thickness_m` thick; `None` for
/// fewer than three distinct points or points on a line.
pub fn convex_hull(points: &[DVec3], max_vertices: usize, min_thickness_m: f64) -> Option<ConvexHull> {
    let full = hull_of(points).filter(|hull| is_thick(hull, min_thickness_m));
    let full = match full {
        Some(full) => full,
        None if min_thickness_m > 0.0 => hull_of(&thickened(points, min_thickness_m)?)?,
        None => return None,
    };
    if full.points.len() <= max_vertices {
        return Some(full);
    }
    simplified(&full, max_vertices)
}

/// Largest signed distance of the point above a face of the hull: negative inside (then the depth).
pub fn distance_above(planes: &[(DVec3, f64)], point: DVec3) -> f64 {
    planes.iter().map(|(normal, offset)| normal.dot(point) - offset).fold(f64::NEG_INFINITY, f64::max)
}

/// Outward unit normal and offset of each face.
pub fn planes(hull: &ConvexHull) -> Vec<(DVec3, f64)> {
    hull.triangles
        .iter()
        .filter_map(|t| {
            let [a, b, c] = t.map(|v| hull.points[v as usize]);
            let normal = (b - a).cross(c - a).try_normalize()?;
            Some((normal, normal.dot(a)))
        })
        .collect()
}

/// Planes in groups of four, for SIMD distance tests of one point against many planes.
pub struct FlatPlanes(Vec<[f64x4; 4]>);

impl FlatPlanes {
    pub fn of(planes: &[(DVec3, f64)]) -> Self {
        // No point is above a plane at infinity.
        let at =
            |chunk: &[(DVec3, f64)], k: usize| chunk.get(k).copied().unwrap_or((DVec3::ZERO, f64::INFINITY));
        let four = |chunk: &[(DVec3, f64)]| {
            let four = [0, 1, 2, 3].map(|k| at(chunk, k));
            let axis = |axis: usize| f64x4::from(four.map(|(normal, _)| normal[axis]));
            [axis(0), axis(1), axis(2), f64x4::from(four.map(|(_, offset)| offset))]
        };
        Self(planes.chunks(4).map(four).collect())
    }

    /// As [`distance_above`], the same number.
    pub fn distance_above(&self, point: DVec3) -> f64 {
        let [x, y, z] = point.to_array().map(f64x4::splat);
        let mut highest = f64x4::splat(f64::NEG_INFINITY);
        for [normal_x, normal_y, normal_z, offset] in &self.0 {
            highest = (*normal_x * x + *normal_y * y + *normal_z * z - *offset).fast_max(highest);
        }
        highest.to_array().into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// As [`distance_above`](Self::distance_above); `None` if that is `limit_m` or more, which is faster.
    pub fn distance_above_below(&self, point: DVec3, limit_m: f64) -> Option<f64> {
        let [x, y, z] = point.to_array().map(f64x4::splat);
        let limit = f64x4::splat(limit_m);
        let mut highest = f64x4::splat(f64::NEG_INFINITY);
        for [normal_x, normal_y, normal_z, offset] in &self.0 {
            highest = (*normal_x * x + *normal_y * y + *normal_z * z - *offset).fast_max(highest);
            if highest.simd_ge(limit).any() {
                return None;
            }
        }
        Some(highest.to_array().into_iter().fold(f64::NEG_INFINITY, f64::max))
    }
}

/// Sufficient test that the hull is at least `min_m` thick everywhere: its width is at least twice its inradius,
/// which is at least volume / area.
fn is_thick(hull: &ConvexHull, min_m: f64) -> bool {
    2.0 * hull.volume_m3() >= min_m * area_m2(hull)
}

fn hull_of(points: &[DVec3]) -> Option<ConvexHull> {
    // Nearly equal or nearly coplanar points can defeat the incremental hull; a coarser grid removes them.
    [0.0, 1e-7, 1e-6, 1e-5, 1e-4].into_iter().find_map(|grid_m| {
        let snapped = if grid_m > 0.0 { Cow::Owned(snapped(points, grid_m)) } else { Cow::Borrowed(points) };
        let (points, triangles) = try_convex_hull(&snapped).ok()?;
        let hull = ConvexHull { points, triangles };
        is_sound(&hull, &snapped).then_some(hull)
    })
}

/// The points rounded to a grid, without repeats, in an order independent of the input order.
fn snapped(points: &[DVec3], grid_m: f64) -> Vec<DVec3> {
    let mut cells: Vec<[i64; 3]> =
        points.iter().map(|p| (*p / grid_m).round().to_array().map(|c| c as i64)).collect();
    cells.sort_unstable();
    cells.dedup();
    cells.into_iter().map(|c| DVec3::from_array(c.map(|x| x as f64 * grid_m))).collect()
}

/// Whether the faces form a closed surface with positive volume and no point is outside. If there are many points and
/// faces, only a subset of the points is tested.
fn is_sound(hull: &ConvexHull, points: &[DVec3]) -> bool {
    const MAX_TESTS: usize = 20_000;
    let (low, high) = points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let tolerance_m = 1e-5 + 1e-6 * (high - low).length();
    let faces = planes(hull);
    let stride = (points.len() * faces.len()).div_ceil(MAX_TESTS).max(1);
    let faces = FlatPlanes::of(&faces);
    // Euler's formula for a closed surface of triangles without holes: V - E + F = 2 with 2 E = 3 F.
    hull.triangles.len() + 4 == 2 * hull.points.len()
        && hull.volume_m3() > 0.0
        && points.iter().step_by(stride).all(|&p| faces.distance_above(p) < tolerance_m)
}

/// Points this close to the lowest (highest, ...) one lie in a flat face with it, meters.
const FLAT_M: f64 = 1e-6;

/// Corners kept of the outline of a flat face: of the bottom and the top, which carry, and of the sides.
const CORNERS_OF_A_BASE: usize = 8;
const CORNERS_OF_A_SIDE: usize = 4;

/// The corners that keep flat what is flat along an axis: of the points lowest along -z, +z, -x, ... those
/// that are extreme within their plane. Of 32 points in a plane one is as extreme as the other, and a hull
/// that kept three of them would rock.
fn corners_of_flat_faces(points: &[DVec3]) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::new();
    for (out, u, v, corners) in [
        (DVec3::NEG_Z, DVec3::X, DVec3::Y, CORNERS_OF_A_BASE),
        (DVec3::Z, DVec3::X, DVec3::Y, CORNERS_OF_A_BASE),
        (DVec3::NEG_X, DVec3::Y, DVec3::Z, CORNERS_OF_A_SIDE),
        (DVec3::X, DVec3::Y, DVec3::Z, CORNERS_OF_A_SIDE),
        (DVec3::NEG_Y, DVec3::X, DVec3::Z, CORNERS_OF_A_SIDE),
        (DVec3::Y, DVec3::X, DVec3::Z, CORNERS_OF_A_SIDE),
    ] {
        let highest = points.iter().map(|p| p.dot(out)).fold(f64::NEG_INFINITY, f64::max);
        let face: Vec<usize> =
            (0..points.len()).filter(|&k| points[k].dot(out) >= highest - FLAT_M).collect();
        for k in 0..corners {
            // Half a step off the axes, so that the two ends of an edge along an axis are both found.
            let (sin, cos) = (TAU * (k as f64 + 0.5) / corners as f64).sin_cos();
            let along = cos * u + sin * v;
            let farthest =
                face.iter().copied().max_by(|&a, &b| points[a].dot(along).total_cmp(&points[b].dot(along)));
            chosen.extend(farthest.filter(|farthest| !chosen.contains(farthest)));
        }
    }
    chosen
}

/// The hull simplified to `max_vertices` corners. Corners with the smallest volume loss are removed first, and the hull
/// then grows back to its volume. A large round hull is simplified by distance instead ([`evenly_missed`]). Corners of
/// flat faces stay.
fn simplified(full: &ConvexHull, max_vertices: usize) -> Option<ConvexHull> {
    let points = &full.points;
    let mut kept: Vec<DVec3> = corners_of_flat_faces(points).into_iter().map(|k| points[k]).collect();
    kept.truncate(max_vertices / 2);
    let mut hull = with_fewer_corners(full.clone(), &kept, max_vertices)?;
    let missing_m = |hull: &ConvexHull| (full.volume_m3() - hull.volume_m3()) / area_m2(hull);
    let (_, outside_m) = farthest_outside(&hull, points)?;
    if outside_m - missing_m(&hull) > MAX_MISSED_M {
        return evenly_missed(points, max_vertices, 0.5).or(Some(hull));
    }
    for _ in 0..GROWTHS {
        match grown(&hull, missing_m(&hull).max(0.0), points).filter(|hull| hull.points.len() <= max_vertices)
        {
            Some(grown) => hull = grown,
            None => break,
        }
    }
    Some(hull)
}

/// Largest distance by which simplification by volume may miss the hull, meters; beyond it, corners are chosen by
/// distance.
const MAX_MISSED_M: f64 = 0.0013;
/// Steps of the growth: corners stopped by the box of the points leave the rest of the growth to others.
const GROWTHS: usize = 3;

/// Greedy subset of the corners: first those of flat faces, then repeatedly the one farthest outside. In the end the
/// hull grows by a share of the remaining error: by half of it, the error of a curved surface is the same on both
/// sides.
fn evenly_missed(points: &[DVec3], max_vertices: usize, share: f64) -> Option<ConvexHull> {
    let mut chosen: Vec<DVec3> = corners_of_flat_faces(points).into_iter().map(|k| points[k]).collect();
    chosen.truncate(max_vertices);
    loop {
        let hull = hull_of(&chosen)?;
        let (farthest, outside_m) = farthest_outside(&hull, points)?;
        if outside_m < 1e-9 || chosen.contains(&farthest) {
            return Some(hull);
        }
        if chosen.len() >= max_vertices {
            let grown = grown(&hull, share * outside_m, points);
            return Some(grown.filter(|grown| grown.points.len() <= max_vertices).unwrap_or(hull));
        }
        chosen.push(farthest);
    }
}

/// Approximate volume that a hull loses when it is simplified to `max_vertices` corners.
pub fn loss_of_corners_m3(hull: &ConvexHull, max_vertices: usize) -> f64 {
    let surplus = hull.points.len().saturating_sub(max_vertices);
    if surplus == 0 {
        return 0.0;
    }
    let mut losses = losses_m3(hull);
    losses.sort_by(f64::total_cmp);
    losses.iter().take(surplus).sum()
}

/// Removes corners until `max_corners` are left, a few at a time, because the loss of one depends on its neighbors.
fn with_fewer_corners(mut hull: ConvexHull, kept: &[DVec3], max_corners: usize) -> Option<ConvexHull> {
    while hull.points.len() > max_corners {
        let surplus = hull.points.len() - max_corners;
        let dropped = min_missed(&hull, kept, surplus.min(surplus / 4 + 4));
        if dropped.is_empty() {
            break;
        }
        let left: Vec<DVec3> =
            (0..hull.points.len()).filter(|k| !dropped.contains(k)).map(|k| hull.points[k]).collect();
        hull = hull_of(&left)?;
    }
    Some(hull)
}

/// The point farthest outside the hull, and how far.
fn farthest_outside(hull: &ConvexHull, points: &[DVec3]) -> Option<(DVec3, f64)> {
    let faces = FlatPlanes::of(&planes(hull));
    points.iter().map(|&p| (p, faces.distance_above(p))).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// At most `max_corners` corners with the smallest volume loss, none adjacent to another, none in `kept`.
fn min_missed(hull: &ConvexHull, kept: &[DVec3], max_corners: usize) -> Vec<usize> {
    let count = hull.points.len();
    let losses = losses_m3(hull);
    let mut order: Vec<(f64, usize)> =
        (0..count).filter(|&k| !kept.contains(&hull.points[k])).map(|k| (losses[k], k)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut neighbors: Vec<Vec<u32>> = vec![Vec::new(); count];
    for t in &hull.triangles {
        (0..3).for_each(|k| neighbors[t[k] as usize].push(t[(k + 1) % 3]));
    }
    let mut dropped: Vec<usize> = Vec::new();
    for (_, k) in order {
        if dropped.len() >= max_corners {
            break;
        }
        if !neighbors[k].iter().any(|&n| dropped.contains(&(n as usize))) {
            dropped.push(k);
        }
    }
    dropped
}

/// The volume that would be lost with each corner alone, m^3.
fn losses_m3(hull: &ConvexHull) -> Vec<f64> {
    // For each corner: the opposite edges of its triangles, which run around it. Those of corner k are the ones from
    // first[k] to first[k + 1].
    let mut first = vec![0_usize; hull.points.len() + 2];
    hull.triangles.iter().flatten().for_each(|&k| first[k as usize + 2] += 1);
    (2..first.len()).for_each(|k| first[k] += first[k - 1]);
    let mut around = vec![(0, 0); 3 * hull.triangles.len()];
    for &[a, b, c] in &hull.triangles {
        for (corner, edge) in [(a, (b, c)), (b, (c, a)), (c, (a, b))] {
            let place = &mut first[corner as usize + 1];
            around[*place] = edge;
            *place += 1;
        }
    }
    // The corner's neighbors close up over it as the faces do that leave the most inside: of those that share one
    // neighbor the best.
    let mut fan: Vec<(DVec3, DVec3)> = Vec::new();
    let mut loss = |k: usize| {
        let at = |v: u32| hull.points[v as usize] - hull.points[k];
        fan.clear();
        fan.extend(around[first[k]..first[k + 1]].iter().map(|&(a, b)| (at(a), at(a).cross(at(b)))));
        let lost = |apex: DVec3| -> f64 { fan.iter().map(|(_, across)| across.dot(apex).abs()).sum() };
        fan.iter().map(|&(apex, _)| lost(apex)).fold(f64::INFINITY, f64::min) / 6.0
    };
    (0..hull.points.len()).map(&mut loss).collect()
}

fn area_m2(hull: &ConvexHull) -> f64 {
    let corners = hull.triangles.iter().map(|t| t.map(|v| hull.points[v as usize]));
    corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

/// Corners moved outward by `distance_m` along their mean face normal, inside the box of `points`.
fn grown(hull: &ConvexHull, distance_m: f64, points: &[DVec3]) -> Option<ConvexHull> {
    let mut normals = vec![DVec3::ZERO; hull.points.len()];
    for t in &hull.triangles {
        let [a, b, c] = t.map(|v| hull.points[v as usize]);
        let area = (b - a).cross(c - a);
        for &v in t {
            normals[v as usize] += area;
        }
    }
    let (low, high) = points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let moved: Vec<DVec3> = hull
        .points
        .iter()
        .zip(&normals)
        .map(|(&p, n)| (p + distance_m * n.normalize_or_zero()).clamp(low, high))
        .collect();
    hull_of(&moved)
}

/// Adds copies of the points if the cloud is thinner than `min_m` along its thinnest direction. No side grows by more
/// than half of that. A cloud that is thin along z grows upward first, so that its rest height does not change.
fn thickened(points: &[DVec3], min_m: f64) -> Option<Vec<DVec3>> {
    let first = *points.first()?;
    let farthest = |from: &dyn Fn(DVec3) -> f64| {
        points.iter().copied().max_by(|a, b| from(*a).total_cmp(&from(*b))).unwrap_or(first)
    };
    let a = farthest(&|p| (p - first).length_squared());
    let along = (a - first).try_normalize()?;
    let off = |p: DVec3| (p - first).reject_from_normalized(along);
    let b = farthest(&|p| off(p).length_squared());
    if off(b).length() < 1e-7 {
        return None;
    }
    let mut directions = vec![DVec3::Z, DVec3::X, DVec3::Y, along.cross(off(b)).normalize()];
    directions.extend(min_spread(points));
    if let Some(hull) = hull_of(points) {
        directions.extend(planes(&hull).into_iter().map(|(normal, _)| normal));
    }
    let extent = |d: DVec3| {
        let (low, high) = points
            .iter()
            .map(|p| p.dot(d))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    let (direction, thin) =
        directions.into_iter().map(|d| (d, extent(d))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut thick = points.to_vec();
    let missing = min_m - thin;
    if missing > 0.0 {
        if direction.z.abs() > 0.9 {
            let up = missing.min(0.5 * min_m);
            thick.iter_mut().for_each(|p| p.z -= missing - up);
            thick.extend(points.iter().map(|&p| p + up * DVec3::Z));
        } else {
            thick.iter_mut().for_each(|p| *p -= 0.5 * missing * direction);
            thick.extend(points.iter().map(|&p| p + 0.5 * missing * direction));
        }
    }
    Some(thick)
}

/// Direction of the smallest variance of the points.
fn min_spread(points: &[DVec3]) -> Option<DVec3> {
    let center = points.iter().sum::<DVec3>() / points.len() as f64;
    let outer = |d: DVec3| DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    let spread = points.iter().map(|p| outer(*p - center)).fold(DMat3::ZERO, |a, b| a + b);
    let axes = spread.symmetric_eigen();
    let (x, y, z) = (axes.eigenvectors.x_axis, axes.eigenvectors.y_axis, axes.eigenvectors.z_axis);
    let by_axis = [(axes.eigenvalues.x, x), (axes.eigenvalues.y, y), (axes.eigenvalues.z, z)];
    by_axis.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).and_then(|(_, axis)| axis.try_normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{block, cylinder, rounded_block, sphere};
    use glam::{DQuat, EulerRot};
    use proptest::prelude::*;

    #[test]
    fn hull_of_a_block_has_eight_corners() {
        let hull = convex_hull(&block(DVec3::new(0.2, 0.1, 0.05)).positions, 64, 0.001).expect("a block");
        assert_eq!((hull.points.len(), hull.triangles.len()), (8, 12));
        assert!((hull.volume_m3() - 0.001).abs() < 1e-12);
    }

    #[test]
    fn simplification_of_a_round_hull_keeps_its_volume() {
        let ball = sphere(0.04, 64);
        let hull = convex_hull(&ball.positions, 64, 0.001).expect("a ball");
        assert!(hull.points.len() <= 64);
        let faces = planes(&hull);
        let worst = ball.positions.iter().map(|&p| distance_above(&faces, p)).fold(0.0, f64::max);
        assert!(worst < 0.0015, "the ball sticks out by {worst}");
        let reach =
            hull.points.iter().map(|p| (*p - DVec3::new(0.0, 0.0, 0.04)).length()).fold(0.0, f64::max);
        assert!(reach < 0.0415, "the hull reaches {reach}");
        let can = convex_hull(&cylinder(0.03, 0.1, 0.002, 64).positions, 64, 0.001).expect("a can");
        let lowest = can.points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        assert!(lowest.abs() < 1e-12, "the bottom stays flat at 0, not {lowest}");
        assert!(can.points.iter().filter(|p| p.z < 1e-9).count() >= 8);
    }

    #[test]
    fn simplification_keeps_the_base_corners_of_a_rounded_board() {
        // Regression: three bottom corners were left, and stacks of books rocked and crept.
        let board = rounded_block(DVec3::new(0.16, 0.23, 0.0025), 0.0012, 0.0008);
        let hull = convex_hull(&board.positions, 64, 0.001).expect("a board");
        let lowest = board.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        for corner in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let reach = |p: &&DVec3| p.x * corner.0 > 0.07 && p.y * corner.1 > 0.1;
            assert!(hull.points.iter().filter(reach).any(|p| p.z - lowest < 1e-9), "no corner at {corner:?}");
        }
    }

    #[test]
    fn thickening_grows_a_card_upward_and_a_sheet_of_paper_on_both_sides() {
        for (height_m, low_m, high_m) in [(0.0006, 0.0, 0.001), (0.0001, -0.0004, 0.0006)] {
            let sheet: Vec<DVec3> = block(DVec3::new(0.2, 0.3, height_m)).positions;
            let hull = convex_hull(&sheet, 64, 0.001).expect("a sheet");
            let z = |f: fn(f64, f64) -> f64, start| hull.points.iter().map(|p| p.z).fold(start, f);
            assert!((z(f64::min, 1.0) - low_m).abs() < 1e-12 && (z(f64::max, -1.0) - high_m).abs() < 1e-9);
        }
        let sheet: Vec<DVec3> = block(DVec3::new(0.2, 0.3, 0.0001)).positions;
        let flat: Vec<DVec3> = sheet.iter().map(|p| p.with_z(0.0)).collect();
        assert!(convex_hull(&flat, 64, 0.001).is_some());
        assert!(convex_hull(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0], 64, 0.001).is_none());
    }

    /// As [`losses_m3`], from the triangles of each corner alone.
    fn slow_losses_m3(hull: &ConvexHull) -> Vec<f64> {
        let loss = |k: usize| {
            let at = |v: u32| hull.points[v as usize] - hull.points[k];
            let opposite = |t: &[u32; 3]| {
                let place = t.iter().position(|&v| v as usize == k)?;
                Some((t[(place + 1) % 3], t[(place + 2) % 3]))
            };
            let around: Vec<(u32, u32)> = hull.triangles.iter().filter_map(opposite).collect();
            let lost = |apex: u32| -> f64 {
                around.iter().map(|&(a, b)| at(a).cross(at(b)).dot(at(apex)).abs()).sum()
            };
            around.iter().map(|&(a, _)| lost(a)).fold(f64::INFINITY, f64::min) / 6.0
        };
        (0..hull.points.len()).map(loss).collect()
    }

    proptest! {
        #[test]
        fn losses_and_limited_distances_are_those_computed_slowly(
            cloud in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..80),
            point in prop::array::uniform3(-2.0..2.0_f64), limit_m in -1.0..1.0_f64,
        ) {
            let cloud: Vec<DVec3> = cloud.into_iter().map(DVec3::from).collect();
            let hull = convex_hull(&cloud, usize::MAX, 0.0).expect("a volume");
            prop_assert_eq!(losses_m3(&hull), slow_losses_m3(&hull));
            let above_m = distance_above(&planes(&hull), DVec3::from(point));
            let faces = FlatPlanes::of(&planes(&hull));
            for limit_m in [limit_m, above_m, above_m.next_up()] {
                let expected = Some(above_m).filter(|&above_m| above_m < limit_m);
                prop_assert_eq!(faces.distance_above_below(DVec3::from(point), limit_m), expected);
            }
        }

        #[test]
        fn thickening_grows_no_side_by_more_than_half_a_millimeter(
            size_m in prop::array::uniform3(0.01..0.2_f64), thickness_m in 0.0..0.002_f64, thin in 0..3_usize,
            turn in prop::array::uniform3(-1.6..1.6_f64), sides in 3..24_usize,
        ) {
            // A round plate, thin along one axis, in any orientation.
            let turn = DQuat::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]);
            let cloud: Vec<DVec3> = (0..2 * sides)
                .map(|k| {
                    let (sin, cos) = (TAU * (k / 2) as f64 / sides as f64).sin_cos();
                    let mut p = DVec3::ZERO;
                    p[(thin + 1) % 3] = size_m[0] * cos;
                    p[(thin + 2) % 3] = size_m[1] * sin;
                    p[thin] = if k % 2 == 0 { 0.0 } else { thickness_m };
                    turn * p
                })
                .collect();
            let hull = convex_hull(&cloud, usize::MAX, 0.001).expect("a plate");
            let normal = turn * [DVec3::X, DVec3::Y, DVec3::Z][thin];
            let extent = |points: &[DVec3]| {
                let along = || points.iter().map(|p| p.dot(normal));
                (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max))
            };
            let (was, is) = (extent(&cloud), extent(&hull.points));
            prop_assert!(was.0 - is.0 < 0.000_501 && is.1 - was.1 < 0.000_501, "{was:?} became {is:?}");
            prop_assert!(is.1 - is.0 > 0.0009, "{is:?}");
        }
    }
}
