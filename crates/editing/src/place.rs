//! The search for a free place: a grid over a surface, by yaw, with the hulls of everything else as obstacles.
//!
//! The search is exhaustive within its grid (1 cm, and 5 mm where that finds nothing; 16 yaws), so that a refusal
//! means that there is no room. Candidates are ordered by how well they fit the relation; the caller lets them come to
//! rest in this order ([`crate::rest`]). World frame, meters, radians.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec2, DVec3};
use rayon::prelude::*;

use crate::workspace::{Workspace, WorkspaceObject};
use geometry::drop_cast::{PosedShape, are_closer, drop_height};
use geometry::polygon::depth_in_convex_m;
use geometry::pose::wrap_angle_rad;
use geometry::Pose;
use scene::predicates::{PosedFootprint, PosedRelation, direction_of, edge_distance_m, holds};
use scene::{RelationKind, SupportRelation, Supporter};

/// Free space that the search keeps around an object where there is enough of it, and at least.
const CLEARANCES_M: [f64; 2] = [0.01, 0.003];

/// Grid steps, meters.
const STEPS_M: [f64; 2] = [0.01, 0.005];

/// Yaws of the search.
const YAWS: usize = 16;

/// Distance from the table's edge that everything keeps.
const EDGE_MARGIN_M: f64 = 0.005;

/// Height at which an object is let go above its supporter.
const DROP_GAP_M: f64 = 0.0005;

/// Most candidates of one search.
const MAX_CANDIDATES: usize = 12;

/// Free distance that a directed relation without a stated one aims at.
const USUAL_GAP_M: f64 = 0.04;

/// An object longer than this many times its second extent may stand upright in a container.
const SLENDERNESS: f64 = 2.0;

/// Lean of slender objects in a container from the vertical, radians.
const LEAN_RAD: f64 = 0.22;

/// Where an object is to be.
#[derive(Clone, Debug, Default)]
pub struct PlaceQuery {
    /// `None` for anywhere on the table, or for `position_m`.
    pub relation: Option<RelationKind>,
    pub target: Option<usize>,
    pub second_target: Option<usize>,
    /// Stated free distance to the target or edge.
    pub distance_m: Option<f64>,
    /// Stated center on the table.
    pub position_m: Option<DVec2>,
    /// Stated yaw.
    pub yaw_rad: Option<f64>,
    /// Where it would best be, if there is room: the place that it has now.
    pub near_m: Option<DVec2>,
    /// The yaw to prefer where none is stated.
    pub usual_yaw_rad: f64,
}

/// A pose from which an object may come to rest.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    pub world_from_object: Pose,
    pub supporter: Supporter,
}

/// There is no free place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoPlace {
    #[error("{object} does not fit {place}: it is larger than the space there")]
    TooLarge { object: String, place: String },
    #[error("there is no free place {place} for {object}: {} in the way", blockers(.by))]
    Blocked { object: String, place: String, by: Vec<String> },
}

fn blockers(by: &[String]) -> String {
    match by {
        [] => "the edge of the table is".to_owned(),
        [only] => format!("{only} is"),
        [first, last] => format!("{first} and {last} are"),
        [first, second, ..] => format!("{first}, {second} and others are"),
    }
}

/// A feasible place of the grid.
struct Scored {
    cost: f64,
    pose: Pose,
}

impl Workspace {
    /// Places where an object may be let down, the best first; at least one.
    ///
    /// # Errors
    ///
    /// [`NoPlace`] if no place of the grid is free.
    pub fn places(&self, object: usize, query: &PlaceQuery) -> Result<Vec<Candidate>, NoPlace> {
        let mut blocked_by: Vec<usize> = Vec::new();
        let mut fits_nowhere = true;
        for supporter in self.surfaces(query) {
            for clearance_m in CLEARANCES_M {
                for step_m in STEPS_M {
                    let search = Search::new(self, object, query, supporter, clearance_m, step_m);
                    let found = search.run(&mut blocked_by);
                    fits_nowhere &= !found.has_fitted;
                    if !found.candidates.is_empty() {
                        return Ok(found.candidates);
                    }
                    // A container has few places, and the finer grid covers those of the coarser one.
                    if supporter.relation == SupportRelation::In {
                        continue;
                    }
                }
            }
        }
        let (object, place) = (self.objects[object].body.name.clone(), self.place_in_words(query));
        if fits_nowhere {
            return Err(NoPlace::TooLarge { object, place });
        }
        blocked_by.sort_unstable();
        blocked_by.dedup();
        let by = blocked_by.into_iter().map(|other| self.objects[other].body.name.clone()).collect();
        Err(NoPlace::Blocked { object, place, by })
    }

    /// The place straight below or above a pose: same position and orientation in the plane, let down onto the
    /// supporter.
    ///
    /// # Errors
    ///
    /// [`NoPlace`] if the object would reach over the table's edge, or into another one.
    pub fn place_at(
        &self,
        object: usize,
        world_from_object: Pose,
        supporter: Supporter,
    ) -> Result<Candidate, NoPlace> {
        let query = PlaceQuery::default();
        let search = Search::new(self, object, &query, supporter, 0.001, STEPS_M[0]);
        let rotation = world_from_object.rotation;
        let (low, high) = search.object.shape.bounds(&Pose { translation_m: DVec3::ZERO, rotation });
        let center_m = world_from_object.translation_m.truncate() + 0.5 * (low + high).truncate();
        let name = || self.objects[object].body.name.clone();
        let place = || "where it is".to_owned();
        let scored = search.posed(rotation, center_m);
        let pose = scored.ok_or_else(|| NoPlace::TooLarge { object: name(), place: place() })?;
        match search.obstacle_of(&pose) {
            None => Ok(Candidate { world_from_object: pose, supporter }),
            Some(other) => {
                let by = vec![self.objects[other].body.name.clone()];
                Err(NoPlace::Blocked { object: name(), place: place(), by })
            }
        }
    }

    /// The surfaces to search, in order.
    fn surfaces(&self, query: &PlaceQuery) -> Vec<Supporter> {
        match (query.relation, query.target) {
            (Some(RelationKind::On | RelationKind::StackedOn), Some(target)) => vec![Supporter::on(target)],
            (Some(RelationKind::In), Some(target)) => vec![Supporter::containing(target)],
            (Some(_), Some(target)) => {
                let beside = self.surface_beside(target);
                if beside == Supporter::TABLE { vec![beside] } else { vec![beside, Supporter::TABLE] }
            }
            _ => vec![Supporter::TABLE],
        }
    }

    /// The place in words, for messages.
    pub fn place_in_words(&self, query: &PlaceQuery) -> String {
        let name = |index: Option<usize>| match index {
            Some(index) => self.objects[index].body.name.clone(),
            None => "the table".to_owned(),
        };
        match query.relation {
            None if query.position_m.is_some() => "at the stated position".to_owned(),
            None => "on the table".to_owned(),
            Some(RelationKind::Between) => {
                format!("between {} and {}", name(query.target), name(query.second_target))
            }
            Some(relation) => {
                let words = serde_json::to_value(relation).ok();
                let words = words.as_ref().and_then(|value| value.as_str()).unwrap_or("at").replace('_', " ");
                match query.target {
                    Some(_) => format!("{words} {}", name(query.target)),
                    None => format!("{words} of the table"),
                }
            }
        }
    }
}

/// One pass over the grid of one surface.
struct Search<'a> {
    workspace: &'a Workspace,
    object: &'a WorkspaceObject,
    query: &'a PlaceQuery,
    supporter: Supporter,
    clearance_m: f64,
    step_m: f64,
    /// The object and what rests on it, in the object's frame of now.
    branch: Vec<usize>,
    /// What may be in the way.
    obstacles: Vec<usize>,
    target: Option<PosedFootprint>,
    second_target: Option<PosedFootprint>,
    surface: Option<PosedFootprint>,
}

struct Found {
    candidates: Vec<Candidate>,
    /// Whether the object fits on the surface if nothing else is there.
    has_fitted: bool,
}

impl<'a> Search<'a> {
    fn new(
        workspace: &'a Workspace,
        object: usize,
        query: &'a PlaceQuery,
        supporter: Supporter,
        clearance_m: f64,
        step_m: f64,
    ) -> Self {
        let branch = workspace.branch(object);
        let obstacles = (0..workspace.objects.len())
            .filter(|other| workspace.objects[*other].is_placed && !branch.contains(other))
            .collect();
        let footprint = |index: Option<usize>| index.map(|index| workspace.objects[index].footprint());
        Self {
            workspace,
            object: &workspace.objects[object],
            query,
            supporter,
            clearance_m,
            step_m,
            branch,
            obstacles,
            target: footprint(query.target),
            second_target: footprint(query.second_target),
            surface: footprint(supporter.parent),
        }
    }

    fn is_container(&self) -> bool {
        self.supporter.relation == SupportRelation::In && self.supporter.parent.is_some()
    }

    fn run(&self, blocked_by: &mut Vec<usize>) -> Found {
        let mut found = Found { candidates: Vec::new(), has_fitted: false };
        for rotation in self.rotations() {
            let mut fitting = self.fitting(rotation);
            found.has_fitted |= !fitting.is_empty();
            fitting.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            // Free ones among the best; the whole grid is looked at before the next yaw is.
            for chunk in fitting.chunks(64) {
                let hindered: Vec<Option<usize>> =
                    chunk.par_iter().map(|scored| self.obstacle_of(&scored.pose)).collect();
                for (scored, obstacle) in chunk.iter().zip(hindered) {
                    match obstacle {
                        None => found.candidates.push(Candidate {
                            world_from_object: scored.pose,
                            supporter: self.supporter,
                        }),
                        Some(other) => blocked_by.push(other),
                    }
                }
                if found.candidates.len() >= MAX_CANDIDATES {
                    found.candidates.truncate(MAX_CANDIDATES);
                    return found;
                }
            }
            // A container may need another orientation.
            if !found.candidates.is_empty() && !self.is_container() {
                return found;
            }
        }
        found
    }

    /// Orientations, the preferred one first.
    fn rotations(&self) -> Vec<DQuat> {
        let usual_rad = self.query.yaw_rad.unwrap_or(self.query.usual_yaw_rad);
        let upright = |yaw_rad: f64| {
            // The object keeps how it lies or stands; only its yaw changes.
            let now = self.object.body.world_from_object.rotation;
            let now_rad = self.object.body.world_from_object.yaw_rad().unwrap_or(0.0);
            (DQuat::from_rotation_z(wrap_angle_rad(yaw_rad - now_rad)) * now).normalize()
        };
        let mut rotations = Vec::new();
        if self.is_container() {
            rotations.extend(self.leaning());
        }
        if self.query.yaw_rad.is_some() {
            rotations.push(upright(usual_rad));
            return rotations;
        }
        let mut turns: Vec<f64> =
            (0..YAWS).map(|k| wrap_angle_rad(TAU * k as f64 / YAWS as f64)).collect();
        // Small turns first, then those that keep the edges parallel.
        turns.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        rotations.extend(turns.into_iter().map(|turn_rad| upright(usual_rad + turn_rad)));
        rotations
    }

    /// Orientations of a slender object in a container: its long axis nearly vertical, leaning to eight sides.
    fn leaning(&self) -> Vec<DQuat> {
        let (low, high) = self.object.shape.bounds(&Pose::IDENTITY);
        let size = high - low;
        let mut extents = size.to_array();
        extents.sort_by(f64::total_cmp);
        if extents[2] < SLENDERNESS * extents[1] {
            return Vec::new();
        }
        let axis = if size.x >= size.y && size.x >= size.z {
            DVec3::X
        } else if size.y >= size.z {
            DVec3::Y
        } else {
            DVec3::Z
        };
        (0..8)
            .flat_map(|k| {
                let toward = DVec2::from_angle(TAU * f64::from(k) / 8.0);
                let up = DVec3::Z * LEAN_RAD.cos() + toward.extend(0.0) * LEAN_RAD.sin();
                [axis, -axis].map(|axis| DQuat::from_rotation_arc(axis, up))
            })
            .collect()
    }

    /// Every place of the grid where the object meets the query, without regard to obstacles.
    fn fitting(&self, rotation: DQuat) -> Vec<Scored> {
        let (low, high) = match &self.surface {
            Some(surface) => surface.bounds(),
            None => self.workspace.outline.bounds(),
        };
        if let Some(position_m) = self.query.position_m {
            return self.scored(rotation, position_m).into_iter().collect();
        }
        let cells = ((high - low) / self.step_m).ceil().max(DVec2::ONE);
        let (columns, rows) = (cells.x as usize + 1, cells.y as usize + 1);
        (0..columns * rows)
            .into_par_iter()
            .filter_map(|cell| {
                let at = DVec2::new((cell % columns) as f64, (cell / columns) as f64);
                self.scored(rotation, low + self.step_m * at)
            })
            .collect()
    }

    /// The object with the center of its footprint at a point, let down onto the surface; `None` beyond its edge.
    fn posed(&self, rotation: DQuat, center_m: DVec2) -> Option<Pose> {
        let at_origin = Pose { translation_m: DVec3::ZERO, rotation };
        let (low, high) = self.object.shape.bounds(&at_origin);
        let offset_m = 0.5 * (low + high).truncate();
        let xy_m = center_m - offset_m;
        let mut pose = Pose { translation_m: xy_m.extend(DROP_GAP_M - low.z), rotation };
        match self.supporter.parent {
            None => {
                let corner_depth_m = |corner: DVec2| self.workspace.outline.depth_inside_m(corner);
                let half_m = 0.5 * (high - low).truncate();
                // The box is tested first, as most places of the grid are well inside.
                let is_inside = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .into_iter()
                    .all(|(x, y)| corner_depth_m(center_m + half_m * DVec2::new(x, y)) >= EDGE_MARGIN_M);
                let is_inside = is_inside
                    || self
                        .object
                        .footprint_at(&pose)
                        .corners()
                        .iter()
                        .all(|corner| corner_depth_m(*corner) >= EDGE_MARGIN_M);
                if !is_inside {
                    return None;
                }
            }
            Some(parent) => {
                let surface = self.surface.as_ref()?;
                if depth_in_convex_m(surface.corners(), center_m) < 0.0 {
                    return None;
                }
                let below = &self.workspace.objects[parent];
                let mut supporters = vec![below.posed()];
                if self.is_container() {
                    let contents = self.obstacles.iter().map(|other| &self.workspace.objects[*other]);
                    supporters.extend(
                        contents
                            .filter(|other| other.supporter.parent == Some(parent))
                            .map(WorkspaceObject::posed),
                    );
                }
                let z_m = drop_height(&self.object.shape, rotation, xy_m, &supporters)?;
                pose.translation_m.z = z_m + DROP_GAP_M;
            }
        }
        Some(pose)
    }

    /// The object with the center of its footprint at a point, if that meets the query.
    fn scored(&self, rotation: DQuat, center_m: DVec2) -> Option<Scored> {
        let pose = self.posed(rotation, center_m)?;
        let footprint = self.object.footprint_at(&pose);
        if self.is_container() {
            let rim_m = self.surface.as_ref()?.top_m;
            if footprint.bottom_m >= rim_m - 0.003 {
                return None;
            }
            let surface = self.surface.as_ref()?;
            let off_m = surface.center().distance(center_m);
            return Some(Scored { cost: 4.0 * footprint.bottom_m + off_m, pose });
        }
        self.cost(&footprint).map(|cost| Scored { cost, pose })
    }

    /// How far a place is from the ideal one, meters; `None` if the relation does not hold there.
    fn cost(&self, footprint: &PosedFootprint) -> Option<f64> {
        let outline = &self.workspace.outline;
        let center = footprint.center();
        let away_m = self.query.near_m.map_or(0.0, |near_m| near_m.distance(center));
        let Some(kind) = self.query.relation else {
            let usual_m = match self.query.near_m {
                Some(_) => 0.0,
                // Anywhere: rather toward the middle, where a robot reaches.
                None => {
                    let (low, high) = outline.bounds();
                    0.2 * center.distance(0.5 * (low + high))
                }
            };
            return Some(away_m + usual_m);
        };
        let relation = PosedRelation {
            kind,
            object: footprint,
            target: self.target.as_ref(),
            second_target: self.second_target.as_ref(),
            distance_m: self.query.distance_m,
        };
        if !kind.is_support() && !holds(&relation, outline) {
            return None;
        }
        let Some(target) = &self.target else {
            let edge_m = edge_distance_m(kind, footprint, outline);
            let off_m = match (edge_m, self.query.distance_m) {
                (Some(edge_m), stated_m) => 3.0 * (edge_m - stated_m.unwrap_or(USUAL_GAP_M)).abs(),
                (None, _) => {
                    let (low, high) = outline.bounds();
                    let half_m = 0.5 * (high - low);
                    let (from, to) = scene::predicates::place_shares(kind)?;
                    let ideal_m = 0.5 * (low + high) + half_m * 0.5 * (from + to);
                    center.distance(ideal_m)
                }
            };
            return Some(off_m + 0.5 * away_m);
        };
        if kind.is_support() {
            return Some(target.center().distance(center) + 0.2 * away_m);
        }
        let free_m = footprint.distance_m(target);
        // Clear of the relation's tolerance, so that it still holds at rest.
        if free_m < 0.001 {
            return None;
        }
        let ideal_m = self.query.distance_m.unwrap_or(USUAL_GAP_M);
        let weight = if self.query.distance_m.is_some() { 10.0 } else { 1.0 };
        let off_m = weight * (free_m - ideal_m).abs();
        let across_m = match (direction_of(kind), &self.second_target) {
            (Some(way), _) => (center - target.center()).dot(way.perp()).abs(),
            (None, Some(second)) => return Some(center.distance(0.5 * (target.center() + second.center()))),
            (None, None) => 0.0,
        };
        Some(off_m + 0.7 * across_m + 0.2 * away_m)
    }

    /// An object that is in the way of the object, or of what rests on it, in a pose.
    fn obstacle_of(&self, pose: &Pose) -> Option<usize> {
        let change = *pose * self.object.body.world_from_object.inverse();
        let members: Vec<PosedShape> = self
            .branch
            .iter()
            .map(|member| {
                let member = &self.workspace.objects[*member];
                let is_root = std::ptr::eq(member, self.object);
                member.posed_at(if is_root { *pose } else { change * member.body.world_from_object })
            })
            .collect();
        self.obstacles.iter().copied().find(|&other| {
            let supports = self.supporter.parent == Some(other);
            let obstacle = &self.workspace.objects[other];
            let is_mate = self.is_container() && obstacle.supporter.parent == self.supporter.parent;
            if supports || is_mate {
                // It was let down onto these; they touch.
                return false;
            }
            // Below what stands on a tray, the tray's own rim is no obstacle but the supporter.
            members.iter().any(|member| are_closer(member, &obstacle.posed(), self.clearance_m))
        })
    }
}

/// The multiple of a right angle that is nearest to a yaw.
pub fn nearest_right_angle_rad(yaw_rad: f64) -> f64 {
    wrap_angle_rad((yaw_rad / FRAC_PI_2).round() * FRAC_PI_2)
}
