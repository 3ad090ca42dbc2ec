//! Share of the area under a heap that bodies cover, seen from above.

use glam::DVec2;

use crate::Body;
use geometry::Outline;
use geometry::polygon::{convex_hull_2d, depth_in_convex_m};

/// Side of the cells that are counted, meters.
const CELL_M: f64 = 0.005;

/// Share of the covered area that the disk under the heap holds: a ball that rolled away does not widen it.
const HELD_SHARE: f64 = 0.9;

/// Share of the disk under a heap that its bodies cover. The disk is the smallest around the center of what they cover
/// that holds nine tenths of it; what of it lies outside the outline does not count. 0 without bodies.
pub fn covered_share(bodies: &[&Body], outline: &Outline) -> f64 {
    let grid = Grid::over(outline);
    let covered = grid.covered(bodies);
    let cells: Vec<DVec2> = (0..covered.len()).filter(|&k| covered[k]).map(|k| grid.center(k)).collect();
    if cells.is_empty() {
        return 0.0;
    }
    let center = cells.iter().sum::<DVec2>() / cells.len() as f64;
    let mut distances_m: Vec<f64> = cells.iter().map(|cell| cell.distance(center)).collect();
    distances_m.sort_by(f64::total_cmp);
    let held = ((HELD_SHARE * cells.len() as f64).ceil() as usize).clamp(1, cells.len());
    let radius_m = distances_m[held - 1];
    let disk = (0..covered.len())
        .map(|k| grid.center(k))
        .filter(|cell| cell.distance(center) <= radius_m && outline.contains(*cell))
        .count();
    let within = distances_m.iter().filter(|distance_m| **distance_m <= radius_m).count();
    (within as f64 / disk.max(within) as f64).min(1.0)
}

/// Cells over the box of an outline, row by row.
struct Grid {
    low: DVec2,
    columns: usize,
    rows: usize,
}

impl Grid {
    fn over(outline: &Outline) -> Self {
        let (low, high) = outline.bounds();
        let count = ((high - low) / CELL_M).ceil().max(DVec2::ONE);
        Self { low, columns: count.x as usize, rows: count.y as usize }
    }

    fn center(&self, index: usize) -> DVec2 {
        let (row, column) = (index / self.columns, index % self.columns);
        self.low + CELL_M * (DVec2::new(column as f64, row as f64) + 0.5)
    }

    /// Whether each cell's center lies below a hull of a body.
    fn covered(&self, bodies: &[&Body]) -> Vec<bool> {
        let mut covered = vec![false; self.columns * self.rows];
        for (body, hull) in bodies.iter().flat_map(|body| body.hulls.iter().map(move |hull| (body, hull))) {
            let points: Vec<DVec2> =
                hull.points.iter().map(|p| body.world_from_object.transform_point(*p).truncate()).collect();
            let outline = convex_hull_2d(&points);
            let range = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            let (low, high) = outline.iter().fold(range, |(low, high), p| (low.min(*p), high.max(*p)));
            let clamp = |at: DVec2| {
                let cell = (at - self.low) / CELL_M;
                let inside = |value: f64, count: usize| value.clamp(0.0, count as f64) as usize;
                (inside(cell.x, self.columns), inside(cell.y, self.rows))
            };
            let ((left, bottom), (right, top)) = (clamp(low), clamp(high + CELL_M));
            for index in
                (bottom..top).flat_map(|row| (left..right).map(move |column| row * self.columns + column))
            {
                covered[index] = covered[index] || depth_in_convex_m(&outline, self.center(index)) >= 0.0;
            }
        }
        covered
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::test_bodies::body;
    use geometry::Pose;
    use geometry::shapes::{block, rectangle};

    #[test]
    fn covered_share_is_that_of_the_disk_under_the_heap() {
        let outline = Outline::new(rectangle(2.0, 2.0)).expect("a square");
        let tile = |x: f64, y: f64| {
            body("tile", block(DVec3::new(0.1, 0.1, 0.02)), Pose::upright(DVec3::new(x, y, 0.0), 0.0))
        };
        assert_eq!(covered_share(&[], &outline), 0.0);
        // One square fills the central disk that holds nine tenths of it, but for its sides.
        let one = tile(0.0, 0.0);
        assert!(covered_share(&[&one], &outline) > 0.85);
        // Tiles every 20 cm cover a quarter of the plane.
        let spread: Vec<Body> =
            (0..36).map(|k| tile(0.2 * f64::from(k % 6) - 0.5, 0.2 * f64::from(k / 6) - 0.5)).collect();
        let share = covered_share(&spread.iter().collect::<Vec<_>>(), &outline);
        assert!((share - 0.25).abs() < 0.05, "{share}");
        // Tiles on each other cover no more than one of them.
        let two = [tile(0.0, 0.0), tile(0.0, 0.0)];
        assert_eq!(covered_share(&[&two[0], &two[1]], &outline), covered_share(&[&one], &outline));
    }
}
