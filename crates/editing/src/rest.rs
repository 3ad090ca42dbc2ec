//! How objects come to rest while everything else stays where it is, and whether they may stay there.

use std::fmt;

use crate::place::{Candidate, PlaceQuery};
use crate::workspace::{Workspace, WorkspaceObject};
use geometry::Pose;
use geometry::collide::{PlacedSolid, penetration};
use physics::settle::{SettleError, angle_between_rad, settle, simulate_to_the_end};
use physics::{Body, CertifySettings, SettleSettings, support};
use runtime::{CancelFlag, Cancelled};
use scene::SupportRelation;

/// Objects whose boxes are farther apart do not meet while one of them settles.
const REACH_M: f64 = 0.05;

/// An object that is put down slides no farther than this, meters, and turns no more than this, radians: round ones
/// roll a little, and what turns more has fallen over. In a container it may.
const MAX_SLIDE_M: f64 = 0.015;
const MAX_TURN_RAD: f64 = 0.5;

/// What moves and turns less than this in the time of a simulation stays, meters and radians.
const STILL_M: f64 = 0.002;
const STILL_RAD: f64 = 0.1;

/// Simulations until an object must stay.
const MAX_SETTLINGS: usize = 4;

/// What a simulation needs.
#[derive(Clone, Copy, Debug)]
pub struct RestSettings<'a> {
    pub settle: &'a SettleSettings,
    pub certify: &'a CertifySettings,
    /// Whether an object may roll and turn over before it rests: what loses its support has no pose to keep.
    pub may_roll: bool,
}

/// Why an object may not stay where it came to rest.
#[derive(Clone, Debug, PartialEq)]
pub enum RestFault {
    /// It still moves at the end of the simulation.
    Restless,
    /// It slid, rolled or fell over.
    Slipped {
        distance_m: f64,
        angle_rad: f64,
    },
    /// It came to rest outside its container, or beside what it was put on.
    LeftSupporter {
        supporter: String,
    },
    /// Its contacts do not carry its center of mass, which the certificate demands.
    NotCarried,
    /// Its mesh reaches into another one's.
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
            Self::LeftSupporter { supporter } => write!(f, "it does not stay with {supporter}"),
            Self::NotCarried => {
                f.write_str("it rests, but its contacts do not lie around its center of mass")
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
    /// Puts an object, with what rests on it, at a candidate's place, and lets it come to rest there.
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
        let mut changed = self.clone();
        changed.move_branch(object, candidate.world_from_object);
        changed.objects[object].supporter = candidate.supporter;
        changed.objects[object].is_placed = true;
        changed.come_to_rest(&changed.branch(object), settings, cancel)?;
        *self = changed;
        Ok(())
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
