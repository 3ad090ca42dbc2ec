//! Sets of pixels as flags: growing, shrinking, connected parts, holes.

use imaging::distance_transform::distance_transform;

/// Radius up to which a disc is stamped along the boundary instead of transforming the whole picture.
const STAMPED: f32 = 8.0;

/// Pixels within `radius` of a set one.
pub(crate) fn grown(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    if radius > STAMPED {
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

/// Pixels farther than `radius` from every clear one; the border of the picture does not count.
pub(crate) fn shrunk(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    let clear: Vec<bool> = bits.iter().map(|b| !b).collect();
    grown(&clear, width, height, radius).iter().map(|b| !b).collect()
}

/// Shrunk, then grown: thin parts vanish.
pub(crate) fn opened(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    grown(&shrunk(bits, width, height, radius), width, height, radius)
}

/// Grown, then shrunk: thin gaps close.
pub(crate) fn closed(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    shrunk(&grown(bits, width, height, radius), width, height, radius)
}

/// Connected parts (eight neighbors), each as pixel indices in row order of their first pixel.
pub(crate) fn parts(bits: &[bool], width: usize, height: usize) -> Vec<Vec<usize>> {
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

/// The set without holes: clear pixels not connected (four neighbors) to the picture's border join it,
/// where the hole has at most `largest` pixels.
pub(crate) fn filled(bits: &[bool], width: usize, height: usize, largest: usize) -> Vec<bool> {
    let mut out = bits.to_vec();
    let mut seen = bits.to_vec();
    let mut stack = Vec::new();
    for start in 0..bits.len() {
        if seen[start] {
            continue;
        }
        let (mut hole, mut open) = (Vec::new(), false);
        seen[start] = true;
        stack.push(start);
        while let Some(at) = stack.pop() {
            hole.push(at);
            let (x, y) = (at % width, at / width);
            open |= x == 0 || y == 0 || x + 1 == width || y + 1 == height;
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
        if !open && hole.len() <= largest {
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

    fn picture(rows: &[&str]) -> (Vec<bool>, usize, usize) {
        let bits = rows.iter().flat_map(|row| row.bytes().map(|b| b == b'#')).collect();
        (bits, rows[0].len(), rows.len())
    }

    #[test]
    fn stamping_discs_equals_the_distance_transform() {
        let (w, h) = (61, 47);
        let bits: Vec<bool> = (0..w * h).map(|k| (k * 7919 + k / w * 31) % 23 == 0 || k % w > 50).collect();
        for radius in [1.0, 1.5, 2.0, 3.0, 4.5] {
            let slow: Vec<bool> = distance_transform(&bits, w, h).iter().map(|&d| d <= radius).collect();
            assert_eq!(grown(&bits, w, h, radius), slow, "{radius}");
        }
    }

    #[test]
    fn parts_holes_and_thin_things() {
        let (bits, w, h) = picture(&["........", ".#####..", ".#...#..", ".#...#.#", ".#####.#", "........"]);
        assert_eq!(parts(&bits, w, h).iter().map(Vec::len).collect::<Vec<_>>(), vec![14, 2]);
        assert_eq!(area(&filled(&bits, w, h, 100)), 14 + 6 + 2);
        assert_eq!(area(&filled(&bits, w, h, 5)), 16);
        assert_eq!(area(&opened(&bits, w, h, 1.0)), 0);
        assert!(area(&closed(&bits, w, h, 2.0)) >= 22);
    }
}
