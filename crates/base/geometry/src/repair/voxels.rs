//! Rebuilds a broken surface from the voxels that it encloses.
//!
//! A grid point is inside by majority vote of three rays along the axes. A ray votes inside if it has entered the
//! surface more often than it has left it, and abstains if it enters and leaves unequally often, because it passed a
//! hole. The new surface is a surface net (Gibson, "Constrained elastic surface nets", 1998): each cell with corners
//! on both sides gets a vertex at the mean of its edges' crossings with the old surface, and each grid edge with one
//! end inside gets a quad of the four cells around it. Diagonal patterns are filled first, so that the result is
//! closed. The result is decimated.

use glam::{DVec3, IVec3, Vec2, Vec3};

use crate::decimate::decimated;
use crate::shells::{Shell, shells};
use crate::{Material, Rgb, Solid, TexturedMesh};

/// Voxels along the longest edge of the surface's box.
const STEPS: f64 = 72.0;
/// Offset of the grid from the box, share of a voxel, so that rays miss the vertices of meshes that lie on a grid.
const OFF_GRID: DVec3 = DVec3::new(0.5377, 0.4613, 0.5129);
/// Maximum number of triangles of the result, and how far decimation may move the surface, in voxels.
const MAX_TRIANGLES: usize = 6000;
const SIMPLIFIED_VOXELS: f64 = 0.1;
/// Islands of fewer voxels than this are removed.
const DUST_VOXELS: f64 = 8.0;

/// Share of the volume of a closed shell that it encloses more than once, or inverted.
pub(super) fn share_covered_wrong(shell: &Shell) -> f64 {
    let (low, high) = shell.bounds();
    let step_m = (high - low).max_element() / STEPS;
    if step_m.is_nan() || step_m <= 0.0 {
        return 0.0;
    }
    let (mut all, mut wrong) = (0.0, 0.0);
    for column in &Grid::over(shell, low, high, step_m).crossings[2] {
        let mut depth = 0;
        for pair in column.windows(2) {
            depth += pair[0].1;
            let length = pair[1].0 - pair[0].0;
            all += if depth == 0 { 0.0 } else { length };
            wrong += if depth == 0 || depth == 1 { 0.0 } else { length };
        }
    }
    if all > 0.0 { wrong / all } else { 0.0 }
}

/// The surfaces of the enclosed volume, and the voxels' edge in meters. `None` if the shell encloses no voxel.
pub(super) fn around_voxels(shell: &Shell) -> Option<(Vec<Shell>, f64)> {
    let (low, high) = shell.bounds();
    let step_m = (high - low).max_element() / STEPS;
    if step_m.is_nan() || step_m <= 0.0 {
        return None;
    }
    let grid = Grid::over(shell, low, high, step_m);
    let inside = grid.inside();
    let solid = grid.surface(&inside);
    if solid.triangles.is_empty() {
        return None;
    }
    let mut mesh = TexturedMesh::default();
    mesh.add(solid, &Material::plain("voxels", Rgb::hex(0x80_80_80), 0.5));
    let mesh = decimated(&mesh, MAX_TRIANGLES, SIMPLIFIED_VOXELS * step_m);
    let parts: Vec<Shell> = shells(&mesh)
        .into_iter()
        .filter(|part| part.volume_m3().abs() > DUST_VOXELS * step_m.powi(3))
        .collect();
    (!parts.is_empty()).then_some((parts, step_m))
}

struct Grid {
    low: DVec3,
    step_m: f64,
    /// Grid points along each axis.
    size: IVec3,
    /// Of each axis, of each of its columns: where the surface is crossed, ascending, +1 entering and -1 leaving.
    crossings: [Vec<Vec<(f64, i32)>>; 3],
}

impl Grid {
    fn over(shell: &Shell, low: DVec3, high: DVec3, step_m: f64) -> Self {
        let low = low - step_m * (DVec3::ONE + OFF_GRID);
        let size = ((high - low) / step_m).ceil().as_ivec3() + IVec3::splat(3);
        let mut grid = Self { low, step_m, size, crossings: Default::default() };
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            grid.crossings[axis] = vec![Vec::new(); (size[u] * size[v]) as usize];
            for corners in shell.corners() {
                grid.cross(axis, corners.map(|p| (p - low) / step_m));
            }
            grid.crossings[axis].iter_mut().for_each(|column| column.sort_by(|a, b| a.0.total_cmp(&b.0)));
        }
        grid
    }

    /// Records where the columns along an axis meet a triangle, all in steps.
    fn cross(&mut self, axis: usize, corners: [DVec3; 3]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let flat = corners.map(|p| (p[u], p[v]));
        let [a, b, c] = flat;
        let turn = |a: (f64, f64), b: (f64, f64), p: (f64, f64)| {
            (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)
        };
        let area = turn(a, b, c);
        if area == 0.0 {
            return;
        }
        let range = |of: fn(&(f64, f64)) -> f64, highest: i32| {
            let low = flat.iter().map(of).fold(f64::INFINITY, f64::min).ceil().max(0.0) as i32;
            let high = flat.iter().map(of).fold(f64::NEG_INFINITY, f64::max).floor() as i32;
            low..=high.min(highest - 1)
        };
        for j in range(|p| p.1, self.size[v]) {
            for i in range(|p| p.0, self.size[u]) {
                let p = (f64::from(i), f64::from(j));
                let weights = [turn(b, c, p) / area, turn(c, a, p) / area, turn(a, b, p) / area];
                if weights.iter().all(|&w| w >= 0.0) {
                    let at: f64 = weights.iter().zip(corners).map(|(w, corner)| w * corner[axis]).sum();
                    // The ray enters through a face that faces it.
                    let sign = if area < 0.0 { 1 } else { -1 };
                    self.crossings[axis][(j * self.size[u] + i) as usize].push((at, sign));
                }
            }
        }
    }

    fn column(&self, axis: usize, p: IVec3) -> &[(f64, i32)] {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        &self.crossings[axis][(p[v] * self.size[u] + p[u]) as usize]
    }

    fn index(&self, p: IVec3) -> usize {
        ((p.z * self.size.y + p.y) * self.size.x + p.x) as usize
    }

    fn points(&self) -> impl Iterator<Item = IVec3> + use<> {
        let size = self.size;
        (0..size.z)
            .flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| IVec3::new(x, y, z))))
    }

    /// Marks the grid points inside the surface, and fills diagonal patterns.
    fn inside(&self) -> Vec<bool> {
        let mut inside: Vec<bool> = self.points().map(|p| self.votes(p) > 0).collect();
        loop {
            let mut filled = false;
            for p in self.points() {
                for (u, v) in [(IVec3::X, IVec3::Y), (IVec3::Y, IVec3::Z), (IVec3::Z, IVec3::X)] {
                    if (p + u + v).cmpge(self.size).any() {
                        continue;
                    }
                    let square = [p, p + u, p + u + v, p + v].map(|q| self.index(q));
                    let [a, b, c, d] = square.map(|k| inside[k]);
                    if a == c && b == d && a != b {
                        square.iter().for_each(|&k| inside[k] = true);
                        filled = true;
                    }
                }
            }
            if !filled {
                return inside;
            }
        }
    }

    /// Number of rays that vote inside minus those that vote outside.
    fn votes(&self, p: IVec3) -> i32 {
        (0..3)
            .map(|axis| {
                let column = self.column(axis, p);
                if column.iter().map(|(_, sign)| sign).sum::<i32>() != 0 {
                    return 0;
                }
                let here = f64::from(p[axis]);
                let depth: i32 = column.iter().take_while(|(at, _)| *at < here).map(|(_, sign)| sign).sum();
                if depth > 0 { 1 } else { -1 }
            })
            .sum()
    }

    /// Crossing of the surface with the grid edge that starts at a point, in steps along the axis from it; 0.5 where no
    /// ray measured one.
    fn crossing(&self, axis: usize, p: IVec3) -> f64 {
        let here = f64::from(p[axis]);
        let between =
            self.column(axis, p).iter().map(|(at, _)| at - here).find(|at| (0.0..=1.0).contains(at));
        between.unwrap_or(0.5)
    }

    fn surface(&self, inside: &[bool]) -> Solid {
        const AXES: [IVec3; 3] = [IVec3::X, IVec3::Y, IVec3::Z];
        let mut sum: Vec<(DVec3, u32)> = vec![(DVec3::ZERO, 0); inside.len()];
        let mut squares: Vec<[IVec3; 4]> = Vec::new();
        for p in self.points() {
            for axis in 0..3 {
                let next = p + AXES[axis];
                if next[axis] >= self.size[axis] || inside[self.index(p)] == inside[self.index(next)] {
                    continue;
                }
                let (u, v) = (AXES[(axis + 1) % 3], AXES[(axis + 2) % 3]);
                let at = p.as_dvec3() + self.crossing(axis, p) * AXES[axis].as_dvec3();
                // Cells are named by their lowest corner; counter-clockwise seen from the end of the axis.
                let mut cells = [p - u - v, p - v, p, p - u];
                for cell in cells {
                    let (total, count) = &mut sum[self.index(cell)];
                    *total += at;
                    *count += 1;
                }
                if inside[self.index(next)] {
                    cells.reverse();
                }
                squares.push(cells);
            }
        }
        let mut number = vec![u32::MAX; inside.len()];
        let mut solid = Solid::default();
        for cells in squares {
            let corners = cells.map(|cell| {
                let index = self.index(cell);
                if number[index] == u32::MAX {
                    number[index] = solid.positions.len() as u32;
                    let (total, count) = sum[index];
                    solid.positions.push(self.low + self.step_m * total / f64::from(count));
                }
                number[index]
            });
            let [a, b, c, d] = corners;
            solid.triangles.extend([[a, b, c], [a, c, d]]);
        }
        solid.normals = vec![Vec3::Z; solid.positions.len()];
        solid.uvs = vec![Vec2::ZERO; solid.positions.len()];
        solid
    }
}
