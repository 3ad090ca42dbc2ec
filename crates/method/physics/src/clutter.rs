//! Clutter: objects are dropped onto a table and onto each other, and lie as they come to rest.
//!
//! Bodies that may be dropped fall in small groups, large ones first. Each starts a few millimeters above the first
//! contact straight below a random place of the drop region ([`mod@region`]), with a random yaw, side and tilt
//! ([`mod@start`]), so that little energy is left to scatter the heap. All other bodies are fixed while groups fall.
//! Then everything comes to rest together, and is judged as the certificate does: on the table, at rest for five
//! seconds of gravity, carried by what it touches, and not inside another mesh. What fails is lifted and dropped
//! elsewhere, and after a few times set down upright on a free place ([`mod@set_down`]).
//!
//! The density is the share of the drop region that footprints would cover if they were strewn at random over each
//! other: of footprints with the area A in a region of area R that is 1 - exp(-A / R).
//!
//! World frame, meters, radians. Deterministic: the same seed gives the same bytes with any number of threads.

mod contacts;
mod coverage;
mod faults;
mod fall;
mod region;
mod set_down;
mod start;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use glam::DVec2;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::metrics::CertifySettings;
use super::rigid_world::UnfitBody;
use super::settle::{SettleError, SettleSettings};
use super::{Body, resolve::ResolveSettings};
use geometry::collision_shape::CollisionShape;
use geometry::drop_cast::PosedShape;
use geometry::polygon::convex_hull_2d;
use geometry::solid_query::MeshSolid;
use geometry::{Outline, Pose};
use runtime::seed::{Rng, child_rng};
use runtime::{CancelFlag, Cancelled};

pub use contacts::{Contact, contacts, supporters};
pub use coverage::covered_share;
use region::Region;
use start::Sides;

/// Index of the table among the bodies.
const TABLE: usize = 0;

/// Bodies that fall at the same time.
const GROUP: usize = 5;

/// A body that was dropped this often is set down upright.
const MAX_DROPS: usize = 3;

/// Rounds of dropping and judging.
const MAX_ROUNDS: usize = 8;

/// Distance that bodies start from the table's edge, meters.
const EDGE_M: f64 = 0.05;

/// Treatment of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DropRole {
    /// Stays where it is.
    Kept,
    /// Falls standing, nine times in ten.
    Standing,
    /// Falls on any side, rather on a large one.
    AnySide,
}

/// Bodies of which some are dropped. The slices have the same order and length, but for `roles`.
#[derive(Clone, Copy)]
pub struct ClutterProblem<'a> {
    /// The table, which is fixed, then the objects, free of each other and at rest.
    pub bodies: &'a [Body],
    /// Visual meshes of the bodies.
    pub solids: &'a [&'a MeshSolid],
    /// Of the objects, without the table. What is dropped carries nothing.
    pub roles: &'a [DropRole],
    /// Edge of the table's top in the world's xy plane.
    pub outline: &'a Outline,
    /// 0..1; see the module.
    pub density: f64,
    pub seed: u64,
}

/// Settings of the simulation and of the judgment.
#[derive(Clone, Copy)]
pub struct ClutterSettings<'a> {
    pub settle: &'a SettleSettings,
    pub resolve: &'a ResolveSettings,
    pub certify: &'a CertifySettings,
}

/// Bodies at rest after some were dropped.
#[derive(Clone, Debug, PartialEq)]
pub struct DroppedLayout {
    /// `world_from_object` at rest, in the order of the bodies.
    pub poses: Vec<Pose>,
    /// `world_from_object` from which each body fell last; of a kept one its pose before.
    pub starts: Vec<Pose>,
    /// Of the bodies that were set down upright in the end.
    pub set_down: Vec<usize>,
    /// Number of drops over all bodies.
    pub drops: usize,
    /// Faults that are left, one sentence each; usually none.
    pub faults: Vec<String>,
}

/// Reason why bodies cannot be dropped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClutterError {
    #[error("dropping: {bodies} bodies but {roles} roles; give the table and one role per object")]
    BadRoles { bodies: usize, roles: usize },
    #[error("dropping: there is no free place on the table; use a larger table or fewer objects")]
    NoRegion,
    #[error("dropping: {0}")]
    Settle(#[from] SettleError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The heap while it grows.
struct Heap<'a> {
    problem: ClutterProblem<'a>,
    settings: ClutterSettings<'a>,
    cancel: &'a CancelFlag,
    shapes: Vec<CollisionShape>,
    /// Of the bodies that are dropped.
    sides: Vec<Option<Sides>>,
    region: Region,
    rng: Rng,
    /// Of each body; `None` while it is not in the scene.
    poses: Vec<Option<Pose>>,
    starts: Vec<Pose>,
    drops: Vec<usize>,
    is_set_down: Vec<bool>,
}

/// Drops the bodies that may be dropped.
///
/// # Errors
///
/// [`ClutterError`] if roles are missing, a body cannot be simulated, or the table is full of what is kept.
pub fn drop_clutter(
    problem: ClutterProblem,
    settings: ClutterSettings,
    cancel: &CancelFlag,
) -> Result<DroppedLayout, ClutterError> {
    let mut heap = Heap::new(problem, settings, cancel)?;
    let mut waiting = heap.drop_order();
    let mut faults = Vec::new();
    for _ in 0..MAX_ROUNDS {
        heap.pour(waiting)?;
        faults = heap.come_to_rest()?;
        if faults.iter().all(|fault| fault.lift.is_empty()) {
            break;
        }
        let mut lifted: Vec<usize> = faults.iter().flat_map(|fault| &fault.lift).copied().collect();
        lifted.sort_unstable();
        lifted.dedup();
        waiting = lifted;
    }
    // Bodies that were lifted in the last round are still where they failed, which the certificate states.
    let placed = |(pose, start): (&Option<Pose>, &Pose)| pose.unwrap_or(*start);
    Ok(DroppedLayout {
        poses: heap.poses.iter().zip(&heap.starts).map(placed).collect(),
        set_down: (0..heap.poses.len()).filter(|&body| heap.is_set_down[body]).collect(),
        drops: heap.drops.iter().sum(),
        starts: heap.starts,
        faults: faults.into_iter().map(|fault| fault.reason).collect(),
    })
}

impl<'a> Heap<'a> {
    fn new(
        problem: ClutterProblem<'a>,
        settings: ClutterSettings<'a>,
        cancel: &'a CancelFlag,
    ) -> Result<Self, ClutterError> {
        let (bodies, roles) = (problem.bodies.len(), problem.roles.len());
        if bodies != roles + 1 {
            return Err(ClutterError::BadRoles { bodies, roles });
        }
        let shapes = problem
            .bodies
            .iter()
            .map(|body| {
                CollisionShape::new(&body.hulls)
                    .map_err(|source| UnfitBody::BrokenHull { name: body.name.clone(), source })
                    .map_err(SettleError::from)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let mut rng = child_rng(problem.seed, "clutter");
        let is_kept = |body: usize| body == TABLE || problem.roles[body - 1] == DropRole::Kept;
        let sides: Vec<Option<Sides>> =
            (0..bodies).map(|body| (!is_kept(body)).then(|| Sides::new(&shapes[body]))).collect();
        let area_m2 = sides.iter().flatten().map(Sides::mean_area_m2).sum();
        let starts: Vec<Pose> = problem.bodies.iter().map(|body| body.world_from_object).collect();
        let kept: Vec<Vec<DVec2>> = (1..bodies)
            .filter(|&body| is_kept(body))
            .map(|body| footprint(&shapes[body], &starts[body]))
            .collect();
        let region = Region::new(problem.outline, &kept, area_m2, problem.density, &mut rng)
            .ok_or(ClutterError::NoRegion)?;
        let poses = (0..bodies).map(|body| is_kept(body).then_some(starts[body])).collect();
        let (drops, is_set_down) = (vec![0; bodies], vec![false; bodies]);
        Ok(Self { problem, settings, cancel, shapes, sides, region, rng, poses, starts, drops, is_set_down })
    }

    fn is_dropped(&self, body: usize) -> bool {
        self.sides[body].is_some()
    }

    fn name(&self, body: usize) -> &str {
        &self.problem.bodies[body].name
    }

    /// Bodies to be dropped, large ones first, with some chance for smaller ones to come earlier.
    fn drop_order(&mut self) -> Vec<usize> {
        let dropped: Vec<usize> = (0..self.poses.len()).filter(|&body| self.is_dropped(body)).collect();
        let mut keyed: Vec<(f64, usize)> = dropped
            .into_iter()
            .map(|body| {
                let (low, high) = self.shapes[body].bounds(&Pose::IDENTITY);
                let chance: f64 = self.rng.random_range(-0.5..0.5);
                ((high - low).element_product() * chance.exp(), body)
            })
            .collect();
        keyed.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        keyed.into_iter().map(|(_, body)| body).collect()
    }

    /// The bodies that are in the scene.
    fn present(&self) -> Vec<usize> {
        (0..self.poses.len()).filter(|&body| self.poses[body].is_some()).collect()
    }

    fn placed(&self, except: usize) -> Vec<PosedShape<'_>> {
        self.poses
            .iter()
            .zip(&self.shapes)
            .enumerate()
            .filter(|(body, _)| *body != except)
            .filter_map(|(_, (pose, shape))| {
                pose.map(|world_from_object| PosedShape { shape, world_from_object })
            })
            .collect()
    }

    /// Drops bodies in groups. What falls off the table is dropped again.
    fn pour(&mut self, bodies: Vec<usize>) -> Result<(), ClutterError> {
        bodies.iter().for_each(|&body| self.poses[body] = None);
        let mut waiting = VecDeque::from(bodies);
        // Each body can be dropped `MAX_DROPS` times and set down a few times.
        let mut groups_left = (MAX_DROPS + 2) * (waiting.len() / GROUP + 1);
        while !waiting.is_empty() && groups_left > 0 {
            groups_left -= 1;
            let group: Vec<usize> = (0..GROUP).filter_map(|_| waiting.pop_front()).collect();
            for body in group {
                self.cancel.check()?;
                let start = if self.drops[body] >= MAX_DROPS {
                    self.is_set_down[body] = true;
                    self.free_place(body)
                } else {
                    self.drops[body] += 1;
                    self.draw_start(body)
                };
                (self.starts[body], self.poses[body]) = (start, Some(start));
            }
            self.fall()?;
            let fallen: Vec<usize> = self
                .present()
                .into_iter()
                .filter(|&body| self.is_dropped(body) && self.is_off(body))
                .collect();
            fallen.iter().for_each(|&body| self.poses[body] = None);
            waiting.extend(fallen);
        }
        // What is left would fall off again wherever it is put.
        for body in waiting {
            let start = self.free_place(body);
            (self.starts[body], self.poses[body], self.is_set_down[body]) = (start, Some(start), true);
        }
        Ok(())
    }
}

/// Outline of a shape seen from above.
fn footprint(shape: &CollisionShape, world_from_object: &Pose) -> Vec<DVec2> {
    let points: Vec<DVec2> = shape.points(world_from_object).map(|p| p.truncate()).collect();
    convex_hull_2d(&points)
}
