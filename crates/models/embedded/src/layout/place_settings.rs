//! Place settings: positions of plates around the table, and of what lies beside each of them.
//!
//! A plate with its cutlery, glass and napkin is one group with fixed inner placements, so that settings do not disturb
//! each other: the ends of the cutlery are level with the edge of the plate that is nearest to the person, the knife
//! is beside the plate and the spoon beyond it, and a glass stands behind the plate, toward the right hand.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DQuat, DVec2};
use rand::RngExt;

use super::group::{Group, LayoutAttempt};
use super::spatial_constraints::{LEFT, RIGHT, RelativePosition, SpatialConstraint};
use super::{Footprint, LayoutObject, Placement, StatedDemands};
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

/// Free space between the parts of a setting, meters; less where the table is crowded.
const PART_GAP_M: f64 = 0.014;

/// Plates on the table whose positions the text leaves open.
pub(super) fn free_plates(
    objects: &[LayoutObject],
    stated: &StatedDemands,
    supports: &SupportTree,
) -> Vec<usize> {
    let is_free = |k: usize| {
        supports.supporter(k).parent.is_none()
            && objects[k].category.name == "plate"
            && objects[k].relations.is_empty()
            && !stated.determine(k)
    };
    (0..objects.len()).filter(|&k| is_free(k)).collect()
}

/// A place setting for each of the plates.
pub(super) fn place_settings(
    objects: &[LayoutObject],
    stated: &StatedDemands,
    plates: &[usize],
    groups: &[Group],
    outline: &Outline,
    margin_m: f64,
) -> Vec<(usize, Placement)> {
    // Stated directions are those of a viewer at the front edge, so plates with directed relations are placed there.
    let directed = objects.iter().enumerate().any(|(from, object)| {
        object.relations.iter().any(|&(kind, target)| {
            use RelationKind::{Behind, InFrontOf, LeftOf, RightOf};
            matches!(kind, LeftOf | RightOf | InFrontOf | Behind)
                && target.is_some_and(|to| plates.contains(&to) && !stated.is_seated(from, kind, to))
        })
    });
    let (low, high) = outline.bounds();
    let settings = settings_along_edges(plates.len(), high - low, directed);
    let placement = |plate: usize, setting: PlaceSetting| {
        let group = groups.iter().find(|group| group.root == plate)?;
        let at = setting.placement(&group.footprint, outline, margin_m);
        // The person sits at the nearest edge, also where that of a round table is oblique.
        let yaw_rad = if directed { at.yaw_rad } else { seat_yaw_rad(at.xy_m, outline) };
        Some((plate, Placement { yaw_rad, ..at }))
    };
    plates.iter().zip(settings).filter_map(|(plate, setting)| placement(*plate, setting)).collect()
}

impl LayoutAttempt<'_> {
    /// The groups, with what belongs to the setting of each of these plates joined to its group.
    pub(super) fn with_settings(&mut self, groups: Vec<Group>, plates: &[usize]) -> Vec<Group> {
        let mut groups: Vec<Option<Group>> = groups.into_iter().map(Some).collect();
        for &plate in plates {
            let slot_of = |groups: &[Option<Group>], object: usize| {
                groups.iter().position(|group| group.as_ref().is_some_and(|group| group.bases == [object]))
            };
            let Some(slot) = slot_of(&groups, plate) else { continue };
            let Some(mut setting) = groups[slot].take() else { continue };
            // Directions of the viewer can be others than those of the person at the plate.
            let is_of_viewer =
                |part: &SpatialConstraint| part.to == plate && part.hard && !part.in_target_frame;
            let parts = if self.constraints.iter().any(is_of_viewer) { vec![] } else { self.parts_of(plate) };
            let own = self.objects[plate].footprint.clone();
            let mut placed = vec![setting.footprint.clone()];
            for constraint in parts {
                let Some(part) = slot_of(&groups, constraint.from).and_then(|slot| groups[slot].take())
                else {
                    continue;
                };
                let at = self.part_placement(&own, &part, constraint.position, &placed);
                placed.push(part.footprint.placed(&at));
                setting.height_m = setting.height_m.max(part.height_m);
                setting.bases.push(part.root);
                setting.add(self.objects, part, at, DQuat::IDENTITY);
            }
            setting.footprint = Footprint::union(setting.members.iter().map(|member| &member.footprint));
            groups[slot] = Some(setting);
        }
        groups.into_iter().flatten().collect()
    }

    /// Objects that have a usual place at a plate and nothing else to be placed by, those at its sides first and from
    /// the inside out.
    fn parts_of(&self, plate: usize) -> Vec<SpatialConstraint> {
        let is_of_plate =
            |constraint: &&SpatialConstraint| constraint.in_target_frame && constraint.to == plate;
        let of_plate: Vec<SpatialConstraint> = self.constraints.iter().filter(is_of_plate).copied().collect();
        let is_part = |object: usize| of_plate.iter().any(|constraint| constraint.from == object);
        let is_free = |object: usize| {
            let own =
                self.constraints.iter().filter(|constraint| constraint.hard && constraint.from == object);
            let relations = &self.requests[object].relations;
            !self.stated.determine(object)
                && own.into_iter().all(|constraint| constraint.to == plate || is_part(constraint.to))
                && relations.iter().all(|(kind, target)| target.is_some() || kind.is_support())
        };
        let mut parts: Vec<SpatialConstraint> = Vec::new();
        for constraint in of_plate.iter().filter(|constraint| is_free(constraint.from)) {
            // What the text states counts where there is a habit, too.
            match parts.iter_mut().find(|part| part.from == constraint.from) {
                Some(part) if constraint.hard => *part = *constraint,
                Some(_) => {}
                None => parts.push(*constraint),
            }
        }
        let is_inner =
            |object: usize| ["fork", "knife"].contains(&self.objects[object].category.name.as_str());
        parts.sort_by_key(|part| match part.position {
            LEFT | RIGHT if is_inner(part.from) => 0,
            LEFT | RIGHT => 1,
            _ => 2,
        });
        parts
    }

    /// Placement of a part in the frame of its plate, whose front is toward the person, beside what is placed already.
    fn part_placement(
        &mut self,
        plate: &Footprint,
        part: &Group,
        position: RelativePosition,
        placed: &[Footprint],
    ) -> Placement {
        let jitter = |attempt: &mut Self| attempt.rng.random_range(-1.0..1.0_f64);
        let yaw_rad = 0.3 * self.settings.jitter_rad * jitter(self);
        let turned = part.footprint.placed(&Placement { xy_m: DVec2::ZERO, yaw_rad });
        let way = position.direction(0.0).unwrap_or(DVec2::X);
        let gap_m = self.gap_m.min(PART_GAP_M);
        let clear_m = plate.extent_m(way) + turned.extent_m(-way) + gap_m;
        let is_at_side = matches!(position, LEFT | RIGHT);
        let aside_m = if is_at_side {
            let level_m = turned.extent_m(DVec2::NEG_Y) - plate.extent_m(DVec2::NEG_Y) + 0.01;
            let is_long = turned.size_m().y > 0.5 * plate.size_m().y;
            DVec2::new(0.0, if is_long { level_m } else { 0.0 } + 0.004 * jitter(self))
        } else if way.x.abs() < 1e-9 && part.height_m > 0.04 {
            // A glass is reached for with the right hand.
            DVec2::new(0.4 * plate.extent_m(DVec2::X), 0.0)
        } else {
            DVec2::ZERO
        };
        let start = plate.center() + clear_m * way + aside_m - turned.center();
        let at = |steps: u32| Placement { xy_m: start + 0.003 * f64::from(steps) * way, yaw_rad };
        let is_clear = |at: &Placement| {
            let own = part.footprint.placed(at);
            placed.iter().all(|other| own.gap_m(other) >= gap_m)
        };
        (0..200).map(at).find(is_clear).unwrap_or_else(|| at(200))
    }
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
    /// The placement of a setting with this footprint: as near to the person as the margin to the edge allows, and
    /// nearer to its neighbor where it would not fit otherwise.
    fn placement(&self, setting: &Footprint, outline: &Outline, margin_m: f64) -> Placement {
        let (low, high) = outline.bounds();
        let inward = DVec2::from_angle(self.yaw_rad + FRAC_PI_2);
        let right = -inward.perp();
        let at = |sideways_m: f64, out_m: f64| Placement {
            xy_m: 0.5 * (low + high) + sideways_m * right - out_m * inward,
            yaw_rad: self.yaw_rad,
        };
        let is_inside = |at: &Placement| setting.placed(at).depth_inside_m(outline) >= margin_m;
        let outermost = |share: f64| {
            let outward = (0..200).rev().map(|step| at(share * self.sideways_m, 0.01 * f64::from(step)));
            outward.into_iter().find(is_inside)
        };
        [1.0, 0.92, 0.84, 0.76].into_iter().find_map(outermost).unwrap_or(at(self.sideways_m, 0.0))
    }
}
