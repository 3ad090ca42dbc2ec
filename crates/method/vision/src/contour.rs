//! Boundary tracing: a set of pixels as a polygon.

use std::collections::HashMap;

use glam::DVec2;

use crate::polygon::area;

/// Outer boundary of the connected component of the first pixel, as corners in pixels (angle grows with y down).
/// Where parts of it touch in corners of pixels alone, it is that of the largest part. It is simplified by Douglas and
/// Peucker to `tolerance_px`.
pub(crate) fn trace(indices: &[usize], width: usize, tolerance_px: f64) -> Vec<DVec2> {
    let Some(&first) = indices.iter().min() else { return Vec::new() };
    let mut inside = vec![false; indices.iter().max().map_or(0, |highest| highest + 1)];
    indices.iter().for_each(|&index| inside[index] = true);
    let is_set = |x: i64, y: i64| {
        let within = x >= 0 && y >= 0 && x < width as i64;
        within && inside.get(y as usize * width + x as usize).is_some_and(|set| *set)
    };
    // The walk follows pixel edges with the set on its right hand (y down), from the top edge of the first pixel.
    let start = ((first % width) as i64, (first / width) as i64);
    let (mut at, mut toward) = (start, (1_i64, 0_i64));
    let mut corners = vec![DVec2::new(at.0 as f64, at.1 as f64)];
    for _ in 0..8 * indices.len() + 8 {
        at = (at.0 + toward.0, at.1 + toward.1);
        // Pixels ahead, on the left and on the right of the corner just reached.
        let ahead = |side: i64| {
            let (dx, dy) = (toward.0 - side * toward.1, toward.1 + side * toward.0);
            let x = at.0 + if dx > 0 { 0 } else { -1 };
            let y = at.1 + if dy > 0 { 0 } else { -1 };
            is_set(x, y)
        };
        let next = if ahead(-1) {
            (toward.1, -toward.0)
        } else if ahead(1) {
            toward
        } else {
            (-toward.1, toward.0)
        };
        if next != toward {
            corners.push(DVec2::new(at.0 as f64, at.1 as f64));
        }
        toward = next;
        if at == start && toward == (1, 0) {
            break;
        }
    }
    corners.dedup();
    if corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    simplify(&largest_loop(&corners), tolerance_px)
}

/// The largest of the loops that a walk consists of, if it visits corners twice. Solids on such a walk would have edges
/// with four faces.
fn largest_loop(corners: &[DVec2]) -> Vec<DVec2> {
    let key = |p: DVec2| [p.x as i64, p.y as i64];
    let (mut open, mut largest): (Vec<DVec2>, Vec<DVec2>) = (Vec::new(), Vec::new());
    let mut places: HashMap<[i64; 2], usize> = HashMap::new();
    for &corner in corners {
        if let Some(&first) = places.get(&key(corner)) {
            let closed = open.split_off(first);
            for p in &closed[1..] {
                places.remove(&key(*p));
            }
            open.push(corner);
            if area(&closed) > area(&largest) {
                largest = closed;
            }
        } else {
            places.insert(key(corner), open.len());
            open.push(corner);
        }
    }
    if area(&open) >= area(&largest) { open } else { largest }
}

fn simplify(corners: &[DVec2], tolerance_px: f64) -> Vec<DVec2> {
    if corners.len() < 4 {
        return corners.to_vec();
    }
    let far = (0..corners.len())
        .max_by(|&i, &j| (corners[i] - corners[0]).length().total_cmp(&(corners[j] - corners[0]).length()))
        .unwrap_or(0);
    let mut kept = vec![false; corners.len()];
    (kept[0], kept[far]) = (true, true);
    let mut spans = vec![(0, far), (far, corners.len())];
    while let Some((i, j)) = spans.pop() {
        let (a, b) = (corners[i], corners[j % corners.len()]);
        let along = (b - a).normalize_or_zero();
        let farthest =
            (i + 1..j).map(|k| (k, along.perp_dot(corners[k] - a).abs())).max_by(|x, y| x.1.total_cmp(&y.1));
        if let Some((k, distance)) = farthest
            && distance > tolerance_px
        {
            kept[k] = true;
            spans.extend([(i, k), (k, j)]);
        }
    }
    corners.iter().zip(kept).filter(|(_, keep)| *keep).map(|(corner, _)| *corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(rows: &[&str]) -> Vec<usize> {
        let width = rows[0].len();
        let row = |(y, row): (usize, &&str)| {
            let set = row.bytes().enumerate().filter(|(_, b)| *b == b'#').map(|(x, _)| y * width + x);
            set.collect::<Vec<usize>>()
        };
        rows.iter().enumerate().flat_map(row).collect()
    }

    #[test]
    fn parts_that_touch_in_corners_are_left_out() {
        let outline = trace(&pixels(&[".#......", "#.####..", "..####..", "..####..", "......##"]), 8, 0.2);
        assert!((area(&outline) - 12.0).abs() < 1e-9, "{outline:?}");
        let corners: std::collections::BTreeSet<[i64; 2]> =
            outline.iter().map(|p| [p.x as i64, p.y as i64]).collect();
        assert_eq!(corners.len(), outline.len(), "{outline:?}");
    }

    #[test]
    fn contour_of_l_shape_has_six_corners_and_its_area() {
        let outline = trace(&pixels(&["......", ".##...", ".##...", ".####.", ".####."]), 6, 0.2);
        assert_eq!(outline.len(), 6, "{outline:?}");
        assert!((area(&outline) - 12.0).abs() < 1e-9);
    }
}
