//! Ear clipping of a simple polygon. O(n^2), for outlines of at most a few hundred corners.

use glam::DVec2;

/// Triangles (indices into `outline`) of a simple counter-clockwise polygon, themselves
/// counter-clockwise; n - 2 of them.
pub fn triangulate(outline: &[DVec2]) -> Vec<[u32; 3]> {
    let cross = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    let mut left: Vec<u32> = (0..outline.len() as u32).collect();
    let mut triangles = Vec::with_capacity(outline.len().saturating_sub(2));
    while left.len() > 3 {
        let n = left.len();
        let corner = |k: usize| outline[left[k % n] as usize];
        let is_ear = |k: usize| {
            let (a, b, c) = (corner(k + n - 1), corner(k), corner(k + 1));
            cross(a, b, c) > 1e-14
                && !(k + 2..k + n - 1).any(|j| {
                    let p = corner(j);
                    cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0
                })
        };
        // The ear with the best shape comes first, to avoid slivers. A degenerate rest is clipped at its flattest
        // corner.
        let shape = |k: usize| {
            let (a, b, c) = (corner(k + n - 1), corner(k), corner(k + 1));
            let longest =
                (a - b).length_squared().max((b - c).length_squared()).max((c - a).length_squared());
            cross(a, b, c) / longest.max(1e-300)
        };
        let ear = (0..n).filter(|&k| is_ear(k)).max_by(|&i, &j| shape(i).total_cmp(&shape(j)));
        let ear = ear.unwrap_or_else(|| {
            (0..n).min_by(|&i, &j| shape(i).abs().total_cmp(&shape(j).abs())).unwrap_or(0)
        });
        triangles.push([left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]]);
        left.remove(ear);
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangulation_of_a_concave_polygon_keeps_its_area() {
        let outline =
            [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (1.5, 1.0), (0.0, 3.0)].map(|(x, y)| DVec2::new(x, y));
        let area: f64 = triangulate(&outline)
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| outline[v as usize]);
                0.5 * (b - a).perp_dot(c - a)
            })
            .sum();
        assert!((area - 6.0).abs() < 1e-12);
    }
}
