//! Binary morphology on flags a pixel: dilation, erosion, opening, connected components, holes.

use imaging::distance_transform::distance_transform;

/// Radius up to which a disc is stamped along the boundary; beyond, the distance transform of the whole image is
/// cheaper.
const MAX_STAMP_RADIUS: f32 = 8.0;

/// Dilation with a disc: pixels within `radius` of a set one.
pub(crate) fn dilate(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    if radius > MAX_STAMP_RADIUS {
        return distance_transform(bits, width, height).iter().map(|&d| d <= radius).collect();
    }
    let reach = radius as i64;
    let disc: Vec<(i64, i64)> = (-reach..=reach)
        .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
        .filter(|(dx, dy)| ((dx * dx + dy * dy) as f32).sqrt() <= radius)
        .collect();
    let mut out = bits.to_vec();
    for (index, _) in bits.iter().enumerate().filter(|(_, set)| **set) {
        let (x, y) = (index % width, index / width);
        // The set pixel nearest to a clear one always has a clear neighbor itself.
        let inner = (x == 0 || bits[index - 1])
            && (x + 1 == width || bits[index + 1])
            && (y == 0 || bits[index - width])
            && (y + 1 == height || bits[index + width]);
        if inner {
            continue;
        }
        for (dx, dy) in &disc {
            let (u, v) = (x as i64 + dx, y as i64 + dy);
            if u >= 0 && v >= 0 && u < width as i64 && v < height as i64 {
                out[v as usize * width + u as usize] = true;
            }
        }
    }
    out
}

/// Erosion with a disc: pixels farther than `radius` from every clear one. The border of the image does not count
/// as clear.
pub(crate) fn erode(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    let clear: Vec<bool> = bits.iter().map(|b| !b).collect();
    dilate(&clear, width, height, radius).iter().map(|b| !b).collect()
}

/// Opening: erosion, then dilation. Thin parts vanish.
pub(crate) fn open(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    dilate(&erode(bits, width, height, radius), width, height, radius)
}

/// Connected components (eight neighbors), each as pixel indices, in the row order of their first pixels.
pub(crate) fn connected_components(bits: &[bool], width: usize, height: usize) -> Vec<Vec<usize>> {
    let mut seen = vec![false; bits.len()];
    let mut found = Vec::new();
    let mut stack = Vec::new();
    for start in 0..bits.len() {
        if !bits[start] || seen[start] {
            continue;
        }
        let mut part = Vec::new();
        seen[start] = true;
        stack.push(start);
        while let Some(at) = stack.pop() {
            part.push(at);
            let (x, y) = (at % width, at / width);
            for v in y.saturating_sub(1)..(y + 2).min(height) {
                for u in x.saturating_sub(1)..(x + 2).min(width) {
                    let next = v * width + u;
                    if bits[next] && !seen[next] {
                        seen[next] = true;
                        stack.push(next);
                    }
                }
            }
        }
        found.push(part);
    }
    found
}

/// The set with its holes filled. A hole is a component of clear pixels (four neighbors) that does not reach the
/// border and has at most `largest` pixels.
pub(crate) fn fill_holes(bits: &[bool], width: usize, height: usize, largest: usize) -> Vec<bool> {
    let mut out = bits.to_vec();
    let mut seen = bits.to_vec();
    let mut stack = Vec::new();
    for start in 0..bits.len() {
        if seen[start] {
            continue;
        }
        let (mut hole, mut at_border) = (Vec::new(), false);
        seen[start] = true;
        stack.push(start);
        while let Some(at) = stack.pop() {
            hole.push(at);
            let (x, y) = (at % width, at / width);
            at_border |= x == 0 || y == 0 || x + 1 == width || y + 1 == height;
            let left = (x > 0).then(|| at - 1);
            let right = (x + 1 < width).then(|| at + 1);
            let above = (y > 0).then(|| at - width);
            let below = (y + 1 < height).then(|| at + width);
            for next in [left, right, above, below].into_iter().flatten() {
                if !seen[next] {
                    seen[next] = true;
                    stack.push(next);
                }
            }
        }
        if !at_border && hole.len() <= largest {
            hole.iter().for_each(|&at| out[at] = true);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(bits: &[bool]) -> usize {
        bits.iter().filter(|&&b| b).count()
    }

    fn image(rows: &[&str]) -> (Vec<bool>, usize, usize) {
        let bits = rows.iter().flat_map(|row| row.bytes().map(|b| b == b'#')).collect();
        (bits, rows[0].len(), rows.len())
    }

    #[test]
    fn dilation_by_stamping_equals_distance_transform() {
        let (w, h) = (61, 47);
        let bits: Vec<bool> = (0..w * h).map(|k| (k * 7919 + k / w * 31) % 23 == 0 || k % w > 50).collect();
        for radius in [1.0, 1.5, 2.0, 3.0, 4.5] {
            let slow: Vec<bool> = distance_transform(&bits, w, h).iter().map(|&d| d <= radius).collect();
            assert_eq!(dilate(&bits, w, h, radius), slow, "{radius}");
        }
    }

    #[test]
    fn components_holes_and_opening_of_small_image() {
        let (bits, w, h) = image(&["........", ".#####..", ".#...#..", ".#...#.#", ".#####.#", "........"]);
        assert_eq!(connected_components(&bits, w, h).iter().map(Vec::len).collect::<Vec<_>>(), vec![14, 2]);
        assert_eq!(area(&fill_holes(&bits, w, h, 100)), 14 + 6 + 2);
        assert_eq!(area(&fill_holes(&bits, w, h, 5)), 16);
        assert_eq!(area(&open(&bits, w, h, 1.0)), 0);
        assert!(area(&erode(&dilate(&bits, w, h, 2.0), w, h, 2.0)) >= 22);
    }
}
