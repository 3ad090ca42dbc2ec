//! Costs of a rotation by extents, hints and image.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::rotations::{raw_up, turned_size};
use super::{UprightProblem, UprightSettings};
use crate::appearance::{ImageCrop, Model, SIDE_PX};
use crate::yaw::YawSettings;
use crate::yaw::comparison::Comparison;
use crate::yaw::crop::Crop;
use crate::yaw::outline_mesh::OutlineMesh;
use imaging::Mask;
use runtime::{CancelFlag, Cancelled};

/// Root mean square difference of the logarithms of the extents, common factor removed, weighted.
pub fn extent_cost(raw_size: DVec3, turn: DQuat, size_m: DVec3, settings: &UprightSettings) -> f64 {
    let turned = turned_size(raw_size, turn).max(DVec3::splat(1e-3 * raw_size.max_element()));
    let difference =
        DVec3::new((turned.x / size_m.x).ln(), (turned.y / size_m.y).ln(), (turned.z / size_m.z).ln());
    let mean = difference.element_sum() / 3.0;
    settings.extent_weight * ((difference - mean).length_squared() / 3.0).sqrt()
}

/// Cost of deviating from the hints; of several hints the nearest counts.
pub fn hint_cost(turn: DQuat, hints: &[DQuat], settings: &UprightSettings) -> f64 {
    let costs = hints.iter().map(|said| match () {
        () if raw_up(*said).dot(raw_up(turn)) < 0.5 => settings.hint_up_weight,
        () if said.dot(turn).abs() < 0.99 => settings.hint_front_weight,
        () => 0.0,
    });
    costs.reduce(f64::min).unwrap_or(0.0)
}

/// Bound on the rounding of a color disagreement of 0.
const ROUNDING: f64 = 1e-9;

/// Crops of the instance, for silhouettes and for colors.
pub struct InstanceCrops {
    silhouette: Crop,
    colors: Option<(Crop, ImageCrop)>,
}

impl InstanceCrops {
    /// `bbox` is the box of the problem's mask.
    pub fn new(problem: &UprightProblem, bbox: [u32; 4], settings: &UprightSettings) -> Self {
        let unknown = Mask::empty(problem.mask.width_px(), problem.mask.height_px());
        let colors = problem.image.map(|(image, crop_px)| {
            let crop = Crop::new(problem.mask, &unknown, bbox, SIDE_PX);
            let colors = ImageCrop::new(image, crop_px, &crop);
            (crop, colors)
        });
        Self { silhouette: Crop::new(problem.mask, &unknown, bbox, settings.side_px as usize), colors }
    }
}

/// A candidate up direction with its silhouette losses over a full turn.
pub struct UprightHypothesis {
    turn: DQuat,
    scale: f64,
    outline: OutlineMesh,
    /// (yaw in radians, silhouette loss), best first.
    yaws: Vec<(f64, f64)>,
}

impl UprightHypothesis {
    /// The mesh rotated by `turn`. `raw_outline` is that of the raw mesh.
    pub fn new(
        problem: &UprightProblem,
        raw_outline: &OutlineMesh,
        seen: &InstanceCrops,
        turn: DQuat,
        settings: &UprightSettings,
        dro: &YawSettings,
        cancel: &CancelFlag,
    ) -> Result<Self, Cancelled> {
        let turned = turned_size(problem.raw_mesh.size_m(), turn);
        let scale = (problem.size_m.element_product() / turned.element_product().max(1e-30)).cbrt();
        let outline = raw_outline.stood_up(turn, scale);
        let comparison = Comparison::new(&outline, problem.camera, 0.0, &seen.silhouette, dro);
        let count = settings.yaws.max(4);
        let mut yaws = Vec::with_capacity(count as usize);
        for k in 0..count {
            cancel.check()?;
            let yaw_rad = TAU * f64::from(k) / f64::from(count);
            yaws.push((yaw_rad, comparison.loss(yaw_rad)));
        }
        yaws.sort_by(|a, b| a.1.total_cmp(&b.1));
        Ok(Self { turn, scale, outline, yaws })
    }

    /// Lower bound on [`Self::image_cost`].
    pub fn min_cost(&self) -> f64 {
        self.yaws[0].1 - ROUNDING
    }

    /// Minimum cost over the turn: silhouette loss plus weighted color disagreement at the best silhouettes. Exact
    /// where `matters` holds for it; `matters` must hold for every cost below one it holds for.
    pub fn image_cost(
        &self,
        problem: &UprightProblem,
        seen: &InstanceCrops,
        settings: &UprightSettings,
        dro: &YawSettings,
        matters: &dyn Fn(f64) -> bool,
        cancel: &CancelFlag,
    ) -> Result<f64, Cancelled> {
        let Some((crop, image)) = &seen.colors else { return Ok(self.yaws[0].1) };
        let comparison = Comparison::new(&self.outline, problem.camera, 0.0, crop, dro);
        let mesh = problem.raw_mesh.clone().rotated(self.turn).scaled(DVec3::splat(self.scale)).seated();
        let model = Model::new(&mesh, None);
        let mut lowest = f64::INFINITY;
        for &(yaw_rad, loss) in self.yaws.iter().take(settings.color_candidates.max(1) as usize) {
            cancel.check()?;
            // Colors add to the loss: no outline from here on can be the best.
            if loss >= lowest || !matters(loss - ROUNDING) {
                break;
            }
            let colors = image.disagreement(&model, &comparison, yaw_rad);
            lowest = lowest.min(loss + settings.appearance_weight * colors);
        }
        Ok(lowest)
    }
}
