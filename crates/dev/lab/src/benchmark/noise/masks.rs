//! Mask degradation as in network output: eroded boundaries and holes.

use rand::RngExt;

use super::Noise;
use imaging::Mask;
use imaging::distance_transform::distance_transform;
use runtime::seed::{Rng, child_rng};

/// Grid spacing of the erosion depth, pixels.
const GRID_PX: usize = 12;

/// The mask with its boundary eroded by a smoothly varying depth, and with `holes` round holes. A nonempty mask
/// stays nonempty.
pub fn degrade(mask: &Mask, noise: &Noise, holes: u32, seed: u64) -> Mask {
    let (width, height) = (mask.width_px() as usize, mask.height_px() as usize);
    let outside: Vec<bool> = mask.bits().iter().map(|bit| !bit).collect();
    let inward_px = distance_transform(&outside, width, height);
    let inside = |k: &usize| mask.bits()[*k];
    let deepest_px = (0..width * height).filter(inside).map(|k| f64::from(inward_px[k])).fold(0.0, f64::max);
    let max_px = noise.mask_erosion_px.min(noise.mask_erosion_share * deepest_px);
    let mut rng = child_rng(seed, "wear");
    let depth = Depth::new(width, height, &mut rng);
    let area = mask.area_px() as f64;
    let cells: Vec<usize> = (0..width * height).filter(inside).collect();
    let holes: Vec<(f64, f64, f64)> = match cells.len() {
        0 => Vec::new(),
        count => (0..holes)
            .map(|_| {
                let at = cells[rng.random_range(0..count)];
                let share = noise.mask_hole_share * rng.random_range(0.0..1.0);
                ((at % width) as f64, (at / width) as f64, (share * area / std::f64::consts::PI).sqrt())
            })
            .collect(),
    };
    let worn = Mask::from_fn(mask.width_px(), mask.height_px(), |x, y| {
        let k = y as usize * width + x as usize;
        // The first inside pixel is one pixel from the nearest outside one.
        let eroded = f64::from(inward_px[k]) <= max_px * depth.at(x as usize, y as usize);
        let in_hole =
            holes.iter().any(|(u, v, r)| (f64::from(x) - u).powi(2) + (f64::from(y) - v).powi(2) < r * r);
        mask.contains(x, y) && !eroded && !in_hole
    });
    if worn.area_px() == 0 { mask.clone() } else { worn }
}

/// A smooth random field in 0..1: grid values with bilinear interpolation.
struct Depth {
    columns: usize,
    values: Vec<f64>,
}

impl Depth {
    fn new(width_px: usize, height_px: usize, rng: &mut Rng) -> Self {
        let (columns, rows) = (width_px / GRID_PX + 2, height_px / GRID_PX + 2);
        Self { columns, values: (0..columns * rows).map(|_| rng.random_range(0.0..1.0)).collect() }
    }

    fn at(&self, x: usize, y: usize) -> f64 {
        let (column, row) = (x / GRID_PX, y / GRID_PX);
        let (s, t) = ((x % GRID_PX) as f64 / GRID_PX as f64, (y % GRID_PX) as f64 / GRID_PX as f64);
        let value = |c: usize, r: usize| self.values[r * self.columns + c];
        let above = value(column, row) * (1.0 - s) + value(column + 1, row) * s;
        let below = value(column, row + 1) * (1.0 - s) + value(column + 1, row + 1) * s;
        above * (1.0 - t) + below * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degraded_mask_is_subset_and_keeps_three_quarters() {
        let disk = Mask::from_fn(120, 90, |x, y| (x as f64 - 60.0).hypot(y as f64 - 45.0) < 30.0);
        let left = degrade(&disk, &Noise::NOISY, 3, 9);
        assert!(left.bits().iter().zip(disk.bits()).all(|(worn, whole)| !worn || *whole));
        let share = left.area_px() as f64 / disk.area_px() as f64;
        assert!((0.75..0.99).contains(&share), "{share}");
        assert_eq!(left, degrade(&disk, &Noise::NOISY, 3, 9));
        let thin = Mask::from_fn(60, 60, |x, y| x == 20 && y > 5 && y < 50);
        assert!(degrade(&thin, &Noise::NOISY, 0, 1).area_px() > 0);
    }
}
