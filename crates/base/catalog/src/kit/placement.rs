//! Positions of the copies of a part.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};
use serde::Deserialize;

use geometry::Solid;

/// Position, orientation and repetition of a part in the shape's frame.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    pub at_m: DVec3,
    /// About x, then y, then z.
    pub turn_deg: DVec3,
    pub mirror: Option<Mirror>,
    pub rows: Vec<Row>,
    pub circle: Option<Circle>,
}

/// Planes in which a part has a mirror image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Mirror {
    /// x = 0.
    X,
    /// y = 0.
    Y,
    /// Both: four copies.
    Xy,
}

/// `count` copies, each moved by `step` from the one before. Several rows make a grid.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Row {
    count: u32,
    step: DVec3,
}

/// `count` copies around a vertical axis, evenly spaced.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Circle {
    count: u32,
    /// Position of the axis, meters.
    #[serde(default)]
    around: DVec2,
}

impl Placement {
    /// All copies of `solid`.
    pub fn copies(&self, solid: &Solid) -> Vec<Solid> {
        let [x, y, z] = self.turn_deg.to_array().map(f64::to_radians);
        let turn = DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x);
        let first = if self.turn_deg == DVec3::ZERO { solid.clone() } else { solid.clone().rotated(turn) };
        let mut copies = vec![first.translated(self.at_m)];
        for row in &self.rows {
            let moved = |solid: &Solid, k: u32| solid.clone().translated(f64::from(k) * row.step);
            copies = (0..row.count).flat_map(|k| copies.iter().map(move |solid| moved(solid, k))).collect();
        }
        if let Some(circle) = self.circle {
            let axis = circle.around.extend(0.0);
            let around = |solid: &Solid, k: u32| {
                let angle = TAU * f64::from(k) / f64::from(circle.count);
                solid.clone().translated(-axis).rotated(DQuat::from_rotation_z(angle)).translated(axis)
            };
            copies = (0..circle.count).flat_map(|k| copies.iter().map(move |s| around(s, k))).collect();
        }
        if matches!(self.mirror, Some(Mirror::X | Mirror::Xy)) {
            copies.extend(copies.clone().into_iter().map(mirrored_x));
        }
        if matches!(self.mirror, Some(Mirror::Y | Mirror::Xy)) {
            copies.extend(copies.clone().into_iter().map(mirrored_y));
        }
        copies
    }
}

/// The mirror image in the plane x = 0.
fn mirrored_x(mut solid: Solid) -> Solid {
    solid.positions.iter_mut().for_each(|p| p.x = -p.x);
    solid.normals.iter_mut().for_each(|n| n.x = -n.x);
    solid.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    solid
}

/// The mirror image in the plane y = 0.
fn mirrored_y(mut solid: Solid) -> Solid {
    solid.positions.iter_mut().for_each(|p| p.y = -p.y);
    solid.normals.iter_mut().for_each(|n| n.y = -n.y);
    solid.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    solid
}
