//! Joint estimate of object shape proxies and camera elevation.
//!
//! The outline of a rectangular or round top corrects the predicted elevation better than objects could. Other
//! outlines do not constrain it. There, the estimate is the elevation that maximizes the summed shape-fit score.
//! Under a wrong elevation boxes and cylinders lean or sink, or their silhouettes do not exist.

use glam::DVec2;
use rayon::prelude::*;

use super::camera_fit::ExpectedCamera;
use super::instances::DetectedObject;
use super::table_top::{TableTop, TopObservation};
use crate::VisionError;
use crate::measured_depth::HeightRange;
use crate::pixels::Pixels;
use crate::reading::TopShape;
use crate::shape_fit;
use crate::shape_fit::{BasePrior, InnerEdges, PosedPrimitive, ShapePrior, Surroundings};
use crate::table_network::maps::Maps;
use geometry::Camera;
use imaging::Mask;
use runtime::{CancelFlag, Cancelled};

/// Standard deviation of the predicted footprint center, map cells.
const BASE_SIGMA: f64 = 1.5;
/// Minimum height of an object, as a share of the camera's height above the table.
const MIN_HEIGHT: f64 = 0.002;
/// Standard deviation of the predicted elevation, on validation images.
const ELEVATION_SIGMA_RAD: f64 = 0.1;
/// Standard deviation of the logarithm of a measured height, beside the noise of the depth.
const MEASURED_LOG_HEIGHT_SIGMA: f64 = 0.05;
/// The lowest visible surface of an object on the table lies lower than this, in standard deviations of a height and as
/// a share of the object's top.
const ON_TABLE_SIGMAS: f64 = 4.0;
const ON_TABLE_SHARE: f64 = 0.2;
/// Minimum ratio of the predicted height of a support to that of the lowest visible surface on it.
const MIN_PREDICTED_SHARE: f64 = 0.3;
/// Step between the hypotheses, and their number on either side of the prediction.
const ELEVATION_STEP_RAD: f64 = 0.06;
const STEPS_PER_SIDE: i32 = 3;
/// Increase of the summed score that multiplies the likelihood of an elevation by e; chosen on validation images.
const MERIT_UNIT: f64 = 0.05;

/// A fitted primitive, and the height of its support above the table.
pub(super) struct Solid {
    pub fit: PosedPrimitive,
    pub support: f64,
}

/// Input of the joint estimate: objects and what the image shows of each.
pub(super) struct JointEstimate<'a> {
    pub objects: &'a [DetectedObject],
    /// Pixels of the working copy, without holes.
    pub silhouettes: &'a [Vec<usize>],
    /// Masks of the occluders of each object.
    pub in_front: &'a [Mask],
    /// Measured heights of each object; `None` where they are not measured.
    pub heights: &'a [Option<HeightRange>],
    pub edges: &'a InnerEdges,
    pub maps: &'a Maps,
    pub pixels: &'a Pixels,
    pub cancel: &'a CancelFlag,
}

impl JointEstimate<'_> {
    /// The top under the best camera, and the best primitive of each object there; `None` for objects that no
    /// primitive fits. A measured elevation is taken as it is.
    pub fn solve(
        &self,
        seen: &TopObservation,
        expected: &ExpectedCamera,
    ) -> Result<(TableTop, Vec<Option<Solid>>), VisionError> {
        let first = seen.with_camera(expected).ok_or(VisionError::NoCamera)?;
        if constrains_elevation(&first) || expected.measured_roll_rad.is_some() {
            let (solids, _) = self.fit_solids(&first)?;
            return Ok((first, solids));
        }
        let hypothesis = |steps: f64| -> Result<Option<ElevationHypothesis>, Cancelled> {
            let off_rad = ELEVATION_STEP_RAD * steps;
            // Under another camera the top may be of another shape, or not exist.
            let tried = expected.at(expected.elevation_rad + off_rad);
            let Some(top) = seen.with_camera(&tried).filter(|top| !constrains_elevation(top)) else {
                return Ok(None);
            };
            let (solids, merit) = self.fit_solids(&top)?;
            let likelihood = merit / MERIT_UNIT - 0.5 * (off_rad / ELEVATION_SIGMA_RAD).powi(2);
            Ok(Some(ElevationHypothesis { top, solids, likelihood }))
        };
        let tried = (-STEPS_PER_SIDE..=STEPS_PER_SIDE)
            .map(|k| hypothesis(f64::from(k)))
            .collect::<Result<Vec<Option<ElevationHypothesis>>, Cancelled>>()?;
        let likelihoods: Vec<Option<f64>> =
            tried.iter().map(|seen| seen.as_ref().map(|seen| seen.likelihood)).collect();
        let steps = parabola_peak(&likelihoods).map(|index| index - f64::from(STEPS_PER_SIDE));
        let between = steps.map(hypothesis).transpose()?.flatten();
        let all = tried.into_iter().flatten().chain(between);
        let best = all.max_by(|a, b| a.likelihood.total_cmp(&b.likelihood)).ok_or(VisionError::NoCamera)?;
        Ok((best.top, best.solids))
    }

    /// The best primitive of each object under the top's camera, and the sum of their scores.
    fn fit_solids(&self, top: &TableTop) -> Result<(Vec<Option<Solid>>, f64), Cancelled> {
        let fits = (0..self.objects.len())
            .into_par_iter()
            .map(|index| {
                self.cancel.check()?;
                Ok(self.solid(index, top))
            })
            .collect::<Result<Vec<Option<(Solid, f64)>>, Cancelled>>()?;
        let merit = fits.iter().flatten().map(|(_, merit)| merit).sum();
        Ok((fits.into_iter().map(|fit| fit.map(|(solid, _)| solid)).collect(), merit))
    }

    fn solid(&self, index: usize, top: &TableTop) -> Option<(Solid, f64)> {
        let camera = &top.found.camera;
        let eye_height = camera.world_from_camera.translation_m.z;
        let prior = self.expected(index, camera);
        let support = prior.as_ref().map_or(0.0, |(_, support)| *support);
        let around = Surroundings {
            in_front: Some(self.in_front[index].bits()),
            top: Some((&top.outline, (eye_height - support) / eye_height)),
        };
        let expected = prior.as_ref().map(|(expected, _)| expected);
        let (fit, merit) =
            shape_fit::fit(&self.silhouettes[index], camera, Some(self.edges), expected, &around)?;
        Some((Solid { fit, support }, merit))
    }

    /// The shape prior of an object as if it stood on the table along the same rays, and the height of its
    /// support. `None` if its base lies above the horizon.
    fn expected(&self, index: usize, camera: &Camera) -> Option<(ShapePrior, f64)> {
        let object = &self.objects[index];
        let in_copy = |p: DVec2| self.pixels.scale * self.maps.in_image(p);
        let row = |y: f64| in_copy(DVec2::new(object.base.x, y));
        let eye_height = camera.world_from_camera.translation_m.z;
        let ground = camera.meet_plane(row(object.ground_row), 0.0)?.truncate();
        let predicted = height_over(camera, ground, in_copy(object.base)).clamp(0.0, 0.9 * eye_height);
        let (support, top, sigma) = match &self.heights[index] {
            Some(measured) => {
                let support = measured_support(measured, predicted / eye_height);
                (support * eye_height, measured.top * eye_height, measured.sigma * eye_height)
            }
            None => (predicted, height_over(camera, ground, row(object.top_row)), 0.0),
        };
        let height = (top - support).max(MIN_HEIGHT * eye_height);
        let log_height_sigma = match &self.heights[index] {
            Some(_) => MEASURED_LOG_HEIGHT_SIGMA.hypot(sigma / height),
            None => ShapePrior::LOG_HEIGHT_SIGMA,
        };
        let sigma_px = BASE_SIGMA * self.maps.pixel_px() * self.pixels.scale;
        let base = BasePrior { at_px: in_copy(object.base), sigma_px };
        // An object on a support is nearer to the camera, so its proxy on the table is larger.
        let height = height * eye_height / (eye_height - support);
        Some((ShapePrior { base: Some(base), height, log_height_sigma }, support))
    }
}

/// Height of an object's support, in heights of the camera. `predicted` is the network's, and decides where the lower
/// part of an object is hidden.
fn measured_support(heights: &HeightRange, predicted: f64) -> f64 {
    let HeightRange { bottom, top, sigma } = *heights;
    if bottom < (ON_TABLE_SIGMAS * sigma).max(ON_TABLE_SHARE * top) {
        0.0
    } else if predicted > MIN_PREDICTED_SHARE * bottom {
        bottom
    } else {
        predicted
    }
}

/// Whether the outline of the top constrains the elevation.
fn constrains_elevation(top: &TableTop) -> bool {
    matches!(top.shape, TopShape::Rectangle | TopShape::Circle)
}

/// Top and primitives under one elevation.
struct ElevationHypothesis {
    top: TableTop,
    solids: Vec<Option<Solid>>,
    likelihood: f64,
}

/// Index of the maximum of the parabola through the largest value and its neighbors; `None` if a neighbor is
/// missing.
fn parabola_peak(values: &[Option<f64>]) -> Option<f64> {
    let known = values.iter().enumerate().filter_map(|(index, value)| Some((index, (*value)?)));
    let (highest, here) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (before, after) = ((*values.get(highest.checked_sub(1)?)?)?, (*values.get(highest + 1)?)?);
    let bend = before + after - 2.0 * here;
    (bend < 0.0).then(|| highest as f64 + 0.5 * (before - after) / bend)
}

/// Height above a point of the table at which the vertical through it appears in the row of a pixel.
fn height_over(camera: &Camera, ground: DVec2, at_px: DVec2) -> f64 {
    let eye = camera.world_from_camera.translation_m;
    let away = ground - eye.truncate();
    let ray = camera.ray_direction_in_world(at_px);
    // The ray is cut with the plane through the vertical that faces the camera.
    eye.z + away.length_squared() / ray.truncate().dot(away).max(1e-9) * ray.z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabola_peak_interpolates_between_hypotheses() {
        let along = |highest: f64| -> Vec<Option<f64>> {
            (0..7).map(|cell| Some(5.0 - 2.0 * (f64::from(cell) - highest).powi(2))).collect()
        };
        for highest in [1.0, 3.3, 4.45] {
            let found = parabola_peak(&along(highest)).expect("has neighbors");
            assert!((found - highest).abs() < 1e-9, "{found} for {highest}");
        }
        assert_eq!(parabola_peak(&along(-1.0)), None, "the first has no neighbor before it");
        assert_eq!(parabola_peak(&along(9.0)), None, "nor the last one after it");
        let mut torn = along(3.3);
        torn[2] = None;
        assert_eq!(parabola_peak(&torn), None);
        assert_eq!(parabola_peak(&[Some(1.0), Some(1.0), Some(1.0)]), None, "a plain has none");
        assert_eq!(parabola_peak(&[None, None]), None);
    }
}
