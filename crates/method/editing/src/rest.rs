//! Simulation of objects that come to rest while everything else stays in place, and the test whether they may stay
//! there.

use std::f64::consts::TAU;
use std::fmt;

use glam::{DQuat, DVec2, DVec3};

use crate::place::{Candidate, PlaceQuery};
use crate::workspace::{Workspace, WorkspaceObject};
use geometry::Pose;
use geometry::collide::{PlacedSolid, penetration};
use geometry::polygon::{convex_hull_2d, depth_in_convex_m};
use physics::settle::{SettleError, angle_between_rad, settle, simulate_to_the_end};
use physics::{Body, CertifySettings, SettleSettings, support};
use runtime::{CancelFlag, Cancelled};
use scene::SupportRelation;
use scene::predicates::YAW_TOLERANCE_RAD;

/// Objects whose boxes are farther apart do not meet while one of them settles.
const REACH_M: f64 = 0.05;

/// An object that is put down slides no farther than this, meters, and turns no more than this, radians: round ones
/// roll a little, and what turns more has fallen over. In a container it may.
const MAX_SLIDE_M: f64 = 0.015;
const MAX_TURN_RAD: f64 = 0.5;

/// Limits of movement in the time of a simulation below which an object stays, meters and radians: those of
/// `resolve.rest_displacement_m` and `resolve.rest_rotation_rad`, below what the certificate allows.
const STILL_M: f64 = 0.001;
const STILL_RAD: f64 = 0.02;

/// Simulations until an object must stay. A round one rolls on slowly for some of them.
const MAX_SETTLINGS: usize = 8;

/// Distance from its place above which an object is put there once more, in the attitude in which it came to lie,
/// meters.
const BESIDE_M: f64 = 0.004;

/// Maximum number of times that an object that rolled is turned back to the yaw of its place.
const MAX_TURNS_BACK: usize = 3;

/// An object at rest has its stated yaw up to this, radians: half of what a reader of the scene accepts.
const STATED_YAW_RAD: f64 = 0.5 * YAW_TOLERANCE_RAD;

/// Depth below an object in which points of its supporter count as its top, meters.
const TOP_LAYER_M: f64 = 0.002;

/// The center of mass of an object lies at least so deep inside the top of what carries it, as a share of half the
/// smaller extent of its outline: a book that balances on an orange is no stable scene.
const BALANCED_SHARE: f64 = 0.2;

/// Settings of a simulation.
#[derive(Clone, Copy, Debug)]
pub struct RestSettings<'a> {
    pub settle: &'a SettleSettings,
    pub certify: &'a CertifySettings,
    /// Whether an object may roll and turn over before it rests: what loses its support has no pose to keep.
    pub may_roll: bool,
}

/// Reason why an object may not stay where it came to rest.
#[derive(Clone, Debug, PartialEq)]
pub enum RestFault {
    /// Movement at the end of the simulation.
    Restless,
    /// Sliding, rolling or falling over.
    Slipped {
        distance_m: f64,
        angle_rad: f64,
    },
    /// Rest near the place, where the relation to others does not hold.
    LeftPlace,
    /// Rest with another yaw than the stated one.
    Turned {
        angle_rad: f64,
    },
    /// Rest outside the container, or beside the supporter.
    LeftSupporter {
        supporter: String,
    },
    /// Contacts that do not carry the center of mass, which the certificate demands.
    NotCarried,
    /// Balance on a top that is much narrower than the object.
    TooNarrow {
        supporter: String,
    },
    /// Mesh that reaches into another one.
    Collides {
        other: String,
    },
    /// The simulation has no result.
    NotSimulated {
        reason: String,
    },
    Cancelled,
}

impl fmt::Display for RestFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Restless => f.write_str("it does not come to rest there"),
            Self::Slipped { distance_m, angle_rad } => {
                let (mm, degrees) = (1000.0 * distance_m, angle_rad.to_degrees());
                write!(f, "it slides {mm:.0} mm and turns {degrees:.0} degrees there")
            }
            Self::LeftPlace => f.write_str("it slides too far from there"),
            Self::Turned { angle_rad } => {
                write!(f, "it turns {:.0} degrees away from the stated yaw", angle_rad.to_degrees())
            }
            Self::LeftSupporter { supporter } => write!(f, "it does not stay with {supporter}"),
            Self::NotCarried => {
                f.write_str("it rests, but its contacts do not lie around its center of mass")
            }
            Self::TooNarrow { supporter } => {
                write!(f, "the top of {supporter} is too narrow below it, so that it would only balance")
            }
            Self::Collides { other } => write!(f, "it would reach into {other}"),
            Self::NotSimulated { reason } => f.write_str(reason),
            Self::Cancelled => f.write_str("the job was cancelled"),
        }
    }
}

impl From<Cancelled> for RestFault {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<SettleError> for RestFault {
    fn from(error: SettleError) -> Self {
        match error {
            SettleError::Cancelled(_) => Self::Cancelled,
            other => Self::NotSimulated { reason: other.to_string() },
        }
    }
}

/// Poses in which the bodies stay for seconds: what moves on slowly after it came to rest, as round objects do, is let
/// move on.
fn lasting_rest(
    bodies: &mut [Body],
    settings: RestSettings,
    cancel: &CancelFlag,
) -> Result<Vec<Pose>, RestFault> {
    for _ in 0..MAX_SETTLINGS {
        let settled = settle(bodies, settings.settle, cancel)?;
        bodies.iter_mut().zip(&settled.poses).for_each(|(body, pose)| body.world_from_object = *pose);
        let later = simulate_to_the_end(bodies, settings.settle, cancel)?;
        let stays = later.displacements_m.iter().all(|moved_m| *moved_m < STILL_M)
            && later.rotations_rad.iter().all(|turned_rad| *turned_rad < STILL_RAD);
        if settled.at_rest && stays {
            return Ok(settled.poses);
        }
        bodies.iter_mut().zip(&later.poses).for_each(|(body, pose)| body.world_from_object = *pose);
    }
    Err(RestFault::Restless)
}

impl Workspace {
    /// Puts an object, with what rests on it, at a candidate's place, and lets it come to rest there. What rolls is put
    /// back there as it came to lie: so it stays, and with the candidate's yaw.
    ///
    /// # Errors
    ///
    /// [`RestFault`] if it may not stay there; the workspace is unchanged then.
    pub fn put_down(
        &mut self,
        object: usize,
        candidate: &Candidate,
        settings: RestSettings,
        cancel: &CancelFlag,
    ) -> Result<(), RestFault> {
        let mut at = *candidate;
        let mut fault = None;
        // Where it came to rest a little beside its place.
        let mut beside: Option<Self> = None;
        for _ in 0..=MAX_TURNS_BACK {
            let lying = match self.at_rest(object, &at, settings, cancel) {
                Ok(rested) => match rested.turn_from_stated_rad(object, candidate) {
                    Some(angle_rad) => {
                        fault = Some(RestFault::Turned { angle_rad });
                        rested
                    }
                    None if beside.is_none() && rested.is_beside(object, candidate) => {
                        beside = Some(rested.clone());
                        rested
                    }
                    None => {
                        *self = rested;
                        return Ok(());
                    }
                },
                Err(_) if beside.is_some() => break,
                Err(slipped @ RestFault::Slipped { .. }) if fault.is_none() => {
                    let may_roll = RestSettings { may_roll: true, ..settings };
                    let Ok(rolled) = self.at_rest(object, &at, may_roll, cancel) else { return Err(slipped) };
                    fault = Some(slipped);
                    rolled
                }
                Err(other) => return Err(fault.unwrap_or(other)),
            };
            let lying = lying.objects[object].body.world_from_object;
            let Some(back) = self.turned_back(object, &lying, candidate) else { break };
            at = back;
        }
        match beside {
            Some(rested) => {
                *self = rested;
                Ok(())
            }
            None => Err(fault.unwrap_or(RestFault::Restless)),
        }
    }

    /// Whether an object rests off the place of a candidate, as seen from above. In a container it may.
    fn is_beside(&self, object: usize, candidate: &Candidate) -> bool {
        let wanted_m = self.objects[object].footprint_at(&candidate.world_from_object).center();
        let off_m = self.objects[object].footprint().center().distance(wanted_m);
        !self.is_contained(object) && off_m > BESIDE_M
    }

    /// The workspace with an object at rest at a candidate's place.
    fn at_rest(
        &self,
        object: usize,
        candidate: &Candidate,
        settings: RestSettings,
        cancel: &CancelFlag,
    ) -> Result<Self, RestFault> {
        let mut changed = self.clone();
        changed.move_branch(object, candidate.world_from_object);
        changed.objects[object].supporter = candidate.supporter;
        changed.objects[object].is_placed = true;
        changed.come_to_rest(&changed.branch(object), settings, cancel)?;
        Ok(changed)
    }

    /// The turn by which an object has another yaw than the stated one; `None` if it has that.
    fn turn_from_stated_rad(&self, object: usize, candidate: &Candidate) -> Option<f64> {
        let object = &self.objects[object];
        let yaw_rad = object.body.world_from_object.yaw_rad()?;
        let off_rad = match object.symmetry_order {
            0 => 0.0,
            order => {
                let period_rad = TAU / f64::from(order);
                let off_rad = (candidate.stated_yaw_rad? - yaw_rad).rem_euclid(period_rad);
                off_rad.min(period_rad - off_rad)
            }
        };
        (off_rad > STATED_YAW_RAD).then_some(off_rad)
    }

    /// The candidate's place and yaw for an object that lies as it came to lie; `None` if it does not fit so.
    fn turned_back(&self, object: usize, lying: &Pose, candidate: &Candidate) -> Option<Candidate> {
        let wanted = &candidate.world_from_object;
        let turn_rad = candidate.stated_yaw_rad.or(wanted.yaw_rad())? - lying.yaw_rad()?;
        let center_m = self.objects[object].footprint_at(wanted).center();
        let rotation = (DQuat::from_rotation_z(turn_rad) * lying.rotation).normalize();
        let about_origin = Pose { translation_m: DVec3::ZERO, rotation };
        let offset_m = self.objects[object].footprint_at(&about_origin).center();
        let pose = Pose { translation_m: (center_m - offset_m).extend(0.0), rotation };
        let found = self.place_at(object, pose, candidate.supporter).ok()?;
        Some(Candidate { stated_yaw_rad: candidate.stated_yaw_rad, ..found })
    }

    /// Lets objects come to rest; all others are fixed.
    ///
    /// # Errors
    ///
    /// [`RestFault`] of the first object that may not stay where it came to rest. Poses are changed then; work on a
    /// copy.
    pub fn come_to_rest(
        &mut self,
        moving: &[usize],
        settings: RestSettings,
        cancel: &CancelFlag,
    ) -> Result<(), RestFault> {
        let near = self.near(moving);
        let body = |object: &WorkspaceObject, fixed: bool| Body { fixed, ..object.body.clone() };
        let mut bodies = vec![body(&self.table, true)];
        bodies.extend(near.iter().map(|&index| body(&self.objects[index], !moving.contains(&index))));
        let poses = lasting_rest(&mut bodies, settings, cancel)?;
        for (&index, pose) in near.iter().zip(&poses[1..]) {
            if !moving.contains(&index) {
                continue;
            }
            let before = self.objects[index].body.world_from_object;
            if !settings.may_roll {
                self.judge_slide(index, &before, pose)?;
            }
            self.objects[index].body.world_from_object = *pose;
        }
        for &index in moving {
            self.judge_support(index)?;
            self.judge_collisions(index, &near, settings.certify, cancel)?;
            self.judge_contacts(index, &near, settings.certify, cancel)?;
            self.judge_breadth(index)?;
        }
        Ok(())
    }

    /// Whether an object is within the outline of the table.
    pub fn is_on_table(&self, object: usize) -> bool {
        let footprint = self.objects[object].footprint();
        footprint.corners().iter().all(|corner| self.outline.contains(*corner))
    }

    /// The moving objects and all whose boxes they may reach.
    fn near(&self, moving: &[usize]) -> Vec<usize> {
        let boxes: Vec<_> = self.objects.iter().map(|o| o.shape.bounds(&o.body.world_from_object)).collect();
        (0..self.objects.len())
            .filter(|&index| {
                let is_close = |other: usize| {
                    let gap = (boxes[index].0 - boxes[other].1).max(boxes[other].0 - boxes[index].1);
                    gap.max_element() < REACH_M
                };
                let is_placed = self.objects[index].is_placed;
                is_placed && (moving.contains(&index) || moving.iter().any(|&other| is_close(other)))
            })
            .collect()
    }

    fn judge_slide(&self, index: usize, before: &Pose, after: &Pose) -> Result<(), RestFault> {
        if self.is_contained(index) {
            return Ok(());
        }
        let distance_m = (after.translation_m - before.translation_m).truncate().length();
        let angle_rad = angle_between_rad(before, after);
        if distance_m > MAX_SLIDE_M || angle_rad > MAX_TURN_RAD {
            return Err(RestFault::Slipped { distance_m, angle_rad });
        }
        Ok(())
    }

    /// Whether an object is in a container, itself or with what it stands on.
    fn is_contained(&self, index: usize) -> bool {
        let supports = self.supports();
        std::iter::once(index)
            .chain(supports.ancestors(index))
            .any(|member| supports.supporter(member).relation == SupportRelation::In)
    }

    fn judge_support(&self, index: usize) -> Result<(), RestFault> {
        let object = &self.objects[index];
        let Some(parent) = object.supporter.parent else {
            let low_m = object.footprint().bottom_m;
            return if low_m.abs() < 0.01 {
                Ok(())
            } else {
                Err(RestFault::LeftSupporter { supporter: "the table".to_owned() })
            };
        };
        let query = PlaceQuery {
            relation: Some(object.supporter.relation.into()),
            target: Some(parent),
            ..PlaceQuery::default()
        };
        if self.meets(index, &query) {
            Ok(())
        } else {
            Err(RestFault::LeftSupporter { supporter: self.objects[parent].body.name.clone() })
        }
    }

    /// As the certificate does: the contacts of an object lie around its center of mass.
    fn judge_contacts(
        &self,
        index: usize,
        near: &[usize],
        certify: &CertifySettings,
        cancel: &CancelFlag,
    ) -> Result<(), RestFault> {
        let members: Vec<&WorkspaceObject> =
            std::iter::once(&self.table).chain(near.iter().map(|&other| &self.objects[other])).collect();
        let solids: Vec<PlacedSolid> = members
            .iter()
            .map(|member| PlacedSolid {
                solid: &member.solid,
                world_from_object: member.body.world_from_object,
            })
            .collect();
        let bodies: Vec<Body> = members.iter().map(|member| member.body.clone()).collect();
        let position = |object: usize| near.iter().position(|&other| other == object).map(|at| at + 1);
        let supporter = self.objects[index].supporter;
        let mates = near.iter().copied().filter(|&other| {
            let is_mate = supporter.relation == SupportRelation::In && supporter.parent.is_some();
            is_mate && other != index && self.objects[other].supporter == supporter
        });
        let below = supporter.parent.map_or(Some(0), position);
        let carriers: Vec<usize> = below.into_iter().chain(mates.filter_map(position)).collect();
        let Some(object) = position(index) else { return Ok(()) };
        let found = support(&solids, &bodies, object, &carriers, certify, cancel)?;
        if found.is_supported() { Ok(()) } else { Err(RestFault::NotCarried) }
    }

    /// Checks that the top of the object's supporter reaches far enough around its center of mass.
    fn judge_breadth(&self, index: usize) -> Result<(), RestFault> {
        let object = &self.objects[index];
        let (Some(parent), SupportRelation::On) = (object.supporter.parent, object.supporter.relation) else {
            return Ok(());
        };
        let (below, footprint) = (&self.objects[parent], object.footprint());
        let points = || below.shape.points(&below.body.world_from_object);
        // What is tilted reaches below the top that carries it.
        let is_covered = |point: &DVec3| depth_in_convex_m(footprint.corners(), point.truncate()) >= 0.0;
        let level_m = points().filter(is_covered).map(|point| point.z).fold(footprint.bottom_m, f64::max);
        let top: Vec<DVec2> =
            points().filter(|point| point.z > level_m - TOP_LAYER_M).map(DVec3::truncate).collect();
        let pose = &object.body.world_from_object;
        let center_of_mass_m = pose.transform_point(object.body.mass.center_of_mass_m).truncate();
        let depth_m = depth_in_convex_m(&convex_hull_2d(&top), center_of_mass_m);
        let half_m = depth_in_convex_m(footprint.corners(), footprint.center());
        if depth_m >= BALANCED_SHARE * half_m {
            Ok(())
        } else {
            Err(RestFault::TooNarrow { supporter: below.body.name.clone() })
        }
    }

    fn judge_collisions(
        &self,
        index: usize,
        near: &[usize],
        certify: &CertifySettings,
        cancel: &CancelFlag,
    ) -> Result<(), RestFault> {
        let rule = certify.collision_rule();
        let placed =
            |object: &WorkspaceObject| -> (Pose, _) { (object.body.world_from_object, object.solid.clone()) };
        let (pose, solid) = placed(&self.objects[index]);
        let own = PlacedSolid { solid: &solid, world_from_object: pose };
        let others = near.iter().filter(|&&other| other != index).map(|&other| &self.objects[other]);
        for other in others.chain(std::iter::once(&self.table)) {
            let (other_pose, other_solid) = placed(other);
            let other_solid = PlacedSolid { solid: &other_solid, world_from_object: other_pose };
            if penetration(&own, &other_solid, &rule, cancel)?.is_some() {
                return Err(RestFault::Collides { other: other.body.name.clone() });
            }
        }
        Ok(())
    }
}
