//! The part of a table onto which bodies are dropped.

use glam::DVec2;
use rand::RngExt;

use super::EDGE_M;
use geometry::Outline;
use geometry::polygon::depth_in_convex_m;
use runtime::seed::Rng;

/// Side of the cells of which a region consists, meters.
const CELL_M: f64 = 0.01;

/// Distance of drops from bodies that stay in place, meters.
const KEPT_M: f64 = 0.02;

/// Density above which the region shrinks no more: of two and a half layers, a heap slides apart already.
const MAX_DENSITY: f64 = 0.92;

/// Random centers of which the best is taken.
const CENTERS: usize = 8;

/// Cells of a table's top, nearest to the center of the heap first.
pub(super) struct Region {
    cells: Vec<DVec2>,
    /// Number of cells that are the region; the others are the rest of the table.
    count: usize,
}

impl Region {
    /// The region in which footprints with that total area have that density; `None` if nothing of the table is free
    /// of `kept`, the convex footprints of what stays in place.
    pub fn new(
        outline: &Outline,
        kept: &[Vec<DVec2>],
        area_m2: f64,
        density: f64,
        rng: &mut Rng,
    ) -> Option<Self> {
        let cells = free_cells(outline, kept);
        if cells.is_empty() {
            return None;
        }
        // The logarithm of 1 is a negative zero here; without density the region is the whole table.
        let layers = -(1.0 - density.clamp(0.0, MAX_DENSITY)).ln();
        let wanted = if layers > 0.0 { area_m2 / layers / (CELL_M * CELL_M) } else { f64::INFINITY };
        let count = if wanted < cells.len() as f64 { (wanted.ceil() as usize).max(1) } else { cells.len() };
        let centers: Vec<DVec2> = (0..CENTERS).map(|_| cells[rng.random_range(0..cells.len())]).collect();
        let mut best: Option<(f64, Vec<DVec2>)> = None;
        for center in centers {
            let mut sorted = cells.clone();
            sorted.sort_by(|a, b| a.distance_squared(center).total_cmp(&b.distance_squared(center)));
            let spread_m2 = sorted[..count].iter().map(|cell| cell.distance_squared(center)).sum::<f64>();
            if best.as_ref().is_none_or(|(other_m2, _)| spread_m2 < *other_m2) {
                best = Some((spread_m2, sorted));
            }
        }
        best.map(|(_, cells)| Self { cells, count })
    }

    /// A random place of the region, or of one with the same center and `widening` times its area.
    pub fn draw(&self, widening: usize, rng: &mut Rng) -> DVec2 {
        let count = self.count.saturating_mul(widening).min(self.cells.len());
        let cell = self.cells[rng.random_range(0..count)];
        let half_m = 0.5 * CELL_M;
        cell + DVec2::new(rng.random_range(-half_m..half_m), rng.random_range(-half_m..half_m))
    }

    #[cfg(test)]
    pub fn area_m2(&self) -> f64 {
        self.count as f64 * CELL_M * CELL_M
    }
}

/// Centers of the cells inside the outline that are clear of its edge and of what stays in place.
fn free_cells(outline: &Outline, kept: &[Vec<DVec2>]) -> Vec<DVec2> {
    let (low, high) = outline.bounds();
    // Small tables have a narrower border.
    let edge_m = EDGE_M.min(0.15 * (high - low).min_element());
    let count = ((high - low) / CELL_M).ceil();
    let columns = (0..count.x as u32).map(|x| low.x + CELL_M * (f64::from(x) + 0.5));
    let at = |x: f64| (0..count.y as u32).map(move |y| DVec2::new(x, low.y + CELL_M * (f64::from(y) + 0.5)));
    columns
        .flat_map(at)
        .filter(|cell| outline.depth_inside_m(*cell) >= edge_m)
        .filter(|cell| kept.iter().all(|footprint| depth_in_convex_m(footprint, *cell) < -KEPT_M))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::rectangle;
    use runtime::seed::child_rng;

    #[test]
    fn regions_shrink_with_density_and_avoid_what_is_kept() {
        let outline = Outline::new(rectangle(1.2, 0.8)).expect("a rectangle");
        let kept = [vec![
            DVec2::new(-0.1, -0.1),
            DVec2::new(0.1, -0.1),
            DVec2::new(0.1, 0.1),
            DVec2::new(-0.1, 0.1),
        ]];
        let region = |density| {
            Region::new(&outline, &kept, 0.1, density, &mut child_rng(3, "region")).expect("a region")
        };
        let whole = region(0.0);
        assert!((whole.area_m2() - (1.1 * 0.7 - 0.24 * 0.24)).abs() < 0.02, "{}", whole.area_m2());
        assert!((region(0.5).area_m2() - 0.1 / 2.0_f64.ln()).abs() < 1e-3);
        let mut last = f64::INFINITY;
        for density in [0.2, 0.5, 0.8, 0.92] {
            let area_m2 = region(density).area_m2();
            assert!(area_m2 < last, "{density}: {area_m2}");
            last = area_m2;
        }
        assert_eq!(region(1.0).area_m2(), last);
        let mut rng = child_rng(1, "draws");
        for _ in 0..500 {
            let at = region(0.3).draw(1, &mut rng);
            assert!(at.abs().max_element() > 0.1 && outline.depth_inside_m(at) > 0.04, "{at}");
        }
        let full = [rectangle(3.0, 3.0)];
        assert!(Region::new(&outline, &full, 0.1, 0.5, &mut rng).is_none());
    }
}
