//! What a thing looks like from straight above: heights on a small grid. Where it is flat things can
//! stand; where it is deep things can lie in it.

use glam::DVec2;

use super::Footprint;
use geometry::{Pose, TexturedMesh};
use render::{RenderObject, TopView, View, render_geometry};

/// Cells along the longer side.
const CELLS: u32 = 44;

/// Heights of the top surface above the mesh's origin, object frame, meters; `None` beside the thing.
pub(super) struct Relief {
    view: TopView,
    heights_m: Vec<Option<f64>>,
    /// Of the rim and of the cavity's floor.
    highest_m: f64,
    lowest_m: f64,
    /// Middles of the cavity's cells with their distance to its wall.
    room: Vec<(DVec2, f64)>,
}

impl Relief {
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
        let seen = render_geometry(&[object], &View::Orthographic(view));
        let heights_m: Vec<Option<f64>> =
            seen.depth_m.iter().map(|&d| d.is_finite().then(|| eye_z_m - f64::from(d))).collect();
        let lowest_m = heights_m.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let mut relief = Self { view, heights_m, highest_m: high.z, lowest_m, room: Vec::new() };
        relief.room = relief.cavity();
        relief
    }

    fn cavity(&self) -> Vec<(DVec2, f64)> {
        let level = self.lowest_m + 0.45 * (self.highest_m - self.lowest_m);
        let deep = |height: Option<f64>| height.is_some_and(|z| z < level);
        let (open, walls): (Vec<_>, Vec<_>) = self.cells().partition(|(_, height)| deep(*height));
        let margin = 0.5 * self.view.meters_per_px;
        let to_wall = |at: DVec2| {
            walls.iter().map(|(wall, _)| wall.distance_squared(at)).fold(f64::INFINITY, f64::min).sqrt()
        };
        open.iter().map(|(at, _)| (*at, to_wall(*at).min(self.to_edge_m(*at)) - margin)).collect()
    }

    /// Middle of every cell with the height there.
    fn cells(&self) -> impl Iterator<Item = (DVec2, Option<f64>)> + '_ {
        let width = self.view.width_px;
        self.heights_m.iter().enumerate().map(move |(k, &height)| {
            let pixel = DVec2::new(f64::from(k as u32 % width), f64::from(k as u32 / width)) + 0.5;
            (self.view.world_from_pixel(pixel), height)
        })
    }

    /// How well a thing of that footprint stands there, 0 = perfectly: the share of it that hangs in the
    /// air plus a tenth for each millimeter of unevenness below its middle.
    pub fn unevenness(&self, footprint: &Footprint) -> f64 {
        let center = footprint.center();
        let corner_count = footprint.corners().len() as f64;
        let inside = |p: DVec2| geometry::collide::depth_in_convex_m(footprint.corners(), p) >= 0.0;
        let (mut under, mut low, mut high) = (0_usize, f64::INFINITY, f64::NEG_INFINITY);
        let half = 0.5 * footprint.size_m().min_element();
        let (least, most) = footprint.bounds();
        for (at, height) in self.cells() {
            let Some(height) = height else { continue };
            if at.cmplt(least).any() || at.cmpgt(most).any() || !inside(at) {
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

    /// Places for round things of these radii in the cavity, largest free place first, each as far as it
    /// can be from the walls and from those before it. With the depth to the wall each has left, negative
    /// where it will lie on others.
    pub fn places_inside(&self, radii_m: &[f64]) -> Vec<(DVec2, f64)> {
        let mut taken: Vec<(DVec2, f64)> = Vec::new();
        let mut places = Vec::new();
        for &radius in radii_m {
            let left = |(at, to_wall): &(DVec2, f64)| {
                let to_others =
                    taken.iter().map(|(o, r)| o.distance(*at) - r - radius).fold(f64::INFINITY, f64::min);
                // Snug beside the others rather than in the very middle once there are others.
                (to_wall - radius).min(to_others)
            };
            let best = self.room.iter().max_by(|a, b| left(a).total_cmp(&left(b)));
            let (at, depth) = best.map_or((self.view.center_m, -1.0), |cell| (cell.0, left(cell)));
            taken.push((at, radius));
            places.push((at, depth));
        }
        places
    }

    fn to_edge_m(&self, at: DVec2) -> f64 {
        let half = 0.5
            * self.view.meters_per_px
            * DVec2::new(f64::from(self.view.width_px), f64::from(self.view.height_px));
        (half - (at - self.view.center_m).abs()).min_element()
    }

    /// Narrowest width of the cavity's opening and how deep it is, meters.
    pub fn opening(&self) -> (f64, f64) {
        let widest = self.places_inside(&[0.0]).first().map_or(0.0, |place| 2.0 * place.1);
        (widest.max(0.0), (self.highest_m - self.lowest_m).max(0.0))
    }
}
