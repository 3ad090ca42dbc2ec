//! Rasterizer: the front triangle of a mesh in each cell of a small grid. One sample a cell, at its center. Back
//! faces are culled, since the catalog's meshes are closed.

use glam::{DMat3, DQuat, DVec2, DVec3, Vec2, Vec3};

use geometry::Camera;

/// Grid of cells over a part of an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Corner of the first cell and side of each, pixels.
    pub origin_px: DVec2,
    pub cell_px: f64,
    pub columns: usize,
    pub rows: usize,
}

impl Grid {
    pub fn cells(&self) -> usize {
        self.columns * self.rows
    }
}

/// Stance of an upright mesh, and the ratio of its extents to those it was built with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stance {
    /// Center of its base on the table, meters.
    pub center: DVec2,
    pub yaw_rad: f64,
    pub stretch: DVec3,
}

/// From a mesh's frame to cells, in homogeneous coordinates.
pub(super) struct Projection {
    x: [f32; 4],
    y: [f32; 4],
    w: [f32; 4],
}

impl Projection {
    pub fn new(camera: &Camera, grid: &Grid, stance: &Stance) -> Self {
        let camera_from_world = camera.world_from_camera.inverse();
        let turn = DMat3::from_quat(camera_from_world.rotation * DQuat::from_rotation_z(stance.yaw_rad));
        let linear = turn * DMat3::from_diagonal(stance.stretch);
        let offset = camera_from_world.transform_point(stance.center.extend(0.0));
        let row = |k: usize| [linear.col(0)[k], linear.col(1)[k], linear.col(2)[k], offset[k]];
        let (right, down, forward) = (row(0), row(1), row(2));
        let mix = |a: [f64; 4], focal: f64, principal: f64| {
            let mixed: [f64; 4] =
                std::array::from_fn(|k| (focal * a[k] + principal * forward[k]) / grid.cell_px);
            mixed.map(|value| value as f32)
        };
        Self {
            x: mix(right, camera.fx, camera.cx - grid.origin_px.x),
            y: mix(down, camera.fy, camera.cy - grid.origin_px.y),
            w: forward.map(|value| value as f32),
        }
    }

    /// Orthographic projection from that elevation above the horizon, rotated by the yaw; one cell is one meter.
    pub fn from_afar(elevation_rad: f64, yaw_rad: f64) -> Self {
        let turn = DMat3::from_rotation_z(yaw_rad);
        let row = |direction: DVec3| {
            let [x, y, z] = (turn.transpose() * direction).as_vec3().to_array();
            [x, y, z, 0.0]
        };
        let (sin, cos) = elevation_rad.sin_cos();
        // Inverse depth grows toward the eye; it stays within a few percent of 1, so no point lies behind the eye.
        let [x, y, z, _] = row(DVec3::new(0.0, cos, -sin));
        Self { x: row(DVec3::X), y: row(DVec3::new(0.0, -sin, -cos)), w: [1e-4 * x, 1e-4 * y, 1e-4 * z, 1.0] }
    }

    /// Column, row, and inverse depth; the last is negative behind the camera.
    fn cell(&self, p: Vec3) -> [f32; 3] {
        let dot = |row: &[f32; 4]| row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
        let nearness = 1.0 / dot(&self.w);
        [dot(&self.x) * nearness, dot(&self.y) * nearness, nearness]
    }

    /// Bounding box of the points in cells; `None` if one lies behind the camera.
    pub fn bounds(&self, positions: &[Vec3]) -> Option<(Vec2, Vec2)> {
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for p in positions {
            let [x, y, nearness] = self.cell(*p);
            if nearness <= 0.0 {
                return None;
            }
            let at = Vec2::new(x, y);
            (low, high) = (low.min(at), high.max(at));
        }
        (low.x < high.x && low.y < high.y).then_some((low, high))
    }
}

/// No triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// Reused buffers.
#[derive(Default)]
pub(super) struct Raster {
    columns: usize,
    rows: usize,
    nearness: Vec<f32>,
    /// Index of the triangle in front, or [`NOTHING`].
    front: Vec<u32>,
    corners: Vec<[f32; 3]>,
}

impl Raster {
    /// Rasterizes the triangles on an empty grid of that size; false if a part lies behind the camera.
    pub fn draw(
        &mut self,
        (columns, rows): (usize, usize),
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        through: &Projection,
    ) -> bool {
        self.corners.clear();
        self.corners.extend(positions.iter().map(|p| through.cell(*p)));
        self.draw_corners((columns, rows), triangles)
    }

    /// As [`Self::draw`], stretched so that the given box in cells fills the grid.
    pub fn draw_filling(
        &mut self,
        side: usize,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        through: &Projection,
        (low, high): (Vec2, Vec2),
    ) -> bool {
        let scale = side as f32 / (high - low).max(Vec2::splat(1e-9));
        self.corners.clear();
        self.corners.extend(positions.iter().map(|p| {
            let [x, y, nearness] = through.cell(*p);
            [(x - low.x) * scale.x, (y - low.y) * scale.y, nearness]
        }));
        self.draw_corners((side, side), triangles)
    }

    fn draw_corners(&mut self, (columns, rows): (usize, usize), triangles: &[[u32; 3]]) -> bool {
        (self.columns, self.rows) = (columns, rows);
        self.nearness.clear();
        self.nearness.resize(columns * rows, 0.0);
        self.front.clear();
        self.front.resize(columns * rows, NOTHING);
        if self.corners.iter().any(|corner| corner[2].is_nan() || corner[2] <= 0.0) {
            return false;
        }
        for (index, triangle) in triangles.iter().enumerate() {
            self.triangle(index as u32, triangle.map(|v| self.corners[v as usize]));
        }
        true
    }

    /// Index of the triangle in front in each cell, row by row.
    pub fn front(&self) -> &[u32] {
        &self.front
    }

    fn triangle(&mut self, index: u32, [a, b, c]: [[f32; 3]; 3]) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        // Rows grow downward: clockwise triangles face the camera.
        if area.is_nan() || area >= 0.0 {
            return;
        }
        let span = |k: usize, size: usize| {
            let low = (a[k].min(b[k]).min(c[k]) - 0.5).ceil().max(0.0);
            let high = (a[k].max(b[k]).max(c[k]) - 0.5).floor().min(size as f32 - 1.0);
            (low, high)
        };
        let ((x0, x1), (y0, y1)) = (span(0, self.columns), span(1, self.rows));
        if x0 > x1 || y0 > y1 {
            return;
        }
        let edge = |p: [f32; 3], q: [f32; 3], x: f32, y: f32| {
            (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
        };
        let inverse = 1.0 / area;
        for row in y0 as usize..=y1 as usize {
            let y = row as f32 + 0.5;
            for column in x0 as usize..=x1 as usize {
                let x = column as f32 + 0.5;
                let (u, v) = (edge(b, c, x, y) * inverse, edge(c, a, x, y) * inverse);
                let w = 1.0 - u - v;
                if u < 0.0 || v < 0.0 || w < 0.0 {
                    continue;
                }
                let nearness = u * a[2] + v * b[2] + w * c[2];
                let at = row * self.columns + column;
                if nearness > self.nearness[at] {
                    self.nearness[at] = nearness;
                    self.front[at] = index;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::block;

    #[test]
    fn rasterized_box_matches_projected_bounds() {
        let camera = Camera::orbit(320, 240, 0.6, DVec3::ZERO, 0.0, 0.5, 1.2);
        let solid = block(DVec3::new(0.1, 0.1, 0.1));
        let positions: Vec<Vec3> = solid.positions.iter().map(|p| p.as_vec3()).collect();
        let grid = Grid { origin_px: DVec2::ZERO, cell_px: 2.0, columns: 160, rows: 120 };
        let stance =
            Stance { center: DVec2::new(0.02, 0.0), yaw_rad: 0.3, stretch: DVec3::new(1.0, 1.5, 0.5) };
        let through = Projection::new(&camera, &grid, &stance);
        let mut raster = Raster::default();
        assert!(raster.draw((160, 120), &positions, &solid.triangles, &through));
        let low = solid.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let corner = stance.center.extend(0.0)
            + DQuat::from_rotation_z(0.3) * (DVec3::new(0.05, -0.05, low + 0.1) * stance.stretch);
        let (pixel, _) = camera.project(corner).expect("in front");
        let (min, max) = through.bounds(&positions).expect("in front");
        let at = (pixel / 2.0).as_vec2();
        assert!(at.cmpge(min - 1e-3).all() && at.cmple(max + 1e-3).all(), "{at} {min} {max}");
        let midpoint = camera.project(stance.center.extend(0.02)).expect("in front").0 / 2.0;
        assert_ne!(raster.front()[midpoint.y as usize * 160 + midpoint.x as usize], NOTHING);
        let seen = raster.front().iter().filter(|front| **front != NOTHING).count() as f32;
        let filled = (max.x - min.x) * (max.y - min.y);
        assert!(seen > 0.5 * filled && seen <= filled, "{seen} {filled}");
    }
}
