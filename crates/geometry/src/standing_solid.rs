//! A simple solid on a plane: what one view of a thing tells of its shape and place.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// What kind of solid; lengths in the unit of the plane, frame with its origin at the middle of the base, +z up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum SolidKind {
    /// Turned about +z: (radius, z) from the base up.
    Turned { profile: Vec<DVec2> },
    /// A box.
    Block,
    /// This outline (x, y; counter-clockwise) raised to the solid's height.
    Flat { outline: Vec<DVec2> },
    /// This outline (x, z; counter-clockwise) in the plane of x and z, as deep as the solid.
    Upright { outline: Vec<DVec2> },
    /// This outline blown up, so that wide parts are fat and narrow ones thin ([`Inflation`](super::shapes::Inflation)).
    Inflated { outline: Vec<DVec2>, posture: Posture },
}

/// How an outline is held that is blown up on both sides of its plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Posture {
    /// In the plane of x and y; the solid's height is its greatest thickness.
    Lying,
    /// In the plane of x and z; its depth is.
    Standing,
}

/// A solid and where it stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolidFit {
    #[serde(flatten)]
    pub kind: SolidKind,
    /// Middle of the base on the plane.
    pub center: DVec2,
    /// Turn about +z.
    pub yaw_rad: f64,
    /// Extents in its own frame.
    pub size: DVec3,
    /// Intersection over union of its outline with the pixels it was fitted to, 0..1.
    pub overlap: f64,
}

/// Corners of the footprint of a round body.
const AROUND: u32 = 48;

impl SolidFit {
    /// The solid with all lengths multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let times = |points: &[DVec2]| points.iter().map(|p| factor * *p).collect::<Vec<_>>();
        let kind = match &self.kind {
            SolidKind::Turned { profile } => SolidKind::Turned { profile: times(profile) },
            SolidKind::Block => SolidKind::Block,
            SolidKind::Flat { outline } => SolidKind::Flat { outline: times(outline) },
            SolidKind::Upright { outline } => SolidKind::Upright { outline: times(outline) },
            SolidKind::Inflated { outline, posture } => {
                SolidKind::Inflated { outline: times(outline), posture: *posture }
            }
        };
        Self {
            kind,
            center: factor * self.center,
            yaw_rad: self.yaw_rad,
            size: factor * self.size,
            overlap: self.overlap,
        }
    }

    /// Corners of what it covers of the plane, counter-clockwise.
    pub fn footprint(&self) -> Vec<DVec2> {
        let own: Vec<DVec2> = match &self.kind {
            SolidKind::Turned { .. } => around(DVec2::splat(self.size.x)),
            // Its widest and its fattest places lie about its middle.
            SolidKind::Inflated { posture: Posture::Standing, .. } => around(self.size.truncate()),
            SolidKind::Flat { outline } | SolidKind::Inflated { outline, posture: Posture::Lying } => {
                outline.clone()
            }
            SolidKind::Block | SolidKind::Upright { .. } => {
                let half = 0.5 * self.size.truncate();
                [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .map(|(x, y)| half * DVec2::new(x, y))
                    .to_vec()
            }
        };
        own.into_iter().map(|p| self.center + DVec2::from_angle(self.yaw_rad).rotate(p)).collect()
    }
}

/// An ellipse of these extents.
fn around(extents: DVec2) -> Vec<DVec2> {
    let corner = |k: u32| 0.5 * extents * DVec2::from_angle(TAU * f64::from(k) / f64::from(AROUND));
    (0..AROUND).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scaled_solid_covers_a_scaled_place_and_reads_back() {
        let outline = [(-1.0, -1.0), (1.0, -1.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        let fit = SolidFit {
            kind: SolidKind::Flat { outline },
            center: DVec2::new(3.0, 1.0),
            yaw_rad: std::f64::consts::FRAC_PI_2,
            size: DVec3::new(2.0, 3.0, 0.1),
            overlap: 0.9,
        };
        let covered = fit.footprint();
        assert!((covered[2] - DVec2::new(1.0, 1.0)).length() < 1e-12, "{covered:?}");
        let larger = fit.scaled(0.1).footprint();
        assert!(larger.iter().zip(&covered).all(|(a, b)| (*a - 0.1 * *b).length() < 1e-12));
        let text = serde_json::to_string(&fit).expect("serializes");
        assert_eq!(serde_json::from_str::<SolidFit>(&text).expect("reads back"), fit, "{text}");
    }
    #[test]
    fn an_inflated_outline_is_scaled_with_all_it_has() {
        let outline = [(-1.0, 0.0), (1.0, 0.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        for posture in [Posture::Lying, Posture::Standing] {
            let fit = SolidFit {
                kind: SolidKind::Inflated { outline: outline.clone(), posture },
                center: DVec2::new(3.0, 1.0),
                yaw_rad: 0.3,
                size: DVec3::new(2.0, 0.5, 2.0),
                overlap: 0.9,
            };
            let halved = fit.scaled(0.5);
            let SolidKind::Inflated { outline: smaller, posture: kept } = &halved.kind else {
                panic!("{halved:?}")
            };
            assert!(*kept == posture && smaller[2] == DVec2::new(0.0, 1.0));
            let corners = fit.footprint();
            assert!(halved.footprint().iter().zip(&corners).all(|(a, b)| (*a - 0.5 * *b).length() < 1e-12));
            let text = serde_json::to_string(&fit).expect("serializes");
            assert_eq!(serde_json::from_str::<SolidFit>(&text).expect("reads back"), fit, "{text}");
        }
    }
}
