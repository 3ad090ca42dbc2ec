//! Stance fit: position, yaw and extents of a category's mesh for an object's mask.
//!
//! The initial stance aligns the bounding boxes of the outlines. Then a coordinate search with shrinking steps
//! maximizes the overlap. Extents may deviate from the category's proportions at a penalty.

use glam::{DVec2, DVec3};

use super::observed::Observation;
use super::outline_raster::{Projection, Raster, Stance};
use super::stock_mesh::StockMesh;
use geometry::Camera;

/// Rounds of shrinking steps.
const ROUNDS: usize = 3;
/// Free deviation of proportions (natural logarithm of an extent relative to the common scale), and the weight of
/// more.
const FREE_STRAY: f64 = 0.08;
const STRAY_PRICE: f64 = 1.2;
/// Maximum deviation of an extent.
const MAX_STRAY: f64 = 0.35;

/// A stance and its score.
#[derive(Clone, Copy, Debug)]
pub(super) struct FittedStance {
    pub stance: Stance,
    /// Intersection over union, occluded cells left out.
    pub overlap: f64,
    /// Penalty of unusual proportions.
    pub stray: f64,
}

impl FittedStance {
    pub fn merit(&self) -> f64 {
        self.overlap - self.stray
    }
}

/// One object and the mesh that is fitted to it.
pub(super) struct StanceFit<'a> {
    pub observed: &'a Observation,
    pub camera: &'a Camera,
    pub mesh: &'a StockMesh,
}

impl StanceFit<'_> {
    /// The best stance near an initial one; `None` if the mesh is not visible there.
    pub fn from(&self, first: Stance, raster: &mut Raster) -> Option<FittedStance> {
        let boxed = self.boxed(first)?;
        let mut best = self.evaluate(boxed, raster)?;
        let away = self.away(best.stance.center);
        let right = DVec2::new(away.y, -away.x);
        let reach = 0.05 * (best.stance.stretch * self.mesh.size_m).max_element();
        let turns_alike = self.mesh.symmetry_order == 0;
        let mut step = 1.0;
        for _ in 0..ROUNDS {
            for parameter in 0..7 {
                if turns_alike && matches!(parameter, 3 | 5) {
                    continue;
                }
                for sign in [1.0, -1.0] {
                    let by = sign * step;
                    let mut stance = best.stance;
                    match parameter {
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
                        self.evaluate(stance, raster).filter(|moved| moved.merit() > best.merit())
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

    /// Moves and scales the stance until the outline's box is about the object's.
    fn boxed(&self, mut stance: Stance) -> Option<Stance> {
        let grid = &self.observed.grid;
        let (low, high) = (self.observed.low_px, self.observed.high_px);
        for _ in 0..4 {
            let through = Projection::new(self.camera, grid, &stance);
            let (own_low, own_high) = through.bounds(&self.mesh.outline_positions)?;
            let in_image = |p: glam::Vec2| grid.origin_px + grid.cell_px * p.as_dvec2();
            let (own_low, own_high) = (in_image(own_low), in_image(own_high));
            let ratio = (high - low) / (own_high - own_low).max(DVec2::splat(1e-6));
            stance.stretch *= (ratio.x * ratio.y).sqrt().clamp(0.5, 2.0);
            let base = self.camera.project(stance.center.extend(0.0))?.0;
            // The center of the base keeps its relative position in the box.
            let place = (base - own_low) / (own_high - own_low).max(DVec2::splat(1e-6));
            let target = low + place * (high - low);
            stance.center = self.camera.meet_plane(target, 0.0)?.truncate();
        }
        stance.center.is_finite().then_some(stance)
    }

    fn evaluate(&self, stance: Stance, raster: &mut Raster) -> Option<FittedStance> {
        let grid = &self.observed.grid;
        let stray = stray(stance.stretch);
        let through = Projection::new(self.camera, grid, &stance);
        let cells = (grid.columns, grid.rows);
        raster
            .draw(cells, &self.mesh.outline_positions, &self.mesh.outline_triangles, &through)
            .then(|| FittedStance { stance, overlap: self.observed.overlap(raster.front()), stray })
    }

    fn away(&self, center: DVec2) -> DVec2 {
        (center - self.camera.world_from_camera.translation_m.truncate()).normalize_or(DVec2::Y)
    }
}

/// Penalty of inconsistent extents.
fn stray(stretch: DVec3) -> f64 {
    let logs = [stretch.x, stretch.y, stretch.z].map(f64::ln);
    let center = logs.iter().sum::<f64>() / 3.0;
    logs.iter()
        .map(|log| {
            let off = (log - center).abs();
            if off > MAX_STRAY { 1.0 } else { STRAY_PRICE * (off - FREE_STRAY).max(0.0).powi(2) }
        })
        .sum()
}
