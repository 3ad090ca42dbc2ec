//! Reference implementation of the soft silhouette and loss, in double precision: every pixel against every face. The
//! fast ones must agree with it, and their derivatives with its central differences.
//!
//! It finds the outline differently: every edge of every face, moved slightly outward, less the parts that each other
//! face covers. It uses no neighbors, no cells and no crossings of edges.

pub mod color;

use glam::DVec2;

/// Distance beyond an edge of the tested position, pixels: far below relevance, far above rounding.
const BEYOND_PX: f64 = 1e-6;

/// Gaps up to this are rounding, pixels.
const NO_GAP_PX: f64 = 1e-9;

/// `eps` of the edge magnitude, as in [`terms`](super::loss::terms).
const EDGE_EPSILON: f64 = 1e-6;

/// Soft coverage of an image's pixels, row-major; `corners` of the faces in pixels.
pub fn coverage(faces: &[[DVec2; 3]], width_px: usize, height_px: usize, sigma_px2: f64) -> Vec<f64> {
    let outline = outline(faces);
    pixel_centers(width_px, height_px)
        .map(|p| {
            let distance2 = outline.iter().map(|s| distance_squared(p, s)).fold(f64::INFINITY, f64::min);
            let inside = faces.iter().any(|face| contains(face, p));
            sigmoid(if inside { distance2 } else { -distance2 } / sigma_px2)
        })
        .collect()
}

/// Liu et al., eq. 1 and 3, unchanged: `1 - prod(1 - D_j)` over the faces. The tests compare [`coverage`] with it; the
/// crate's documentation explains why it is not used.
pub fn coverage_by_product(
    faces: &[[DVec2; 3]],
    width_px: usize,
    height_px: usize,
    sigma_px2: f64,
) -> Vec<f64> {
    pixel_centers(width_px, height_px)
        .map(|p| {
            let nothing: f64 = faces
                .iter()
                .map(|face| {
                    let sides = [[face[0], face[1]], [face[1], face[2]], [face[2], face[0]]];
                    let distance2 =
                        sides.iter().map(|s| distance_squared(p, s)).fold(f64::INFINITY, f64::min);
                    let x = if contains(face, p) { distance2 } else { -distance2 } / sigma_px2;
                    sigmoid(-x)
                })
                .product();
            1.0 - nothing
        })
        .collect()
}

/// The two terms of the loss, silhouette and edge; planes as in [`Target`](super::loss::Target).
pub fn terms(
    coverage: &[f64],
    width_px: usize,
    mask: &[f32],
    known: &[f32],
    distance_px: &[f32],
    side_px: f64,
) -> (f64, f64) {
    let height_px = coverage.len() / width_px;
    let (mut common, mut union, mut far, mut edges) = (0.0, 0.0, 0.0, 0.0);
    for (at, &cover) in coverage.iter().enumerate() {
        let (mask, known) = (f64::from(mask[at]), f64::from(known[at]));
        common += cover * mask;
        union += mask + cover * known - cover * mask;
        let (x, y) = (at % width_px, at / width_px);
        if x == 0 || x + 1 == width_px {
            continue;
        }
        let value = |dx: i64, dy: i64| {
            let row = (y as i64 + dy).clamp(0, height_px as i64 - 1) as usize;
            coverage[row * width_px + (x as i64 + dx) as usize]
        };
        let gx =
            value(1, -1) - value(-1, -1) + 2.0 * (value(1, 0) - value(-1, 0)) + value(1, 1) - value(-1, 1);
        let gy =
            value(-1, 1) - value(-1, -1) + 2.0 * (value(0, 1) - value(0, -1)) + value(1, 1) - value(1, -1);
        let edge = ((gx * gx + gy * gy + EDGE_EPSILON).sqrt() - EDGE_EPSILON.sqrt()) * known;
        far += edge * f64::from(distance_px[at]);
        edges += edge;
    }
    (1.0 - common / union, far / edges / side_px)
}

/// The parts of all faces' edges beyond which no face lies.
pub fn outline(faces: &[[DVec2; 3]]) -> Vec<[DVec2; 2]> {
    let mut pieces = Vec::new();
    for face in faces {
        let area = (face[1] - face[0]).perp_dot(face[2] - face[0]);
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            let Some(direction) = (b - a).try_normalize() else { continue };
            // The face lies to the perpendicular's side where its area is positive.
            let beyond = direction.perp() * -area.signum() * BEYOND_PX;
            let mut hidden: Vec<(f64, f64)> =
                faces.iter().filter_map(|other| covered_part(a + beyond, b + beyond, other)).collect();
            hidden.sort_by(|s, t| s.0.total_cmp(&t.0));
            let mut from = 0.0;
            for (start, end) in hidden.into_iter().chain([(1.0, 1.0)]) {
                // Faces that share an edge cover what is beyond a third's without a gap, but for rounding.
                if (start - from) * a.distance(b) > NO_GAP_PX {
                    pieces.push([a.lerp(b, from), a.lerp(b, start)]);
                }
                from = f64::max(from, end);
            }
        }
    }
    pieces
}

/// Shares of the way from `a` to `b` between which a face covers it.
fn covered_part(a: DVec2, b: DVec2, face: &[DVec2; 3]) -> Option<(f64, f64)> {
    let turn = (face[1] - face[0]).perp_dot(face[2] - face[0]).signum();
    let (mut from, mut to) = (0.0, 1.0);
    for k in 0..3 {
        let (p, q) = (face[k], face[(k + 1) % 3]);
        let (at_a, at_b) = (turn * (q - p).perp_dot(a - p), turn * (q - p).perp_dot(b - p));
        if at_a < 0.0 && at_b < 0.0 {
            return None;
        }
        if at_a < 0.0 {
            from = f64::max(from, at_a / (at_a - at_b));
        } else if at_b < 0.0 {
            to = f64::min(to, at_a / (at_a - at_b));
        }
    }
    (from < to).then_some((from, to))
}

fn pixel_centers(width_px: usize, height_px: usize) -> impl Iterator<Item = DVec2> {
    (0..width_px * height_px)
        .map(move |at| DVec2::new((at % width_px) as f64 + 0.5, (at / width_px) as f64 + 0.5))
}

fn contains([a, b, c]: &[DVec2; 3], p: DVec2) -> bool {
    let sides = [(*b - *a).perp_dot(p - *a), (*c - *b).perp_dot(p - *b), (*a - *c).perp_dot(p - *c)];
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

fn distance_squared(p: DVec2, [a, b]: &[DVec2; 2]) -> f64 {
    let direction = *b - *a;
    let t = ((p - *a).dot(direction) / direction.length_squared().max(1e-300)).clamp(0.0, 1.0);
    p.distance_squared(*a + t * direction)
}

fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}
