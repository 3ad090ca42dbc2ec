//! A thing with everything it carries, laid out and moved as one.

use glam::{DQuat, DVec2};
use rand::RngExt;

use super::ground::Ground;
use super::links::Link;
use super::seats;
use super::tree::Carrier;
use super::{Footprint, LayoutSettings, Placement, Prepared, Thing, container};
use geometry::Outline;
use runtime::seed::Rng;
use scene::RelationKind;

/// One thing of a group.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub thing: usize,
    /// In the group's frame.
    pub at: Placement,
    /// Applied before the yaw: what leans in a container.
    pub lean: DQuat,
    /// In the group's frame.
    pub footprint: Footprint,
}

/// Things that move together.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// The one that stands on the ground; its frame is the group's.
    pub root: usize,
    pub members: Vec<Member>,
    pub footprint: Footprint,
    pub height_m: f64,
}

/// One attempt.
pub(super) struct Grouping<'a> {
    pub things: &'a [Prepared<'a>],
    pub carriers: &'a [Option<Carrier>],
    pub links: &'a [Link],
    pub wishes: &'a [Thing<'a>],
    pub settings: &'a LayoutSettings,
    pub gap_m: f64,
    /// 1 = relations as they are meant, more = looser.
    pub slack: f64,
    pub rng: Rng,
}

impl Grouping<'_> {
    /// Groups on the table and where they stand; the error is the thing that found no place.
    pub fn arrange_on(&mut self, outline: &Outline) -> Result<Vec<(Placement, Group)>, usize> {
        let roots: Vec<usize> = (0..self.things.len()).filter(|&k| self.carriers[k].is_none()).collect();
        let groups = roots.into_iter().map(|root| self.gather(root)).collect::<Result<Vec<_>, _>>()?;
        let margin_m = self.settings.edge_margin_m;
        let ground = Ground::Table {
            outline,
            margin_m,
            seats: seats::seats(self.wishes, self.carriers, self.things, outline, margin_m + 0.004),
        };
        let placements = self.place_all(&ground, &groups)?;
        Ok(placements.into_iter().zip(groups).collect())
    }

    fn children(&self, parent: usize, inside: bool) -> Vec<usize> {
        let carried = Some(Carrier { parent, inside });
        (0..self.things.len()).filter(|&k| self.carriers[k] == carried).collect()
    }

    /// A thing with all it carries.
    fn gather(&mut self, root: usize) -> Result<Group, usize> {
        let own = &self.things[root];
        let origin = Placement { xy_m: DVec2::ZERO, yaw_rad: 0.0 };
        let mut group = Group {
            root,
            members: vec![Member {
                thing: root,
                at: origin,
                lean: DQuat::IDENTITY,
                footprint: own.footprint.clone(),
            }],
            footprint: own.footprint.clone(),
            height_m: own.height_m,
        };
        let contained = self.children(root, true);
        for (at, lean, child) in container::stow(self, root, &contained) {
            let inner = self.gather(child)?;
            let rise_m = if lean == DQuat::IDENTITY { inner.height_m } else { own.height_m };
            group.take(self.things, inner, at, lean);
            group.height_m = group.height_m.max(0.4 * own.height_m + rise_m);
        }
        let carried = self.children(root, false);
        let inner = carried.iter().map(|&child| self.gather(child)).collect::<Result<Vec<_>, _>>()?;
        let placements = self.place_on(root, &inner)?;
        let base_m = own.height_m;
        for (placement, inner) in placements.into_iter().zip(inner) {
            group.height_m = group.height_m.max(base_m + inner.height_m);
            group.take(self.things, inner, placement, DQuat::IDENTITY);
        }
        group.footprint = Footprint::union(group.members.iter().map(|member| &member.footprint));
        Ok(group)
    }

    /// Where groups stand on a thing, in its frame.
    fn place_on(&mut self, root: usize, groups: &[Group]) -> Result<Vec<Placement>, usize> {
        let things = self.things;
        let own = &things[root];
        let Some(relief) = own.relief.as_ref().filter(|_| !groups.is_empty()) else { return Ok(Vec::new()) };
        let piled = |group: &Group| {
            self.wishes[group.root].relations.contains(&(RelationKind::StackedOn, Some(root)))
        };
        if groups.len() == 1 && piled(&groups[0]) {
            let careless = 0.03 * own.footprint.size_m();
            let shift = DVec2::new(self.rng.random_range(-1.0..1.0), self.rng.random_range(-1.0..1.0));
            let turn_rad = 2.0 * self.settings.jitter_rad * self.rng.random_range(-1.0..1.0);
            let xy_m = own.footprint.center() + careless * shift - groups[0].footprint.center();
            return Ok(vec![Placement { xy_m, yaw_rad: turn_rad }]);
        }
        let ground = Ground::Top { footprint: &own.footprint, relief };
        let close = self.gap_m;
        self.gap_m = self.settings.least_gap_m;
        let placed = self.place_all(&ground, groups);
        self.gap_m = close;
        // What finds no free place lies on top of the others.
        Ok(placed.unwrap_or_else(|_| self.heap_on(own, groups)))
    }

    fn heap_on(&mut self, own: &Prepared, groups: &[Group]) -> Vec<Placement> {
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
    /// Adds the members of a group that stands at `at` in this one's frame.
    fn take(&mut self, things: &[Prepared], inner: Group, at: Placement, lean: DQuat) {
        for member in inner.members {
            let at = at.then(&member.at);
            let lean = (lean * member.lean).normalize();
            let footprint = if lean == DQuat::IDENTITY {
                things[member.thing].footprint.placed(&at)
            } else {
                let turned = things[member.thing].mesh.positions.iter().map(|p| (lean * *p).truncate());
                Footprint::around(turned).placed(&at)
            };
            self.members.push(Member { thing: member.thing, at, lean, footprint });
        }
    }

    /// Footprint of a member when the group stands at `at`.
    pub fn member_at(&self, thing: usize, at: &Placement) -> Option<(Footprint, f64)> {
        let member = self.members.iter().find(|member| member.thing == thing)?;
        Some((member.footprint.placed(at), at.yaw_rad + member.at.yaw_rad))
    }
}
