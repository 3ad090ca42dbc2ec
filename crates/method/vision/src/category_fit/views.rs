//! Outlines of categories from all directions, each stretched to a square of bits, for the initial comparison.

use std::f64::consts::TAU;

use super::outline_raster::{NOTHING, Projection, Raster};
use super::stock_mesh::StockMesh;

/// Cells a side.
pub(super) const SIDE: usize = 32;

/// Yaws around a full turn.
pub(super) const YAWS: usize = 24;

/// A square of bits; bit 0 of a row is its left cell.
pub(super) type Bits = [u32; SIDE];

/// An orthographic view of a category.
pub(super) struct View {
    /// Yaw about +z with the view along +y.
    pub yaw_rad: f64,
    /// Extents of the view, meters.
    pub width_m: f64,
    pub height_m: f64,
    pub bits: Bits,
}

/// All views from that elevation; a single one of a rotationally symmetric mesh.
pub(super) fn around(mesh: &StockMesh, elevation_rad: f64) -> Vec<View> {
    let order = mesh.symmetry_order as usize;
    let count = match order {
        0 => 1,
        order if YAWS.is_multiple_of(order) => YAWS / order,
        _ => YAWS,
    };
    let mut raster = Raster::default();
    let (positions, triangles) = (&mesh.outline_positions, &mesh.outline_triangles);
    let view = |k: usize| {
        let yaw_rad = TAU * k as f64 / YAWS as f64;
        let through = Projection::from_afar(elevation_rad, yaw_rad);
        let (low, high) = through.bounds(positions)?;
        raster.draw_filling(SIDE, positions, triangles, &through, (low, high)).then(|| {
            let mut bits = [0; SIDE];
            for (cell, _) in raster.front().iter().enumerate().filter(|(_, front)| **front != NOTHING) {
                bits[cell / SIDE] |= 1 << (cell % SIDE);
            }
            let (width_m, height_m) = (f64::from(high.x - low.x), f64::from(high.y - low.y));
            View { yaw_rad, width_m, height_m, bits }
        })
    };
    (0..count).filter_map(view).collect()
}

/// Intersection over union outside occluded cells.
pub(super) fn overlap(a: &Bits, b: &Bits, hidden: &Bits) -> f64 {
    let (mut both, mut either) = (0, 0);
    for ((a, b), hidden) in a.iter().zip(b).zip(hidden) {
        both += (a & b & !hidden).count_ones();
        either += ((a | b) & !hidden).count_ones();
    }
    f64::from(both) / f64::from(either.max(1))
}
