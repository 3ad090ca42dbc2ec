//! Layout synthesis: samples collision-free, functional arrangements of objects on a table.
//!
//! Objects form a support tree. Objects on or in a supporter are laid out first, in the supporter's frame; the group
//! then moves as one. On each surface (table, tray, plate) groups are placed one after the other. Candidate
//! placements are sampled from three sources: relations of the text, co-occurrence priors (the mouse right of the
//! keyboard, the fork left of the plate, one place setting for each plate, objects of one use beside each other), and
//! the zone of the category. Candidates that overlap, extend beyond the outline or violate a relation are rejected;
//! the candidate with the lowest cost is selected. An infeasible group ends the attempt, and the next attempt uses
//! another random stream. Late attempts use smaller gaps and larger tolerances.
//!
//! Exact demands (distances, positions, yaws, between, facing) move each candidate until it meets them
//! ([`exact_placement`]); arrangements are groups with fixed inner placements ([`arranged_group`]). If no attempt meets
//! all demands, they yield in the order of [`Yielding`]: habits of the theme, closeness, places, distances, then all
//! relations. If no attempt succeeds even so, the error names the objects without space.
//!
//! Input: meshes in canonical frames (meters, +z up, front toward -y) and their relations. Output: poses in the
//! world frame (table top at z = 0) with approximate heights, to be settled by simulation. Guarantees: the same input
//! gives the same poses; footprints on one surface are disjoint and lie inside the outline. Arrangements that lean are
//! out of scope. Cost: milliseconds for twelve objects.

mod footprint;
mod height_map;
mod support_tree;
mod spatial_constraints;
mod co_occurrence_priors;
mod habits;
mod place_settings;
mod support_surface;
mod group;
mod placement_sampler;
mod container;
mod stated_demands;
mod exact_placement;
mod arranged_group;
mod yielding;
#[cfg(test)]
mod stated_demands_tests;
#[cfg(test)]
mod tests;

use glam::{DQuat, DVec2};
use serde::{Deserialize, Serialize};

use self::footprint::Footprint;
use self::group::{Group, LayoutAttempt};
use self::height_map::HeightMap;
use catalog::Category;
use geometry::{Outline, Pose, TexturedMesh};
use runtime::seed::child_rng;
use runtime::{CancelFlag, Cancelled};
use scene::predicates::PosedFootprint;
use scene::{RelationKind, SupportTree};
pub use stated_demands::{Demand, DemandKind, StatedArrangement, StatedDemands};
pub use support_tree::support_tree;
pub use yielding::Yielding;

/// Section `[layout]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct LayoutSettings {
    /// Maximum number of attempts, 1..1000. Higher: fuller tables, slower failures.
    pub attempts: u32,
    /// Candidate placements for each object, 10..1000. Higher: more orderly, slower.
    pub candidates: u32,
    /// Free space around each object, meters, 0.002..0.1. Higher: sparser.
    pub gap_m: f64,
    /// Free space in the last attempts, meters, 0.001..`gap_m`.
    pub min_gap_m: f64,
    /// Minimum distance from the table's edge, meters, 0..0.2.
    pub edge_margin_m: f64,
    /// Scale of the random yaw of objects, radians, 0..0.5. Higher: less aligned.
    pub jitter_rad: f64,
    /// Upper bound of the uniform random term in the placement cost, 0..2. A relation violated by 10 cm costs 1.
    /// Higher: more varied, less orderly.
    pub placement_cost_noise: f64,
}

/// An object to place.
pub struct LayoutObject<'a> {
    /// Name in errors.
    pub name: String,
    pub category: &'a Category,
    /// Mesh in the canonical frame.
    pub mesh: &'a TexturedMesh,
    /// Relations to other objects by index; `None` is the table.
    pub relations: Vec<(RelationKind, Option<usize>)>,
}

/// Failure of the layout sampler.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LayoutError {
    #[error(
        "laying out the table: no room for {} after {attempts} attempts; ask for a larger table or fewer objects",
        names.join(", ")
    )]
    NoRoom { names: Vec<String>, attempts: u32 },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Position and yaw of an object on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Placement {
    xy_m: DVec2,
    yaw_rad: f64,
}

impl Placement {
    /// The composition: `self` is `outer_from_inner`, `inner` is `inner_from_object`.
    fn compose(&self, inner: &Placement) -> Placement {
        Placement {
            xy_m: self.xy_m + DVec2::from_angle(self.yaw_rad).rotate(inner.xy_m),
            yaw_rad: self.yaw_rad + inner.yaw_rad,
        }
    }
}

/// An object's category and geometry, precomputed for the sampler.
struct ObjectGeometry<'a> {
    category: &'a Category,
    mesh: &'a TexturedMesh,
    footprint: Footprint,
    height_m: f64,
    /// For supporters and containers only.
    height_map: Option<HeightMap>,
}

/// Objects to lay out on a table, with everything that a text demands.
#[derive(Clone, Copy)]
pub struct LayoutProblem<'a> {
    pub objects: &'a [LayoutObject<'a>],
    /// Indices are those of `objects`.
    pub stated: &'a StatedDemands,
    pub outline: &'a Outline,
    /// Demands that may stay unmet.
    pub max_yielding: Yielding,
}

/// A finished layout.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutOutcome {
    /// `world_from_object`, in the order of the objects.
    pub poses: Vec<Pose>,
    /// Demands that were permitted to stay unmet in the successful attempt; they may be met nevertheless.
    pub yielded: Yielding,
}

/// A pose for each object by plain relations, all of which are met. Another seed gives another arrangement.
///
/// # Errors
///
/// `NoRoom` if no attempt places every object; `Cancelled` if `cancel` is set.
pub fn arrange(
    objects: &[LayoutObject],
    outline: &Outline,
    seed: u64,
    settings: &LayoutSettings,
    cancel: &CancelFlag,
) -> Result<Vec<Pose>, LayoutError> {
    let stated = StatedDemands::default();
    let problem = LayoutProblem { objects, stated: &stated, outline, max_yielding: Yielding::Nothing };
    lay_out(problem, seed, settings, cancel).map(|outcome| outcome.poses)
}

/// A pose for each object that meets the demands, except those that yield. Another seed gives another layout.
///
/// # Errors
///
/// `NoRoom` if no attempt places every object; `Cancelled` if `cancel` is set.
pub fn lay_out(
    problem: LayoutProblem,
    seed: u64,
    settings: &LayoutSettings,
    cancel: &CancelFlag,
) -> Result<LayoutOutcome, LayoutError> {
    let LayoutProblem { objects, stated, outline, max_yielding } = problem;
    let supports = support_tree(objects);
    let geometries: Vec<ObjectGeometry> = objects
        .iter()
        .enumerate()
        .map(|(index, object)| {
            let is_supporter = supports.children(Some(index)).next().is_some();
            ObjectGeometry {
                category: object.category,
                mesh: object.mesh,
                footprint: Footprint::around(object.mesh.positions.iter().map(|p| p.truncate())),
                height_m: object.mesh.size_m().z,
                height_map: is_supporter.then(|| HeightMap::of(object.mesh)),
            }
        })
        .collect();
    let mut constraints = spatial_constraints::hard_constraints(objects, &supports, stated);
    co_occurrence_priors::add_soft_constraints(objects, &supports, &mut constraints);
    let mut failures = vec![0_u32; objects.len()];
    let mut count = 0;
    for yielding in Yielding::ALL.into_iter().filter(|yielding| *yielding <= max_yielding) {
        let attempts = yielding.attempts(settings.attempts);
        for number in 0..attempts {
            cancel.check()?;
            let lateness = f64::from(number) / f64::from(attempts);
            let relaxation = ((lateness - 0.4) / 0.5).clamp(0.0, 1.0);
            let mut attempt = LayoutAttempt {
                objects: &geometries,
                supports: &supports,
                constraints: &constraints,
                requests: objects,
                stated,
                yielding,
                settings,
                gap_m: settings.gap_m + relaxation * (settings.min_gap_m - settings.gap_m),
                tolerance_factor: 1.0 + 2.0 * relaxation,
                rng: child_rng(seed, &yielding.stream(number)),
            };
            match attempt.arrange_on(outline) {
                Ok(groups) => {
                    let poses = poses(&geometries, &supports, &groups);
                    return Ok(LayoutOutcome { poses, yielded: yielding });
                }
                Err(object) => failures[object] += 1,
            }
            count += 1;
        }
    }
    // Objects that failed in at least a fifth of the attempts.
    let min_failures = (count / 5).max(1).min(failures.iter().copied().max().unwrap_or(0));
    let names = objects
        .iter()
        .zip(&failures)
        .filter(|(_, f)| **f >= min_failures)
        .map(|(object, _)| object.name.clone())
        .collect();
    Err(LayoutError::NoRoom { names, attempts: count })
}

/// Footprint and height range of a posed mesh, for [`scene::predicates`]. A pose without a yaw has yaw 0.
pub fn posed_footprint(mesh: &TexturedMesh, world_from_object: &Pose) -> PosedFootprint {
    let points = mesh.positions.iter().map(|point| world_from_object.transform_point(*point));
    PosedFootprint::of_points(points, world_from_object)
}

/// Poses of all members of the groups on the table.
fn poses(objects: &[ObjectGeometry], supports: &SupportTree, groups: &[(Placement, Group)]) -> Vec<Pose> {
    let mut poses = vec![Pose::IDENTITY; objects.len()];
    for (placement, group) in groups {
        for member in &group.members {
            let at = placement.compose(&member.at);
            let rotation = DQuat::from_rotation_z(at.yaw_rad) * member.lean;
            poses[member.object] =
                Pose { translation_m: at.xy_m.extend(0.0), rotation: rotation.normalize() };
        }
    }
    for (object, pose) in poses.iter_mut().enumerate() {
        // Approximate height: the sum of the heights of the supporters.
        for below in supports.ancestors(object) {
            pose.translation_m.z += objects[below].height_m;
        }
    }
    poses
}

impl ObjectGeometry<'_> {
    /// Whether the longer horizontal extent is along the object's y axis.
    fn long_in_y(&self) -> bool {
        let size = self.footprint.size_m();
        size.y > size.x
    }

    /// Ratio of the longest to the second-longest extent.
    fn slenderness(&self) -> f64 {
        let size = self.footprint.size_m().extend(self.height_m);
        let mut extents = size.to_array();
        extents.sort_by(f64::total_cmp);
        extents[2] / extents[1].max(1e-6)
    }
}
