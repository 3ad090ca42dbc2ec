//! What extents and picture say about a rotation.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::turns::{raw_up, turned_size};
use super::{CanonicalizeSettings, UprightProblem};
use crate::appearance::{Model, PictureCrop, SIDE_PX};
use crate::dro::DroSettings;
use crate::dro::comparison::Comparison;
use crate::dro::crop::Crop;
use crate::dro::outline_mesh::OutlineMesh;
use imaging::Mask;
use runtime::{Interrupt, Interrupted};

/// Root mean square difference of the logarithms of the extents, common factor removed, weighted.
pub fn extent_cost(raw_size: DVec3, turn: DQuat, size_m: DVec3, settings: &CanonicalizeSettings) -> f64 {
    let turned = turned_size(raw_size, turn).max(DVec3::splat(1e-3 * raw_size.max_element()));
    let difference =
        DVec3::new((turned.x / size_m.x).ln(), (turned.y / size_m.y).ln(), (turned.z / size_m.z).ln());
    let mean = difference.element_sum() / 3.0;
    settings.extent_weight * ((difference - mean).length_squared() / 3.0).sqrt()
}

/// What it costs to turn the mesh otherwise than somebody says who has looked; of several sayings the nearest counts.
pub fn told_cost(turn: DQuat, told: &[DQuat], settings: &CanonicalizeSettings) -> f64 {
    let costs = told.iter().map(|said| match () {
        () if raw_up(*said).dot(raw_up(turn)) < 0.5 => settings.told_up_weight,
        () if said.dot(turn).abs() < 0.99 => settings.told_front_weight,
        () => 0.0,
    });
    costs.reduce(f64::min).unwrap_or(0.0)
}

/// More than rounding takes from a color disagreement of 0.
const ROUNDING: f64 = 1e-9;

/// The instance as the picture shows it, cropped for silhouettes and for colors.
pub struct Seen {
    silhouette: Crop,
    colors: Option<(Crop, PictureCrop)>,
}

impl Seen {
    /// `bbox` is the box of the problem's mask.
    pub fn new(problem: &UprightProblem, bbox: [u32; 4], settings: &CanonicalizeSettings) -> Self {
        let unknown = Mask::empty(problem.mask.width_px(), problem.mask.height_px());
        let colors = problem.picture.map(|(picture, shown_px)| {
            let crop = Crop::new(problem.mask, &unknown, bbox, SIDE_PX);
            let colors = PictureCrop::new(picture, shown_px, &crop);
            (crop, colors)
        });
        Self { silhouette: Crop::new(problem.mask, &unknown, bbox, settings.side_px as usize), colors }
    }
}

/// A mesh stood up one way, its outline compared with the picture's over a full turn.
pub struct Standing {
    turn: DQuat,
    scale: f64,
    outline: OutlineMesh,
    /// (yaw in radians, silhouette loss), best first.
    yaws: Vec<(f64, f64)>,
}

impl Standing {
    /// The mesh stood up by `turn`. `raw_outline` is that of the raw mesh.
    pub fn new(
        problem: &UprightProblem,
        raw_outline: &OutlineMesh,
        seen: &Seen,
        turn: DQuat,
        settings: &CanonicalizeSettings,
        dro: &DroSettings,
        interrupt: &Interrupt,
    ) -> Result<Self, Interrupted> {
        let turned = turned_size(problem.raw_mesh.size_m(), turn);
        let scale = (problem.size_m.element_product() / turned.element_product().max(1e-30)).cbrt();
        let outline = raw_outline.stood_up(turn, scale);
        let comparison = Comparison::new(&outline, problem.camera, 0.0, &seen.silhouette, dro);
        let count = settings.yaws.max(4);
        let mut yaws = Vec::with_capacity(count as usize);
        for k in 0..count {
            interrupt.check()?;
            let yaw_rad = TAU * f64::from(k) / f64::from(count);
            yaws.push((yaw_rad, comparison.loss(yaw_rad)));
        }
        yaws.sort_by(|a, b| a.1.total_cmp(&b.1));
        Ok(Self { turn, scale, outline, yaws })
    }

    /// What [`Self::picture_cost`] is at least.
    pub fn least_cost(&self) -> f64 {
        self.yaws[0].1 - ROUNDING
    }

    /// Least cost over the turn: silhouette loss plus weighted color disagreement at the best silhouettes.
    /// Exact where `matters` holds for it; `matters` must hold for every cost below one it holds for.
    pub fn picture_cost(
        &self,
        problem: &UprightProblem,
        seen: &Seen,
        settings: &CanonicalizeSettings,
        dro: &DroSettings,
        matters: &dyn Fn(f64) -> bool,
        interrupt: &Interrupt,
    ) -> Result<f64, Interrupted> {
        let Some((crop, picture)) = &seen.colors else { return Ok(self.yaws[0].1) };
        let comparison = Comparison::new(&self.outline, problem.camera, 0.0, crop, dro);
        let mesh = problem.raw_mesh.clone().rotated(self.turn).scaled(DVec3::splat(self.scale)).seated();
        let model = Model::new(&mesh, None);
        let mut least = f64::INFINITY;
        for &(yaw_rad, loss) in self.yaws.iter().take(settings.looks.max(1) as usize) {
            interrupt.check()?;
            // Colors add to the loss: no outline from here on can be the best.
            if loss >= least || !matters(loss - ROUNDING) {
                break;
            }
            let colors = picture.disagreement(&model, &comparison, yaw_rad);
            least = least.min(loss + settings.appearance_weight * colors);
        }
        Ok(least)
    }
}
