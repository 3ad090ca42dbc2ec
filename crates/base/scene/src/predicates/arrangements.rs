//! Regular arrangements of posed footprints.

use std::f64::consts::TAU;

use glam::DVec2;

use super::{CONTACT_TOLERANCE_M, DISTANCE_TOLERANCE_M, PosedFootprint, YAW_TOLERANCE_RAD};
use crate::description::ArrangementKind;
use geometry::pose::wrap_angle_rad;

/// Deviation of centers from a common line or circle, meters.
const ALIGNMENT_TOLERANCE_M: f64 = 0.015;

/// Free distance up to which neighbors of a pile belong together, meters.
const PILE_GAP_M: f64 = 0.03;

/// Whether objects form an arrangement, in its order (see `Arrangement::objects`).
///
/// - Row, column: centers deviate from a common line by at most 1.5 cm and advance strictly.
/// - Grid: each row and each column of it does.
/// - Circle: the distances to the center (that of the object `center`, or the mean of the centers) are equal within
///   1.5 cm, and the directions are equally spaced, counter-clockwise, within 10 degrees.
/// - Pile: every object is connected to the others by free distances of at most 3 cm.
/// - Pyramid: the layers of [`pyramid_layers`]; each object of a layer is above the two below it, between their centers
///   within 1.5 cm, and its bottom is at their tops within [`CONTACT_TOLERANCE_M`].
/// - Free distances between neighbors equal `gap_m` within 1 cm where it is stated, otherwise neighbors do not overlap;
///   piles are exempt. In grids and circles the smallest free distance counts.
pub fn arrangement_holds(
    kind: ArrangementKind,
    objects: &[&PosedFootprint],
    gap_m: Option<f64>,
    center: Option<&PosedFootprint>,
) -> bool {
    if objects.len() < 2 {
        return false;
    }
    let gaps_hold = |mut gaps_m: Vec<f64>, smallest_only: bool| {
        if smallest_only {
            gaps_m = vec![gaps_m.into_iter().fold(f64::INFINITY, f64::min)];
        }
        gaps_m.into_iter().all(|free_m| match gap_m {
            Some(stated_m) => (free_m - stated_m).abs() <= DISTANCE_TOLERANCE_M,
            None => free_m > -0.001,
        })
    };
    match kind {
        ArrangementKind::Row => is_line(objects, DVec2::X) && gaps_hold(neighbor_gaps_m(objects), false),
        ArrangementKind::Column => is_line(objects, DVec2::Y) && gaps_hold(neighbor_gaps_m(objects), false),
        ArrangementKind::Grid { columns } => {
            let columns = columns.max(1);
            let rows: Vec<Vec<&PosedFootprint>> = objects.chunks(columns).map(<[_]>::to_vec).collect();
            let of_column = |k: usize| -> Vec<&PosedFootprint> {
                rows.iter().filter_map(|row| row.get(k).copied()).collect()
            };
            let lines = |line: &[&PosedFootprint], way| line.len() < 2 || is_line(line, way);
            rows.iter().all(|row| lines(row, DVec2::X))
                && (0..columns).all(|k| lines(&of_column(k), DVec2::Y))
                && gaps_hold(pair_gaps_m(objects), true)
        }
        ArrangementKind::Circle => {
            is_circle(objects, center)
                && center.is_none_or(|center| objects.iter().all(|object| object.distance_m(center) > -0.001))
                && gaps_hold(pair_gaps_m(objects), true)
        }
        ArrangementKind::Pile => is_connected(objects),
        ArrangementKind::Pyramid => is_pyramid(objects, &gaps_hold),
    }
}

/// Sizes of the layers of a pyramid of `count` objects, from the bottom up: a triangle, the last layers of which may be
/// shortened (6: 3 2 1; 5: 3 2; 4: 3 1).
pub fn pyramid_layers(count: usize) -> Vec<usize> {
    let mut widest = 1;
    while widest * (widest + 1) / 2 < count {
        widest += 1;
    }
    let (mut layers, mut left) = (Vec::new(), count);
    for width in (1..=widest).rev() {
        let taken = width.min(left);
        if taken > 0 {
            layers.push(taken);
        }
        left -= taken;
    }
    layers
}

fn is_line(objects: &[&PosedFootprint], way: DVec2) -> bool {
    let across: Vec<f64> = objects.iter().map(|object| object.center().dot(way.perp())).collect();
    let mean = across.iter().sum::<f64>() / across.len() as f64;
    let advances = |pair: &[&PosedFootprint]| (pair[1].center() - pair[0].center()).dot(way) > 0.0;
    across.iter().all(|value| (value - mean).abs() <= ALIGNMENT_TOLERANCE_M)
        && objects.windows(2).all(advances)
}

fn neighbor_gaps_m(objects: &[&PosedFootprint]) -> Vec<f64> {
    objects.windows(2).map(|pair| pair[0].distance_m(pair[1])).collect()
}

fn pair_gaps_m(objects: &[&PosedFootprint]) -> Vec<f64> {
    (0..objects.len()).flat_map(|a| (0..a).map(move |b| objects[a].distance_m(objects[b]))).collect()
}

fn is_circle(objects: &[&PosedFootprint], center: Option<&PosedFootprint>) -> bool {
    let count = objects.len() as f64;
    let mean = objects.iter().map(|object| object.center()).sum::<DVec2>() / count;
    let center = center.map_or(mean, PosedFootprint::center);
    let offsets: Vec<DVec2> = objects.iter().map(|object| object.center() - center).collect();
    let radius_m = offsets.iter().map(|offset| offset.length()).sum::<f64>() / count;
    let step = TAU / count;
    radius_m > 0.005
        && offsets.iter().all(|offset| (offset.length() - radius_m).abs() <= ALIGNMENT_TOLERANCE_M)
        && (0..offsets.len()).all(|k| {
            let next = offsets[(k + 1) % offsets.len()];
            let turn = wrap_angle_rad(next.to_angle() - offsets[k].to_angle() - step);
            turn.abs() <= YAW_TOLERANCE_RAD
        })
}

fn is_connected(objects: &[&PosedFootprint]) -> bool {
    let mut reached = vec![false; objects.len()];
    let mut open = vec![0];
    while let Some(at) = open.pop() {
        if std::mem::replace(&mut reached[at], true) {
            continue;
        }
        open.extend((0..objects.len()).filter(|&k| objects[at].distance_m(objects[k]) <= PILE_GAP_M));
    }
    reached.into_iter().all(|is_reached| is_reached)
}

fn is_pyramid(objects: &[&PosedFootprint], gaps_hold: &dyn Fn(Vec<f64>, bool) -> bool) -> bool {
    let mut start = 0;
    let mut below: Option<&[&PosedFootprint]> = None;
    for size in pyramid_layers(objects.len()) {
        let layer = &objects[start..start + size];
        let is_carried = |slot: usize, object: &PosedFootprint| {
            let Some(pair) = below.and_then(|below| below.get(slot..slot + 2)) else {
                return below.is_none();
            };
            let between = 0.5 * (pair[0].center() + pair[1].center());
            pair.iter().all(|lower| (object.bottom_m - lower.top_m).abs() <= CONTACT_TOLERANCE_M)
                && object.center().distance(between) <= ALIGNMENT_TOLERANCE_M
        };
        let is_row = size < 2 || (is_line(layer, DVec2::X) && gaps_hold(neighbor_gaps_m(layer), false));
        if !is_row || !layer.iter().enumerate().all(|(slot, object)| is_carried(slot, object)) {
            return false;
        }
        (start, below) = (start + size, Some(layer));
    }
    true
}
