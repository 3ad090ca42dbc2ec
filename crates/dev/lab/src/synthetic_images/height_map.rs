//! Height maps of an object from above and from below, for resting one object on another.

use glam::{DQuat, DVec2};

use geometry::{Pose, TexturedMesh};
use render::{RenderObject, TopView, View, render_geometry};

/// Cell size, meters.
pub(super) const CELL_M: f64 = 0.004;
/// Maximum number of cells along a side.
const MAX_CELLS: u32 = 160;

/// Heights in meters by position (object frame, rotated by the yaw); `None` outside the object.
pub(super) struct HeightMap {
    width: u32,
    height: u32,
    cell_m: f64,
    /// Position of the grid's lower left corner.
    low: DVec2,
    heights_m: Vec<Option<f64>>,
}

impl HeightMap {
    /// Upper surface of the mesh rotated by `yaw_rad`.
    pub(super) fn above(mesh: &TexturedMesh, yaw_rad: f64) -> Self {
        Self::render(mesh, DQuat::from_rotation_z(yaw_rad), false)
    }

    /// Lower surface of the mesh rotated by `yaw_rad`.
    pub(super) fn below(mesh: &TexturedMesh, yaw_rad: f64) -> Self {
        Self::render(
            mesh,
            DQuat::from_rotation_x(std::f64::consts::PI) * DQuat::from_rotation_z(yaw_rad),
            true,
        )
    }

    fn render(mesh: &TexturedMesh, rotation: DQuat, flipped: bool) -> Self {
        let turned = mesh.positions.iter().map(|p| rotation * *p);
        let (low, high) =
            turned.fold((glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let size = (high - low).truncate();
        let cell_m = CELL_M.max(size.max_element() / f64::from(MAX_CELLS));
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
        // Grid rows run upward; a half turn about x mirrors y.
        let row = |y: u32| if flipped { y } else { height - 1 - y };
        let heights_m = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| height_at(x, row(y)))
            .collect();
        let center = if flipped { DVec2::new(center_m.x, -center_m.y) } else { center_m };
        let low = center - 0.5 * cell_m * DVec2::new(f64::from(width), f64::from(height));
        Self { width, height, cell_m, low, heights_m }
    }

    /// Height at a position.
    pub(super) fn at(&self, position: DVec2) -> Option<f64> {
        let cell = ((position - self.low) / self.cell_m).floor();
        let inside = cell.x >= 0.0
            && cell.y >= 0.0
            && cell.x < f64::from(self.width)
            && cell.y < f64::from(self.height);
        if inside { self.heights_m[cell.y as usize * self.width as usize + cell.x as usize] } else { None }
    }

    /// Center and height of every occupied cell.
    pub(super) fn cells(&self) -> impl Iterator<Item = (DVec2, f64)> + '_ {
        self.heights_m.iter().enumerate().filter_map(|(k, height_m)| {
            let (x, y) = (k % self.width as usize, k / self.width as usize);
            let center = self.low + self.cell_m * DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            height_m.map(|height_m| (center, height_m))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::{block, cone};
    use geometry::{DVec3, Material, Rgb};

    #[test]
    fn height_maps_match_upper_and_lower_surface() {
        let mut mesh = TexturedMesh::default();
        let material = Material::plain("gray", Rgb([0.5; 3]), 0.5);
        mesh.add(block(DVec3::new(0.1, 0.06, 0.02)).translated(DVec3::new(0.0, 0.0, 0.05)), &material);
        mesh.add(cone(0.01, 0.0, 0.05, 16).translated(DVec3::new(0.0, -0.02, 0.0)), &material);
        let (above, below) = (HeightMap::above(&mesh, 0.0), HeightMap::below(&mesh, 0.0));
        let at = |relief: &HeightMap, x: f64, y: f64| relief.at(DVec2::new(x, y)).expect("within");
        assert!((at(&above, 0.03, 0.02) - 0.07).abs() < 1e-6);
        assert!((at(&below, 0.03, 0.02) - 0.05).abs() < 1e-6);
        assert!(at(&below, 0.0, -0.02) < 0.01, "{}", at(&below, 0.0, -0.02));
        assert_eq!(above.at(DVec2::new(0.06, 0.0)), None);
        // After a quarter turn its length lies along y.
        let turned = HeightMap::above(&mesh, std::f64::consts::FRAC_PI_2);
        assert!(turned.at(DVec2::new(0.0, 0.045)).is_some() && turned.at(DVec2::new(0.045, 0.0)).is_none());
    }
}
