//! Boxes and lofted bodies.

use glam::{DMat3, DQuat, DVec2, DVec3};
use serde::Deserialize;

use crate::kit::skins::{Section, column};
use geometry::Solid;
use geometry::shapes::{block, loft, rounded_rectangle};

/// A box. Vertical corners are rounded by `corner`, the other edges by `edge`. `top` is the size of its upper face
/// where it differs. A box with a `wall` is open above.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Block {
    size: DVec3,
    #[serde(default)]
    corner: f64,
    #[serde(default)]
    edge: f64,
    top: Option<DVec2>,
    wall: Option<f64>,
    floor: Option<f64>,
}

/// Points of a quarter of a rounded corner, and of a rounded edge.
const CORNER_STEPS: usize = 4;
const EDGE_STEPS: i32 = 3;

impl Block {
    pub fn solid(&self) -> Solid {
        let height = self.size.z;
        if self.corner <= 0.0 && self.edge <= 0.0 && self.top.is_none() && self.wall.is_none() {
            return block(self.size);
        }
        let edge = self.edge.min(0.49 * height);
        let level = |z: f64, inset: f64| -> Vec<DVec3> {
            let bottom = self.size.truncate();
            let size = bottom.lerp(self.top.unwrap_or(bottom), z / height) - DVec2::splat(2.0 * inset);
            let radius = (self.corner.max(1.05 * edge) - inset).max(1e-5);
            rounded_rectangle(size.x, size.y, radius, CORNER_STEPS).iter().map(|p| p.extend(z)).collect()
        };
        let quarter = |k: i32| {
            let angle = 0.5 * std::f64::consts::PI * f64::from(k) / f64::from(EDGE_STEPS);
            (edge * (1.0 - angle.sin()), edge * (1.0 - angle.cos()))
        };
        let mut rings = Vec::new();
        if edge > 0.0 {
            rings.extend((0..=EDGE_STEPS).map(|k| level(quarter(k).1, quarter(k).0)));
        } else {
            rings.push(level(0.0, 0.0));
        }
        match self.wall {
            Some(wall) => {
                let rim = 0.3 * wall;
                let floor = self.floor.unwrap_or(wall);
                rings.extend(
                    [(height - rim, 0.0), (height, rim), (height, wall - rim), (height - rim, wall)]
                        .map(|(z, inset)| level(z, inset)),
                );
                rings.push(level(floor, wall));
            }
            None if edge > 0.0 => {
                rings.extend((0..=EDGE_STEPS).rev().map(|k| level(height - quarter(k).1, quarter(k).0)));
            }
            None => rings.push(level(height, 0.0)),
        }
        loft(&rings).with_flat_ends()
    }
}

/// Direction in which a loft proceeds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Axis {
    X,
    Y,
    #[default]
    Z,
}

/// A skin over superellipse sections. A section is the position along the axis, the two coordinates of its center, and
/// its two extents: along x (x, y, z, width in y, height in z); along y (y, x, z, width in x, height in z); along z
/// (z, x, y, width in x, depth in y).
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Loft {
    pub sections: Vec<[f64; 5]>,
    #[serde(default)]
    along: Axis,
    /// Exponent of the superellipse: 2 is round, 6 boxy.
    #[serde(default = "round")]
    squareness: f64,
    /// Segments of a smooth surface between neighboring sections; straight where it is 0.
    #[serde(default)]
    smooth: usize,
    #[serde(default = "usual_segments")]
    segments: usize,
}

const fn round() -> f64 {
    2.0
}

const fn usual_segments() -> usize {
    28
}

impl Loft {
    pub fn solid(&self) -> Solid {
        let sections: Vec<Section> = self
            .between()
            .iter()
            .map(|&[position, a, b, width_a, width_b]| match self.along {
                Axis::X | Axis::Z => (position, a, b, width_a.max(0.0), width_b.max(0.0)),
                Axis::Y => (position, b, a, width_b.max(0.0), width_a.max(0.0)),
            })
            .collect();
        let upward = column(&sections, self.squareness, self.segments);
        match self.along {
            Axis::Z => upward,
            Axis::X => upward.rotated(axes(DVec3::Y, DVec3::Z, DVec3::X)),
            Axis::Y => upward.rotated(axes(DVec3::Z, DVec3::X, DVec3::Y)),
        }
    }

    /// The sections with those between them (Catmull-Rom).
    fn between(&self) -> Vec<[f64; 5]> {
        if self.smooth < 2 {
            return self.sections.clone();
        }
        let last = self.sections.len() - 1;
        let mut smooth = Vec::with_capacity(last * self.smooth + 1);
        for k in 0..last {
            let (p1, p2) = (self.sections[k], self.sections[k + 1]);
            let (p0, p3) = (self.sections[k.saturating_sub(1)], self.sections[(k + 2).min(last)]);
            for step in 0..self.smooth {
                let t = step as f64 / self.smooth as f64;
                smooth.push(std::array::from_fn(|c| {
                    0.5 * (2.0 * p1[c]
                        + (p2[c] - p0[c]) * t
                        + (2.0 * p0[c] - 5.0 * p1[c] + 4.0 * p2[c] - p3[c]) * t * t
                        + (3.0 * p1[c] - p0[c] - 3.0 * p2[c] + p3[c]) * t * t * t)
                }));
            }
        }
        smooth.push(self.sections[last]);
        smooth
    }
}

fn axes(x: DVec3, y: DVec3, z: DVec3) -> DQuat {
    DQuat::from_mat3(&DMat3::from_cols(x, y, z))
}
