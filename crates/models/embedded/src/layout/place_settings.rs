//! Place settings: positions of plates around the table.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec2;

use super::{Footprint, LayoutObject, ObjectGeometry, Placement, StatedDemands};
use geometry::Outline;
use scene::predicates::seat_yaw_rad;
use scene::{RelationKind, SupportTree};

/// Width of a place setting with its cutlery, meters.
const SETTING_WIDTH_M: f64 = 0.46;

/// A place setting for a person who sits outside the edge and faces inward.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlaceSetting {
    /// Yaw of objects that face the person; 0 = at the front edge.
    yaw_rad: f64,
    /// Offset from the center to the person's right, meters.
    sideways_m: f64,
}

/// A place setting for each plate on the table whose position the text leaves open.
pub(super) fn place_settings(
    objects: &[LayoutObject],
    stated: &StatedDemands,
    supports: &SupportTree,
    geometries: &[ObjectGeometry],
    outline: &Outline,
    margin_m: f64,
) -> Vec<(usize, Placement)> {
    let free = |k: usize| {
        supports.supporter(k).parent.is_none()
            && objects[k].category.name == "plate"
            && objects[k].relations.is_empty()
    };
    let plates: Vec<usize> = (0..objects.len()).filter(|&k| free(k)).collect();
    // Stated directions are those of a viewer at the front edge, so plates with directed relations are placed there.
    let directed = objects.iter().enumerate().any(|(from, object)| {
        object.relations.iter().any(|&(kind, target)| {
            use RelationKind::{Behind, InFrontOf, LeftOf, RightOf};
            matches!(kind, LeftOf | RightOf | InFrontOf | Behind)
                && target.is_some_and(|to| plates.contains(&to) && !stated.is_seated(from, kind, to))
        })
    });
    let (low, high) = outline.bounds();
    let size = high - low;
    let settings = settings_along_edges(plates.len(), size, directed);
    let placement = |plate: usize, setting: PlaceSetting| {
        let at = setting.placement(&geometries[plate].footprint, outline, margin_m);
        // The person sits at the nearest edge, also where that of a round table is oblique.
        if directed { at } else { Placement { yaw_rad: seat_yaw_rad(at.xy_m, outline), ..at } }
    };
    plates.into_iter().zip(settings).map(|(plate, setting)| (plate, placement(plate, setting))).collect()
}

/// `count` place settings, distributed over the sides of the table.
fn settings_along_edges(count: usize, size: DVec2, directed: bool) -> Vec<PlaceSetting> {
    let max_abreast = ((0.94 * size.x / SETTING_WIDTH_M) as usize).max(1);
    let row = |count: usize, yaw_rad: f64| {
        let pitch_m = (0.86 * size.x / count.max(1) as f64).clamp(SETTING_WIDTH_M.min(0.5 * size.x), 0.72);
        (0..count).map(move |k| PlaceSetting {
            yaw_rad,
            sideways_m: (k as f64 - 0.5 * (count as f64 - 1.0)) * pitch_m,
        })
    };
    let deep = size.y > 0.62;
    if directed || !deep {
        let front = count.min(max_abreast);
        return row(front, 0.0).chain(row(count - front, PI)).collect();
    }
    match count {
        0 | 1 => row(count, 0.0).collect(),
        2 => row(1, 0.0).chain(row(1, PI)).collect(),
        _ if size.x < 1.25 * size.y => (0..count)
            .map(|k| PlaceSetting { yaw_rad: TAU * k as f64 / count as f64, sideways_m: 0.0 })
            .collect(),
        _ => {
            let ends = if count > 2 * max_abreast { 2 } else { 0 };
            let front = (count - ends).div_ceil(2);
            let sides = [FRAC_PI_2, -FRAC_PI_2].into_iter().take(ends);
            row(front, 0.0)
                .chain(row(count - ends - front, PI))
                .chain(sides.map(|yaw_rad| PlaceSetting { yaw_rad, sideways_m: 0.0 }))
                .collect()
        }
    }
}

impl PlaceSetting {
    /// The placement of a plate with this footprint: as near to the person as the margin to the edge allows.
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
