//! Convex polygons in the image.

use geometry::polygon::convex_hull_2d_with_tolerance;
use glam::DVec2;

/// Convex hull by Andrew's monotone chain, in the order of growing angle with y down (clockwise on screen).
/// Collinear points are left out.
pub(crate) fn convex_hull(points: &[DVec2]) -> Vec<DVec2> {
    convex_hull_2d_with_tolerance(points, 1e-12)
}

/// Hull of the pixels' corners.
pub(crate) fn hull_of_pixels(indices: impl Iterator<Item = usize>, width: usize) -> Vec<DVec2> {
    // Only the ends of each row can be corners of the hull.
    let mut rows: std::collections::BTreeMap<usize, (usize, usize)> = std::collections::BTreeMap::new();
    for index in indices {
        let (x, y) = (index % width, index / width);
        let row = rows.entry(y).or_insert((x, x));
        *row = (row.0.min(x), row.1.max(x));
    }
    let corners: Vec<DVec2> = rows
        .iter()
        .flat_map(|(&y, &(x0, x1))| {
            let (y, x0, x1) = (y as f64, x0 as f64, x1 as f64 + 1.0);
            [(x0, y), (x1, y), (x0, y + 1.0), (x1, y + 1.0)].map(|(x, y)| DVec2::new(x, y))
        })
        .collect();
    convex_hull(&corners)
}

/// Enclosed area, positive for the order [`convex_hull`] gives.
pub(crate) fn area(polygon: &[DVec2]) -> f64 {
    (0..polygon.len()).map(|k| 0.5 * polygon[k].perp_dot(polygon[(k + 1) % polygon.len()])).sum()
}

/// The part of a convex polygon inside another (both in [`convex_hull`]'s order): Sutherland and Hodgman.
pub(crate) fn intersection(a: &[DVec2], b: &[DVec2]) -> Vec<DVec2> {
    let mut left = a.to_vec();
    for k in 0..b.len() {
        let (p, q) = (b[k], b[(k + 1) % b.len()]);
        let side = |r: DVec2| (q - p).perp_dot(r - p);
        let input = std::mem::take(&mut left);
        for (j, &here) in input.iter().enumerate() {
            let before = input[(j + input.len() - 1) % input.len()];
            let (s0, s1) = (side(before), side(here));
            if (s0 < 0.0) != (s1 < 0.0) {
                left.push(before + (here - before) * (s0 / (s0 - s1)));
            }
            if s1 >= 0.0 {
                left.push(here);
            }
        }
    }
    left
}

/// Intersection over union of two convex polygons.
pub(crate) fn overlap(a: &[DVec2], b: &[DVec2]) -> f64 {
    let both = area(&intersection(a, b)).max(0.0);
    both / (area(a) + area(b) - both).max(1e-12)
}

/// Whether a convex polygon in [`convex_hull`]'s order contains the point.
pub(crate) fn contains(polygon: &[DVec2], p: DVec2) -> bool {
    (0..polygon.len()).all(|k| {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        (b - a).perp_dot(p - a) >= 0.0
    })
}

/// Whether any simple polygon contains the point (crossings of a ray).
pub(crate) fn encloses(polygon: &[DVec2], p: DVec2) -> bool {
    let sides = (0..polygon.len()).map(|k| (polygon[k], polygon[(k + 1) % polygon.len()]));
    let crossed = sides
        .filter(|(a, b)| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y));
    crossed.count() % 2 == 1
}

/// Intersection of two lines, each through two points; `None` if (nearly) parallel.
pub(crate) fn line_intersection(a: (DVec2, DVec2), b: (DVec2, DVec2)) -> Option<DVec2> {
    let (u, v) = (a.1 - a.0, b.1 - b.0);
    let across = u.perp_dot(v);
    (across.abs() > 1e-9 * u.length() * v.length()).then(|| a.0 + u * ((b.0 - a.0).perp_dot(v) / across))
}

/// Encloses a convex polygon by one of `sides` sides. The side whose removal adds the smallest area is removed
/// repeatedly; its neighbors meet beyond it. `None` if that is impossible.
pub(crate) fn enclosing_polygon(hull: &[DVec2], sides: usize) -> Option<Vec<DVec2>> {
    let mut polygon = hull.to_vec();
    while polygon.len() > sides {
        let n = polygon.len();
        let removal = |k: usize| {
            let [p, a, b, q] = [k + n - 1, k, k + 1, k + 2].map(|j| polygon[j % n]);
            let tip = line_intersection((p, a), (q, b))?;
            // Beyond the removed side, not behind it.
            let ahead = (tip - a).dot(a - p) >= 0.0 && (tip - b).dot(b - q) >= 0.0;
            ahead.then(|| (0.5 * (tip - a).perp_dot(b - a).abs(), tip))
        };
        let (k, (_, tip)) = (0..n)
            .filter_map(|k| removal(k).map(|found| (k, found)))
            .min_by(|x, y| x.1.0.total_cmp(&y.1.0))?;
        polygon[k] = tip;
        polygon.remove((k + 1) % n);
    }
    (polygon.len() == sides).then_some(polygon)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enclosing_polygon_restores_square_with_cut_corners() {
        let cut = [(1.0, 0.0), (9.0, 0.0), (10.0, 1.0), (10.0, 9.5), (9.5, 10.0), (0.0, 10.0), (0.0, 1.0)]
            .map(|(x, y)| DVec2::new(x, y));
        let hull = convex_hull(&cut);
        assert_eq!(hull.len(), 7);
        let square = enclosing_polygon(&hull, 4).expect("four sides");
        assert!((area(&square) - 100.0).abs() < 1e-9);
        assert!((overlap(&hull, &square) - area(&hull) / 100.0).abs() < 1e-9);
        assert!(contains(&square, DVec2::new(5.0, 5.0)) && !contains(&square, DVec2::new(-1.0, 5.0)));
    }
}
