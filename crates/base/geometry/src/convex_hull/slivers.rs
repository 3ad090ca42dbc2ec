//! Removal of corners that give sliver faces.
//!
//! Corners at the center of an edge and corners that nearly coincide give faces without area, in this triangulation or
//! in that of another program. Programs that build a volume mesh from a hull fail on them (Drake rejects normals of
//! less than 1e-10 m^2), and engines gain nothing from them. Removed are corners that change the surface by less than a
//! micrometer, and of each face without area the corner opposite to its longest edge. Object frame, meters.

use glam::DVec3;

use super::{hull_of, losses_m3};
use crate::ConvexHull;

/// Twice the area of the smallest face that stays, m^2.
const MIN_TWICE_AREA_M2: f64 = 4e-10;
/// Minimum of twice the area as a share of the squared size of the hull: hulls may be made smaller afterwards.
const MIN_TWICE_AREA_SHARE: f64 = 1e-8;
/// Mean distance by which the surface around a corner must shrink with it, meters; others are spared.
const MIN_HEIGHT_M: f64 = 1e-6;
/// Hulls built at most: new faces can be slivers, too.
const ROUNDS: usize = 12;

/// The hull without sliver faces, as far as its corners can be spared.
pub fn without_slivers(hull: ConvexHull) -> ConvexHull {
    let mut best = hull;
    for _ in 0..ROUNDS {
        let spared = spare_corners(&best);
        if spared.is_empty() || best.points.len() < spared.len() + 4 {
            break;
        }
        let left: Vec<DVec3> =
            (0..best.points.len()).filter(|k| !spared.contains(k)).map(|k| best.points[k]).collect();
        match hull_of(&left) {
            Some(hull) => best = hull,
            None => break,
        }
    }
    best
}

/// Corners of slivers and corners that change nothing, no two of them adjacent.
fn spare_corners(hull: &ConvexHull) -> Vec<usize> {
    let (low, high) = hull
        .points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let min_m2 = MIN_TWICE_AREA_M2.max(MIN_TWICE_AREA_SHARE * (high - low).length_squared());
    let mut spared: Vec<usize> = Vec::new();
    let mut touched: Vec<u32> = Vec::new();
    let mut around_m2 = vec![0.0; hull.points.len()];
    for t in &hull.triangles {
        let [a, b, c] = t.map(|v| hull.points[v as usize]);
        t.iter().for_each(|v| around_m2[*v as usize] += 0.5 * (b - a).cross(c - a).length());
    }
    for (k, loss_m3) in losses_m3(hull).into_iter().enumerate() {
        let ring = || hull.triangles.iter().filter(|t| t.contains(&(k as u32))).flatten();
        // A cone over the ring around the corner: a third of its base times its height.
        if 3.0 * loss_m3 < MIN_HEIGHT_M * around_m2[k] && !touched.contains(&(k as u32)) {
            spared.push(k);
            touched.extend(ring());
        }
    }
    for t in &hull.triangles {
        let [a, b, c] = t.map(|v| hull.points[v as usize]);
        if (b - a).cross(c - a).length() >= min_m2 || t.iter().any(|v| touched.contains(v)) {
            continue;
        }
        let opposite = [(b - c).length(), (c - a).length(), (a - b).length()];
        let longest = (0..3).fold(0, |best, k| if opposite[k] > opposite[best] { k } else { best });
        spared.push(t[longest] as usize);
        touched.extend(t);
    }
    spared
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convex_hull::convex_hull;
    use crate::shapes::{block, cylinder};

    fn min_twice_area_m2(hull: &ConvexHull) -> f64 {
        let corners = hull.triangles.iter().map(|t| t.map(|v| hull.points[v as usize]));
        corners.map(|[a, b, c]| (b - a).cross(c - a).length()).fold(f64::INFINITY, f64::min)
    }

    /// Regression: Drake refused hulls whose corners lay at the center of an edge or nearly coincided.
    #[test]
    fn corners_on_edges_and_near_others_are_spared() {
        let size = DVec3::new(0.06, 0.04, 0.002);
        let mut points = block(size).positions;
        // Just outside the center of an edge, and a copy of a corner moved by a nanometer.
        points.push(DVec3::new(0.0, -0.02 - 1e-9, 0.0));
        points.push(DVec3::new(0.01, 0.02 + 2e-9, 0.002));
        points.push(DVec3::new(0.03 + 3e-9, 0.02, 0.002 + 1e-9));
        points.push(DVec3::new(0.03 + 2e-6, 0.02, 0.001));
        let quick = parry3d_f64::transformation::try_convex_hull(&points).expect("a hull");
        let given = ConvexHull { points: quick.0, triangles: quick.1 };
        let cleaned = without_slivers(given.clone());
        assert!(min_twice_area_m2(&cleaned) >= MIN_TWICE_AREA_M2, "{}", min_twice_area_m2(&cleaned));
        assert!((cleaned.volume_m3() / (size.x * size.y * size.z) - 1.0).abs() < 2e-4);
    }

    #[test]
    fn hulls_without_slivers_stay_as_they_are() {
        for solid in [block(DVec3::new(0.3, 0.2, 0.001)), cylinder(0.03, 0.1, 0.002, 32)] {
            let hull = convex_hull(&solid.positions, 64, 0.001).expect("a hull");
            assert_eq!(without_slivers(hull.clone()), hull);
        }
    }
}
