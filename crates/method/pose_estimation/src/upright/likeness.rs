//! Similarity of the surface distributions of a rotated mesh and an example in their boxes.

use glam::{DQuat, DVec3};

use super::surface_samples::{CELLS, apart, centered};
use geometry::TexturedMesh;

/// Samples along a cell's side.
const SAMPLES: f64 = 2.0;

/// Dissimilarity 0..1 of the mesh to the example under each rotation: half the L1 distance between their surface areas
/// per cell of the box, both boxes stretched to the unit cube.
pub fn costs(mesh: &TexturedMesh, turns: &[DQuat], example: &TexturedMesh) -> Vec<f64> {
    let (wanted, found) = (histogram(example), histogram(mesh));
    turns.iter().map(|&turn| 0.5 * apart(&wanted, &found, turn)).collect()
}

/// Share of the area in each cell, x fastest, spread linearly over the neighboring cells.
fn histogram(mesh: &TexturedMesh) -> Vec<f64> {
    let mut cells = vec![0.0; CELLS * CELLS * CELLS];
    // Cells on both sides and their weights, along one axis.
    let beside = |at: f64| {
        let low = at as i64 - i64::from((at as i64) as f64 > at);
        let t = at - low as f64;
        [(low, 1.0 - t), (low + 1, t)].map(|(cell, w)| (cell.clamp(0, CELLS as i64 - 1) as usize, w))
    };
    centered(mesh, SAMPLES, |sample| {
        let at: DVec3 = (sample.in_box + 0.5) * CELLS as f64 - 0.5;
        let (xs, ys, zs) = (beside(at.x), beside(at.y), beside(at.z));
        for (z, wz) in zs {
            for (y, wy) in ys {
                for (x, wx) in xs {
                    cells[(z * CELLS + y) * CELLS + x] += sample.area * wx * wy * wz;
                }
            }
        }
    });
    let total: f64 = cells.iter().sum::<f64>().max(1e-30);
    cells.iter_mut().for_each(|cell| *cell /= total);
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::upright::rotations::axis_aligned;
    use geometry::{Material, Rgb, shapes};

    #[test]
    fn costs_are_minimal_for_inverse_rotation() {
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
