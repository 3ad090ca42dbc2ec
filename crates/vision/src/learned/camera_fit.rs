//! Where the camera stands: what the network said of it, corrected by the outline of a level table top.
//!
//! The camera is held level (no roll), its principal point is the middle of the picture. The network's elevation and focal
//! length enter as observations with the error it has on pictures of the validation split; corners of a rectangle, or the
//! extremes of a circle's ellipse, enter with theirs. Least squares over all of them: where the outline is frontal and
//! cannot tell pitch from focal length, the network decides; where it can, it does. Of other outlines nothing but the
//! network's word is known. The unit of length is the width of the top; the world's origin is its center.

use glam::{DVec2, DVec3};

use super::ellipse::Ellipse;
use crate::minimize::least_squares;
use geometry::Camera;

/// Standard deviations given to what the network says. On pictures of the validation split it errs by 0.1 in the elevation;
/// were it given that, tops would be read worse (rectangles to 1.9 degrees for 1.7, circles to 0.8 for 0.5).
const ELEVATION_SIGMA_RAD: f64 = 0.15;
const LOG_FOCAL_SIGMA: f64 = 0.22;

/// A copy of a picture, and what the network says of the camera that took it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Said {
    pub width_px: u32,
    pub height_px: u32,
    pub elevation_rad: f64,
    pub focal_px: f64,
    /// How far corners and edges of the outline may be off, pixels.
    pub outline_sigma_px: f64,
}

/// A camera and the top it sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// Lengths in widths of the top.
    pub camera: Camera,
    /// Depth of the top in widths.
    pub depth: f64,
}

impl Said {
    /// The camera that sees a level rectangle with these corners, in the order of growing angle (y down).
    pub fn rectangle(&self, corners: &[DVec2; 4]) -> Option<Found> {
        let center = corners.iter().sum::<DVec2>() / 4.0;
        // Each of the four may be the back left corner; the right one turns the camera least.
        let read = |first: usize| {
            let seen: [DVec2; 4] = std::array::from_fn(|k| corners[(first + k) % 4]);
            let width_px = 0.5 * ((seen[1] - seen[0]).length() + (seen[2] - seen[3]).length());
            let height_px = 0.5 * ((seen[3] - seen[0]).length() + (seen[2] - seen[1]).length());
            let front = (seen[2] - seen[3]).normalize_or_zero();
            if front.x < 0.5 {
                return None;
            }
            let sine = self.elevation_rad.sin().max(0.1);
            let azimuth = (front.y / sine).atan2(front.x).clamp(-0.9, 0.9);
            let depth = (height_px / width_px / sine).clamp(0.2, 5.0);
            let eye = self.first_eye(center, width_px)?;
            let start = [azimuth, self.elevation_rad, eye.x, eye.y, eye.z, depth.ln(), self.focal_px.ln()];
            let residuals = |q: &[f64; 7]| {
                let camera = self.camera(q[0], q[1], q[6], DVec3::new(q[2], q[3], q[4]))?;
                let (x, y) = (0.5, 0.5 * q[5].clamp(-3.0, 3.0).exp());
                let mut out = Vec::with_capacity(10);
                for (corner, (sx, sy)) in seen.iter().zip([(-x, y), (x, y), (x, -y), (-x, -y)]) {
                    let d = (camera.project(DVec3::new(sx, sy, 0.0))?.0 - *corner) / self.outline_sigma_px;
                    out.extend([d.x, d.y]);
                }
                out.extend(self.disbelief(q[1], q[6]));
                Some(out)
            };
            let (q, cost) = least_squares(start, [1e-5; 7], residuals)?;
            let camera = self.camera(q[0], q[1], q[6], DVec3::new(q[2], q[3], q[4]))?;
            Some((Found { camera, depth: q[5].exp() }, cost))
        };
        let all: Vec<(Found, f64)> = (0..4).filter_map(read).collect();
        let least = all.iter().map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
        all.into_iter()
            .filter(|(found, cost)| *cost < least + 1.0 && found.depth > 0.1 && found.depth < 10.0)
            .map(|(found, _)| found)
            .filter(|found| found.camera.azimuth_rad().abs() < 0.95)
            .min_by(|a, b| a.camera.azimuth_rad().abs().total_cmp(&b.camera.azimuth_rad().abs()))
    }

    /// The camera that sees a level circle as this ellipse.
    pub fn circle(&self, ellipse: &Ellipse) -> Option<Found> {
        let eye = self.first_eye(ellipse.center, 2.0 * ellipse.semi_axes.max_element())?;
        let on_edge =
            Ellipse { center: DVec2::ZERO, semi_axes: DVec2::splat(0.5), angle_rad: 0.0 }.polygon(180);
        let seen = extremes(ellipse.polygon(180).into_iter());
        // Five unknowns, four extremes and the network's word.
        let residuals = |q: &[f64; 5]| {
            let camera = self.camera(0.0, q[0], q[4], DVec3::new(q[1], q[2], q[3]))?;
            let points: Option<Vec<DVec2>> =
                on_edge.iter().map(|p| camera.project(p.extend(0.0)).map(|(pixel, _)| pixel)).collect();
            let own = extremes(points?.into_iter());
            let apart = own.iter().zip(seen).map(|(a, b)| (a - b) / self.outline_sigma_px);
            Some(apart.chain(self.disbelief(q[0], q[4])).collect())
        };
        let start = [self.elevation_rad, eye.x, eye.y, eye.z, self.focal_px.ln()];
        let (q, _) = least_squares(start, [1e-5; 5], residuals)?;
        let camera = self.camera(0.0, q[0], q[4], DVec3::new(q[1], q[2], q[3]))?;
        Some(Found { camera, depth: 1.0 })
    }

    /// The camera as the network has it, over some outline, turned so that it looks along +y; `None` where the outline
    /// does not lie below the horizon. Also the outline on the table, counter-clockwise.
    pub fn any_outline(&self, outline_px: &[DVec2]) -> Option<(Found, Vec<DVec2>)> {
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
        Some((Found { camera, depth: unit * extent.y }, on_table))
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
        Some(Camera::look_at(self.width_px, self.height_px, fov_x_rad, eye, eye - offset))
    }

    /// A first guess of the eye: the outline's middle seen at the distance its width tells.
    fn first_eye(&self, center: DVec2, width_px: f64) -> Option<DVec3> {
        let distance = self.focal_px / width_px.max(1.0);
        let at_origin = self.camera(0.0, self.elevation_rad, self.focal_px.ln(), DVec3::Z)?;
        let toward = at_origin.ray_direction_in_world(center);
        Some(-distance * toward).filter(|eye| eye.z > 0.0)
    }

    /// Distance from what the network says, in its standard deviations.
    fn disbelief(&self, elevation_rad: f64, log_focal: f64) -> [f64; 2] {
        let elevation = (elevation_rad - self.elevation_rad) / ELEVATION_SIGMA_RAD;
        [elevation, (log_focal - self.focal_px.ln()) / LOG_FOCAL_SIGMA]
    }
}

/// Least and greatest x and y.
fn extremes(points: impl Iterator<Item = DVec2>) -> [f64; 4] {
    let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    [low.x, low.y, high.x, high.y]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOV_X_RAD: f64 = 0.6109;

    /// The network's word, off by as much as it usually is.
    fn said(elevation_rad: f64, focal_px: f64) -> Said {
        let (elevation_rad, focal_px) = (elevation_rad + 0.04, 1.15 * focal_px);
        Said { width_px: 768, height_px: 576, elevation_rad, focal_px, outline_sigma_px: 0.1 }
    }

    fn orbit(azimuth: f64, elevation: f64, aim: DVec3) -> Camera {
        Camera::orbit(768, 576, FOV_X_RAD, aim, azimuth, elevation, 2.1)
    }

    #[test]
    fn a_turned_rectangle_corrects_the_network() {
        for (azimuth, elevation, depth) in [(0.4, 0.9, 0.5), (-0.6, 0.4, 0.8)] {
            let camera = orbit(azimuth, elevation, DVec3::new(0.05, -0.02, 0.0));
            let corners = [(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]
                .map(|(x, y)| camera.project(DVec3::new(x, y * depth, 0.0)).expect("in front").0);
            let found = said(elevation, camera.fx).rectangle(&corners).expect("a camera");
            assert!((found.camera.elevation_rad() - elevation).abs() < 0.01, "{found:?}");
            assert!((found.camera.azimuth_rad() - azimuth).abs() < 0.01);
            assert!((found.depth - depth).abs() < 0.01);
        }
    }

    #[test]
    fn a_circle_corrects_the_elevation() {
        for elevation in [0.35, 0.7, 1.1] {
            let camera = orbit(0.0, elevation, DVec3::new(0.1, 0.05, 0.0));
            let points: Vec<DVec2> = (0..360)
                .map(|k| {
                    let p = 0.5 * DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 360.0);
                    camera.project(p.extend(0.0)).expect("in front").0
                })
                .collect();
            let ellipse = Ellipse::with_moments_of(&points).expect("an area");
            let found = said(elevation, camera.fx).circle(&ellipse).expect("a camera");
            assert!((found.camera.elevation_rad() - elevation).abs() < 0.02, "{found:?}");
        }
    }

    #[test]
    fn an_outline_of_another_shape_lies_where_the_network_sees_it() {
        let camera = orbit(0.0, 0.6, DVec3::ZERO);
        let outline = [(-0.5, 0.3), (0.5, 0.3), (0.2, -0.3)].map(|(x, y)| DVec2::new(x, y));
        let seen = outline.map(|p| camera.project(p.extend(0.0)).expect("in front").0);
        let said = Said { elevation_rad: 0.6, focal_px: camera.fx, ..said(0.6, camera.fx) };
        let (found, on_table) = said.any_outline(&seen).expect("below the horizon");
        assert!((found.depth - 0.6).abs() < 1e-6);
        let back: Vec<DVec2> = outline.into_iter().rev().collect();
        assert!(on_table.iter().zip(&back).all(|(a, b)| (*a - *b).length() < 1e-6), "{on_table:?}");
        assert!(said.any_outline(&[DVec2::ZERO, DVec2::X, DVec2::new(300.0, -4000.0)]).is_none());
    }
}
