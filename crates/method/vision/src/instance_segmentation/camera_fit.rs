//! Camera estimate: the network's prior, corrected by the outline of a level table top.
//!
//! The camera is level (no roll) unless a depth image measured its roll, and its principal point is the center of the
//! image unless the client states another one. Elevation and focal length of the prior are observations with a fixed
//! standard deviation. So are the corners of a rectangle, or the extremes of a circle's ellipse.
//!
//! The estimate is the least-squares solution over all observations. A frontal outline cannot separate pitch from
//! focal length, so the prior decides there. For other outlines the prior is the only observation.
//!
//! Unit of length: width of the top. World origin: center of the top.

use glam::{DQuat, DVec2, DVec3};

use super::ellipse::Ellipse;
use geometry::optimize::least_squares;
use geometry::{Camera, Pose};

/// Standard deviations of the network's camera. On validation images the elevation error is 0.1. With that value
/// tops are read worse (rectangles to 1.9 degrees instead of 1.7, circles to 0.8 instead of 0.5).
const ELEVATION_SIGMA_RAD: f64 = 0.15;
/// Standard deviations of an elevation that a depth image measured, and of the focal length that it was measured with.
const MEASURED_ELEVATION_SIGMA_RAD: f64 = 0.001;
const MEASURED_LOG_FOCAL_SIGMA: f64 = 0.0005;
const LOG_FOCAL_SIGMA: f64 = 0.22;
/// Standard deviation of the logarithm of a focal length that the client states.
const KNOWN_LOG_FOCAL_SIGMA: f64 = 0.01;

/// Camera of the working copy before the outline of the top is known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExpectedCamera {
    pub elevation_rad: f64,
    /// Longer sides of the image.
    pub focal: f64,
    /// Whether the client states the focal length.
    pub is_focal_known: bool,
    /// Rotation about the optical axis as a depth image measured it, with the elevation.
    pub measured_roll_rad: Option<f64>,
    /// Principal point in the copy and ratio of the vertical to the horizontal focal length, where the client states
    /// them.
    pub lens: Option<Lens>,
}

/// Deviations of a camera from square pixels and a centered principal point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    pub center_px: DVec2,
    pub focal_ratio: f64,
}

impl ExpectedCamera {
    /// The same camera at another elevation.
    pub fn at(&self, elevation_rad: f64) -> Self {
        Self { elevation_rad, ..*self }
    }

    fn log_focal_sigma(&self) -> f64 {
        match (self.measured_roll_rad, self.is_focal_known) {
            (Some(_), _) => MEASURED_LOG_FOCAL_SIGMA,
            (None, true) => KNOWN_LOG_FOCAL_SIGMA,
            (None, false) => LOG_FOCAL_SIGMA,
        }
    }
}

/// Size of the working copy, and the estimate of its camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraPrior {
    pub width_px: u32,
    pub height_px: u32,
    pub elevation_rad: f64,
    pub elevation_sigma_rad: f64,
    pub focal_px: f64,
    /// Standard deviation of the focal length's logarithm.
    pub log_focal_sigma: f64,
    pub measured_roll_rad: Option<f64>,
    pub lens: Option<Lens>,
    /// Standard deviation of corners and edges of the outline, pixels.
    pub outline_sigma_px: f64,
}

/// A camera and the depth of the top in its view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableCamera {
    /// Lengths in widths of the top.
    pub camera: Camera,
    /// Depth of the top in widths.
    pub depth: f64,
}

impl CameraPrior {
    /// The prior of an expected camera in a copy of that size.
    pub fn new(expected: &ExpectedCamera, [width_px, height_px]: [u32; 2], outline_sigma_px: f64) -> Self {
        Self {
            width_px,
            height_px,
            elevation_rad: expected.elevation_rad.clamp(0.03, 1.55),
            elevation_sigma_rad: match expected.measured_roll_rad {
                Some(_) => MEASURED_ELEVATION_SIGMA_RAD,
                None => ELEVATION_SIGMA_RAD,
            },
            focal_px: expected.focal * f64::from(width_px.max(height_px)),
            log_focal_sigma: expected.log_focal_sigma(),
            measured_roll_rad: expected.measured_roll_rad,
            lens: expected.lens,
            outline_sigma_px,
        }
    }

    /// The camera that projects a level rectangle onto these corners, in the order of growing angle (y down).
    pub fn rectangle(&self, corners: &[DVec2; 4]) -> Option<TableCamera> {
        let center = corners.iter().sum::<DVec2>() / 4.0;
        // Each of the four corners may be the back left one; the solution with the smallest azimuth is the right
        // one.
        let read = |first: usize| {
            let seen: [DVec2; 4] = std::array::from_fn(|k| corners[(first + k) % 4]);
            let width_px = 0.5 * ((seen[1] - seen[0]).length() + (seen[2] - seen[3]).length());
            let height_px = 0.5 * ((seen[3] - seen[0]).length() + (seen[2] - seen[1]).length());
            let front = (seen[2] - seen[3]).normalize_or_zero();
            if front.x < 0.5 {
                return None;
            }
            // Lengths along the view appear shorter by the sine of the elevation.
            let sine = self.elevation_rad.sin().max(0.1);
            let azimuth = (front.y / sine).atan2(front.x).clamp(-0.9, 0.9);
            let depth = (height_px / width_px / sine).clamp(0.2, 5.0);
            let eye = self.initial_eye(center, width_px)?;
            let start = [azimuth, self.elevation_rad, eye.x, eye.y, eye.z, depth.ln(), self.focal_px.ln()];
            let residuals = |q: &[f64; 7]| {
                let camera = self.camera(q[0], q[1], q[6], DVec3::new(q[2], q[3], q[4]))?;
                let (x, y) = (0.5, 0.5 * q[5].clamp(-3.0, 3.0).exp());
                let mut out = Vec::with_capacity(10);
                for (corner, (sx, sy)) in seen.iter().zip([(-x, y), (x, y), (x, -y), (-x, -y)]) {
                    let d = (camera.project(DVec3::new(sx, sy, 0.0))?.0 - *corner) / self.outline_sigma_px;
                    out.extend([d.x, d.y]);
                }
                out.extend(self.prior_residuals(q[1], q[6]));
                Some(out)
            };
            let (q, cost) = least_squares(start, [1e-5; 7], residuals)?;
            let camera = self.camera(q[0], q[1], q[6], DVec3::new(q[2], q[3], q[4]))?;
            Some((TableCamera { camera, depth: q[5].exp() }, cost))
        };
        let all: Vec<(TableCamera, f64)> = (0..4).filter_map(read).collect();
        let lowest = all.iter().map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
        all.into_iter()
            // Costs are in squared standard deviations: within one of the lowest, solutions fit equally well.
            .filter(|(found, cost)| *cost < lowest + 1.0 && found.depth > 0.1 && found.depth < 10.0)
            .map(|(found, _)| found)
            .filter(|found| found.camera.azimuth_rad().abs() < 0.95)
            .min_by(|a, b| a.camera.azimuth_rad().abs().total_cmp(&b.camera.azimuth_rad().abs()))
    }

    /// The camera that projects a level circle onto this ellipse.
    pub fn circle(&self, ellipse: &Ellipse) -> Option<TableCamera> {
        let eye = self.initial_eye(ellipse.center, 2.0 * ellipse.semi_axes.max_element())?;
        let on_edge =
            Ellipse { center: DVec2::ZERO, semi_axes: DVec2::splat(0.5), angle_rad: 0.0 }.polygon(180);
        let seen = extremes(ellipse.polygon(180).into_iter());
        // Five unknowns; four extremes and two priors.
        let residuals = |q: &[f64; 5]| {
            let camera = self.camera(0.0, q[0], q[4], DVec3::new(q[1], q[2], q[3]))?;
            let points: Option<Vec<DVec2>> =
                on_edge.iter().map(|p| camera.project(p.extend(0.0)).map(|(pixel, _)| pixel)).collect();
            let own = extremes(points?.into_iter());
            let apart = own.iter().zip(seen).map(|(a, b)| (a - b) / self.outline_sigma_px);
            Some(apart.chain(self.prior_residuals(q[0], q[4])).collect())
        };
        let start = [self.elevation_rad, eye.x, eye.y, eye.z, self.focal_px.ln()];
        let (q, _) = least_squares(start, [1e-5; 5], residuals)?;
        let camera = self.camera(0.0, q[0], q[4], DVec3::new(q[1], q[2], q[3]))?;
        Some(TableCamera { camera, depth: 1.0 })
    }

    /// The prior camera with azimuth 0 over an outline of any shape, and the outline on the table,
    /// counter-clockwise. `None` if part of the outline lies above the horizon.
    pub fn any_outline(&self, outline_px: &[DVec2]) -> Option<(TableCamera, Vec<DVec2>)> {
        let above = self.camera(0.0, self.elevation_rad, self.focal_px.ln(), DVec3::Z)?;
        let met: Option<Vec<DVec2>> =
            outline_px.iter().map(|p| above.meet_plane(*p, 0.0).map(|q| q.truncate())).collect();
        let met = met?;
        let (low, high) =
            met.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let (center, extent) = (0.5 * (low + high), high - low);
        if !(extent.min_element() > 0.0 && extent.max_element() < 50.0) {
            return None;
        }
        let unit = 1.0 / extent.x;
        let eye = (-unit * center).extend(unit);
        let camera = self.camera(0.0, self.elevation_rad, self.focal_px.ln(), eye)?;
        let on_table = met.into_iter().rev().map(|p| unit * (p - center)).collect();
        Some((TableCamera { camera, depth: unit * extent.y }, on_table))
    }

    fn camera(&self, azimuth_rad: f64, elevation_rad: f64, log_focal: f64, eye: DVec3) -> Option<Camera> {
        if !(0.02..1.57).contains(&elevation_rad) || !eye.is_finite() || eye.z <= 0.0 {
            return None;
        }
        let offset = DVec3::new(
            azimuth_rad.sin() * elevation_rad.cos(),
            -azimuth_rad.cos() * elevation_rad.cos(),
            elevation_rad.sin(),
        );
        let fov_x_rad = 2.0 * (0.5 * f64::from(self.width_px) / log_focal.clamp(2.0, 12.0).exp()).atan();
        let mut camera = Camera::look_at(self.width_px, self.height_px, fov_x_rad, eye, eye - offset);
        if let Some(roll_rad) = self.measured_roll_rad {
            let pose = &mut camera.world_from_camera;
            *pose = Pose { rotation: pose.rotation * DQuat::from_rotation_z(roll_rad), ..*pose };
        }
        if let Some(Lens { center_px, focal_ratio }) = self.lens {
            (camera.cx, camera.cy, camera.fy) = (center_px.x, center_px.y, focal_ratio * camera.fx);
        }
        Some(camera)
    }

    /// Initial position of the eye: the ray through the center of the outline, at the distance that follows from
    /// its width.
    fn initial_eye(&self, center: DVec2, width_px: f64) -> Option<DVec3> {
        let distance = self.focal_px / width_px.max(1.0);
        let at_origin = self.camera(0.0, self.elevation_rad, self.focal_px.ln(), DVec3::Z)?;
        let toward = at_origin.ray_direction_in_world(center);
        Some(-distance * toward).filter(|eye| eye.z > 0.0)
    }

    /// Deviation from the prior, in its standard deviations.
    fn prior_residuals(&self, elevation_rad: f64, log_focal: f64) -> [f64; 2] {
        let elevation = (elevation_rad - self.elevation_rad) / self.elevation_sigma_rad;
        [elevation, (log_focal - self.focal_px.ln()) / self.log_focal_sigma]
    }
}

/// Minimum and maximum x and y.
fn extremes(points: impl Iterator<Item = DVec2>) -> [f64; 4] {
    let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    [low.x, low.y, high.x, high.y]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOV_X_RAD: f64 = 0.6109;

    fn expected(elevation_rad: f64, focal_px: f64) -> ExpectedCamera {
        ExpectedCamera {
            elevation_rad,
            focal: focal_px / 768.0,
            is_focal_known: false,
            measured_roll_rad: None,
            lens: None,
        }
    }

    /// A prior with a typical error of the network.
    fn prior(elevation_rad: f64, focal_px: f64) -> CameraPrior {
        CameraPrior::new(&expected(elevation_rad + 0.04, 1.15 * focal_px), [768, 576], 0.1)
    }

    fn orbit(azimuth: f64, elevation: f64, aim: DVec3) -> Camera {
        Camera::orbit(768, 576, FOV_X_RAD, aim, azimuth, elevation, 2.1)
    }

    #[test]
    fn rotated_rectangle_corrects_prior() {
        for (azimuth, elevation, depth) in [(0.4, 0.9, 0.5), (-0.6, 0.4, 0.8)] {
            let camera = orbit(azimuth, elevation, DVec3::new(0.05, -0.02, 0.0));
            let corners = [(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]
                .map(|(x, y)| camera.project(DVec3::new(x, y * depth, 0.0)).expect("in front").0);
            let found = prior(elevation, camera.fx).rectangle(&corners).expect("a camera");
            assert!((found.camera.elevation_rad() - elevation).abs() < 0.01, "{found:?}");
            assert!((found.camera.azimuth_rad() - azimuth).abs() < 0.01);
            assert!((found.depth - depth).abs() < 0.01);
        }
    }

    #[test]
    fn circle_corrects_prior_elevation() {
        for elevation in [0.35, 0.7, 1.1] {
            let camera = orbit(0.0, elevation, DVec3::new(0.1, 0.05, 0.0));
            let points: Vec<DVec2> = (0..360)
                .map(|k| {
                    let p = 0.5 * DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 360.0);
                    camera.project(p.extend(0.0)).expect("in front").0
                })
                .collect();
            let ellipse = Ellipse::with_moments_of(&points).expect("an area");
            let found = prior(elevation, camera.fx).circle(&ellipse).expect("a camera");
            assert!((found.camera.elevation_rad() - elevation).abs() < 0.02, "{found:?}");
        }
    }

    #[test]
    fn measured_angles_hold_against_the_outline() {
        let mut camera = orbit(0.3, 0.7, DVec3::new(0.05, -0.02, 0.0));
        let pose = camera.world_from_camera;
        let rolled = Pose { rotation: pose.rotation * DQuat::from_rotation_z(0.1), ..pose };
        camera.world_from_camera = rolled;
        (camera.cx, camera.cy, camera.fy) = (420.0, 250.0, 1.02 * camera.fx);
        // Corners as a wrong outline has them: 3 % too wide.
        let corners = [(-0.515, 0.3), (0.515, 0.3), (0.515, -0.3), (-0.515, -0.3)]
            .map(|(x, y)| camera.project(DVec3::new(x, y, 0.0)).expect("in front").0);
        let known = ExpectedCamera {
            is_focal_known: true,
            measured_roll_rad: Some(0.1),
            lens: Some(Lens { center_px: DVec2::new(420.0, 250.0), focal_ratio: 1.02 }),
            ..expected(0.7, camera.fx)
        };
        let found = CameraPrior::new(&known, [768, 576], 0.1).rectangle(&corners).expect("a camera");
        assert!((found.camera.elevation_rad() - 0.7).abs() < 1e-3, "{found:?}");
        assert!((found.camera.fx / camera.fx - 1.0).abs() < 1e-3, "{found:?}");
        assert!((found.depth - 0.6 / 1.03).abs() < 2e-3, "{found:?}");
        assert!((found.camera.world_from_camera.translation_m * 1.03 - pose.translation_m).length() < 4e-3);
    }

    #[test]
    fn other_outline_is_placed_by_prior_camera() {
        let camera = orbit(0.0, 0.6, DVec3::ZERO);
        let outline = [(-0.5, 0.3), (0.5, 0.3), (0.2, -0.3)].map(|(x, y)| DVec2::new(x, y));
        let seen = outline.map(|p| camera.project(p.extend(0.0)).expect("in front").0);
        let prior = CameraPrior { elevation_rad: 0.6, focal_px: camera.fx, ..prior(0.6, camera.fx) };
        let (found, on_table) = prior.any_outline(&seen).expect("below the horizon");
        assert!((found.depth - 0.6).abs() < 1e-6);
        let back: Vec<DVec2> = outline.into_iter().rev().collect();
        assert!(on_table.iter().zip(&back).all(|(a, b)| (*a - *b).length() < 1e-6), "{on_table:?}");
        assert!(prior.any_outline(&[DVec2::ZERO, DVec2::X, DVec2::new(300.0, -4000.0)]).is_none());
    }
}
