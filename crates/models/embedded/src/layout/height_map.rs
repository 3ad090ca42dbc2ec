//! Height map of an object from above: flat cells support other objects, deep cells form a cavity that holds them.

use glam::DVec2;

use super::Footprint;
use geometry::{Pose, TexturedMesh};
use render::{RenderObject, TopView, View, render_geometry};

/// Number of cells along the longer side.
const CELLS: u32 = 44;

/// Heights of the top surface above the mesh's origin, object frame, meters; `None` outside the object.
pub(super) struct HeightMap {
    view: TopView,
    heights_m: Vec<Option<f64>>,
    /// Height of the rim.
    max_height_m: f64,
    /// Height of the cavity's floor.
    min_height_m: f64,
    /// Centers of the cavity's cells with their distance to its wall, meters.
    cavity_cells: Vec<(DVec2, f64)>,
}

impl HeightMap {
    pub fn of(mesh: &TexturedMesh) -> Self {
        let (low, high) = mesh.bounds();
        let size = (high - low).truncate();
        let meters_per_px = (size.max_element() / f64::from(CELLS)).max(1e-4);
        let cells = (size / meters_per_px).ceil().max(DVec2::ONE);
        let eye_z_m = high.z + 0.1;
        let view = TopView {
            width_px: cells.x as u32,
            height_px: cells.y as u32,
            meters_per_px,
            center_m: 0.5 * (low + high).truncate(),
            eye_z_m,
        };
        let object = RenderObject { mesh, world_from_object: Pose::IDENTITY, id: 1 };
        let frame = render_geometry(&[object], &View::Orthographic(view));
        let heights_m: Vec<Option<f64>> =
            frame.depth_m.iter().map(|&d| d.is_finite().then(|| eye_z_m - f64::from(d))).collect();
        let min_height_m = heights_m.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let mut height_map =
            Self { view, heights_m, max_height_m: high.z, min_height_m, cavity_cells: Vec::new() };
        height_map.cavity_cells = height_map.cavity();
        height_map
    }

    fn cavity(&self) -> Vec<(DVec2, f64)> {
        let level = self.min_height_m + 0.45 * (self.max_height_m - self.min_height_m);
        let deep = |height: Option<f64>| height.is_some_and(|z| z < level);
        let (open, walls): (Vec<_>, Vec<_>) = self.cells().partition(|(_, height)| deep(*height));
        let margin = 0.5 * self.view.meters_per_px;
        let to_wall = |at: DVec2| {
            walls.iter().map(|(wall, _)| wall.distance_squared(at)).fold(f64::INFINITY, f64::min).sqrt()
        };
        open.iter().map(|(at, _)| (*at, to_wall(*at).min(self.to_edge_m(*at)) - margin)).collect()
    }

    /// Center and height of every cell.
    fn cells(&self) -> impl Iterator<Item = (DVec2, Option<f64>)> + '_ {
        let width = self.view.width_px;
        self.heights_m.iter().enumerate().map(move |(k, &height)| {
            let pixel = DVec2::new(f64::from(k as u32 % width), f64::from(k as u32 / width)) + 0.5;
            (self.view.world_from_pixel(pixel), height)
        })
    }

    /// Unevenness below a footprint, 0 = flat: the unsupported share of its area plus 0.1 for each millimeter of
    /// height range below its center.
    pub fn unevenness(&self, footprint: &Footprint) -> f64 {
        let center = footprint.center();
        let corner_count = footprint.corners().len() as f64;
        let inside = |p: DVec2| geometry::polygon::depth_in_convex_m(footprint.corners(), p) >= 0.0;
        let (mut under, mut low, mut high) = (0_usize, f64::INFINITY, f64::NEG_INFINITY);
        let half = 0.5 * footprint.size_m().min_element();
        let (min_corner, max_corner) = footprint.bounds();
        for (at, height) in self.cells() {
            let Some(height) = height else { continue };
            if at.cmplt(min_corner).any() || at.cmpgt(max_corner).any() || !inside(at) {
                continue;
            }
            under += 1;
            if at.distance(center) < half {
                (low, high) = (low.min(height), high.max(height));
            }
        }
        let cell_m2 = self.view.meters_per_px * self.view.meters_per_px;
        let covered = (under as f64 * cell_m2 / footprint.area_m2().max(cell_m2)).min(1.0);
        let range_mm = if high >= low && corner_count > 2.0 { 1e3 * (high - low) } else { 0.0 };
        (1.0 - covered) + 0.1 * range_mm
    }

    /// Positions in the cavity for discs of these radii in order, each at the maximum clearance from the walls and
    /// from earlier discs. Each position comes with its clearance, meters, negative if discs overlap.
    pub fn positions_inside(&self, radii_m: &[f64]) -> Vec<(DVec2, f64)> {
        let mut discs: Vec<(DVec2, f64)> = Vec::new();
        let mut positions = Vec::new();
        for &radius in radii_m {
            let clearance = |(at, to_wall): &(DVec2, f64)| {
                let to_others =
                    discs.iter().map(|(o, r)| o.distance(*at) - r - radius).fold(f64::INFINITY, f64::min);
                (to_wall - radius).min(to_others)
            };
            let best = self.cavity_cells.iter().max_by(|a, b| clearance(a).total_cmp(&clearance(b)));
            let (at, depth) = best.map_or((self.view.center_m, -1.0), |cell| (cell.0, clearance(cell)));
            discs.push((at, radius));
            positions.push((at, depth));
        }
        positions
    }

    fn to_edge_m(&self, at: DVec2) -> f64 {
        let half = 0.5
            * self.view.meters_per_px
            * DVec2::new(f64::from(self.view.width_px), f64::from(self.view.height_px));
        (half - (at - self.view.center_m).abs()).min_element()
    }

    /// Width of the largest disc inside the cavity and the cavity's depth, meters.
    pub fn opening(&self) -> (f64, f64) {
        let width_m = self.positions_inside(&[0.0]).first().map_or(0.0, |position| 2.0 * position.1);
        (width_m.max(0.0), (self.max_height_m - self.min_height_m).max(0.0))
    }
}
