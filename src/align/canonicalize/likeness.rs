//! How alike a turned mesh and an example fill their boxes.

use glam::{DQuat, DVec3};

use crate::geometry::TexturedMesh;

/// Cells along each axis of the box.
const CELLS: usize = 8;

/// Unlikeness 0..1 of the mesh to the example under each rotation: half the L1 distance between their
/// surface areas per cell of the box, both boxes stretched to the unit cube.
pub fn costs(mesh: &TexturedMesh, turns: &[DQuat], example: &TexturedMesh) -> Vec<f64> {
    let (wanted, found) = (histogram(&samples(example)), histogram(&samples(mesh)));
    turns.iter().map(|&turn| 0.5 * distance(&wanted, &found, turn)).collect()
}

/// L1 distance between the cells and the others after an axis-aligned rotation, which takes cells to cells.
fn distance(wanted: &[f64], found: &[f64], turn: DQuat) -> f64 {
    let middle = 0.5 * (CELLS - 1) as f64;
    let back = turn.conjugate();
    (0..wanted.len())
        .map(|k| {
            let cell = DVec3::new((k % CELLS) as f64, (k / CELLS % CELLS) as f64, (k / CELLS / CELLS) as f64);
            let from = (back * (cell - middle) + middle).round();
            let at = (from.z as usize * CELLS + from.y as usize) * CELLS + from.x as usize;
            (wanted[k] - found[at]).abs()
        })
        .sum()
}

/// Points spread over the surface with the area they stand for; coordinates from the middle of the
/// box, -0.5..0.5 along each axis.
fn samples(mesh: &TexturedMesh) -> Vec<(DVec3, f64)> {
    let (low, high) = mesh.bounds();
    let size = (high - low).max(DVec3::splat(1e-12));
    let middle = 0.5 * (low + high);
    let mut points = Vec::new();
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let area = 0.5 * (b - a).cross(c - a).length();
        let longest = ((b - a) / size).length().max(((c - a) / size).length()).max(((c - b) / size).length());
        let n = ((longest * 2.0 * CELLS as f64).ceil() as usize).clamp(1, 32);
        // Centers of the n x n congruent parts.
        for i in 0..n {
            for j in 0..n - i {
                let mut part = |u: f64, v: f64| {
                    let p = a + (b - a) * (u / n as f64) + (c - a) * (v / n as f64);
                    points.push(((p - middle) / size, area / (n * n) as f64));
                };
                part(i as f64 + 1.0 / 3.0, j as f64 + 1.0 / 3.0);
                if i + j + 1 < n {
                    part(i as f64 + 2.0 / 3.0, j as f64 + 2.0 / 3.0);
                }
            }
        }
    }
    points
}

/// Share of the area in each cell, x fastest, spread linearly over the neighboring cells.
fn histogram(points: &[(DVec3, f64)]) -> Vec<f64> {
    let mut cells = vec![0.0; CELLS * CELLS * CELLS];
    let total: f64 = points.iter().map(|p| p.1).sum::<f64>().max(1e-30);
    for (p, area) in points {
        let at = (*p + 0.5) * CELLS as f64 - 0.5;
        // Cells on both sides and their weights, along one axis.
        let beside = |at: f64| {
            let low = at as i64 - i64::from((at as i64) as f64 > at);
            let t = at - low as f64;
            [(low, 1.0 - t), (low + 1, t)].map(|(cell, w)| (cell.clamp(0, CELLS as i64 - 1) as usize, w))
        };
        let (xs, ys, zs) = (beside(at.x), beside(at.y), beside(at.z));
        let share = area / total;
        for (z, wz) in zs {
            for (y, wy) in ys {
                for (x, wx) in xs {
                    cells[(z * CELLS + y) * CELLS + x] += share * wx * wy * wz;
                }
            }
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::align::canonicalize::turns::axis_aligned;
    use crate::geometry::{Material, Rgb, shapes};

    #[test]
    fn the_rotation_that_undoes_a_turn_is_the_most_alike() {
        let mut mesh = TexturedMesh::default();
        let gray = Material::plain("gray", Rgb::hex(0x808080), 0.5);
        mesh.add(shapes::cone(0.05, 0.02, 0.12, 32), &gray);
        mesh.add(shapes::block(DVec3::new(0.02, 0.08, 0.02)).translated(DVec3::new(0.0, 0.06, 0.02)), &gray);
        let turns = axis_aligned();
        for &raw_from_canonical in &turns {
            let raw = mesh.clone().rotated(raw_from_canonical);
            let costs = costs(&raw, &turns, &mesh);
            let best = (0..24).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).expect("24");
            assert!((turns[best] * raw_from_canonical).w.abs() > 1.0 - 1e-9);
        }
    }
}
