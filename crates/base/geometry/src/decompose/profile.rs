//! Convex partition of a simple polygon, for profiles of bodies of revolution.
//!
//! While a pocket of the polygon is deeper below the polygon's hull than the tolerance, the polygon is cut from the
//! deepest corner of that pocket to the opposite boundary, in the direction that leaves the shallowest pockets. Every
//! corner of a part is a corner of the polygon or lies on one of its edges.

use glam::DVec2;

use crate::polygon::convex_hull_indices;

/// Parts of a counter-clockwise simple polygon whose pockets are at most `tolerance` deep.
pub(super) fn convex_parts(polygon: Vec<DVec2>, tolerance: f64) -> Vec<Vec<DVec2>> {
    /// Maximum number of parts; no profile needs more.
    const MAX_PARTS: usize = 64;
    let mut open = vec![polygon];
    let mut parts = Vec::new();
    while let Some(polygon) = open.pop() {
        let deepest = deepest_corner(&polygon).filter(|&(_, depth)| depth > tolerance);
        let cut = match deepest {
            Some((corner, _)) if parts.len() + open.len() < MAX_PARTS => best_split(&polygon, corner),
            _ => None,
        };
        match cut {
            Some((a, b)) => open.extend([a, b]),
            None => parts.push(polygon),
        }
    }
    parts
}

/// Whether two edges cross, each end of either farther than `slack` from the line of the other.
pub(super) fn crosses_itself(polygon: &[DVec2], slack: f64) -> bool {
    let n = polygon.len();
    let edges: Vec<[DVec2; 2]> = (0..n).map(|k| [polygon[k], polygon[(k + 1) % n]]).collect();
    let on_both_sides = |[a, b]: [DVec2; 2], ends: [DVec2; 2]| {
        let along = (b - a).normalize_or_zero();
        let [from, to] = ends.map(|end| along.perp_dot(end - a));
        from.min(to) < -slack && from.max(to) > slack
    };
    // Edges that share a corner never cross.
    (0..n).any(|j| (0..j).any(|k| on_both_sides(edges[j], edges[k]) && on_both_sides(edges[k], edges[j])))
}

/// The corner farthest below the hull and its depth; `None` for a convex polygon.
fn deepest_corner(polygon: &[DVec2]) -> Option<(usize, f64)> {
    // In the order of the polygon.
    let mut hull = convex_hull_indices(polygon, 0.0);
    hull.sort_unstable();
    let n = polygon.len();
    let mut deepest = None;
    for (h, &from) in hull.iter().enumerate() {
        let to = hull[(h + 1) % hull.len()];
        let edge = (polygon[to] - polygon[from]).normalize_or_zero();
        let mut k = (from + 1) % n;
        while k != to {
            let depth = edge.perp_dot(polygon[k] - polygon[from]);
            if deepest.is_none_or(|(_, highest)| depth > highest) {
                deepest = Some((k, depth));
            }
            k = (k + 1) % n;
        }
    }
    deepest.filter(|&(_, depth)| depth > 0.0)
}

/// The two polygons of a cut.
type Halves = (Vec<DVec2>, Vec<DVec2>);

fn best_split(polygon: &[DVec2], corner: usize) -> Option<Halves> {
    let n = polygon.len();
    let at = polygon[corner];
    let back = (at - polygon[(corner + n - 1) % n]).normalize_or_zero();
    let ahead = (at - polygon[(corner + 1) % n]).normalize_or_zero();
    let across = (back + ahead).normalize_or(back.perp());
    let mut best: Option<(f64, Halves)> = None;
    for direction in [back, ahead, across, DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y] {
        let Some((parts, length)) = split(polygon, corner, direction) else { continue };
        let depth = |part: &[DVec2]| deepest_corner(part).map_or(0.0, |(_, depth)| depth);
        let cost = depth(&parts.0) + depth(&parts.1) + 0.05 * length;
        if best.as_ref().is_none_or(|(lowest, _)| cost < *lowest) {
            best = Some((cost, parts));
        }
    }
    best.map(|(_, parts)| parts)
}

/// Cuts from a corner in a direction that points inside. Also returns the length of the cut.
fn split(polygon: &[DVec2], corner: usize, direction: DVec2) -> Option<(Halves, f64)> {
    let n = polygon.len();
    let at = polygon[corner];
    let (before, after) = (polygon[(corner + n - 1) % n], polygon[(corner + 1) % n]);
    // Inside, seen from a reflex corner: left of the edge that arrives or of the edge that leaves.
    let inside = (at - before).perp_dot(direction) > -1e-9 * (at - before).length()
        || (after - at).perp_dot(direction) > -1e-9 * (after - at).length();
    if direction == DVec2::ZERO || !inside {
        return None;
    }
    let mut hit: Option<(f64, usize)> = None;
    for k in 0..n {
        if k == corner || (k + 1) % n == corner {
            continue;
        }
        let (a, b) = (polygon[k] - at, polygon[(k + 1) % n] - at);
        let (above_a, above_b) = (direction.perp_dot(a), direction.perp_dot(b));
        // The boundary runs counter-clockwise, so leaving the inside it passes from right to left.
        if above_a > 1e-12 || above_b < -1e-12 || above_b - above_a < 1e-15 {
            continue;
        }
        let fraction = -above_a / (above_b - above_a);
        let along = direction.dot(a + fraction * (b - a));
        if along > 1e-9 && hit.is_none_or(|(nearest, _)| along < nearest) {
            hit = Some((along, k));
        }
    }
    let (length, edge) = hit?;
    let mut end = at + length * direction;
    let (from, to) = (polygon[edge], polygon[(edge + 1) % n]);
    // Next to a corner, cut to the corner to avoid slivers.
    let near = 0.05 * (to - from).length();
    if end.distance(from) < near && edge != (corner + 1) % n {
        end = from;
    } else if end.distance(to) < near && (edge + 2) % n != corner {
        end = to;
    }
    let walk = |start: usize, stop: usize, ends: [DVec2; 2]| {
        let mut part = vec![ends[0]];
        let mut k = start;
        loop {
            part.push(polygon[k]);
            if k == stop {
                break;
            }
            k = (k + 1) % n;
        }
        part.push(ends[1]);
        part.dedup();
        if part.len() > 1 && part[0] == part[part.len() - 1] {
            part.pop();
        }
        part
    };
    let one = walk((corner + 1) % n, edge, [at, end]);
    let other = walk((edge + 1) % n, (corner + n - 1) % n, [end, at]);
    let area =
        |part: &[DVec2]| (0..part.len()).map(|k| part[k].perp_dot(part[(k + 1) % part.len()])).sum::<f64>();
    (one.len() > 2 && other.len() > 2 && area(&one) > 0.0 && area(&other) > 0.0)
        .then_some(((one, other), length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(part: &[DVec2]) -> f64 {
        0.5 * (0..part.len()).map(|k| part[k].perp_dot(part[(k + 1) % part.len()])).sum::<f64>()
    }

    #[test]
    fn convex_parts_of_a_cup_are_floor_and_wall() {
        let cup = [(0.0, 0.0), (4.0, 0.0), (4.0, 10.0), (3.6, 10.0), (3.6, 0.5), (0.0, 0.5)];
        let cup: Vec<DVec2> = cup.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let whole = area(&cup);
        let parts = convex_parts(cup, 0.01);
        assert_eq!(parts.len(), 2);
        assert!((parts.iter().map(|p| area(p)).sum::<f64>() - whole).abs() < 1e-9);
    }

    #[test]
    fn crosses_itself_detects_crossings_and_ignores_pockets() {
        // A plate whose underside rises above its upper side beside the foot, millimeters.
        let plate =
            [(0.0, 0.0), (76.5, 0.0), (79.0, 1.5), (127.5, 24.8), (96.3, 16.3), (83.5, 4.6), (0.0, 4.2)];
        let sound: Vec<DVec2> = plate.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let mut crossed = sound.clone();
        crossed[2].y = 2.6;
        assert!(!crosses_itself(&sound, 1e-3) && crosses_itself(&crossed, 1e-3));
        // The column of a round table.
        let column = [(0.0, 75.0), (60.0, 75.0), (65.0, 90.0), (65.0, 200.0), (45.0, 220.0), (40.0, 260.0)]
            .into_iter()
            .chain([(52.0, 360.0), (56.0, 420.0), (45.0, 520.0), (35.0, 590.0), (50.0, 610.0), (50.0, 635.0)])
            .chain([(36.0, 645.0), (50.0, 690.0), (130.0, 708.0), (130.0, 720.0), (0.0, 720.0)]);
        let column: Vec<DVec2> = column.map(|(x, y)| DVec2::new(x, y)).collect();
        assert!(!crosses_itself(&column, 1e-3));
        let touching = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (5.0, 1e-4), (0.0, 10.0)];
        let touching: Vec<DVec2> = touching.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        assert!(!crosses_itself(&touching, 1e-3));
    }

    #[test]
    fn convex_parts_of_a_curved_wall_follow_the_tolerance() {
        let arc = |radius: f64, up: bool| {
            (0..=24).map(move |k| {
                let k = if up { k } else { 24 - k };
                radius * DVec2::from_angle(-1.5 + 1.5 * f64::from(k) / 24.0)
            })
        };
        let wall: Vec<DVec2> = arc(1.0, true).chain(arc(0.95, false)).collect();
        let whole = area(&wall);
        let mut last = 0;
        for tolerance in [0.1, 0.03, 0.01] {
            let parts = convex_parts(wall.clone(), tolerance);
            assert!(parts.len() > last, "{} parts at {tolerance}", parts.len());
            assert!((parts.iter().map(|p| area(p)).sum::<f64>() - whole).abs() < 1e-9);
            assert!(parts.iter().all(|p| deepest_corner(p).is_none_or(|(_, d)| d <= tolerance)));
            last = parts.len();
        }
        assert!(last <= 8, "{last}");
    }
}
