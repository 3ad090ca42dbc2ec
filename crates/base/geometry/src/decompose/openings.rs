//! The openings of a solid: what hulls have to leave open, such as the inside of a cup and the eye of a handle.
//!
//! Points of a grid in the convex hull of the mesh, farther from the mesh than half a step, that a ball of that radius
//! reaches from outside. The ball rolls from point to neighbor: two neighbors that are both farther than half a step
//! from the mesh have nothing of it between them. The air in a lidded dish is no opening, since nothing gets in.
//!
//! Object frame, meters. A few milliseconds.

use glam::{DVec3, UVec3};

use super::DecomposeError;
use super::fit::Depths;
use crate::convex_hull::{convex_hull, planes};
use crate::solid_query::MeshSolid;

/// Steps of the grid along the longest edge of the mesh's box.
const STEPS: f64 = 24.0;
/// Smallest step, meters: what is narrower holds nothing that can stand on a table.
const MIN_STEP_M: f64 = 0.003;
/// Openings of less than this share of the convex hull's volume are dimples and creases.
const MIN_SHARE: f64 = 0.02;
/// Points at most so many steps below the surface of the convex hull may be entrances.
const ENTRANCE_STEPS: f64 = 2.0;

/// The points, in the order of the grid.
pub(super) fn openings(solid: &MeshSolid, depths: &mut Depths<'_>) -> Result<Vec<DVec3>, DecomposeError> {
    let points: Vec<DVec3> = solid.triangles().flatten().collect();
    let hull = convex_hull(&points, usize::MAX, 0.0).ok_or(DecomposeError::NoHull)?;
    let wrap = planes(&hull);
    let (low, high) = solid.bounds();
    let step_m = ((high - low).max_element() / STEPS).max(MIN_STEP_M);
    let grid = Grid { low_m: low, step_m, size: ((high - low) / step_m).ceil().as_uvec3().max(UVec3::ONE) };
    let free = free_points(&grid, &wrap, depths);
    let reached = reached(&grid, &wrap, depths, &free);
    let points: Vec<DVec3> = (0..reached.len()).filter(|&k| reached[k]).map(|k| grid.point(k)).collect();
    let open_m3 = points.len() as f64 * step_m.powi(3);
    Ok(if open_m3 < MIN_SHARE * hull.volume_m3() { Vec::new() } else { points })
}

/// Points at the centers of cells, x fastest.
struct Grid {
    low_m: DVec3,
    step_m: f64,
    size: UVec3,
}

impl Grid {
    fn count(&self) -> usize {
        self.size.element_product() as usize
    }

    fn cell(&self, index: usize) -> UVec3 {
        let (x, y) = (self.size.x as usize, self.size.y as usize);
        UVec3::new((index % x) as u32, (index / x % y) as u32, (index / x / y) as u32)
    }

    fn point(&self, index: usize) -> DVec3 {
        self.low_m + self.step_m * (self.cell(index).as_dvec3() + 0.5)
    }

    /// Indices of the points beside one, along each axis.
    fn neighbors(&self, index: usize) -> impl Iterator<Item = usize> {
        let (cell, size) = (self.cell(index), self.size);
        let strides = [1, size.x as usize, (size.x * size.y) as usize];
        (0..3).flat_map(move |axis| {
            let before = (cell[axis] > 0).then(|| index - strides[axis]);
            let after = (cell[axis] + 1 < size[axis]).then(|| index + strides[axis]);
            before.into_iter().chain(after)
        })
    }
}

/// Marks the grid points in the convex hull that lie farther than half a step outside the mesh.
fn free_points(grid: &Grid, wrap: &[(DVec3, f64)], depths: &mut Depths<'_>) -> Vec<bool> {
    let mut free = vec![false; grid.count()];
    for (row, points) in free.chunks_mut(grid.size.x as usize).enumerate() {
        let first = grid.point(row * grid.size.x as usize);
        let [from_m, to_m] = within(wrap, first);
        // Depth changes no faster than place, so what was found for a point holds for some after it.
        let (mut is_free, mut until_m) = (false, f64::NEG_INFINITY);
        for (x, point) in points.iter_mut().enumerate() {
            let along_m = grid.step_m * x as f64;
            if !(from_m..=to_m).contains(&along_m) {
                continue;
            }
            if along_m >= until_m {
                let beyond_m = -depths.depth_m(first + along_m * DVec3::X) - 0.5 * grid.step_m;
                (is_free, until_m) = (beyond_m > 0.0, along_m + beyond_m.abs());
            }
            *point = is_free;
        }
    }
    free
}

/// Marks the free points that the ball reaches: those within [`ENTRANCE_STEPS`] below the convex hull that are no
/// nearer to the mesh than to the hull, and all free points connected with them.
fn reached(grid: &Grid, wrap: &[(DVec3, f64)], depths: &mut Depths<'_>, free: &[bool]) -> Vec<bool> {
    let mut reached = vec![false; free.len()];
    let mut open: Vec<usize> = (0..free.len())
        .filter(|&k| free[k])
        .filter(|&k| {
            let p = grid.point(k);
            let below_m = wrap.iter().map(|(n, offset_m)| offset_m - n.dot(p)).fold(f64::INFINITY, f64::min);
            below_m <= ENTRANCE_STEPS * grid.step_m && -depths.depth_m(p) >= below_m
        })
        .collect();
    open.iter().for_each(|&k| reached[k] = true);
    while let Some(k) = open.pop() {
        for next in grid.neighbors(k) {
            if free[next] && !reached[next] {
                reached[next] = true;
                open.push(next);
            }
        }
    }
    reached
}

/// Interval of the line through `point` along x that lies below all planes, meters from the point.
fn within(planes: &[(DVec3, f64)], point: DVec3) -> [f64; 2] {
    planes.iter().fold([f64::NEG_INFINITY, f64::INFINITY], |[from_m, to_m], (normal, offset_m)| {
        let below_m = offset_m - normal.dot(point);
        match normal.x {
            x if x > 0.0 => [from_m, to_m.min(below_m / x)],
            x if x < 0.0 => [from_m.max(below_m / x), to_m],
            _ if below_m < 0.0 => [f64::INFINITY, f64::NEG_INFINITY],
            _ => [from_m, to_m],
        }
    })
}
