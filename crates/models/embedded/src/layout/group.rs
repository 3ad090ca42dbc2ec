//! Groups: an object with all objects it supports, laid out and moved as a unit.

use glam::{DQuat, DVec2};
use rand::RngExt;

use super::place_settings;
use super::spatial_constraints::SpatialConstraint;
use super::support_surface::SupportSurface;
use super::yielding::Yielding;
use super::{Footprint, LayoutObject, LayoutSettings, ObjectGeometry, Placement, StatedDemands, container};
use geometry::Outline;
use runtime::seed::Rng;
use scene::{RelationKind, SupportTree, Supporter};

/// Share of the used part of a table that is covered by objects.
const COVERED_SHARE: f64 = 0.24;
/// Smallest used share of the width and depth of a table.
const MIN_USED_SHARE: f64 = 0.4;

/// Share of the width and depth of the table that these groups use.
fn used_share(groups: &[Group], outline: &Outline) -> f64 {
    let (low, high) = outline.bounds();
    let covered_m2: f64 = groups.iter().map(|group| group.footprint.area_m2()).sum();
    let table_m2 = (high - low).element_product();
    (covered_m2 / (COVERED_SHARE * table_m2)).sqrt().clamp(MIN_USED_SHARE, 1.0)
}

/// An object of a group.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub object: usize,
    /// Placement in the group's frame.
    pub at: Placement,
    /// Rotation before the yaw, for objects that lean in a container.
    pub lean: DQuat,
    /// Footprint in the group's frame.
    pub footprint: Footprint,
}

/// Objects that move as a unit.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// The object on the surface; its frame is the group's frame. Of an arrangement, the first object.
    pub root: usize,
    /// All objects on the surface: the root, or those of an arrangement in its order.
    pub bases: Vec<usize>,
    pub members: Vec<Member>,
    pub footprint: Footprint,
    pub height_m: f64,
}

/// One attempt to lay out all objects.
pub(super) struct LayoutAttempt<'a> {
    pub objects: &'a [ObjectGeometry<'a>],
    pub supports: &'a SupportTree,
    pub constraints: &'a [SpatialConstraint],
    pub requests: &'a [LayoutObject<'a>],
    pub stated: &'a StatedDemands,
    pub yielding: Yielding,
    pub settings: &'a LayoutSettings,
    pub gap_m: f64,
    /// Factor on the tolerances of the constraints; 1 = strict.
    pub tolerance_factor: f64,
    pub rng: Rng,
}

impl LayoutAttempt<'_> {
    /// Groups on the table with their placements; the error is the object without a feasible placement.
    pub fn arrange_on(&mut self, outline: &Outline) -> Result<Vec<(Placement, Group)>, usize> {
        let roots: Vec<usize> = self.supports.children(None).collect();
        let groups = roots.into_iter().map(|root| self.build_group(root)).collect::<Result<Vec<_>, _>>()?;
        let groups = self.arranged(groups);
        let margin_m = self.settings.edge_margin_m;
        let plates = if self.yielding < Yielding::Habits {
            place_settings::free_plates(self.requests, self.stated, self.supports)
        } else {
            Vec::new()
        };
        let groups = self.with_settings(groups, &plates);
        let place_settings = place_settings::place_settings(
            self.requests,
            self.stated,
            &plates,
            &groups,
            outline,
            margin_m + 0.004,
        );
        // People keep what they use within reach: few objects do not spread over all of a large table.
        let used_share =
            if place_settings.is_empty() && !self.is_late() { used_share(&groups, outline) } else { 1.0 };
        let surface = SupportSurface::Table { outline, margin_m, place_settings, used_share };
        let placements = self.place_groups(&surface, &groups)?;
        Ok(placements.into_iter().zip(groups).collect())
    }

    /// The group of an object and all objects it supports.
    fn build_group(&mut self, root: usize) -> Result<Group, usize> {
        let own = &self.objects[root];
        let origin = Placement { xy_m: DVec2::ZERO, yaw_rad: 0.0 };
        let mut group = Group {
            root,
            bases: vec![root],
            members: vec![Member {
                object: root,
                at: origin,
                lean: DQuat::IDENTITY,
                footprint: own.footprint.clone(),
            }],
            footprint: own.footprint.clone(),
            height_m: own.height_m,
        };
        let contained: Vec<usize> = self.supports.supported_by(Supporter::containing(root)).collect();
        for (at, lean, child) in container::place_contained(self.objects, root, &contained, &mut self.rng) {
            let inner = self.build_group(child)?;
            let rise_m = if lean == DQuat::IDENTITY { inner.height_m } else { own.height_m };
            group.add(self.objects, inner, at, lean);
            group.height_m = group.height_m.max(0.4 * own.height_m + rise_m);
        }
        let carried: Vec<usize> = self.supports.supported_by(Supporter::on(root)).collect();
        let inner = carried.iter().map(|&child| self.build_group(child)).collect::<Result<Vec<_>, _>>()?;
        let inner = if self.is_pyramid_level(root, &carried) { inner } else { self.arranged(inner) };
        let placements = self.place_on(root, &inner)?;
        let base_m = own.height_m;
        for (placement, inner) in placements.into_iter().zip(inner) {
            group.height_m = group.height_m.max(base_m + inner.height_m);
            group.add(self.objects, inner, placement, DQuat::IDENTITY);
        }
        group.footprint = Footprint::union(group.members.iter().map(|member| &member.footprint));
        Ok(group)
    }

    /// Placements of groups on an object, in its frame.
    fn place_on(&mut self, root: usize, groups: &[Group]) -> Result<Vec<Placement>, usize> {
        let objects = self.objects;
        let own = &objects[root];
        let Some(height_map) = own.height_map.as_ref().filter(|_| !groups.is_empty()) else {
            return Ok(Vec::new());
        };
        let is_stacked = |group: &Group| {
            self.requests[group.root].relations.contains(&(RelationKind::StackedOn, Some(root)))
        };
        if let Some(placements) = self.pyramid_placements(root, groups) {
            return Ok(placements);
        }
        if groups.len() == 1 && is_stacked(&groups[0]) {
            let max_shift = 0.03 * own.footprint.size_m();
            let shift = DVec2::new(self.rng.random_range(-1.0..1.0), self.rng.random_range(-1.0..1.0));
            let turn_rad = 2.0 * self.settings.jitter_rad * self.rng.random_range(-1.0..1.0);
            let xy_m = own.footprint.center() + max_shift * shift - groups[0].footprint.center();
            return Ok(vec![Placement { xy_m, yaw_rad: turn_rad }]);
        }
        let surface = SupportSurface::Top { footprint: &own.footprint, height_map };
        let gap_m = self.gap_m;
        self.gap_m = self.settings.min_gap_m;
        let placed = self.place_groups(&surface, groups);
        self.gap_m = gap_m;
        // Without free space the groups are piled on top of each other.
        Ok(placed.unwrap_or_else(|_| self.pile_on(own, groups)))
    }

    fn pile_on(&mut self, own: &ObjectGeometry, groups: &[Group]) -> Vec<Placement> {
        let half = 0.5 * own.footprint.size_m();
        (0..groups.len())
            .map(|_| {
                let x = self.rng.random_range(-0.4..0.4);
                let y = self.rng.random_range(-0.4..0.4);
                let xy_m = own.footprint.center() + half * DVec2::new(x, y);
                Placement { xy_m, yaw_rad: self.rng.random_range(-0.3..0.3) }
            })
            .collect()
    }
}

impl Group {
    /// Adds the members of a group at `at` in this group's frame.
    pub fn add(&mut self, objects: &[ObjectGeometry], inner: Group, at: Placement, lean: DQuat) {
        for member in inner.members {
            let at = at.compose(&member.at);
            let lean = (lean * member.lean).normalize();
            let footprint = if lean == DQuat::IDENTITY {
                objects[member.object].footprint.placed(&at)
            } else {
                let turned = objects[member.object].mesh.positions.iter().map(|p| (lean * *p).truncate());
                Footprint::around(turned).placed(&at)
            };
            self.members.push(Member { object: member.object, at, lean, footprint });
        }
    }

    /// Footprint and yaw of a member when the group is at `at`.
    pub fn member_at(&self, object: usize, at: &Placement) -> Option<(Footprint, f64)> {
        let member = self.members.iter().find(|member| member.object == object)?;
        Some((member.footprint.placed(at), at.yaw_rad + member.at.yaw_rad))
    }
}
