//! Sequential placement of groups on a surface: sample candidates, reject infeasible ones, select the lowest cost.

use glam::DVec2;
use rand::RngExt;

use super::Placement;
use super::co_occurrence_priors::YawSampler;
use super::group::{Group, LayoutAttempt};
use super::spatial_constraints::{RelativePosition, SpatialConstraint};
use super::stated_demands::{Demand, DemandKind};
use super::support_surface::SupportSurface;
use super::yielding::Yielding;
use catalog::Zone;
use scene::RelationKind;
use scene::predicates::seat_yaw_rad;

/// Cost per meter of space missing beside a group for objects that are still to be placed there.
const SPACE_WEIGHT_PER_M: f64 = 30.0;

/// A constraint between two groups on one surface.
#[derive(Clone, Copy)]
pub(super) struct GroupConstraint {
    spatial: SpatialConstraint,
    from: usize,
    to: usize,
}

/// The groups of a surface with the placements made so far.
pub(super) struct PartialLayout<'a> {
    pub surface: &'a SupportSurface<'a>,
    pub groups: &'a [Group],
    constraints: Vec<GroupConstraint>,
    pub placed: Vec<Option<Placement>>,
}

impl LayoutAttempt<'_> {
    /// A placement for each group; the error is the root object of the group without a feasible placement.
    pub fn place_groups(
        &mut self,
        surface: &SupportSurface,
        groups: &[Group],
    ) -> Result<Vec<Placement>, usize> {
        let group_of =
            |object: usize| groups.iter().position(|group| group.members.iter().any(|m| m.object == object));
        let constraints = self
            .constraints
            .iter()
            .filter_map(|&spatial| {
                let (from, to) = (group_of(spatial.from)?, group_of(spatial.to)?);
                let spatial = self.relaxed(spatial)?;
                (from != to).then_some(GroupConstraint { spatial, from, to })
            })
            .collect();
        let mut layout = PartialLayout { surface, groups, constraints, placed: vec![None; groups.len()] };
        for group in layout.order(&self.stated.demands) {
            match self.best_placement(&layout, group) {
                Some(placement) => layout.placed[group] = Some(placement),
                None => return Err(groups[group].root),
            }
        }
        Ok(layout.placed.into_iter().flatten().collect())
    }

    /// A constraint as far as it has not yielded; `None` for habits that have.
    fn relaxed(&self, spatial: SpatialConstraint) -> Option<SpatialConstraint> {
        if !spatial.hard {
            return (self.yielding < Yielding::Habits).then_some(spatial);
        }
        let is_close = matches!(spatial.position, RelativePosition::Beside | RelativePosition::Around { .. });
        let distance_m = spatial.distance_m.filter(|_| self.yielding < Yielding::Distances);
        let hard = match (is_close, distance_m) {
            (true, None) => self.yielding < Yielding::Closeness,
            _ => self.yielding < Yielding::Relations,
        };
        Some(SpatialConstraint { hard, distance_m, ..spatial })
    }

    fn best_placement(&mut self, layout: &PartialLayout, group: usize) -> Option<Placement> {
        let mut best: Option<(f64, Placement)> = None;
        for number in 0..self.settings.candidates {
            let placement = self.candidate(layout, group, number);
            let placement = self.projected(layout, group, placement);
            let Some(cost) = self.cost(layout, group, &placement) else { continue };
            let cost = cost + self.settings.placement_cost_noise * self.rng.random_range(0.0..1.0);
            if best.is_none_or(|(min_cost, _)| cost < min_cost) {
                best = Some((cost, placement));
            }
        }
        best.map(|(_, placement)| placement)
    }

    /// A random placement from the place settings, the constraints or the zone.
    fn candidate(&mut self, layout: &PartialLayout, group: usize, number: u32) -> Placement {
        let own = &layout.groups[group];
        let root = &self.objects[own.root];
        let half_depth_m = layout.surface.half_m().y;
        let allow_sideways = self.is_late();
        let yaw_sampler = |reference_yaw_rad: Option<f64>, jitter: f64| YawSampler {
            object: root,
            reference_yaw_rad,
            half_depth_m,
            jitter_rad: jitter * self.settings.jitter_rad,
            allow_sideways,
        };
        let places: Vec<RelationKind> =
            self.table_relations(own).filter(|(_, kind)| !kind.is_support()).map(|(_, kind)| kind).collect();
        let constraints: Vec<&GroupConstraint> = layout.constraints_of(group).collect();
        if let SupportSurface::Table { outline, .. } = layout.surface
            && let Some(setting) = layout.surface.setting_of(own.root)
        {
            let mut at = *setting;
            let drift = if own.bases.len() > 1 { 0.01 } else { 0.03 } + 0.002 * f64::from(number);
            at.xy_m.x += drift * self.rng.random_range(-1.0..1.0);
            at.xy_m.y += drift * self.rng.random_range(-1.0..1.0);
            // The person sits at the edge that is nearest now.
            if self.stated.seated.iter().any(|(_, _, plate)| *plate == own.root) {
                at.yaw_rad = seat_yaw_rad(at.xy_m, outline);
            }
            return at;
        }
        if !constraints.is_empty()
            && (places.is_empty() || number.is_multiple_of(2))
            && self.rng.random_bool(0.88)
        {
            let hard: Vec<&&GroupConstraint> =
                constraints.iter().filter(|constraint| constraint.spatial.hard).collect();
            let pick = |count: usize, rng: &mut runtime::seed::Rng| rng.random_range(0..count);
            let constraint = if !hard.is_empty() && self.rng.random_bool(0.6) {
                **hard[pick(hard.len(), &mut self.rng)]
            } else {
                *constraints[pick(constraints.len(), &mut self.rng)]
            };
            if let Some(at) = self.constrained_candidate(layout, group, constraint) {
                return at;
            }
        }
        let named = if places.is_empty() {
            None
        } else {
            layout.surface.named_candidate(places[number as usize % places.len()], &mut self.rng)
        };
        let zone = if places.is_empty() { root.category.zone } else { Zone::Any };
        let xy_m = named.unwrap_or_else(|| layout.surface.candidate(zone, &mut self.rng));
        let reference_yaw_rad = layout.must_be_axis_aligned(self.requests, own).then_some(0.0);
        let yaw_rad = yaw_sampler(reference_yaw_rad, 1.0).yaw_rad(xy_m, &mut self.rng);
        Placement { xy_m, yaw_rad }
    }

    /// A placement that satisfies the constraint, relative to the end that is placed already.
    fn constrained_candidate(
        &mut self,
        layout: &PartialLayout,
        group: usize,
        constraint: GroupConstraint,
    ) -> Option<Placement> {
        let own = &layout.groups[group];
        let root = &self.objects[own.root];
        let (here, there, other) = if constraint.from == group {
            (constraint.spatial.from, constraint.spatial.to, constraint.to)
        } else {
            (constraint.spatial.to, constraint.spatial.from, constraint.from)
        };
        let (target, target_yaw) = layout.groups[other].member_at(there, &layout.placed[other]?)?;
        let like = self.objects[own.root].category.name == self.objects[there].category.name;
        let outward = constraint
            .spatial
            .position
            .direction(target_yaw)
            .map(|d| d.to_angle() + 0.5 * std::f64::consts::PI);
        let reference_yaw_rad = if matches!(constraint.spatial.position, RelativePosition::Around { .. })
            && layout.has_setting(own.root)
        {
            outward
        } else if constraint.spatial.in_target_frame
            || (layout.has_setting(there) && root.slenderness() > 1.8)
        {
            Some(target_yaw)
        } else if (like && root.slenderness() > 1.8) || layout.must_be_axis_aligned(self.requests, own) {
            Some(if like { target_yaw } else { 0.0 })
        } else {
            None
        };
        let yaw_sampler = YawSampler {
            object: root,
            reference_yaw_rad,
            half_depth_m: layout.surface.half_m().y,
            jitter_rad: self.settings.jitter_rad * if like { 3.0 } else { 1.0 },
            allow_sideways: self.is_late(),
        };
        let yaw_rad = yaw_sampler.yaw_rad(target.center(), &mut self.rng);
        let (turned, _) = own.member_at(here, &Placement { xy_m: DVec2::ZERO, yaw_rad })?;
        let spatial = if constraint.from == group {
            constraint.spatial
        } else {
            let position = match constraint.spatial.position {
                RelativePosition::Toward(angle) => RelativePosition::Toward(angle + std::f64::consts::PI),
                RelativePosition::Beside | RelativePosition::Around { .. } => RelativePosition::Beside,
            };
            SpatialConstraint { position, ..constraint.spatial }
        };
        let center = spatial.candidate(&turned, &target, target_yaw, self.gap_m, &mut self.rng);
        Some(Placement { xy_m: center - turned.center(), yaw_rad })
    }

    /// The cost of a placement; `None` if it is infeasible.
    fn cost(&self, layout: &PartialLayout, group: usize, at: &Placement) -> Option<f64> {
        let own = &layout.groups[group];
        let footprint = own.footprint.placed(at);
        let root = &self.objects[own.root];
        let root_footprint = if own.bases.len() > 1 { footprint.clone() } else { root.footprint.placed(at) };
        if !layout.surface.allows(&footprint, self.margin_m(layout, group)) {
            return None;
        }
        let named = self.table_relations(own).next().is_some();
        let zone = if named { Zone::Any } else { root.category.zone };
        let mut cost = layout.surface.cost(&root_footprint, zone);
        if let Some(setting) = layout.surface.setting_of(own.root).filter(|_| own.bases.len() > 1) {
            cost += 10.0 * at.xy_m.distance(setting.xy_m);
        }
        for (other, placement) in layout.placed.iter().enumerate() {
            let Some(placement) = placement else { continue };
            let obstacle = layout.groups[other].footprint.placed(placement);
            let gap_m = footprint.gap_m(&obstacle);
            if gap_m < self.pair_gap_m(layout, group, other) {
                return None;
            }
            let constrained = layout
                .constraints_of(group)
                .any(|constraint| constraint.from == other || constraint.to == other);
            if !constrained {
                cost += 0.35 * (-gap_m / 0.04).exp();
            }
            let other_height_m = layout.groups[other].height_m;
            cost += occlusion_cost(&footprint, own.height_m, &obstacle, other_height_m)
                + occlusion_cost(&obstacle, other_height_m, &footprint, own.height_m);
        }
        for (base, place) in self.table_relations(own) {
            let center = own.member_at(base, at)?.0.center();
            let is_table = matches!(layout.surface, SupportSurface::Table { .. });
            let is_strict = is_table && self.yielding < Yielding::Places;
            if is_strict && !layout.surface.is_at(center, place, self.tolerance_factor) {
                return None;
            }
            cost += layout.surface.corner_cost(center, place);
        }
        if !self.meets_demands(layout, group, at) {
            return None;
        }
        for constraint in layout.constraints_of(group) {
            let placement = |index: usize| if index == group { Some(*at) } else { layout.placed[index] };
            let from = layout.groups[constraint.from]
                .member_at(constraint.spatial.from, &placement(constraint.from)?)?;
            let to =
                layout.groups[constraint.to].member_at(constraint.spatial.to, &placement(constraint.to)?)?;
            if constraint.spatial.hard
                && !constraint.spatial.holds(&from.0, &to.0, to.1, self.tolerance_factor)
            {
                return None;
            }
            cost += constraint.spatial.cost(&from.0, &to.0, to.1).min(5.0);
        }
        Some(cost + SPACE_WEIGHT_PER_M * self.missing_space_m(layout, group, at))
    }

    /// Relations to the table of the objects of a group that stand on its surface.
    fn table_relations<'b>(&'b self, group: &'b Group) -> impl Iterator<Item = (usize, RelationKind)> + 'b {
        group.bases.iter().flat_map(move |&base| {
            let relations = self.requests[base].relations.iter();
            relations.filter(|(_, target)| target.is_none()).map(move |(kind, _)| (base, *kind))
        })
    }

    /// Space missing beside a group for unplaced objects that the text requires there, meters.
    fn missing_space_m(&self, layout: &PartialLayout, group: usize, at: &Placement) -> f64 {
        let unplaced = layout.constraints.iter().filter(|constraint| {
            constraint.to == group
                && constraint.spatial.hard
                && constraint.spatial.is_on_axis()
                && layout.placed[constraint.from].is_none()
        });
        let missing_m = unplaced.filter_map(|constraint| {
            let (target, yaw_rad) = layout.groups[group].member_at(constraint.spatial.to, at)?;
            let direction = constraint.spatial.position.direction(if constraint.spatial.in_target_frame {
                yaw_rad
            } else {
                0.0
            })?;
            let edge_m = target.center() + target.extent_m(direction) * direction;
            let needed_m = layout.groups[constraint.from].footprint.size_m().min_element() + 2.0 * self.gap_m;
            Some((needed_m - layout.surface.free_distance_m(edge_m, direction, needed_m)).max(0.0))
        });
        missing_m.sum()
    }

    /// Whether this is a late attempt, with larger tolerances.
    pub(super) fn is_late(&self) -> bool {
        self.tolerance_factor > 1.0
    }
}

/// Share of the rear object occluded by the front one, viewed at about 40 degrees elevation, times 1.5: 0..1.5.
fn occlusion_cost(front: &super::Footprint, front_m: f64, behind: &super::Footprint, behind_m: f64) -> f64 {
    const TANGENT: f64 = 0.84;
    let ((front_low, front_high), (low, high)) = (front.bounds(), behind.bounds());
    let way_m = low.y - front_high.y;
    if way_m < -0.02 || front.center().y > behind.center().y {
        return 0.0;
    }
    let shared_m = (front_high.x.min(high.x) - front_low.x.max(low.x)).max(0.0);
    let depth_m = TANGENT * (high.y - low.y);
    let covered_m = (front_m - TANGENT * way_m.max(0.0)).max(0.0);
    let share = (covered_m / (behind_m + depth_m).max(0.01)).min(1.0);
    1.5 * share * shared_m / (high.x - low.x).max(1e-6)
}

impl PartialLayout<'_> {
    /// Constraints of a group whose other end is placed.
    fn constraints_of(&self, group: usize) -> impl Iterator<Item = &GroupConstraint> + '_ {
        self.constraints.iter().filter(move |constraint| {
            (constraint.from == group && self.placed[constraint.to].is_some())
                || (constraint.to == group && self.placed[constraint.from].is_some())
        })
    }

    /// Whether other objects are placed in this object's frame (cutlery beside a plate).
    fn has_setting(&self, object: usize) -> bool {
        self.constraints
            .iter()
            .any(|constraint| constraint.spatial.to == object && constraint.spatial.in_target_frame)
    }

    /// Whether a group is aligned with the front edge, because its own left and right are constrained.
    fn must_be_axis_aligned(&self, requests: &[super::LayoutObject], group: &Group) -> bool {
        let directed = |kind: RelationKind| {
            use RelationKind::{AtBack, AtFront, AtLeft, AtRight, Behind, InFrontOf, LeftOf, RightOf};
            matches!(kind, LeftOf | RightOf | InFrontOf | Behind | AtBack | AtFront | AtLeft | AtRight)
        };
        let carries_directed = group.members.iter().filter(|m| m.object != group.root).any(|member| {
            requests[member.object].relations.iter().any(|(kind, target)| {
                directed(*kind) && target.is_some_and(|t| group.members.iter().any(|m| m.object == t))
            })
        });
        self.has_setting(group.root) || carries_directed
    }

    /// The group that holds an object.
    pub fn group_of(&self, object: usize) -> Option<usize> {
        self.groups.iter().position(|group| group.members.iter().any(|member| member.object == object))
    }

    /// Placement order: groups whose position is stated first, then large groups, each followed by the groups
    /// constrained to it.
    fn order(&self, demands: &[Demand]) -> Vec<usize> {
        let mut by_size: Vec<usize> = (0..self.groups.len()).collect();
        by_size.sort_by(|&a, &b| {
            self.groups[b].footprint.area_m2().total_cmp(&self.groups[a].footprint.area_m2()).then(a.cmp(&b))
        });
        let mut order = Vec::new();
        let mut visited = vec![false; self.groups.len()];
        let is_pinned = |group: usize| {
            let pins =
                |demand: &Demand| demand.kind.is_pinning() && self.group_of(demand.object) == Some(group);
            demands.iter().any(pins)
        };
        for &group in by_size.iter().filter(|group| is_pinned(**group)) {
            // Its other demands may need their targets; a target that is pinned too does not wait for it.
            for target in self.demanded_by(demands, group).filter(|target| !is_pinned(*target)) {
                self.visit(target, &by_size, demands, &mut visited, &mut order);
            }
            if !std::mem::replace(&mut visited[group], true) {
                order.push(group);
            }
        }
        for group in &by_size {
            self.visit(*group, &by_size, demands, &mut visited, &mut order);
        }
        order
    }

    /// Other groups that the demands on a group need for its direction or for a place between them.
    fn demanded_by<'b>(&'b self, demands: &'b [Demand], group: usize) -> impl Iterator<Item = usize> + 'b {
        demands
            .iter()
            .filter(move |demand| self.group_of(demand.object) == Some(group))
            .filter(|demand| !matches!(demand.kind, DemandKind::Distance { .. }))
            .flat_map(|demand| demand.kind.targets())
            .flatten()
            .filter_map(|target| self.group_of(target))
            .filter(move |target| *target != group)
    }

    fn visit(
        &self,
        group: usize,
        by_size: &[usize],
        demands: &[Demand],
        visited: &mut [bool],
        order: &mut Vec<usize>,
    ) {
        if std::mem::replace(&mut visited[group], true) {
            return;
        }
        for constraint in self.constraints.iter().filter(|constraint| constraint.from == group) {
            self.visit(constraint.to, by_size, demands, visited, order);
        }
        for target in self.demanded_by(demands, group) {
            self.visit(target, by_size, demands, visited, order);
        }
        order.push(group);
        // An object between two others comes right after them, before its place is taken.
        for demand in demands.iter().filter(|demand| matches!(demand.kind, DemandKind::Between { .. })) {
            let ends = demand.kind.targets().map(|end| end.and_then(|end| self.group_of(end)));
            if ends.contains(&Some(group))
                && ends.iter().all(|end| end.is_some_and(|end| order.contains(&end)))
                && let Some(object) = self.group_of(demand.object)
            {
                self.visit(object, by_size, demands, visited, order);
            }
        }
        // Axis-aligned constraints come before those with more freedom.
        for on_axis in [true, false] {
            for &other in by_size {
                let constrained =
                    |constraint: &&GroupConstraint| constraint.to == group && constraint.from == other;
                if self
                    .constraints
                    .iter()
                    .filter(constrained)
                    .any(|constraint| constraint.spatial.is_on_axis() == on_axis)
                {
                    self.visit(other, by_size, demands, visited, order);
                }
            }
        }
    }
}
