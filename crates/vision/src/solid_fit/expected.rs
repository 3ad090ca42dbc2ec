//! What is expected of a thing before its silhouette is looked at.

use glam::DVec2;

use geometry::Camera;

/// Weight of an expectation against the overlap of outlines, which is 0..1.
const WEIGHT: f64 = 0.04;

/// Standard deviation of the logarithm of an expected height.
const HEIGHT_SIGMA: f64 = 0.3;

/// Where a thing stands and how high it is, as a network says or an earlier reading said; one silhouette hardly tells, since
/// depth and height trade against each other in it.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    pub base: Option<ExpectedBase>,
    /// Above the table, were it to stand there, in the camera's unit.
    pub height: f64,
}

/// Middle of a footprint in the camera's picture, pixels.
#[derive(Clone, Copy, Debug)]
pub struct ExpectedBase {
    pub at_px: DVec2,
    /// Standard deviation.
    pub sigma_px: f64,
}

impl Expected {
    /// How badly a solid agrees, 0 where it does; grows ever more slowly, as expectations may be wrong altogether.
    pub fn disagreement(&self, center: DVec2, height: f64, camera: &Camera) -> f64 {
        let slowly = |sigmas: f64| sigmas.powi(2).ln_1p().min(10.0);
        let higher = (height.max(1e-6) / self.height.max(1e-6)).ln() / HEIGHT_SIGMA;
        let apart = self.base.map_or(0.0, |base| match camera.project(center.extend(0.0)) {
            Some((p, _)) => (p - base.at_px).length() / base.sigma_px,
            None => f64::MAX,
        });
        WEIGHT * (slowly(apart) + slowly(higher))
    }

    /// Middle of the footprint on the table.
    pub fn base(&self, camera: &Camera) -> Option<DVec2> {
        camera.meet_plane(self.base?.at_px, 0.0).map(|p| p.truncate())
    }
}
