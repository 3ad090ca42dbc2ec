//! Places at the table: where plates go.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;

use super::tree::Carrier;
use super::{Footprint, Placement, Prepared, Thing};
use geometry::Outline;
use scene::RelationKind;

/// Width of one place with its cutlery, meters.
const PLACE_WIDTH_M: f64 = 0.46;

/// One place: somebody sits outside the edge and looks inward.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seat {
    /// Yaw of what faces the person; 0 = at the front edge.
    yaw_rad: f64,
    /// To the person's right of the middle, meters.
    sideways_m: f64,
}

/// A place for each plate that stands on the table and has none of its own.
pub(super) fn seats(
    things: &[Thing],
    carriers: &[Option<Carrier>],
    prepared: &[Prepared],
    outline: &Outline,
    margin_m: f64,
) -> Vec<(usize, Placement)> {
    let free = |k: usize| {
        carriers[k].is_none() && things[k].category.name == "plate" && things[k].relations.is_empty()
    };
    let plates: Vec<usize> = (0..things.len()).filter(|&k| free(k)).collect();
    // Left, right and behind are those of somebody at the front edge, so such plates belong there.
    let directed = things.iter().any(|thing| {
        thing.relations.iter().any(|(kind, target)| {
            use RelationKind::{Behind, InFrontOf, LeftOf, RightOf};
            matches!(kind, LeftOf | RightOf | InFrontOf | Behind)
                && target.is_some_and(|target| plates.contains(&target))
        })
    });
    let (low, high) = outline.bounds();
    let size = high - low;
    let places = places(plates.len(), size, directed);
    let placement = |plate: usize, seat: Seat| seat.placement(&prepared[plate].footprint, outline, margin_m);
    plates.into_iter().zip(places).map(|(plate, seat)| (plate, placement(plate, seat))).collect()
}

fn places(count: usize, size: DVec2, directed: bool) -> Vec<Seat> {
    let most_abreast = ((0.94 * size.x / PLACE_WIDTH_M) as usize).max(1);
    let row = |count: usize, yaw_rad: f64| {
        let pitch_m = (0.86 * size.x / count.max(1) as f64).clamp(PLACE_WIDTH_M.min(0.5 * size.x), 0.62);
        (0..count)
            .map(move |k| Seat { yaw_rad, sideways_m: (k as f64 - 0.5 * (count as f64 - 1.0)) * pitch_m })
    };
    let deep = size.y > 0.62;
    if directed || !deep {
        let front = count.min(most_abreast);
        return row(front, 0.0).chain(row(count - front, PI)).collect();
    }
    match count {
        0 | 1 => row(count, 0.0).collect(),
        2 => row(1, 0.0).chain(row(1, PI)).collect(),
        _ if size.x < 1.25 * size.y => {
            (0..count).map(|k| Seat { yaw_rad: TAU * k as f64 / count as f64, sideways_m: 0.0 }).collect()
        }
        _ => {
            let ends = if count > 2 * most_abreast { 2 } else { 0 };
            let front = (count - ends).div_ceil(2);
            let sides = [FRAC_PI_2, -FRAC_PI_2].into_iter().take(ends);
            row(front, 0.0)
                .chain(row(count - ends - front, PI))
                .chain(sides.map(|yaw_rad| Seat { yaw_rad, sideways_m: 0.0 }))
                .collect()
        }
    }
}

impl Seat {
    /// Where a plate of that footprint stands: as near to the person as the margin to the edge allows.
    fn placement(&self, plate: &Footprint, outline: &Outline, margin_m: f64) -> Placement {
        let (low, high) = outline.bounds();
        let inward = DVec2::from_angle(self.yaw_rad + FRAC_PI_2);
        let right = -inward.perp();
        let start = 0.5 * (low + high) + self.sideways_m * right;
        let at = |out_m: f64| Placement { xy_m: start - out_m * inward, yaw_rad: self.yaw_rad };
        let mut best = at(0.0);
        for step in 0..200 {
            let next = at(0.01 * f64::from(step));
            if plate.placed(&next).depth_inside_m(outline) < margin_m {
                break;
            }
            best = next;
        }
        best
    }
}
