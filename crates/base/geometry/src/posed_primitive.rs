//! A primitive solid on a plane: the shape and pose estimate of an object from a single view.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Kind of primitive. Lengths are in the unit of the plane; the frame has its origin at the center of the base, +z up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum PrimitiveKind {
    /// Surface of revolution about +z: (radius, z) from the base up.
    Turned { profile: Vec<DVec2> },
    /// A box.
    Block,
    /// Extrusion of this outline (x, y; counter-clockwise) along z, up to the solid's height.
    Flat { outline: Vec<DVec2> },
    /// Extrusion of this outline (x, z; counter-clockwise) along y, over the solid's depth.
    Upright { outline: Vec<DVec2> },
    /// Inflation of this outline: wide parts are thick, narrow parts thin ([`Inflation`](super::shapes::Inflation)).
    Inflated { outline: Vec<DVec2>, posture: Posture },
}

/// Orientation of an inflated outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Posture {
    /// The outline is in the xy plane; the solid's height is its maximum thickness.
    Lying,
    /// The outline is in the xz plane; the solid's depth is its maximum thickness.
    Standing,
}

/// A primitive with its pose on the plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PosedPrimitive {
    #[serde(flatten)]
    pub kind: PrimitiveKind,
    /// Center of the base on the plane.
    pub center: DVec2,
    /// Rotation about +z.
    pub yaw_rad: f64,
    /// Extents in its own frame.
    pub size: DVec3,
    /// Intersection over union of its outline with the pixels it was fitted to, 0..1.
    pub overlap: f64,
}

/// Corners of the footprint of a round body.
const AROUND: u32 = 48;

impl PosedPrimitive {
    /// The solid with all lengths multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let times = |points: &[DVec2]| points.iter().map(|p| factor * *p).collect::<Vec<_>>();
        let kind = match &self.kind {
            PrimitiveKind::Turned { profile } => PrimitiveKind::Turned { profile: times(profile) },
            PrimitiveKind::Block => PrimitiveKind::Block,
            PrimitiveKind::Flat { outline } => PrimitiveKind::Flat { outline: times(outline) },
            PrimitiveKind::Upright { outline } => PrimitiveKind::Upright { outline: times(outline) },
            PrimitiveKind::Inflated { outline, posture } => {
                PrimitiveKind::Inflated { outline: times(outline), posture: *posture }
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

    /// Corners of its footprint on the plane, counter-clockwise.
    pub fn footprint(&self) -> Vec<DVec2> {
        let own: Vec<DVec2> = match &self.kind {
            PrimitiveKind::Turned { .. } => around(DVec2::splat(self.size.x)),
            // Its widest and its thickest parts are near its center.
            PrimitiveKind::Inflated { posture: Posture::Standing, .. } => around(self.size.truncate()),
            PrimitiveKind::Flat { outline }
            | PrimitiveKind::Inflated { outline, posture: Posture::Lying } => outline.clone(),
            PrimitiveKind::Block | PrimitiveKind::Upright { .. } => {
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
    fn scaled_primitive_has_a_scaled_footprint_and_round_trips() {
        let outline = [(-1.0, -1.0), (1.0, -1.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        let fit = PosedPrimitive {
            kind: PrimitiveKind::Flat { outline },
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
        assert_eq!(serde_json::from_str::<PosedPrimitive>(&text).expect("reads back"), fit, "{text}");
    }
    #[test]
    fn scaled_inflation_scales_outline_and_footprint() {
        let outline = [(-1.0, 0.0), (1.0, 0.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        for posture in [Posture::Lying, Posture::Standing] {
            let fit = PosedPrimitive {
                kind: PrimitiveKind::Inflated { outline: outline.clone(), posture },
                center: DVec2::new(3.0, 1.0),
                yaw_rad: 0.3,
                size: DVec3::new(2.0, 0.5, 2.0),
                overlap: 0.9,
            };
            let halved = fit.scaled(0.5);
            let PrimitiveKind::Inflated { outline: smaller, posture: kept } = &halved.kind else {
                panic!("{halved:?}")
            };
            assert!(*kept == posture && smaller[2] == DVec2::new(0.0, 1.0));
            let corners = fit.footprint();
            assert!(halved.footprint().iter().zip(&corners).all(|(a, b)| (*a - 0.5 * *b).length() < 1e-12));
            let text = serde_json::to_string(&fit).expect("serializes");
            assert_eq!(serde_json::from_str::<PosedPrimitive>(&text).expect("reads back"), fit, "{text}");
        }
    }
}
