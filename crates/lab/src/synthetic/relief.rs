//! Heights of a thing seen from above and from below, on a grid: what another thing can stand on, and with what.

use glam::{DQuat, DVec2};

use geometry::{Pose, TexturedMesh};
use render::{RenderObject, TopView, View, render_geometry};

/// Side of a cell, meters.
pub(super) const CELL_M: f64 = 0.004;
/// Most cells along a side.
const MOST_CELLS: u32 = 160;

/// Heights in meters by place (object frame turned by the yaw it was made for); `None` where nothing is.
pub(super) struct Relief {
    width: u32,
    height: u32,
    cell_m: f64,
    /// Place of the grid's lower left corner.
    low: DVec2,
    heights_m: Vec<Option<f64>>,
}

impl Relief {
    /// Upper surface of the mesh turned by `yaw_rad`.
    pub(super) fn above(mesh: &TexturedMesh, yaw_rad: f64) -> Self {
        Self::seen(mesh, DQuat::from_rotation_z(yaw_rad), false)
    }

    /// Lower surface.
    pub(super) fn below(mesh: &TexturedMesh, yaw_rad: f64) -> Self {
        Self::seen(mesh, DQuat::from_rotation_x(std::f64::consts::PI) * DQuat::from_rotation_z(yaw_rad), true)
    }

    fn seen(mesh: &TexturedMesh, rotation: DQuat, flipped: bool) -> Self {
        let turned = mesh.positions.iter().map(|p| rotation * *p);
        let (low, high) =
            turned.fold((glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let size = (high - low).truncate();
        let cell_m = CELL_M.max(size.max_element() / f64::from(MOST_CELLS));
        let [width, height] = [size.x, size.y].map(|s| ((s / cell_m).ceil() as u32).max(1));
        let center_m = 0.5 * (low + high).truncate();
        let eye_z_m = high.z + 0.1;
        let view = TopView { width_px: width, height_px: height, meters_per_px: cell_m, center_m, eye_z_m };
        let object = RenderObject {
            mesh,
            world_from_object: Pose { translation_m: glam::DVec3::ZERO, rotation },
            id: 1,
        };
        let frame = render_geometry(&[object], &View::Orthographic(view));
        let height_at = |x: u32, y: u32| {
            let depth = f64::from(frame.depth_m[(y * width + x) as usize]);
            depth.is_finite().then_some(if flipped { depth - eye_z_m } else { eye_z_m - depth })
        };
        // Rows of the grid run upward; a half turn about x mirrors y.
        let row = |y: u32| if flipped { y } else { height - 1 - y };
        let heights_m = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| height_at(x, row(y)))
            .collect();
        let middle = if flipped { DVec2::new(center_m.x, -center_m.y) } else { center_m };
        let low = middle - 0.5 * cell_m * DVec2::new(f64::from(width), f64::from(height));
        Self { width, height, cell_m, low, heights_m }
    }

    /// Height at a place.
    pub(super) fn at(&self, place: DVec2) -> Option<f64> {
        let cell = ((place - self.low) / self.cell_m).floor();
        let inside = cell.x >= 0.0
            && cell.y >= 0.0
            && cell.x < f64::from(self.width)
            && cell.y < f64::from(self.height);
        if inside { self.heights_m[cell.y as usize * self.width as usize + cell.x as usize] } else { None }
    }

    /// Middle and height of every cell in which something is.
    pub(super) fn cells(&self) -> impl Iterator<Item = (DVec2, f64)> + '_ {
        self.heights_m.iter().enumerate().filter_map(|(k, height_m)| {
            let (x, y) = (k % self.width as usize, k / self.width as usize);
            let middle = self.low + self.cell_m * DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            height_m.map(|height_m| (middle, height_m))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::{block, cone};
    use geometry::{DVec3, Material, Rgb};

    #[test]
    fn both_sides_are_where_the_mesh_is() {
        let mut mesh = TexturedMesh::default();
        let look = Material::plain("gray", Rgb([0.5; 3]), 0.5);
        mesh.add(block(DVec3::new(0.1, 0.06, 0.02)).translated(DVec3::new(0.0, 0.0, 0.05)), &look);
        mesh.add(cone(0.01, 0.0, 0.05, 16).translated(DVec3::new(0.0, -0.02, 0.0)), &look);
        let (above, below) = (Relief::above(&mesh, 0.0), Relief::below(&mesh, 0.0));
        let at = |relief: &Relief, x: f64, y: f64| relief.at(DVec2::new(x, y)).expect("within");
        assert!((at(&above, 0.03, 0.02) - 0.07).abs() < 1e-6);
        assert!((at(&below, 0.03, 0.02) - 0.05).abs() < 1e-6);
        assert!(at(&below, 0.0, -0.02) < 0.01, "{}", at(&below, 0.0, -0.02));
        assert_eq!(above.at(DVec2::new(0.06, 0.0)), None);
        // Turned a quarter, its length lies along y.
        let turned = Relief::above(&mesh, std::f64::consts::FRAC_PI_2);
        assert!(turned.at(DVec2::new(0.0, 0.045)).is_some() && turned.at(DVec2::new(0.045, 0.0)).is_none());
    }
}
