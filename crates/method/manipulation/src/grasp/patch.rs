//! Share of the pads' area that touches an object.

use geometry::{DVec3, Pose};

use super::hand_shape::HandShape;
use super::solid::HullSolid;

/// The pads are sampled at this many points across and along the approach; the outer ones are near the edges.
const GRID: [i32; 2] = [5, 9];
const TO_EDGE: f64 = 0.95;
/// Surfaces that are behind the first contact by less than this touch too: pads yield. Meters.
const TOUCHING_M: f64 = 7e-4;

/// Contact of the pads with an object when they close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadContact {
    /// Distance of the pads from each other when both touch.
    pub width_m: f64,
    /// The midpoint between the pads is off the origin of the tool along y by this.
    pub center_m: f64,
    /// The share of the pads' area that touches, of the pad with less.
    pub share: f64,
    /// The centers of what touches either pad are apart by this across the closing line.
    pub skew_m: f64,
}

/// Closes the pads on an object along y of the tool; `None` where they meet nothing between them.
///
/// Only the part of the object that the line between the pads' centers passes through, or that is connected with it
/// along other lines, counts: `near_m` is how far along y it may reach.
pub fn close_pads(
    solid: &HullSolid,
    hand: &HandShape,
    object_from_tool: &Pose,
    near_m: f64,
) -> Option<PadContact> {
    let direction = object_from_tool.transform_vector(DVec3::Y);
    let at = |k: i32, count: i32, half_m: f64| {
        TO_EDGE * half_m * f64::from(2 * k - (count - 1)) / f64::from(count - 1)
    };
    let [half_x, half_z] = hand.pad_half_m;
    let mut faces: Vec<([f64; 2], DVec3)> = Vec::new();
    for i in 0..GRID[0] {
        for j in 0..GRID[1] {
            let sample = DVec3::new(at(i, GRID[0], half_x), 0.0, at(j, GRID[1], half_z));
            let origin = object_from_tool.transform_point(sample);
            let within = |from_m: f64, to_m: f64| from_m < near_m && to_m > -near_m;
            let spans = solid.spans(origin, direction);
            let mut met = spans.iter().filter(|span| within(span.from_m, span.to_m));
            if let Some(first) = met.next() {
                let last = met.next_back().unwrap_or(first);
                faces.push(([first.from_m, last.to_m], sample));
            }
        }
    }
    let from_m = faces.iter().map(|(face, _)| face[0]).fold(f64::INFINITY, f64::min);
    let to_m = faces.iter().map(|(face, _)| face[1]).fold(f64::NEG_INFINITY, f64::max);
    if from_m >= to_m {
        return None;
    }
    let area = f64::from(GRID[0] * GRID[1]);
    // The share of a pad that touches, and the center of that.
    let met = |touches: &dyn Fn(&[f64; 2]) -> bool| {
        let met: Vec<DVec3> = faces.iter().filter(|(face, _)| touches(face)).map(|(_, at)| *at).collect();
        (met.len() as f64 / area, met.iter().sum::<DVec3>() / met.len() as f64)
    };
    let (left, left_center) = met(&|face| face[0] < from_m + TOUCHING_M);
    let (right, right_center) = met(&|face| face[1] > to_m - TOUCHING_M);
    Some(PadContact {
        width_m: to_m - from_m,
        center_m: 0.5 * (from_m + to_m),
        share: left.min(right),
        skew_m: left_center.distance(right_center),
    })
}
