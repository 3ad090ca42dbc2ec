//! Lofts: a skin over a stack of rings, which all other shapes are built on.

use glam::{DVec2, DVec3, Vec2};

use super::triangulate;
use crate::Solid;

/// Skins `rings` (at least two closed loops with equally many points, each counter-clockwise seen
/// from the direction in which the stack proceeds) and closes the first and last ring with flat caps. A ring whose
/// points coincide is a tip and gets no cap. On the side u runs once around (0..1) and v along the
/// stack by length (0..1); caps are mapped by their own extent, x right and y up.
pub fn loft(rings: &[Vec<DVec3>]) -> Solid {
    skin(rings, true)
}

/// As [`loft`], but the last ring joins the first (a torus); no caps.
pub fn loft_closed(rings: &[Vec<DVec3>]) -> Solid {
    let mut closed = rings.to_vec();
    closed.extend(rings.first().cloned());
    skin(&closed, false)
}

fn skin(rings: &[Vec<DVec3>], capped: bool) -> Solid {
    let around = rings.first().map_or(0, Vec::len);
    let (mut positions, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let lengths = cumulative(&(0..rings.len()).map(|k| mean_step(rings, k)).collect::<Vec<_>>());
    for (ring, v) in rings.iter().zip(&lengths) {
        let steps: Vec<f64> = (0..=around)
            .map(|k| if k == 0 { 0.0 } else { (ring[k % around] - ring[k - 1]).length() })
            .collect();
        let along = cumulative(&steps);
        for (k, u) in along.iter().enumerate() {
            positions.push(ring[k % around]);
            let even = k as f64 / around as f64;
            uvs.push(Vec2::new(if along[around] > 0.0 { *u } else { even } as f32, *v as f32));
        }
    }
    let row = around as u32 + 1;
    for level in 0..rings.len() as u32 - 1 {
        for k in 0..around as u32 {
            let (a, b) = (level * row + k, level * row + k + 1);
            let (c, d) = (b + row, a + row);
            // The shorter diagonal keeps twisted quads smooth.
            let at = |v: u32| positions[v as usize];
            if (at(a) - at(c)).length_squared() <= (at(b) - at(d)).length_squared() {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    if capped {
        for (ring, faces_back) in [(&rings[0], true), (&rings[rings.len() - 1], false)] {
            cap(ring, faces_back, &mut positions, &mut uvs, &mut triangles);
        }
    }
    Solid::from_corners(&positions, &uvs, &triangles)
}

fn cap(
    ring: &[DVec3],
    faces_back: bool,
    positions: &mut Vec<DVec3>,
    uvs: &mut Vec<Vec2>,
    triangles: &mut Vec<[u32; 3]>,
) {
    let area: DVec3 = (0..ring.len()).map(|k| ring[k].cross(ring[(k + 1) % ring.len()])).sum();
    if area.length() < 1e-14 {
        return;
    }
    let normal = area.normalize();
    let side = if normal.z.abs() > 0.9 { DVec3::X } else { DVec3::Z.cross(normal).normalize() };
    let side = (side - side.dot(normal) * normal).normalize();
    let up = normal.cross(side);
    let flat: Vec<DVec2> = ring.iter().map(|p| DVec2::new(p.dot(side), p.dot(up))).collect();
    let (low, high) = flat.iter().fold((flat[0], flat[0]), |(low, high), &p| (low.min(p), high.max(p)));
    let base = positions.len() as u32;
    for (p, q) in ring.iter().zip(&flat) {
        positions.push(*p);
        uvs.push(((*q - low) / (high - low).max(DVec2::splat(1e-12))).as_vec2());
    }
    for [a, b, c] in triangulate(&flat) {
        let [a, b, c] = [a + base, b + base, c + base];
        triangles.push(if faces_back { [a, c, b] } else { [a, b, c] });
    }
}

fn mean_step(rings: &[Vec<DVec3>], level: usize) -> f64 {
    if level == 0 {
        return 0.0;
    }
    let (before, here) = (&rings[level - 1], &rings[level]);
    before.iter().zip(here).map(|(a, b)| (*b - *a).length()).sum::<f64>() / here.len() as f64
}

/// Running sums divided by the total (zeros where the total is zero).
fn cumulative(steps: &[f64]) -> Vec<f64> {
    let total: f64 = steps.iter().sum();
    let mut sum = 0.0;
    steps
        .iter()
        .map(|step| {
            sum += step;
            if total > 0.0 { sum / total } else { 0.0 }
        })
        .collect()
}
