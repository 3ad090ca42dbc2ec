//! Where the camera stands, from the outline of a level rectangular or round table top.
//!
//! The field of view is given and the camera is held level (no roll), its principal point is the middle of
//! the picture; six unknowns (azimuth, elevation, eye, depth of the top) meet eight corner coordinates, four
//! (elevation, eye) meet a circle's outline. Least squares in pixels. The unit of length is the width of
//! the top; the world's origin is its center.

use glam::{DVec2, DVec3};

use super::minimize::least_squares;
use super::outline::{Ellipse, Seen};
use geometry::Camera;

/// A camera and the top it sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// Lengths in widths of the top.
    pub camera: Camera,
    /// Depth of the top in widths.
    pub depth: f64,
    /// Root mean square distance of the outline from the model's, pixels of the copy.
    pub residual_px: f64,
}

/// The camera of a copy of `width` x `height` pixels that sees the outline.
pub(crate) fn fit(seen: &Seen, width: usize, height: usize, fov_x_rad: f64) -> Option<Found> {
    let view = View { width: width as u32, height: height as u32, fov_x_rad };
    let starts = [50.0_f64, 30.0, 70.0, 15.0];
    let found = starts.iter().filter_map(|degrees| match seen {
        Seen::Quad(corners) => view.rectangle(corners, degrees.to_radians()),
        Seen::Ellipse(ellipse) => view.circle(ellipse, degrees.to_radians()),
    });
    let sound = |found: &Found| {
        let elevation = found.camera.elevation_rad();
        elevation > 0.05 && found.depth > 0.15 && found.depth < 6.0
    };
    found.filter(sound).min_by(|a, b| a.residual_px.total_cmp(&b.residual_px))
}

struct View {
    width: u32,
    height: u32,
    fov_x_rad: f64,
}

impl View {
    fn camera(&self, azimuth_rad: f64, elevation_rad: f64, eye: DVec3) -> Option<Camera> {
        if !(0.02..1.57).contains(&elevation_rad) || !eye.is_finite() || eye.z <= 0.0 {
            return None;
        }
        let offset = DVec3::new(
            azimuth_rad.sin() * elevation_rad.cos(),
            -azimuth_rad.cos() * elevation_rad.cos(),
            elevation_rad.sin(),
        );
        Some(Camera::look_at(self.width, self.height, self.fov_x_rad, eye, eye - offset))
    }

    fn focal_px(&self) -> f64 {
        0.5 * f64::from(self.width) / (0.5 * self.fov_x_rad).tan()
    }

    /// A first guess of the eye: the outline's middle seen at the distance its width tells.
    fn first_eye(&self, center: DVec2, width_px: f64, elevation_rad: f64) -> Option<DVec3> {
        let distance = self.focal_px() / width_px.max(1.0);
        let at_origin = self.camera(0.0, elevation_rad, DVec3::Z)?;
        let toward = at_origin.ray_direction_in_world(center);
        Some(-distance * toward).filter(|eye| eye.z > 0.0)
    }

    fn rectangle(&self, corners: &[DVec2; 4], elevation_rad: f64) -> Option<Found> {
        let center = corners.iter().sum::<DVec2>() / 4.0;
        // Each of the four may be the back left corner; the right one turns the camera least.
        let read = |first: usize| {
            let seen: [DVec2; 4] = std::array::from_fn(|k| corners[(first + k) % 4]);
            let width_px = 0.5 * ((seen[1] - seen[0]).length() + (seen[2] - seen[3]).length());
            let height_px = 0.5 * ((seen[3] - seen[0]).length() + (seen[2] - seen[1]).length());
            let front = (seen[2] - seen[3]).normalize_or_zero();
            if front.x < 0.6 {
                return None;
            }
            let azimuth = (front.y / elevation_rad.sin()).atan2(front.x).clamp(-0.9, 0.9);
            let depth = (height_px / width_px / elevation_rad.sin()).clamp(0.2, 5.0);
            let eye = self.first_eye(center, width_px, elevation_rad)?;
            let start = [azimuth, elevation_rad, eye.x, eye.y, eye.z, depth.ln()];
            let residuals = |q: &[f64; 6]| {
                let camera = self.camera(q[0], q[1], DVec3::new(q[2], q[3], q[4]))?;
                let (x, y) = (0.5, 0.5 * q[5].clamp(-3.0, 3.0).exp());
                let mut out = Vec::with_capacity(8);
                for (corner, (sx, sy)) in seen.iter().zip([(-x, y), (x, y), (x, -y), (-x, -y)]) {
                    let d = camera.project(DVec3::new(sx, sy, 0.0))?.0 - *corner;
                    out.extend([d.x, d.y]);
                }
                Some(out)
            };
            let (q, cost) = least_squares(start, [1e-5; 6], residuals)?;
            let camera = self.camera(q[0], q[1], DVec3::new(q[2], q[3], q[4]))?;
            Some(Found { camera, depth: q[5].exp(), residual_px: (cost / 4.0).sqrt() })
        };
        let all: Vec<Found> = (0..4).filter_map(read).collect();
        let least = all.iter().map(|f| f.residual_px).fold(f64::INFINITY, f64::min);
        all.into_iter()
            .filter(|f| f.residual_px < least + 0.5 && f.camera.azimuth_rad().abs() < 0.9)
            .min_by(|a, b| a.camera.azimuth_rad().abs().total_cmp(&b.camera.azimuth_rad().abs()))
    }

    fn circle(&self, ellipse: &Ellipse, elevation_rad: f64) -> Option<Found> {
        let wide = ellipse.semi_axes.max_element();
        let eye = self.first_eye(ellipse.center, 2.0 * wide, elevation_rad)?;
        let on_edge = |k: u32| 0.5 * DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 180.0);
        let seen = extremes((0..180).map(|k| ellipse.at(std::f64::consts::TAU * f64::from(k) / 180.0)));
        // Four unknowns, four extremes; points on the curve would also be met by a circle shrunk to one.
        let residuals = |q: &[f64; 4]| {
            let camera = self.camera(0.0, q[0], DVec3::new(q[1], q[2], q[3]))?;
            let points: Option<Vec<DVec2>> =
                (0..180).map(|k| camera.project(on_edge(k).extend(0.0)).map(|(p, _)| p)).collect();
            let own = extremes(points?.into_iter());
            Some(own.iter().zip(seen).map(|(a, b)| a - b).collect())
        };
        let start = [elevation_rad, eye.x, eye.y, eye.z];
        let (q, _) = least_squares(start, [1e-5; 4], residuals)?;
        let camera = self.camera(0.0, q[0], DVec3::new(q[1], q[2], q[3]))?;
        let error = |k: u32| {
            let d = camera.project(on_edge(k).extend(0.0))?.0 - ellipse.center;
            let r = (DVec2::from_angle(-ellipse.angle_rad).rotate(d) / ellipse.semi_axes).length();
            Some(((r - 1.0) * d.length() / r.max(1e-9)).powi(2))
        };
        let squares: Option<f64> = (0..180).map(error).sum();
        Some(Found { camera, depth: 1.0, residual_px: (squares? / 180.0).sqrt() })
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

    fn orbit(azimuth: f64, elevation: f64, aim: DVec3) -> Camera {
        Camera::orbit(768, 576, 0.6109, aim, azimuth, elevation, 2.1)
    }

    #[test]
    fn a_rectangle_gives_back_its_camera() {
        for (azimuth, elevation, depth) in [(0.0, 0.6, 0.6), (0.4, 0.9, 0.5), (-0.6, 0.4, 0.8)] {
            let camera = orbit(azimuth, elevation, DVec3::new(0.05, -0.02, 0.0));
            let corners = [(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]
                .map(|(x, y)| camera.project(DVec3::new(x, y * depth, 0.0)).expect("in front").0);
            let found = fit(&Seen::Quad(corners), 768, 576, 0.6109).expect("a camera");
            assert!(found.residual_px < 0.01, "{found:?}");
            assert!((found.camera.elevation_rad() - elevation).abs() < 1e-3);
            assert!((found.camera.azimuth_rad() - azimuth).abs() < 1e-3);
            assert!((found.depth - depth).abs() < 1e-3);
        }
    }

    #[test]
    fn a_circle_gives_back_its_elevation() {
        for elevation in [0.35, 0.7, 1.1] {
            let camera = orbit(0.0, elevation, DVec3::new(0.1, 0.05, 0.0));
            let points: Vec<DVec2> = (0..180)
                .map(|k| {
                    let p = 0.5 * DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 180.0);
                    camera.project(p.extend(0.0)).expect("in front").0
                })
                .collect();
            // A circle's picture is an ellipse; its extremes give the axes where it is nearly upright.
            let low = points.iter().copied().fold(points[0], DVec2::min);
            let high = points.iter().copied().fold(points[0], DVec2::max);
            let ellipse =
                Ellipse { center: 0.5 * (low + high), semi_axes: 0.5 * (high - low), angle_rad: 0.0 };
            let found = fit(&Seen::Ellipse(ellipse), 768, 576, 0.6109).expect("a camera");
            assert!((found.camera.elevation_rad() - elevation).abs() < 0.02, "{found:?}");
        }
    }
}
