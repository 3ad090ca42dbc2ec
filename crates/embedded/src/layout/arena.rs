//! Placing groups one after the other on a surface: draw candidates, drop the impossible, take the
//! cheapest.

use glam::DVec2;
use rand::RngExt;

use super::Placement;
use super::ground::Ground;
use super::group::{Group, Grouping};
use super::habits::Turning;
use super::links::{Link, Spot};
use catalog::Zone;
use scene::RelationKind;

/// Cost of room that is missing for what is to stand at a side, per meter.
const ROOM_WEIGHT_PER_M: f64 = 30.0;

/// A link between two groups of one surface.
#[derive(Clone, Copy)]
struct Tie {
    link: Link,
    from: usize,
    to: usize,
}

/// What is placed so far.
struct Board<'a> {
    ground: &'a Ground<'a>,
    groups: &'a [Group],
    ties: Vec<Tie>,
    placed: Vec<Option<Placement>>,
}

impl Grouping<'_> {
    /// A placement for each group; the error is the thing that found no place.
    pub fn place_all(&mut self, ground: &Ground, groups: &[Group]) -> Result<Vec<Placement>, usize> {
        let group_of =
            |thing: usize| groups.iter().position(|group| group.members.iter().any(|m| m.thing == thing));
        let ties = self
            .links
            .iter()
            .filter_map(|&link| {
                let (from, to) = (group_of(link.from)?, group_of(link.to)?);
                (from != to).then_some(Tie { link, from, to })
            })
            .collect();
        let mut board = Board { ground, groups, ties, placed: vec![None; groups.len()] };
        for group in board.order() {
            match self.best_place(&board, group) {
                Some(placement) => board.placed[group] = Some(placement),
                None => return Err(groups[group].root),
            }
        }
        Ok(board.placed.into_iter().flatten().collect())
    }

    fn best_place(&mut self, board: &Board, group: usize) -> Option<Placement> {
        let mut best: Option<(f64, Placement)> = None;
        for number in 0..self.settings.candidates {
            let placement = self.candidate(board, group, number);
            let Some(cost) = self.cost(board, group, &placement) else { continue };
            let cost = cost + self.settings.whim * self.rng.random_range(0.0..1.0);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, placement));
            }
        }
        best.map(|(_, placement)| placement)
    }

    fn candidate(&mut self, board: &Board, group: usize, number: u32) -> Placement {
        let own = &board.groups[group];
        let root = &self.things[own.root];
        let half_depth_m = board.ground.half_m().y;
        let sideways_too = self.is_late();
        let turning = |follows_rad: Option<f64>, jitter: f64| Turning {
            thing: root,
            follows_rad,
            half_depth_m,
            jitter_rad: jitter * self.settings.jitter_rad,
            sideways_too,
        };
        let places: Vec<RelationKind> = self.wishes[own.root]
            .relations
            .iter()
            .filter(|(kind, target)| target.is_none() && !kind.is_support())
            .map(|(kind, _)| *kind)
            .collect();
        let ties: Vec<&Tie> = board.ties_of(group).collect();
        if let Ground::Table { seats, .. } = board.ground
            && let Some((_, seat)) = seats.iter().find(|(thing, _)| *thing == own.root)
        {
            let mut at = *seat;
            let drift = 0.03 + 0.002 * f64::from(number);
            at.xy_m.x += drift * self.rng.random_range(-1.0..1.0);
            at.xy_m.y += drift * self.rng.random_range(-1.0..1.0);
            return at;
        }
        if !ties.is_empty() && (places.is_empty() || number.is_multiple_of(2)) && self.rng.random_bool(0.88) {
            let firm: Vec<&&Tie> = ties.iter().filter(|tie| tie.link.firm).collect();
            let pick = |count: usize, rng: &mut runtime::seed::Rng| rng.random_range(0..count);
            let tie = if !firm.is_empty() && self.rng.random_bool(0.6) {
                **firm[pick(firm.len(), &mut self.rng)]
            } else {
                *ties[pick(ties.len(), &mut self.rng)]
            };
            if let Some(at) = self.tied_candidate(board, group, tie) {
                return at;
            }
        }
        let named = if places.is_empty() {
            None
        } else {
            board.ground.named_candidate(places[number as usize % places.len()], &mut self.rng)
        };
        let zone = if places.is_empty() { root.category.zone } else { Zone::Any };
        let xy_m = named.unwrap_or_else(|| board.ground.candidate(zone, &mut self.rng));
        let follows = board.must_face_front(self.wishes, own).then_some(0.0);
        let yaw_rad = turning(follows, 1.0).yaw_rad(xy_m, &mut self.rng);
        Placement { xy_m, yaw_rad }
    }

    /// A place at the spot the tie names, whichever end of it is placed.
    fn tied_candidate(&mut self, board: &Board, group: usize, tie: Tie) -> Option<Placement> {
        let own = &board.groups[group];
        let root = &self.things[own.root];
        let (here, there, other) = if tie.from == group {
            (tie.link.from, tie.link.to, tie.to)
        } else {
            (tie.link.to, tie.link.from, tie.from)
        };
        let (target, target_yaw) = board.groups[other].member_at(there, &board.placed[other]?)?;
        let like = self.things[own.root].category.name == self.things[there].category.name;
        let outward = tie.link.spot.direction(target_yaw).map(|d| d.to_angle() + 0.5 * std::f64::consts::PI);
        let follows = if matches!(tie.link.spot, Spot::Around { .. }) && board.is_hosted(own.root) {
            outward
        } else if tie.link.turns || (board.is_hosted(there) && root.slenderness() > 1.8) {
            Some(target_yaw)
        } else if (like && root.slenderness() > 1.8) || board.must_face_front(self.wishes, own) {
            Some(if like { target_yaw } else { 0.0 })
        } else {
            None
        };
        let turning = Turning {
            thing: root,
            follows_rad: follows,
            half_depth_m: board.ground.half_m().y,
            jitter_rad: self.settings.jitter_rad * if like { 3.0 } else { 1.0 },
            sideways_too: self.is_late(),
        };
        let yaw_rad = turning.yaw_rad(target.center(), &mut self.rng);
        let (turned, _) = own.member_at(here, &Placement { xy_m: DVec2::ZERO, yaw_rad })?;
        let link = if tie.from == group {
            tie.link
        } else {
            let spot = match tie.link.spot {
                Spot::Toward(angle) => Spot::Toward(angle + std::f64::consts::PI),
                Spot::Beside | Spot::Around { .. } => Spot::Beside,
            };
            Link { spot, ..tie.link }
        };
        let center = link.candidate(&turned, &target, target_yaw, self.gap_m, &mut self.rng);
        Some(Placement { xy_m: center - turned.center(), yaw_rad })
    }

    /// What the place costs; `None` where the group cannot stand so.
    fn cost(&self, board: &Board, group: usize, at: &Placement) -> Option<f64> {
        let own = &board.groups[group];
        let footprint = own.footprint.placed(at);
        let root = &self.things[own.root];
        let standing = root.footprint.placed(at);
        if !board.ground.allows(&footprint) {
            return None;
        }
        let named = self.wishes[own.root].relations.iter().any(|(_, target)| target.is_none());
        let zone = if named { Zone::Any } else { root.category.zone };
        let mut cost = board.ground.cost(&standing, zone);
        for (other, placement) in board.placed.iter().enumerate() {
            let Some(placement) = placement else { continue };
            let obstacle = board.groups[other].footprint.placed(placement);
            let gap_m = footprint.gap_m(&obstacle);
            if gap_m < self.gap_m {
                return None;
            }
            let tied = board.ties_of(group).any(|tie| tie.from == other || tie.to == other);
            if !tied {
                cost += 0.35 * (-gap_m / 0.04).exp();
            }
            let other_height_m = board.groups[other].height_m;
            cost += hidden(&footprint, own.height_m, &obstacle, other_height_m)
                + hidden(&obstacle, other_height_m, &footprint, own.height_m);
        }
        let places = self.wishes[own.root].relations.iter().filter(|(_, target)| target.is_none());
        let misplaced = places
            .clone()
            .filter(|(kind, _)| !board.ground.is_at(standing.center(), *kind, self.slack))
            .count();
        if misplaced > 0 && matches!(board.ground, Ground::Table { .. }) {
            return None;
        }
        for tie in board.ties_of(group) {
            let placement = |index: usize| if index == group { Some(*at) } else { board.placed[index] };
            let from = board.groups[tie.from].member_at(tie.link.from, &placement(tie.from)?)?;
            let to = board.groups[tie.to].member_at(tie.link.to, &placement(tie.to)?)?;
            if tie.link.firm && !tie.link.holds(&from.0, &to.0, to.1, self.slack) {
                return None;
            }
            cost += tie.link.cost(&from.0, &to.0, to.1).min(5.0);
        }
        Some(cost + ROOM_WEIGHT_PER_M * self.missing_room_m(board, group, at))
    }

    /// How much is missing at the sides of a group for what the text wants there and is not placed yet, meters.
    fn missing_room_m(&self, board: &Board, group: usize, at: &Placement) -> f64 {
        let waiting = board.ties.iter().filter(|tie| {
            tie.to == group && tie.link.firm && tie.link.is_at_a_side() && board.placed[tie.from].is_none()
        });
        let missing_m = waiting.filter_map(|tie| {
            let (target, yaw_rad) = board.groups[group].member_at(tie.link.to, at)?;
            let direction = tie.link.spot.direction(if tie.link.turns { yaw_rad } else { 0.0 })?;
            let edge_m = target.center() + target.reach_m(direction) * direction;
            let needed_m = board.groups[tie.from].footprint.size_m().min_element() + 2.0 * self.gap_m;
            Some((needed_m - board.ground.room_m(edge_m, direction, needed_m)).max(0.0))
        });
        missing_m.sum()
    }

    /// Whether earlier attempts found no arrangement: relations are then read more loosely.
    fn is_late(&self) -> bool {
        self.slack > 1.0
    }
}

/// How much of the thing behind the one in front hides, seen from about 40 degrees up: 0..1.5.
fn hidden(front: &super::Footprint, front_m: f64, behind: &super::Footprint, behind_m: f64) -> f64 {
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

impl Board<'_> {
    /// Ties of a group whose other end is placed.
    fn ties_of(&self, group: usize) -> impl Iterator<Item = &Tie> + '_ {
        self.ties.iter().filter(move |tie| {
            (tie.from == group && self.placed[tie.to].is_some())
                || (tie.to == group && self.placed[tie.from].is_some())
        })
    }

    /// Whether something lies at a place this thing makes (cutlery beside a plate).
    fn is_hosted(&self, thing: usize) -> bool {
        self.ties.iter().any(|tie| tie.link.to == thing && tie.link.turns)
    }

    /// Things whose own left and right matter stand square to the front edge.
    fn must_face_front(&self, wishes: &[super::Thing], group: &Group) -> bool {
        let directed = |kind: RelationKind| {
            use RelationKind::{AtBack, AtFront, AtLeft, AtRight, Behind, InFrontOf, LeftOf, RightOf};
            matches!(kind, LeftOf | RightOf | InFrontOf | Behind | AtBack | AtFront | AtLeft | AtRight)
        };
        let carries_directed = group.members.iter().filter(|m| m.thing != group.root).any(|member| {
            wishes[member.thing].relations.iter().any(|(kind, target)| {
                directed(*kind) && target.is_some_and(|t| group.members.iter().any(|m| m.thing == t))
            })
        });
        self.is_hosted(group.root) || carries_directed
    }

    /// Groups in the order of placing: large ones first, each followed by what belongs to it.
    fn order(&self) -> Vec<usize> {
        let mut by_size: Vec<usize> = (0..self.groups.len()).collect();
        by_size.sort_by(|&a, &b| {
            self.groups[b].footprint.area_m2().total_cmp(&self.groups[a].footprint.area_m2()).then(a.cmp(&b))
        });
        let mut order = Vec::new();
        let mut seen = vec![false; self.groups.len()];
        for group in &by_size {
            self.visit(*group, &by_size, &mut seen, &mut order);
        }
        order
    }

    fn visit(&self, group: usize, by_size: &[usize], seen: &mut [bool], order: &mut Vec<usize>) {
        if std::mem::replace(&mut seen[group], true) {
            return;
        }
        for tie in self.ties.iter().filter(|tie| tie.from == group) {
            self.visit(tie.to, by_size, seen, order);
        }
        order.push(group);
        // What must lie right beside it comes before what may stand farther off.
        for close in [true, false] {
            for &other in by_size {
                let tied = |tie: &&Tie| tie.to == group && tie.from == other;
                if self.ties.iter().filter(tied).any(|tie| tie.link.is_at_a_side() == close) {
                    self.visit(other, by_size, seen, order);
                }
            }
        }
    }
}
