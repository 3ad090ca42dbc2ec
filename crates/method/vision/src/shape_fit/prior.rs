//! Prior on the position and height of an object.

use glam::DVec2;

use geometry::Camera;

/// Weight of the prior relative to the overlap, which is 0..1.
const WEIGHT: f64 = 0.04;

/// Expected footprint and height of an object, from the network or an earlier reading. One silhouette hardly
/// determines them, since depth and height trade against each other.
#[derive(Clone, Copy, Debug)]
pub struct ShapePrior {
    pub base: Option<BasePrior>,
    /// Height above the table if it stood there, in the camera's unit.
    pub height: f64,
    /// Standard deviation of the logarithm of the height.
    pub log_height_sigma: f64,
}

/// Expected center of the footprint in the camera's image, pixels.
#[derive(Clone, Copy, Debug)]
pub struct BasePrior {
    pub at_px: DVec2,
    /// Standard deviation.
    pub sigma_px: f64,
}

impl ShapePrior {
    /// Whether the height is measured. Fits then search along it: a height that follows from other parameters would
    /// hold these in place.
    pub fn has_measured_height(&self) -> bool {
        self.log_height_sigma < Self::LOG_HEIGHT_SIGMA
    }

    /// [`Self::log_height_sigma`] of heights that are not measured.
    pub const LOG_HEIGHT_SIGMA: f64 = 0.3;

    /// Penalty of a deviating primitive, 0 without deviation. It saturates, since a prior may be wrong altogether.
    pub fn disagreement(&self, center: DVec2, height: f64, camera: &Camera) -> f64 {
        let saturating = |sigmas: f64| sigmas.powi(2).ln_1p().min(10.0);
        let higher = (height.max(1e-6) / self.height.max(1e-6)).ln() / self.log_height_sigma;
        let apart = self.base.map_or(0.0, |base| match camera.project(center.extend(0.0)) {
            Some((p, _)) => (p - base.at_px).length() / base.sigma_px,
            None => f64::MAX,
        });
        WEIGHT * (saturating(apart) + saturating(higher))
    }

    /// Center of the footprint on the table.
    pub fn base(&self, camera: &Camera) -> Option<DVec2> {
        camera.meet_plane(self.base?.at_px, 0.0).map(|p| p.truncate())
    }
}
