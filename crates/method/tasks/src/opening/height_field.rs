//! The top surface of convex hulls on a grid.

use geometry::ConvexHull;
use geometry::convex_hull::planes;
use glam::{DVec2, DVec3};

/// Cells along the longer side of the object.
const CELLS: f64 = 72.0;
/// Smallest cell, meters.
const MIN_CELL_M: f64 = 0.001;

/// The highest point of an object in each cell of a grid, object frame, meters. Cells without the object have the
/// height `f64::NEG_INFINITY`; the outermost cells are such.
pub(super) struct HeightField {
    low_m: DVec2,
    pub cell_m: f64,
    pub columns: usize,
    pub rows: usize,
    pub heights_m: Vec<f64>,
    /// Lowest point of the object.
    pub bottom_m: f64,
}

impl HeightField {
    /// The heights of hulls: at the centers of cells, and along the edges of the hulls, so that walls thinner than a
    /// cell have no holes. `None` without a corner.
    pub fn of(hulls: &[ConvexHull]) -> Option<Self> {
        let corners = hulls.iter().flat_map(|hull| &hull.points);
        let (low, high) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &point| {
            (low.min(point), high.max(point))
        });
        let size_m = (high - low).truncate();
        if !size_m.is_finite() || size_m.max_element() <= 0.0 {
            return None;
        }
        let cell_m = (size_m.max_element() / CELLS).max(MIN_CELL_M);
        let counts = (size_m / cell_m).ceil() + 3.0;
        let (columns, rows) = (counts.x as usize, counts.y as usize);
        let mut field = Self {
            low_m: low.truncate() - 1.5 * cell_m,
            cell_m,
            columns,
            rows,
            heights_m: vec![f64::NEG_INFINITY; columns * rows],
            bottom_m: low.z,
        };
        for hull in hulls {
            field.raise_interior(hull);
            field.raise_edges(hull);
        }
        Some(field)
    }

    /// Center of a cell.
    pub fn center_of(&self, cell: usize) -> DVec2 {
        let at = DVec2::new((cell % self.columns) as f64, (cell / self.columns) as f64);
        self.low_m + self.cell_m * (at + 0.5)
    }

    fn cell_at(&self, point_m: DVec2) -> usize {
        let at = ((point_m - self.low_m) / self.cell_m).max(DVec2::ZERO);
        (at.x as usize).min(self.columns - 1) + (at.y as usize).min(self.rows - 1) * self.columns
    }

    fn raise_interior(&mut self, hull: &ConvexHull) {
        let planes = planes(hull);
        let bounds = hull.points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| {
            (low.min(point.truncate()), high.max(point.truncate()))
        });
        let (first, last) = (self.cell_at(bounds.0), self.cell_at(bounds.1));
        for row in first / self.columns..=last / self.columns {
            for column in first % self.columns..=last % self.columns {
                let cell = row * self.columns + column;
                if let Some(top_m) = top_at(&planes, self.center_of(cell)) {
                    self.heights_m[cell] = self.heights_m[cell].max(top_m);
                }
            }
        }
    }

    fn raise_edges(&mut self, hull: &ConvexHull) {
        for triangle in &hull.triangles {
            let [a, b, c] = triangle.map(|corner| hull.points[corner as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let steps = ((to - from).truncate().length() / (0.5 * self.cell_m)).ceil().max(1.0) as u32;
                for step in 0..=steps {
                    let point = from.lerp(to, f64::from(step) / f64::from(steps));
                    let cell = self.cell_at(point.truncate());
                    self.heights_m[cell] = self.heights_m[cell].max(point.z);
                }
            }
        }
    }
}

/// Height at which the vertical line leaves the convex hull of these planes at the top.
fn top_at(planes: &[(DVec3, f64)], at_m: DVec2) -> Option<f64> {
    const VERTICAL: f64 = 1e-9;
    let (mut low_m, mut high_m) = (f64::NEG_INFINITY, f64::INFINITY);
    for (normal, offset_m) in planes {
        let rest_m = offset_m - normal.truncate().dot(at_m);
        if normal.z > VERTICAL {
            high_m = high_m.min(rest_m / normal.z);
        } else if normal.z < -VERTICAL {
            low_m = low_m.max(rest_m / normal.z);
        } else if rest_m < 0.0 {
            return None;
        }
    }
    (low_m <= high_m && high_m.is_finite()).then_some(high_m)
}
