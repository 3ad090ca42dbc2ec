//! One pass over the grid of one surface: what fits, how well, and what is in the way.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};
use rayon::prelude::*;

use super::{Candidate, NoPlace, PlaceQuery};
use crate::workspace::{Workspace, WorkspaceObject};
use geometry::Pose;
use geometry::drop_cast::{PosedShape, are_closer, drop_height};
use geometry::polygon::depth_in_convex_m;
use geometry::pose::wrap_angle_rad;
use scene::predicates::{PosedFootprint, PosedRelation, direction_of, edge_distance_m, holds, place_shares};
use scene::{SupportRelation, Supporter};

/// Yaws of the search.
const YAWS: usize = 16;

/// Distance from the table's edge that everything keeps.
const EDGE_MARGIN_M: f64 = 0.005;

/// Precision of the distance that an object can go toward a place, in halvings of the way.
const HALVINGS: usize = 12;

/// Height at which an object is let go above its supporter.
const DROP_GAP_M: f64 = 0.0005;

/// Candidates of one orientation in a container.
const CANDIDATES_PER_ORIENTATION: usize = 2;

/// Most candidates of one search.
const MAX_CANDIDATES: usize = 12;

/// Free distance that a directed relation without a stated one aims at.
const USUAL_GAP_M: f64 = 0.04;

/// An object longer than this many times its second extent may stand upright in a container.
const SLENDERNESS: f64 = 2.0;

/// Minimum depth below its rim that objects in a container reach, meters.
const BELOW_RIM_M: f64 = 0.003;

/// Lean of slender objects in a container from the vertical, radians.
const LEAN_RAD: f64 = 0.22;

/// A feasible place of the grid.
struct Scored {
    cost: f64,
    pose: Pose,
}

/// One pass over the grid of one surface.
pub(super) struct Search<'a> {
    workspace: &'a Workspace,
    pub object: &'a WorkspaceObject,
    query: &'a PlaceQuery,
    supporter: Supporter,
    clearance_m: f64,
    step_m: f64,
    /// The object and what rests on it, in the object's frame of now.
    branch: Vec<usize>,
    /// Objects that may be in the way.
    obstacles: Vec<usize>,
    target: Option<PosedFootprint>,
    second_target: Option<PosedFootprint>,
    surface: Option<PosedFootprint>,
}

/// The object in one orientation; its footprint is the same at every place.
pub(super) struct Orientation {
    rotation: DQuat,
    /// From the object's origin to the center of its footprint.
    pub offset_m: DVec2,
    /// Convex, from the center of the footprint.
    corners_m: Vec<DVec2>,
    /// Lowest and highest point above the object's origin.
    low_m: f64,
    high_m: f64,
}

impl Orientation {
    pub fn new(object: &WorkspaceObject, rotation: DQuat) -> Self {
        let footprint = object.footprint_at(&Pose { translation_m: DVec3::ZERO, rotation });
        let offset_m = footprint.center();
        Self {
            rotation,
            offset_m,
            corners_m: footprint.corners().iter().map(|corner| *corner - offset_m).collect(),
            low_m: footprint.bottom_m,
            high_m: footprint.top_m,
        }
    }

    fn footprint(&self, center_m: DVec2, pose: &Pose) -> PosedFootprint {
        let corners: Vec<DVec2> = self.corners_m.iter().map(|corner| center_m + *corner).collect();
        let z_m = pose.translation_m.z;
        PosedFootprint::new(&corners, pose.yaw_rad().unwrap_or(0.0), z_m + self.low_m, z_m + self.high_m)
    }
}

pub(super) struct SearchResult {
    pub candidates: Vec<Candidate>,
    /// Whether the object fits on the surface if nothing else is there.
    pub has_fitted: bool,
}

/// Whether what is below the rim of a container is within its outline: a toaster that stands over a jar is not in it.
pub(super) fn reaches_into(object: &WorkspaceObject, pose: &Pose, container: &PosedFootprint) -> bool {
    let below = object.shape.points(pose).filter(|point| point.z < container.top_m - BELOW_RIM_M);
    below.into_iter().all(|point| depth_in_convex_m(container.corners(), point.truncate()) > -BELOW_RIM_M)
}

impl<'a> Search<'a> {
    pub fn new(
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

    pub fn run(&self, blocked_by: &mut Vec<usize>) -> SearchResult {
        let mut found = SearchResult { candidates: Vec::new(), has_fitted: false };
        for rotation in self.rotations() {
            let mut fitting = self.fitting(&Orientation::new(self.object, rotation));
            found.has_fitted |= !fitting.is_empty();
            fitting.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            let before = found.candidates.len();
            // Free ones among the best; the whole grid is searched before the next yaw is.
            for chunk in fitting.chunks(64) {
                let hindered: Vec<Option<usize>> =
                    chunk.par_iter().map(|scored| self.obstacle_of(&scored.pose)).collect();
                for (scored, obstacle) in chunk.iter().zip(hindered) {
                    match obstacle {
                        None => found.candidates.push(Candidate {
                            world_from_object: scored.pose,
                            supporter: self.supporter,
                            stated_yaw_rad: self.query.yaw_rad,
                        }),
                        Some(other) => blocked_by.push(other),
                    }
                }
                if self.is_container() {
                    // Of each orientation a few, since how an object leans decides whether it rests.
                    found.candidates.truncate(before + CANDIDATES_PER_ORIENTATION);
                }
                if found.candidates.len() >= MAX_CANDIDATES {
                    found.candidates.truncate(MAX_CANDIDATES);
                    return found;
                }
                if self.is_container() && found.candidates.len() > before {
                    break;
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
        let mut turns: Vec<f64> = (0..YAWS).map(|k| wrap_angle_rad(TAU * k as f64 / YAWS as f64)).collect();
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
    fn fitting(&self, orientation: &Orientation) -> Vec<Scored> {
        let (low, high) = match &self.surface {
            Some(surface) => surface.bounds(),
            None => self.workspace.outline.bounds(),
        };
        if let Some(position_m) = self.query.position_m {
            return self.scored(orientation, position_m).into_iter().collect();
        }
        let cells = ((high - low) / self.step_m).ceil().max(DVec2::ONE);
        let (columns, rows) = (cells.x as usize + 1, cells.y as usize + 1);
        (0..columns * rows)
            .into_par_iter()
            .filter_map(|cell| {
                let at = DVec2::new((cell % columns) as f64, (cell / columns) as f64);
                self.scored(orientation, low + self.step_m * at)
            })
            .collect()
    }

    /// The object with the center of its footprint at a point, let down onto the surface; `None` beyond its edge.
    pub fn posed(&self, orientation: &Orientation, center_m: DVec2) -> Option<Pose> {
        let rotation = orientation.rotation;
        let xy_m = center_m - orientation.offset_m;
        let mut pose = Pose { translation_m: xy_m.extend(DROP_GAP_M - orientation.low_m), rotation };
        // Nothing reaches over the edge of the table, wherever it stands.
        let margin_m = if self.supporter.parent.is_none() { EDGE_MARGIN_M } else { 0.0 };
        let depth_m = |corner: DVec2| self.workspace.outline.depth_inside_m(corner);
        if !orientation.corners_m.iter().all(|corner| depth_m(center_m + *corner) >= margin_m) {
            return None;
        }
        match self.supporter.parent {
            None => {}
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

    /// Reason why [`Self::posed`] has no pose at a point.
    pub fn beyond_edge(&self, orientation: &Orientation, center_m: DVec2) -> NoPlace {
        let corners = orientation.corners_m.iter().map(|corner| center_m + *corner);
        let outside_m = |corner: DVec2| -self.workspace.outline.depth_inside_m(corner);
        let over_table_m = corners.map(outside_m).fold(f64::NEG_INFINITY, f64::max);
        let surface = self.supporter.parent.zip(self.surface.as_ref()).filter(|_| over_table_m <= 0.0);
        let (surface, beyond_m) = match surface {
            None => ("the table".to_owned(), over_table_m),
            Some((parent, surface)) => {
                let depth_m = depth_in_convex_m(surface.corners(), center_m);
                (self.workspace.objects[parent].body.name.clone(), -depth_m)
            }
        };
        let from_m = self.object.footprint().center();
        let distance_m = from_m.distance(center_m);
        let fits = |share: f64| self.posed(orientation, from_m.lerp(center_m, share)).is_some();
        let way_m = (distance_m > USUAL_GAP_M).then(|| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..HALVINGS {
                let share = 0.5 * (low + high);
                if fits(share) { low = share } else { high = share }
            }
            low * distance_m
        });
        let beyond_m = beyond_m.max(0.0);
        NoPlace::BeyondEdge { object: self.object.body.name.clone(), surface, beyond_m, way_m }
    }

    /// The object with the center of its footprint at a point, if that meets the query.
    fn scored(&self, orientation: &Orientation, center_m: DVec2) -> Option<Scored> {
        let pose = self.posed(orientation, center_m)?;
        let footprint = orientation.footprint(center_m, &pose);
        if self.is_container() {
            let surface = self.surface.as_ref()?;
            if footprint.bottom_m >= surface.top_m - BELOW_RIM_M || !reaches_into(self.object, &pose, surface)
            {
                return None;
            }
            let off_m = surface.center().distance(center_m);
            return Some(Scored { cost: 4.0 * footprint.bottom_m + off_m, pose });
        }
        self.cost(&footprint).map(|cost| Scored { cost, pose })
    }

    /// Distance of a place from the ideal one, meters; `None` if the relation does not hold there.
    fn cost(&self, footprint: &PosedFootprint) -> Option<f64> {
        let outline = &self.workspace.outline;
        let center = footprint.center();
        let away_m = self.query.near_m.map_or(0.0, |near_m| near_m.distance(center));
        if self.query.within_m.is_some_and(|within_m| away_m > within_m) {
            return None;
        }
        let Some(kind) = self.query.relation else {
            let usual_m = match self.query.near_m {
                Some(_) => 0.0,
                // Anywhere: rather toward the center, where a robot reaches.
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
        if self.query.by_nearness {
            return Some(away_m);
        }
        let Some(target) = &self.target else {
            let edge_m = edge_distance_m(kind, footprint, outline);
            let off_m = match (edge_m, self.query.distance_m) {
                (Some(edge_m), stated_m) => 3.0 * (edge_m - stated_m.unwrap_or(USUAL_GAP_M)).abs(),
                (None, _) => {
                    let (low, high) = outline.bounds();
                    let half_m = 0.5 * (high - low);
                    let (from, to) = place_shares(kind)?;
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
    pub fn obstacle_of(&self, pose: &Pose) -> Option<usize> {
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
            let gap_m = self.query.outline_gap_m;
            if gap_m > 0.0 && obstacle.supporter == self.supporter {
                let (own, other) = (self.object.footprint_at(pose), obstacle.footprint());
                let are_beside = own.bottom_m < other.top_m && other.bottom_m < own.top_m;
                if are_beside && own.distance_m(&other) < gap_m {
                    return true;
                }
            }
            // Below what stands on a tray, the tray's own rim is no obstacle but the supporter.
            members.iter().any(|member| are_closer(member, &obstacle.posed(), self.clearance_m))
        })
    }
}
