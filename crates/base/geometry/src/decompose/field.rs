//! Cached signed distance field of a solid: a grid of exact distances, computed lazily.
//!
//! A decomposition needs tens of thousands of distances to the solid, mostly in the same regions. Grid corners are
//! computed on first use, and values between them are interpolated. The error is a small fraction of the spacing next
//! to the surface and smaller away from it. All threads compute the same value for a corner, so results are
//! deterministic. Object frame, meters.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DVec3, UVec3};

use super::depth::ShellDepth;
use crate::solid_query::MeshSolid;

/// Maximum number of grid corners; larger solids are queried directly.
const MAX_CORNERS: usize = 3_000_000;
/// Grid steps along the longest edge of the solid.
const STEPS: f64 = 64.0;
/// Coarsest grid, meters.
const COARSEST_M: f64 = 0.003;

pub(super) struct Field<'a> {
    solid: &'a MeshSolid,
    shells: Vec<ShellDepth<'a>>,
    low: DVec3,
    step_m: f64,
    size: UVec3,
    /// Bits of the depth as `f32`; [`UNKNOWN`] until computed.
    depths: Vec<AtomicU32>,
}

/// Results of the last query, as the guess for the next one nearby.
pub(super) struct Nearby {
    /// The nearest triangle of each shell.
    triangles: Vec<u32>,
    /// Scratch space for open boxes, reused between queries.
    open: Vec<(f32, u32)>,
}

/// A NaN that no computation returns.
const UNKNOWN: u32 = 0x7fc1_2345;

impl<'a> Field<'a> {
    pub(super) fn new(solid: &'a MeshSolid) -> Self {
        let (low, high) = solid.bounds();
        let step_m = ((high - low).max_element() / STEPS).clamp(1e-5, COARSEST_M);
        let low = low - DVec3::splat(step_m);
        let size = ((high - low) / step_m).ceil().as_uvec3() + UVec3::splat(2);
        let count = size.x as usize * size.y as usize * size.z as usize;
        let depths = if count <= MAX_CORNERS {
            std::iter::repeat_with(|| AtomicU32::new(UNKNOWN)).take(count).collect()
        } else {
            Vec::new()
        };
        let far = low.abs().max((low + step_m * size.as_dvec3()).abs()).max_element();
        let shells = solid.shells().iter().map(|shell| ShellDepth::new(&shell.surface, far)).collect();
        Self { solid, shells, low, step_m, size, depths }
    }

    /// State of a first query.
    pub(super) fn nearby(&self) -> Nearby {
        Nearby { triangles: vec![0; self.shells.len()], open: Vec::new() }
    }

    /// Distance of the point outside the solid; at most 0 inside. Faster if the last query of `nearby` was close.
    pub(super) fn outside_m(&self, point: DVec3, nearby: &mut Nearby) -> f64 {
        let at = (point - self.low) / self.step_m;
        let inner = at.cmpge(DVec3::ZERO).all() && (at + 1.0).cmplt(self.size.as_dvec3()).all();
        if self.depths.is_empty() || !inner {
            return (-self.depth_m(point, nearby)).max(0.0);
        }
        let cell = at.floor();
        let f = at - cell;
        let first = self.index(cell.as_uvec3());
        let (row, layer) = (self.size.x as usize, self.size.x as usize * self.size.y as usize);
        let [x, y, z] = f.to_array().map(|f| [1.0 - f, f]);
        let mut sum = 0.0;
        for k in 0..8_usize {
            let corner @ [i, j, l] = [k & 1, (k >> 1) & 1, k >> 2];
            let index = first + i + j * row + l * layer;
            let known = self.depths[index].load(Ordering::Relaxed);
            let depth_m = if known == UNKNOWN {
                self.compute_depth(cell.as_uvec3() + UVec3::from_array(corner.map(|c| c as u32)), nearby)
            } else {
                f64::from(f32::from_bits(known))
            };
            sum += x[i] * y[j] * z[l] * depth_m;
        }
        -sum
    }

    /// Whether the point lies in a shell and not on its surface, computed exactly.
    pub(super) fn is_inside(&self, shell: usize, point: DVec3) -> bool {
        const ON_SURFACE_M: f64 = 1e-5;
        self.solid.depth_in_shell_m(shell, point) > ON_SURFACE_M
    }

    fn index(&self, corner: UVec3) -> usize {
        (corner.z as usize * self.size.y as usize + corner.y as usize) * self.size.x as usize
            + corner.x as usize
    }

    fn depth_at(&self, corner: UVec3, nearby: &mut Nearby) -> f64 {
        // Relaxed: every thread would store the same value, so no order of loads and stores matters.
        let known = self.depths[self.index(corner)].load(Ordering::Relaxed);
        if known != UNKNOWN { f64::from(f32::from_bits(known)) } else { self.compute_depth(corner, nearby) }
    }

    #[cold]
    fn compute_depth(&self, corner: UVec3, nearby: &mut Nearby) -> f64 {
        let depth = self.depth_m(self.low + self.step_m * corner.as_dvec3(), nearby) as f32;
        self.depths[self.index(corner)].store(depth.to_bits(), Ordering::Relaxed);
        f64::from(depth)
    }

    /// Bounds of the distance of the point outside the solid, from the nearest grid corner alone: distance is
    /// 1-Lipschitz.
    pub(super) fn outside_at_most_m(&self, point: DVec3, nearby: &mut Nearby) -> f64 {
        self.next_to(point).map_or(f64::INFINITY, |(corner, away_m)| away_m - self.depth_at(corner, nearby))
    }

    /// Whether the point lies outside the solid, computed exactly unless a bound decides.
    pub(super) fn is_outside(&self, point: DVec3, nearby: &mut Nearby) -> bool {
        if let Some((corner, away_m)) = self.next_to(point) {
            let depth_m = self.depth_at(corner, nearby);
            // Distance is 1-Lipschitz: the sign is that of the corner within its depth, which is rounded to f32.
            if depth_m.abs() * (1.0 - f64::from(f32::EPSILON)) > away_m {
                return depth_m < 0.0;
            }
        }
        self.depth_m(point, nearby) < 0.0
    }

    /// The corner of the grid closest to the point and how far it is; `None` outside the grid.
    fn next_to(&self, point: DVec3) -> Option<(UVec3, f64)> {
        let corner = ((point - self.low) / self.step_m).round();
        let is_in_grid = corner.cmpge(DVec3::ZERO).all() && corner.cmplt(self.size.as_dvec3()).all();
        (is_in_grid && !self.depths.is_empty())
            .then(|| (corner.as_uvec3(), point.distance(self.low + self.step_m * corner)))
    }

    /// As [`MeshSolid::depth_m`], the same number.
    pub(super) fn depth_m(&self, point: DVec3, nearby: &mut Nearby) -> f64 {
        self.depth_besides_m(None, point, nearby)
    }

    /// The depth of a point on the surface of this shell with respect to the other shells: positive inside another one,
    /// negative in a cavity.
    pub(super) fn depth_on_m(&self, shell: usize, point: DVec3, nearby: &mut Nearby) -> f64 {
        self.depth_besides_m(Some(shell), point, nearby)
    }

    /// The depth of a point that lies on the surface of the shell `on`, if any.
    fn depth_besides_m(&self, on: Option<usize>, point: DVec3, nearby: &mut Nearby) -> f64 {
        let (mut solid_m, mut hole_m) = (f64::NEG_INFINITY, f64::INFINITY);
        match on.map(|on| self.solid.shells()[on].outward) {
            Some(true) => solid_m = 0.0,
            Some(false) => hole_m = 0.0,
            None => {}
        }
        for (index, (shell, depth)) in self.solid.shells().iter().zip(&self.shells).enumerate() {
            let outside_box_m = shell.box_distance_m(point);
            // A shell farther away than the best one so far has no effect.
            let is_far = shell.outward && outside_box_m > 0.0 && -outside_box_m < solid_m;
            if is_far || on == Some(index) {
                continue;
            }
            let here_m = depth.depth_m(point, &mut nearby.triangles[index], &mut nearby.open);
            if shell.outward {
                solid_m = solid_m.max(here_m);
            } else {
                hole_m = hole_m.min(here_m);
            }
        }
        solid_m.min(hole_m)
    }
}
