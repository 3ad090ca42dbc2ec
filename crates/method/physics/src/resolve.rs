//! Pose refinement: from poses estimated from an image to poses that are collision-free, supported, inside the table's
//! outline and at rest.
//!
//! The paper leaves collisions unresolved; this step is an addition. Each round drops every object onto its supporter
//! in support order ([`mod@place`]), pushes overlapping objects apart along the shortest horizontal direction and back
//! inside the outline ([`mod@separate`]), settles them under gravity and takes the settled poses. Contained objects
//! are placed one by one ([`mod@contain`]). A round is accepted if no visual meshes interpenetrate, every object rests
//! with its supporter, supported and inside the outline, and five more seconds change nothing. Otherwise the next
//! round starts with more clearance and nudges failed objects toward their supporter's center. Objects that came to
//! rest over the edge (as tall objects do that fall) are kept that much farther from it, and contained objects try
//! other places. If only space is missing at the end, a few more rounds provide more of it, and if only contents do not
//! hold, a few more draw other places for them. An infeasible scene is an error that names the objects. Children move
//! with their supporters; contained objects use their true shapes.
//!
//! World frame, meters, radians. Deterministic. A fraction of a second for twenty objects.

mod place;
mod contain;
mod drop;
pub(crate) mod inside;
mod level;
mod separate;
mod tree;

use glam::DVec2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::metrics::{CertifySettings, collisions, stability};
use super::rigid_world::UnfitBody;
use super::settle::{SettleError, SettleSettings, angle_between_rad, settle};
use super::support::{SupportFinding, carriers, support};
use super::{Body, SettledPoses};
use geometry::collide::PlacedSolid;
use geometry::collision_shape::CollisionShape;
use geometry::drop_cast::{PosedShape, are_closer};
use geometry::polygon::convex_hull_2d;
use geometry::solid_query::MeshSolid;
use geometry::{Outline, Pose};
use runtime::{CancelFlag, Cancelled};
use scene::SupportTree;

use tree::{BodyTree, TABLE};

/// Section `[resolve]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ResolveSettings {
    /// Gap kept between neighbors, meters, one value a round, growing. More values: more tries.
    pub clearances_m: Vec<f64>,
    /// Passes of pushing apart before a round falls back on free places, 1..1000.
    pub separation_passes: usize,
    /// Directions tried for each push, 4..64. More: shorter moves, more time.
    pub directions: usize,
    /// Distance everything keeps from the table's edge, meters.
    pub outline_margin_m: f64,
    /// A contained object must reach down into its container by this share of the cavity's depth, 0..1.
    pub container_depth_share: f64,
    /// A settled scene may move this much in the time of the check, meters.
    pub rest_displacement_m: f64,
    /// A settled scene may turn this much in the time of the check, radians.
    pub rest_rotation_rad: f64,
    /// Checks of five seconds, each followed by another settling, before a moving body fails the round, 0..10; 0 takes
    /// the first rest pose without a check.
    pub settles: usize,
    /// Turning further than this from the wanted pose is falling over, radians.
    pub fallen_rotation_rad: f64,
}

/// A scene to resolve. The slices have the same order and length: the table, which is fixed, then the objects of the
/// support tree.
#[derive(Clone, Copy)]
pub struct ResolveProblem<'a> {
    /// `world_from_object` is the wanted pose; its height matters little, it is dropped anyway.
    pub bodies: &'a [Body],
    /// Visual meshes of the bodies, in the same order.
    pub solids: &'a [&'a MeshSolid],
    /// Supports of all bodies but the table.
    pub supports: &'a SupportTree,
    /// Edge of the table's top in the world's xy plane.
    pub outline: &'a Outline,
}

/// Resolved poses.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedLayout {
    /// `world_from_object` at rest, in the order of the bodies.
    pub poses: Vec<Pose>,
    /// `world_from_object` before gravity: dropped and pushed apart.
    pub planned: Vec<Pose>,
    /// From the wanted pose: horizontal distance, meters, and angle, radians.
    pub displacements_m: Vec<f64>,
    pub rotations_rad: Vec<f64>,
    /// Rounds it took.
    pub rounds: usize,
    /// Changes made to the layout, one sentence each.
    pub log: Vec<String>,
}

/// Reason why a scene is infeasible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ResolveError {
    #[error(
        "resolving: {bodies} bodies but supports of {objects} objects; give the table and one body per object"
    )]
    BadSupport { bodies: usize, objects: usize },
    #[error("resolving: no room on the table for {}; use a larger table or fewer objects", names.join(", "))]
    NoSpace { names: Vec<String> },
    #[error("resolving: {} after {rounds} rounds; remove or replace the named objects", reasons.join("; "))]
    Unresolved { rounds: usize, reasons: Vec<String>, names: Vec<String> },
    #[error("resolving: {0}")]
    Settle(#[from] SettleError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ResolveError {
    /// The objects at fault.
    pub fn names(&self) -> &[String] {
        match self {
            Self::NoSpace { names } | Self::Unresolved { names, .. } => names,
            _ => &[],
        }
    }
}

/// Data shared by the steps of a round.
struct Scene<'a> {
    problem: ResolveProblem<'a>,
    shapes: Vec<CollisionShape>,
    tree: BodyTree<'a>,
    settings: &'a ResolveSettings,
    settle: &'a SettleSettings,
    certify: &'a CertifySettings,
}

impl Scene<'_> {
    fn placed<'b>(&'b self, body: usize, poses: &[Pose]) -> PosedShape<'b> {
        PosedShape { shape: &self.shapes[body], world_from_object: poses[body] }
    }

    fn name(&self, body: usize) -> &str {
        &self.problem.bodies[body].name
    }

    /// Outline of a body seen from above.
    fn footprint(&self, body: usize, poses: &[Pose]) -> Vec<DVec2> {
        let points: Vec<DVec2> = self.shapes[body].points(&poses[body]).map(|p| p.truncate()).collect();
        convex_hull_2d(&points)
    }
}

/// A defect that remains after a round.
struct Fault {
    body: usize,
    reason: String,
    /// Moving it toward its supporter's center may help.
    nudge: bool,
    /// Distance that the body reaches over the table's edge, meters; 0 if it does not.
    over_edge_m: f64,
    /// Keeping more distance from the edge or from others may help.
    needs_space: bool,
    /// Another place in its container may help.
    needs_draw: bool,
}

impl Fault {
    fn of(body: usize, reason: String) -> Self {
        Self { body, reason, nudge: false, over_edge_m: 0.0, needs_space: false, needs_draw: false }
    }

    /// The body is put elsewhere in the next round; in a container there are always other places.
    fn nudged(scene: &Scene, body: usize, reason: String) -> Self {
        Self { nudge: true, needs_draw: scene.tree.is_contained(body), ..Self::of(body, reason) }
    }
}

/// Rounds after the planned ones with more clearance, if only space is missing.
const EXTRA_ROUNDS: usize = 3;

/// Rounds after the planned ones with other draws of what is in containers, if only that is missing too.
const EXTRA_DRAWS: usize = 4;

/// Of a round, counted from 0; after the planned ones it doubles.
fn clearance_m(settings: &ResolveSettings, round: usize) -> f64 {
    let planned = &settings.clearances_m;
    let last_m = planned.last().copied().unwrap_or(0.0);
    let more = (round + 1).saturating_sub(planned.len());
    planned.get(round).copied().unwrap_or(last_m * f64::from(1_u32 << more.min(16)))
}

/// Finds feasible poses near the wanted ones.
///
/// # Errors
///
/// [`ResolveError`] if there is not one body for the table and each object of the tree, a body cannot be simulated, or
/// no round ends without faults; it names the objects at fault.
pub fn resolve(
    problem: ResolveProblem,
    settings: &ResolveSettings,
    settle_settings: &SettleSettings,
    certify: &CertifySettings,
    cancel: &CancelFlag,
) -> Result<ResolvedLayout, ResolveError> {
    let (bodies, objects) = (problem.bodies.len(), problem.supports.len());
    if bodies != objects + 1 {
        return Err(ResolveError::BadSupport { bodies, objects });
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
    let tree = BodyTree::new(problem.supports);
    let scene = Scene { problem, shapes, tree, settings, settle: settle_settings, certify };
    let wanted: Vec<Pose> = problem.bodies.iter().map(|b| b.world_from_object).collect();
    let (mut plan, mut log) = (wanted.clone(), Vec::new());
    let mut nudges = vec![0_usize; wanted.len()];
    let mut insets_m = vec![0.0; wanted.len()];
    let mut faults: Vec<Fault> = Vec::new();
    let planned_rounds = settings.clearances_m.len();
    let (mut rounds, mut more_space) = (planned_rounds, 0);
    for round in 0..planned_rounds + EXTRA_ROUNDS + EXTRA_DRAWS {
        cancel.check()?;
        if round >= planned_rounds {
            // The remaining faults must be those that more space or another draw may mend.
            more_space += usize::from(faults.iter().any(|fault| fault.needs_space && !fault.needs_draw));
            let draws = round + 1 - planned_rounds - more_space;
            let is_mended = |fault: &Fault| fault.needs_space || fault.needs_draw;
            if more_space > EXTRA_ROUNDS || draws > EXTRA_DRAWS || !faults.iter().all(is_mended) {
                break;
            }
            rounds = round + 1;
        }
        let clearance_m = clearance_m(settings, round.min(planned_rounds.saturating_sub(1)) + more_space);
        for fault in faults.iter().filter(|fault| fault.nudge) {
            nudges[fault.body] += 1;
        }
        for fault in faults.iter().filter(|fault| fault.over_edge_m > 0.0) {
            insets_m[fault.body] += fault.over_edge_m + settings.outline_margin_m;
        }
        // Dropping changes heights and pushing changes the supporters below, so the two alternate.
        let mut seated = vec![None; plan.len()];
        for _ in 0..3 {
            place::drop_all(&scene, &mut plan, &nudges, &mut seated, &mut log, cancel)?;
            if !separate::push_apart(&scene, &mut plan, clearance_m, &insets_m, &mut log, cancel)? {
                break;
            }
        }
        let last = round + 1 >= planned_rounds;
        let (settled, found) = settle_and_judge(&scene, &plan, last, cancel)?;
        faults = found;
        if faults.is_empty() {
            return Ok(finish(&scene, &wanted, &plan, settled.poses, round + 1, log));
        }
        log.extend(faults.iter().map(|fault| format!("round {}: {}", round + 1, fault.reason)));
    }
    let mut names: Vec<String> = faults.iter().map(|f| scene.name(f.body).to_owned()).collect();
    names.dedup();
    let reasons = faults.into_iter().map(|fault| fault.reason).collect();
    Err(ResolveError::Unresolved { rounds, reasons, names })
}

/// Settles and collects faults. Without faults it checks that nothing moves any more, and settles again from there
/// while something does.
fn settle_and_judge(
    scene: &Scene,
    plan: &[Pose],
    last_round: bool,
    cancel: &CancelFlag,
) -> Result<(SettledPoses, Vec<Fault>), ResolveError> {
    let mut bodies = scene.problem.bodies.to_vec();
    bodies.iter_mut().zip(plan).for_each(|(body, pose)| body.world_from_object = *pose);
    let mut settled = settle(&bodies, scene.settle, cancel)?;
    if scene.settings.settles == 0 {
        let faults = find_faults(scene, plan, &settled.poses, last_round, cancel)?;
        return Ok((settled, faults));
    }
    let mut moving = Vec::new();
    for _ in 0..scene.settings.settles {
        bodies.iter_mut().zip(&settled.poses).for_each(|(body, pose)| body.world_from_object = *pose);
        // Faults are rare, and one island of bodies is often simulated long after all others.
        let (faults, check) = rayon::join(
            || find_faults(scene, plan, &settled.poses, last_round, cancel),
            || stability(&bodies, scene.certify, scene.settle, cancel),
        );
        let faults = faults?;
        if !faults.is_empty() {
            return Ok((settled, faults));
        }
        let check = check?;
        moving = (0..bodies.len())
            .filter(|&k| {
                let movement = check.movements[k];
                movement.displacement_m > scene.settings.rest_displacement_m
                    || movement.rotation_rad > scene.settings.rest_rotation_rad
                    || !movement.at_rest
            })
            .map(|body| {
                let movement = check.movements[body];
                let (way_mm, overlap_mm) = (1e3 * movement.displacement_m, 1e3 * movement.overlap_m);
                let reason = if movement.overlap_m < movement.limit_m {
                    format!("{} does not come to rest ({way_mm:.1} mm)", scene.name(body))
                } else {
                    format!("{} rests {overlap_mm:.1} mm deep in another body", scene.name(body))
                };
                Fault::nudged(scene, body, reason)
            })
            .collect();
        if moving.is_empty() {
            break;
        }
        settled.poses = settle(&bodies, scene.settle, cancel)?.poses;
    }
    Ok((settled, moving))
}

fn find_faults(
    scene: &Scene,
    plan: &[Pose],
    poses: &[Pose],
    last_round: bool,
    cancel: &CancelFlag,
) -> Result<Vec<Fault>, ResolveError> {
    let (settings, certify) = (scene.settings, scene.certify);
    let mut faults = Vec::new();
    for body in scene.tree.order() {
        let name = scene.name(body);
        let (over_edge_m, _) = inside::missing(scene.problem.outline, &scene.footprint(body, poses), 0.0);
        if over_edge_m > 0.0 {
            let reason = format!("{name} reaches {:.0} mm over the table's edge", 1e3 * over_edge_m);
            faults.push(Fault { over_edge_m, needs_space: true, ..Fault::of(body, reason) });
        }
        let (parent, is_contained) = (scene.tree.parent(body), scene.tree.is_contained(body));
        if is_contained {
            if !contain::reaches_in(scene, body, parent, poses) {
                let reason = format!("{name} does not stay in {}", scene.name(parent));
                faults.push(Fault::nudged(scene, body, reason));
            }
        } else if !touches_group(scene, body, parent, poses, certify.contact_gap_m) {
            let reason = format!("{name} fell off {}", scene.name(parent));
            faults.push(Fault::nudged(scene, body, reason));
        }
        let turned = angle_between_rad(&plan[body], &poses[body]);
        if !is_contained && turned > settings.fallen_rotation_rad && !last_round {
            let reason = format!("{name} turned by {:.0} degrees while settling", turned.to_degrees());
            faults.push(Fault::of(body, reason));
        }
    }
    // What follows costs a hundred times more.
    if !faults.is_empty() {
        return Ok(faults);
    }
    let solids: Vec<PlacedSolid> = scene
        .problem
        .solids
        .iter()
        .zip(poses)
        .map(|(solid, pose)| PlacedSolid { solid, world_from_object: *pose })
        .collect();
    let movable: Vec<usize> = scene.tree.order().collect();
    let findings: Vec<SupportFinding> = movable
        .par_iter()
        .map(|&body| {
            let carriers = carriers(scene.problem.supports, body);
            support(&solids, scene.problem.bodies, body, &carriers, certify, cancel)
        })
        .collect::<Result<_, Cancelled>>()?;
    for (&body, finding) in movable.iter().zip(&findings).filter(|(_, finding)| !finding.is_supported()) {
        let over_mm = 1e3 * (certify.support_dilation_m - finding.margin_m);
        let reason = format!("{} hangs {over_mm:.0} mm over what carries it", scene.name(body));
        faults.push(Fault::nudged(scene, body, reason));
    }
    for pair in collisions(&solids, certify, cancel)?.colliding {
        let body = if pair.a == TABLE { pair.b } else { pair.a };
        let (a, b) = (scene.name(pair.a), scene.name(pair.b));
        let reason = format!("{a} and {b} overlap by {:.1} mm", 1e3 * pair.depth_m);
        // Gravity closes every gap in a container, so what it holds is placed elsewhere and turned instead.
        let is_inside = |&k: &usize| k != TABLE && scene.tree.is_contained(k);
        let contained = [pair.b, pair.a].into_iter().find(is_inside);
        faults.push(match contained {
            Some(body) => Fault::nudged(scene, body, reason),
            None => Fault { needs_space: true, ..Fault::of(body, reason) },
        });
    }
    Ok(faults)
}

/// Whether a body touches its supporter, or something its supporter carries.
fn touches_group(scene: &Scene, body: usize, parent: usize, poses: &[Pose], gap_m: f64) -> bool {
    let own = scene.placed(body, poses);
    let carried_by_parent = |other: usize| {
        other == parent
            || (parent != TABLE
                && other != body
                && scene.tree.is_below(other, parent)
                && !scene.tree.is_below(other, body))
    };
    (0..poses.len())
        .filter(|&other| carried_by_parent(other))
        .any(|other| are_closer(&own, &scene.placed(other, poses), gap_m))
}

fn finish(
    scene: &Scene,
    wanted: &[Pose],
    plan: &[Pose],
    poses: Vec<Pose>,
    rounds: usize,
    mut log: Vec<String>,
) -> ResolvedLayout {
    let displacements_m: Vec<f64> = poses
        .iter()
        .zip(wanted)
        .map(|(p, w)| (p.translation_m - w.translation_m).truncate().length())
        .collect();
    let rotations_rad: Vec<f64> = poses.iter().zip(wanted).map(|(p, w)| angle_between_rad(p, w)).collect();
    for (body, pose) in poses.iter().enumerate() {
        let turned = angle_between_rad(&plan[body], pose);
        if turned > scene.settings.fallen_rotation_rad {
            log.push(format!(
                "{} came to rest turned by {:.0} degrees",
                scene.name(body),
                turned.to_degrees()
            ));
        }
    }
    ResolvedLayout { poses, planned: plan.to_vec(), displacements_m, rotations_rad, rounds, log }
}

#[cfg(test)]
mod tests;
