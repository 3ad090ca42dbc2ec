//! Where a category's mesh must stand, how it is turned and how large it is, so that it shows where a thing shows.
//!
//! From a first guess the box of its outline is brought onto the thing's box; then one number after the other is moved up
//! and down by ever smaller steps as long as the outlines overlap better. Extents may leave the category's
//! proportions at a price.

use glam::{DVec2, DVec3};

use super::observed::Observed;
use super::outline_raster::{Projection, Raster, Stance};
use super::stock_mesh::StockMesh;
use geometry::Camera;

/// Rounds of ever smaller steps.
const ROUNDS: usize = 3;
/// How far proportions (natural logarithm of an extent against the common scale) may stray for nothing, and the price of more.
const FREE_STRAY: f64 = 0.08;
const STRAY_PRICE: f64 = 1.2;
/// Most an extent strays.
const MOST_STRAY: f64 = 0.35;

/// A stance and how well it fits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    pub stance: Stance,
    /// Intersection over union, hidden cells left out.
    pub overlap: f64,
    /// Price of strange proportions.
    pub stray: f64,
}

impl Fitted {
    pub fn merit(&self) -> f64 {
        self.overlap - self.stray
    }
}

/// One thing and the mesh that is held against it.
pub(super) struct StanceFit<'a> {
    pub observed: &'a Observed,
    pub camera: &'a Camera,
    pub mesh: &'a StockMesh,
}

impl StanceFit<'_> {
    /// The best stance near a first one; `None` where the mesh cannot be seen there.
    pub fn from(&self, first: Stance, raster: &mut Raster) -> Option<Fitted> {
        let boxed = self.boxed(first)?;
        let mut best = self.judged(boxed, raster)?;
        let away = self.away(best.stance.center);
        let right = DVec2::new(away.y, -away.x);
        let reach = 0.05 * (best.stance.stretch * self.mesh.size_m).max_element();
        let turns_alike = self.mesh.category.symmetry_order == 0;
        let mut step = 1.0;
        for _ in 0..ROUNDS {
            for knob in 0..7 {
                if turns_alike && matches!(knob, 3 | 5) {
                    continue;
                }
                for sign in [1.0, -1.0] {
                    let by = sign * step;
                    let mut stance = best.stance;
                    match knob {
                        0 => stance.center += by * reach * right,
                        1 => stance.center += by * 1.5 * reach * away,
                        2 => stance.stretch *= (0.06 * by).exp(),
                        3 => stance.yaw_rad += 0.14 * by,
                        4 => stance.stretch.z *= (0.1 * by).exp(),
                        5 => stance.stretch.x *= (0.08 * by).exp(),
                        _ if turns_alike => {
                            stance.stretch.x *= (0.06 * by).exp();
                            stance.stretch.y *= (0.06 * by).exp();
                        }
                        _ => stance.stretch.y *= (0.08 * by).exp(),
                    }
                    if let Some(moved) =
                        self.judged(stance, raster).filter(|moved| moved.merit() > best.merit())
                    {
                        best = moved;
                        break;
                    }
                }
            }
            step *= 0.5;
        }
        Some(best)
    }

    /// The stance moved and scaled until the outline's box is about the thing's.
    fn boxed(&self, mut stance: Stance) -> Option<Stance> {
        let grid = &self.observed.grid;
        let (low, high) = (self.observed.low_px, self.observed.high_px);
        for _ in 0..4 {
            let through = Projection::new(self.camera, grid, &stance);
            let (own_low, own_high) = through.bounds(&self.mesh.outline_positions)?;
            let in_picture = |p: glam::Vec2| grid.origin_px + grid.cell_px * p.as_dvec2();
            let (own_low, own_high) = (in_picture(own_low), in_picture(own_high));
            let ratio = (high - low) / (own_high - own_low).max(DVec2::splat(1e-6));
            stance.stretch *= (ratio.x * ratio.y).sqrt().clamp(0.5, 2.0);
            let base = self.camera.project(stance.center.extend(0.0))?.0;
            // The middle of the base keeps its place in the box.
            let place = (base - own_low) / (own_high - own_low).max(DVec2::splat(1e-6));
            let target = low + place * (high - low);
            stance.center = self.camera.meet_plane(target, 0.0)?.truncate();
        }
        stance.center.is_finite().then_some(stance)
    }

    fn judged(&self, stance: Stance, raster: &mut Raster) -> Option<Fitted> {
        let grid = &self.observed.grid;
        let stray = stray(stance.stretch);
        let through = Projection::new(self.camera, grid, &stance);
        let cells = (grid.columns, grid.rows);
        raster
            .draw(cells, &self.mesh.outline_positions, &self.mesh.outline_triangles, &through)
            .then(|| Fitted { stance, overlap: self.observed.overlap(raster.front()), stray })
    }

    fn away(&self, center: DVec2) -> DVec2 {
        (center - self.camera.world_from_camera.translation_m.truncate()).normalize_or(DVec2::Y)
    }
}

/// Price of extents that do not belong together.
fn stray(stretch: DVec3) -> f64 {
    let logs = [stretch.x, stretch.y, stretch.z].map(f64::ln);
    let middle = logs.iter().sum::<f64>() / 3.0;
    logs.iter()
        .map(|log| {
            let off = (log - middle).abs();
            if off > MOST_STRAY { 1.0 } else { STRAY_PRICE * (off - FREE_STRAY).max(0.0).powi(2) }
        })
        .sum()
}
