//! Regular arrangements: groups that move as one, with fixed placements relative to each other.
//!
//! A row, column, grid, circle or pile of objects on one surface becomes one group whose frame is centered on it and
//! parallel to the front edge. Free distances are exact for convex footprints. Layers of a pyramid above the first
//! stand on objects of the layer below, halfway to its next object. Without a stated gap, neighbors keep a quarter of
//! their mean width. Meters, radians. Cost: the product of corner counts for each pair of neighbors.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DQuat, DVec2};
use rand::RngExt;

use super::group::{Group, LayoutAttempt};
use super::stated_demands::{DemandKind, StatedArrangement};
use super::yielding::Yielding;
use super::{Footprint, Placement};
use geometry::polygon::convex_distance_m;
use scene::ArrangementKind;
use scene::predicates::pyramid_layers;

/// Largest gap that is not stated.
const MAX_DEFAULT_GAP_M: f64 = 0.06;
/// Gap of piles and pyramids that is not stated: objects almost touch.
const TOUCHING_GAP_M: f64 = 0.003;
/// Directions from which an object is added to a pile.
const PILE_DIRECTIONS: u32 = 24;

impl LayoutAttempt<'_> {
    /// The groups, with those of an arrangement joined to one group. Arrangements of which fewer than two objects
    /// are on this surface stay as they are.
    pub(super) fn arranged(&mut self, groups: Vec<Group>) -> Vec<Group> {
        if self.yielding >= Yielding::Relations {
            return groups;
        }
        let mut groups: Vec<Option<Group>> = groups.into_iter().map(Some).collect();
        let stated = self.stated;
        for arrangement in &stated.arrangements {
            let position = |groups: &[Option<Group>], object: usize| {
                groups.iter().position(|group| group.as_ref().is_some_and(|group| group.bases == [object]))
            };
            let slots: Vec<usize> =
                arrangement.objects.iter().filter_map(|&object| position(&groups, object)).collect();
            if slots.len() < 2 {
                continue;
            }
            let members: Vec<Group> = slots.iter().filter_map(|&slot| groups[slot].take()).collect();
            let center_slot = arrangement.center.and_then(|object| position(&groups, object));
            let center = center_slot.and_then(|slot| groups[slot].take());
            let slot = slots.iter().copied().chain(center_slot).min().unwrap_or(slots[0]);
            groups[slot] = Some(self.joined(arrangement, members, center));
        }
        groups.into_iter().flatten().collect()
    }

    fn joined(
        &mut self,
        arrangement: &StatedArrangement,
        members: Vec<Group>,
        center: Option<Group>,
    ) -> Group {
        let placements = self.placements(arrangement, &members, center.as_ref());
        let bases: Vec<usize> = members.iter().chain(&center).map(|group| group.root).collect();
        let parts: Vec<(Placement, Group)> = placements
            .into_iter()
            .zip(members)
            .chain(center.map(|group| (self.turned(&group, 0.0), group)))
            .collect();
        let footprints: Vec<Footprint> = parts.iter().map(|(at, part)| part.footprint.placed(at)).collect();
        let offset = Footprint::union(footprints.iter()).center();
        let height_m = parts.iter().map(|(_, part)| part.height_m).fold(0.0, f64::max);
        let footprint = Footprint::around(std::iter::empty());
        let mut joined = Group { root: bases[0], bases, members: Vec::new(), footprint, height_m };
        for (at, part) in parts {
            let at = Placement { xy_m: at.xy_m - offset, yaw_rad: at.yaw_rad };
            joined.add(self.objects, part, at, DQuat::IDENTITY);
        }
        joined.footprint = Footprint::union(joined.members.iter().map(|member| &member.footprint));
        joined
    }

    /// Placements of the members; those of a circle around the origin.
    fn placements(
        &mut self,
        arrangement: &StatedArrangement,
        members: &[Group],
        center: Option<&Group>,
    ) -> Vec<Placement> {
        let gap_m = self.arrangement_gap_m(arrangement, members);
        match arrangement.kind {
            ArrangementKind::Row => self.line(members, DVec2::X, gap_m, true),
            ArrangementKind::Pyramid => self.line(members, DVec2::X, gap_m, false),
            ArrangementKind::Column => self.line(members, DVec2::Y, gap_m, true),
            ArrangementKind::Grid { columns } => self.grid(members, columns.max(1), gap_m),
            ArrangementKind::Circle => self.circle(arrangement, members, center, gap_m),
            ArrangementKind::Pile => self.pile(members, gap_m),
        }
    }

    fn arrangement_gap_m(&self, arrangement: &StatedArrangement, members: &[Group]) -> f64 {
        let stated_m = arrangement.gap_m.filter(|_| self.yielding < Yielding::Distances);
        let widths: f64 = members.iter().map(|group| group.footprint.size_m().min_element()).sum();
        let mean_width_m = widths / members.len().max(1) as f64;
        let default_m = match arrangement.kind {
            ArrangementKind::Pile | ArrangementKind::Pyramid => TOUCHING_GAP_M,
            _ if self.yielding >= Yielding::Distances => self.gap_m,
            _ => (0.25 * mean_width_m).clamp(self.gap_m, MAX_DEFAULT_GAP_M.max(self.gap_m)),
        };
        // Objects that touch exactly would be pushed apart.
        stated_m.unwrap_or(default_m).max(0.001)
    }

    /// The group at the origin with its yaw: the stated one, or that of the front edge.
    fn turned(&self, group: &Group, yaw_rad: f64) -> Placement {
        let yaw_rad = self
            .stated
            .yaw_rad(group.root)
            .filter(|_| self.yielding < Yielding::Distances)
            .unwrap_or(yaw_rad);
        self.centered(group, yaw_rad, DVec2::ZERO)
    }

    /// The placement with this yaw at which the center of the group's root is at `center`.
    fn centered(&self, group: &Group, yaw_rad: f64, center: DVec2) -> Placement {
        let turned = Placement { xy_m: DVec2::ZERO, yaw_rad };
        let root = self.objects[group.root].footprint.placed(&turned);
        Placement { xy_m: center - root.center(), yaw_rad }
    }

    /// Members one after the other along a direction, with centers on a line and exact free distances. `with_carried`
    /// keeps the distances also between the objects that they carry.
    fn line(&self, members: &[Group], way: DVec2, gap_m: f64, with_carried: bool) -> Vec<Placement> {
        let mut placements: Vec<Placement> = Vec::new();
        let mut previous: Option<Footprint> = None;
        for group in members {
            let root = &self.objects[group.root].footprint;
            let own = if with_carried { &group.footprint } else { root };
            let mut at = self.turned(group, 0.0);
            if let Some(before) = &previous {
                let free_m = before.extent_m(way) + gap_m + own.placed(&at).extent_m(-way);
                at.xy_m += before.center() + free_m * way;
                // Round and slanted sides are farther apart than their boxes.
                for _ in 0..12 {
                    let distance_m = convex_distance_m(own.placed(&at).corners(), before.corners());
                    at.xy_m += (gap_m - distance_m) * way;
                }
                let across = way.perp();
                at.xy_m -= root.placed(&at).center().dot(across) * across;
            }
            previous = Some(own.placed(&at));
            placements.push(at);
        }
        placements
    }

    fn grid(&self, members: &[Group], columns: usize, gap_m: f64) -> Vec<Placement> {
        let size = |group: &Group| group.footprint.placed(&self.turned(group, 0.0)).size_m();
        let pitch = members.iter().map(size).fold(DVec2::ZERO, DVec2::max) + gap_m;
        members
            .iter()
            .enumerate()
            .map(|(k, group)| {
                let cell = DVec2::new((k % columns) as f64, (k / columns) as f64);
                let at = self.turned(group, 0.0);
                Placement { xy_m: at.xy_m + cell * pitch, ..at }
            })
            .collect()
    }

    fn circle(
        &self,
        arrangement: &StatedArrangement,
        members: &[Group],
        center: Option<&Group>,
        gap_m: f64,
    ) -> Vec<Placement> {
        let count = members.len();
        // Members that face the center turn with their place.
        let faces = |group: &Group| {
            self.stated.demands.iter().any(|demand| {
                demand.object == group.root
                    && matches!(demand.kind, DemandKind::Facing { target } if target == arrangement.center)
            })
        };
        // Two objects are left and right; three and more start at the front.
        let first = if count == 2 { PI } else { -FRAC_PI_2 };
        let at = |radius_m: f64| -> Vec<Placement> {
            members
                .iter()
                .enumerate()
                .map(|(k, group)| {
                    let angle = first + TAU * k as f64 / count as f64;
                    let yaw_rad = if faces(group) { angle + PI + FRAC_PI_2 } else { 0.0 };
                    let turned = self.turned(group, yaw_rad);
                    Placement { xy_m: turned.xy_m + radius_m * DVec2::from_angle(angle), ..turned }
                })
                .collect()
        };
        let center_print = center.map(|group| group.footprint.placed(&self.turned(group, 0.0)));
        let is_free = |radius_m: f64| {
            let placed: Vec<Footprint> =
                members.iter().zip(at(radius_m)).map(|(group, at)| group.footprint.placed(&at)).collect();
            let apart = |a: &Footprint, b: &Footprint, free_m: f64| {
                convex_distance_m(a.corners(), b.corners()) >= free_m
            };
            (0..count).all(|a| (0..a).all(|b| apart(&placed[a], &placed[b], gap_m)))
                && center_print.as_ref().is_none_or(|center_print| {
                    placed.iter().all(|print| apart(print, center_print, self.gap_m.min(gap_m)))
                })
        };
        // The smallest radius at which all are free.
        let (mut low, mut high) = (0.0, 0.05);
        while !is_free(high) && high < 4.0 {
            high *= 1.5;
        }
        for _ in 0..24 {
            let between = 0.5 * (low + high);
            if is_free(between) { high = between } else { low = between }
        }
        at(high)
    }

    /// Each object slides toward the pile from the direction in which it comes nearest to the first one.
    fn pile(&mut self, members: &[Group], gap_m: f64) -> Vec<Placement> {
        let mut placements: Vec<Placement> = Vec::new();
        let mut placed: Vec<Footprint> = Vec::new();
        for group in members {
            let yaw_rad = self.rng.random_range(-PI..PI);
            let at = self.turned(group, yaw_rad);
            let start_rad = self.rng.random_range(-PI..PI);
            let moved = |by: DVec2| Placement { xy_m: at.xy_m + by, ..at };
            let is_free = |by: DVec2| {
                let own = group.footprint.placed(&moved(by));
                placed.iter().all(|other| convex_distance_m(own.corners(), other.corners()) >= gap_m)
            };
            let nearest = |direction: u32| {
                let angle = start_rad + TAU * f64::from(direction) / f64::from(PILE_DIRECTIONS);
                let way = DVec2::from_angle(angle);
                let (mut low, mut high) = (0.0, 4.0);
                for _ in 0..14 {
                    let between = 0.5 * (low + high);
                    if is_free(between * way) { high = between } else { low = between }
                }
                high * way
            };
            let by = if placed.is_empty() {
                DVec2::ZERO
            } else {
                let ways = (0..PILE_DIRECTIONS).map(nearest);
                ways.min_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(DVec2::ZERO)
            };
            placed.push(group.footprint.placed(&moved(by)));
            placements.push(moved(by));
        }
        placements
    }

    /// The pyramid, layer and slot of an object.
    fn pyramid_slot(&self, object: usize) -> Option<(&StatedArrangement, usize, usize)> {
        self.stated.arrangements.iter().filter(|a| a.kind == ArrangementKind::Pyramid).find_map(|pyramid| {
            let position = pyramid.objects.iter().position(|k| *k == object)?;
            let mut start = 0;
            for (layer, size) in pyramid_layers(pyramid.objects.len()).into_iter().enumerate() {
                if position < start + size {
                    return Some((pyramid, layer, position - start));
                }
                start += size;
            }
            None
        })
    }

    /// Whether the carried objects belong to a higher layer of the pyramid of `root`.
    pub(super) fn is_pyramid_level(&self, root: usize, carried: &[usize]) -> bool {
        let of = |object: usize| self.pyramid_slot(object).map(|(pyramid, ..)| &pyramid.objects);
        of(root).is_some_and(|own| carried.iter().any(|&object| of(object) == Some(own)))
    }

    /// Placements on an object of a pyramid, halfway to the next object of its layer; `None` for all other objects.
    pub(super) fn pyramid_placements(&self, root: usize, groups: &[Group]) -> Option<Vec<Placement>> {
        let (pyramid, layer, slot) = self.pyramid_slot(root)?;
        let is_higher = |group: &Group| {
            self.pyramid_slot(group.root)
                .is_some_and(|(own, above, _)| own.objects == pyramid.objects && above == layer + 1)
        };
        if groups.len() != 1 || !is_higher(&groups[0]) {
            return None;
        }
        let size = pyramid_layers(pyramid.objects.len())[0];
        // The centers of the lowest layer, then the means of neighbors.
        let width_m = |k: usize| self.objects[pyramid.objects[k]].footprint.size_m().x;
        let stated_m = pyramid.gap_m.filter(|_| self.yielding < Yielding::Distances);
        let gap_m = stated_m.unwrap_or(TOUCHING_GAP_M).max(0.001);
        let mut centers_m = vec![0.0];
        for k in 1..size {
            centers_m.push(centers_m[k - 1] + 0.5 * (width_m(k - 1) + width_m(k)) + gap_m);
        }
        for _ in 0..layer {
            centers_m = centers_m.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        }
        let half_way_m = 0.5 * (centers_m.get(slot + 1)? - centers_m[slot]);
        let center = self.objects[root].footprint.center() + DVec2::new(half_way_m, 0.0);
        Some(vec![self.centered(&groups[0], 0.0, center)])
    }
}
