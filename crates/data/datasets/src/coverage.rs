//! Clutter: the share of the table top that objects cover, seen from above.
//!
//! The footprint of an object is the convex hull of the projected corners of its box (`size_m` at its pose). The area
//! of the union, clipped to the table's outline, is integrated over horizontal lines: exact along x, midpoint rule
//! along y. Cost: lines x objects.

use glam::{DVec2, DVec3};

use geometry::polygon::convex_hull_2d;
use scene::{Instance, Scene};

/// Number of lines across the table.
const LINES: usize = 512;

/// Covered area over the area of the table top, 0 to 1.
pub fn covered_share(scene: &Scene) -> f64 {
    let outline = scene.table.outline_m.corners();
    let (low, high) = scene.table.outline_m.bounds();
    let footprints: Vec<Vec<DVec2>> = scene.instances.iter().map(footprint).collect();
    let (mut covered_m, mut whole_m) = (0.0, 0.0);
    for line in 0..LINES {
        let y = low.y + (high.y - low.y) * (line as f64 + 0.5) / LINES as f64;
        let table = crossings(outline, y);
        let objects = united(footprints.iter().flat_map(|footprint| crossings(footprint, y)).collect());
        whole_m += table.iter().map(|[start, end]| end - start).sum::<f64>();
        for [start, end] in table {
            covered_m += objects.iter().map(|[a, b]| (b.min(end) - a.max(start)).max(0.0)).sum::<f64>();
        }
    }
    if whole_m > 0.0 { (covered_m / whole_m).clamp(0.0, 1.0) } else { 0.0 }
}

/// Outline of an object's box, seen from above.
fn footprint(instance: &Instance) -> Vec<DVec2> {
    let half = instance.size_m / 2.0;
    let corners = (0..8).map(|k| {
        let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corner = DVec3::new(sign(0) * half.x, sign(1) * half.y, half.z + sign(2) * half.z);
        instance.world_from_object.transform_point(corner).truncate()
    });
    convex_hull_2d(&corners.filter(|corner| corner.is_finite()).collect::<Vec<_>>())
}

/// Intervals of x in which the line at height `y` lies in the polygon, by the even-odd rule.
fn crossings(polygon: &[DVec2], y: f64) -> Vec<[f64; 2]> {
    let edges =
        polygon.iter().enumerate().map(|(k, &b)| (polygon[(k + polygon.len() - 1) % polygon.len()], b));
    let crossed = edges.filter(|(a, b)| (a.y > y) != (b.y > y));
    let mut at: Vec<f64> = crossed.map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y)).collect();
    at.sort_by(f64::total_cmp);
    at.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// The union of intervals, sorted and disjoint.
fn united(mut intervals: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut union: Vec<[f64; 2]> = Vec::with_capacity(intervals.len());
    for [start, end] in intervals {
        match union.last_mut() {
            Some(last) if start <= last[1] => last[1] = last[1].max(end),
            _ => union.push([start, end]),
        }
    }
    union
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_intervals_count_once() {
        assert_eq!(united(vec![[2.0, 3.0], [0.0, 1.0], [0.5, 1.5]]), [[0.0, 1.5], [2.0, 3.0]]);
    }

    #[test]
    fn a_line_crosses_a_notched_polygon_twice() {
        let corners =
            [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [3.0, 2.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let polygon: Vec<DVec2> = corners.map(DVec2::from).to_vec();
        assert_eq!(crossings(&polygon, 0.5), [[0.0, 4.0]]);
        assert_eq!(crossings(&polygon, 1.5), [[0.0, 1.0], [3.0, 4.0]]);
    }
}
