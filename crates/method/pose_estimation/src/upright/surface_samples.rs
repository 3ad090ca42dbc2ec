//! Samples of a mesh's surface, located in a grid of cells over its box.

use glam::{DQuat, DVec3, Vec2};

use geometry::TexturedMesh;

/// Cells along each axis of the box.
pub const CELLS: usize = 8;

/// A piece of the surface.
pub struct Sample {
    /// Center of the piece, from the center of the mesh's box, -0.5..0.5 along each axis.
    pub in_box: DVec3,
    /// Square of the mesh's own unit of length.
    pub area: f64,
    /// Index into the mesh's materials.
    pub material: usize,
    pub uv: Vec2,
}

/// Cuts the surface into pieces of about `per_cell` to a cell's side and visits each.
pub fn centered(mesh: &TexturedMesh, per_cell: f64, mut visit: impl FnMut(&Sample)) {
    let (low, high) = mesh.bounds();
    let size = (high - low).max(DVec3::splat(1e-12));
    let center = 0.5 * (low + high);
    for group in &mesh.groups {
        for t in &group.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let [ta, tb, tc] = t.map(|v| mesh.uvs[v as usize]);
            let area = 0.5 * (b - a).cross(c - a).length();
            let longest =
                ((b - a) / size).length().max(((c - a) / size).length()).max(((c - b) / size).length());
            let n = ((longest * per_cell * CELLS as f64).ceil() as usize).clamp(1, 32);
            // Centers of the n x n congruent parts.
            let mut part = |u: f64, v: f64| {
                let (u, v) = (u / n as f64, v / n as f64);
                visit(&Sample {
                    in_box: (a + (b - a) * u + (c - a) * v - center) / size,
                    area: area / (n * n) as f64,
                    material: group.material,
                    uv: ta + (tb - ta) * u as f32 + (tc - ta) * v as f32,
                });
            };
            for i in 0..n {
                for j in 0..n - i {
                    part(i as f64 + 1.0 / 3.0, j as f64 + 1.0 / 3.0);
                    if i + j + 1 < n {
                        part(i as f64 + 2.0 / 3.0, j as f64 + 2.0 / 3.0);
                    }
                }
            }
        }
    }
}

/// L1 distance between values of the cells, x fastest, and others after an axis-aligned rotation, which takes cells to
/// cells.
pub fn apart(wanted: &[f64], found: &[f64], turn: DQuat) -> f64 {
    let center = 0.5 * (CELLS - 1) as f64;
    let back = turn.conjugate();
    (0..wanted.len())
        .map(|k| {
            let cell = DVec3::new((k % CELLS) as f64, (k / CELLS % CELLS) as f64, (k / CELLS / CELLS) as f64);
            let from = (back * (cell - center) + center).round();
            let at = (from.z as usize * CELLS + from.y as usize) * CELLS + from.x as usize;
            (wanted[k] - found[at]).abs()
        })
        .sum()
}
