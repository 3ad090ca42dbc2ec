//! Sets of pixels as flags: growing, shrinking, connected parts, holes.

use crate::geometry::distance_transform::distance_transform;

/// Pixels within `radius` of a set one.
pub(in crate::vision) fn grown(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    distance_transform(bits, width, height).iter().map(|&d| d <= radius).collect()
}

/// Pixels farther than `radius` from every clear one; the border of the picture does not count.
pub(in crate::vision) fn shrunk(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    let clear: Vec<bool> = bits.iter().map(|b| !b).collect();
    distance_transform(&clear, width, height).iter().map(|&d| d > radius).collect()
}

/// Shrunk, then grown: thin parts vanish.
pub(in crate::vision) fn opened(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    grown(&shrunk(bits, width, height, radius), width, height, radius)
}

/// Grown, then shrunk: thin gaps close.
pub(in crate::vision) fn closed(bits: &[bool], width: usize, height: usize, radius: f32) -> Vec<bool> {
    shrunk(&grown(bits, width, height, radius), width, height, radius)
}

/// Connected parts (eight neighbors), each as pixel indices in row order of their first pixel.
pub(in crate::vision) fn parts(bits: &[bool], width: usize, height: usize) -> Vec<Vec<usize>> {
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
pub(in crate::vision) fn filled(bits: &[bool], width: usize, height: usize, largest: usize) -> Vec<bool> {
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
    fn parts_holes_and_thin_things() {
        let (bits, w, h) = picture(&["........", ".#####..", ".#...#..", ".#...#.#", ".#####.#", "........"]);
        assert_eq!(parts(&bits, w, h).iter().map(Vec::len).collect::<Vec<_>>(), vec![14, 2]);
        assert_eq!(area(&filled(&bits, w, h, 100)), 14 + 6 + 2);
        assert_eq!(area(&filled(&bits, w, h, 5)), 16);
        assert_eq!(area(&opened(&bits, w, h, 1.0)), 0);
        assert!(area(&closed(&bits, w, h, 2.0)) >= 22);
    }
}
