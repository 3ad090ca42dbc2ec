//! Geometry from a depth image: the plane of the table top, and heights of objects above it.
//!
//! A plane is a linear function of the pixel in inverse depth, and the noise of stereo and structured-light sensors is
//! about uniform there. So the plane is fitted in inverse depth: RANSAC over the pixels of the bare top, then weighted
//! least squares. Its normal gives elevation and roll of the camera, its distance the camera's height in meters.
//!
//! Heights of an object are percentiles over its mask without the rim, where depths of two surfaces mix. Each height is
//! the median of its neighborhood first: the maximum of noise is no height. Pixels far behind or before the object are
//! no part of it.
//!
//! Frame: camera (x right, y down, z forward), meters. Cost: a few milliseconds an image, linear in its pixels.

mod heights;
mod top_plane;

pub(crate) use heights::HeightRange;
pub(crate) use top_plane::TopPlane;

use glam::{DVec2, DVec3};

use crate::intrinsics::Intrinsics;
use crate::pixels::Pixels;
use imaging::DepthImage;

/// Contribution of the depth image to a reading.
#[derive(Clone, Debug, PartialEq)]
pub enum DepthUse {
    /// Camera, scale and heights follow from the depth.
    Used {
        /// Meters per unit of the reading.
        meters_per_unit: f64,
        /// Root mean square distance of the top's points from their plane, meters.
        plane_rms_m: f64,
    },
    /// The image alone determines the reading.
    Unused(DepthDoubt),
}

/// Reason why a depth image does not determine the reading.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DepthDoubt {
    #[error("{percent:.0} % of the table top have a depth, at least {min_percent:.0} % are needed")]
    FewMeasured { percent: f64, min_percent: f64 },
    #[error(
        "{percent:.0} % of the depths of the table top lie in one plane, at least {min_percent:.0} % must"
    )]
    NoPlane { percent: f64, min_percent: f64 },
    #[error(
        "the plane of the table top would be seen from {elevation_deg:.0} degrees above it with a roll of \
         {roll_deg:.0} degrees"
    )]
    NoTableView { elevation_deg: f64, roll_deg: f64 },
}

/// The depths of the working copy.
pub(crate) struct DepthCopy {
    width: usize,
    height: usize,
    /// Meters along the optical axis; 0 = not measured.
    depths_m: Vec<f64>,
    focal_px: DVec2,
    center_px: DVec2,
}

impl DepthCopy {
    /// `intrinsics` are those of the whole image.
    pub fn new(depth: &DepthImage, intrinsics: &Intrinsics, pixels: &Pixels) -> Self {
        let resampled = depth.resampled(pixels.width as u32, pixels.height as u32);
        let depths_m = resampled.depths_mm().iter().map(|depth_mm| 1e-3 * f64::from(*depth_mm)).collect();
        let own = intrinsics.scaled(pixels.scale);
        Self {
            width: pixels.width,
            height: pixels.height,
            depths_m,
            focal_px: own.focal_px,
            center_px: own.center_in(pixels.width as f64, pixels.height as f64),
        }
    }

    fn len(&self) -> usize {
        self.depths_m.len()
    }

    /// Direction to a pixel's center, with unit length along the optical axis.
    fn direction(&self, index: usize) -> DVec3 {
        let pixel = DVec2::new((index % self.width) as f64 + 0.5, (index / self.width) as f64 + 0.5);
        ((pixel - self.center_px) / self.focal_px).extend(1.0)
    }

    fn depth_m(&self, index: usize) -> Option<f64> {
        Some(self.depths_m[index]).filter(|depth_m| *depth_m > 0.0)
    }

    /// Position of the surface in a pixel, camera frame.
    fn point_m(&self, index: usize) -> Option<DVec3> {
        Some(self.depth_m(index)? * self.direction(index))
    }
}

#[cfg(test)]
mod tests;
