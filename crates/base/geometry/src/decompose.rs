//! Convex decomposition: the collision geometry of a visual mesh.
//!
//! Each closed shell is decomposed alone (a mug's handle, its body); open and broken shells are repaired first. A
//! convex shell is its own hull. Any other shell is cut exactly by planes: of the cuts that reduce its concavity most,
//! the one with the least air in the hulls of the halves is taken, until no piece's hull exceeds the mesh by more than
//! the tolerance. Then neighbors whose common hull stays within the tolerance are merged, also across shells. If too
//! many hulls remain, the pairs that add the least volume are merged. Cuts run through the visual surface itself
//! instead of voxels, so flat undersides stay flat at their height and cavities and handles stay open. Hulls inside
//! another hull are dropped. Boxes and cylinders with rounded edges are squared ([`SimpleSolid::rounding`]).
//!
//! Cutting the mesh itself by planes until each part is nearly convex follows CoACD (Wei et al. 2022), with a greedy
//! choice of planes instead of a tree search. Pieces lie in disjoint cells, so the sum of their hulls' volumes over the
//! solid's volume measures the fit.
//!
//! Input: meters, object frame; output in the same frame. Guarantees: at most `max_vertices` corners per hull, at least
//! `min_thickness_m` thick, the same bytes with any number of threads.

mod budget;
mod concavity;
mod cut;
mod depth;
mod excess;
mod field;
mod fit;
mod fitted_hull;
mod merge;
mod openings;
mod partition;
mod piece;
mod plane;
mod profile;
mod revolution;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::excess::excess;
use self::field::Field;
pub use self::fit::HullFit;
use self::fit::fit;
use self::fitted_hull::FittedHull;
use self::merge::merged;
use self::partition::cut_apart;
use self::revolution::Revolution;
use super::ConvexHull;
use super::SimpleSolid;
use super::TexturedMesh;
use super::convex_hull::{convex_hull, convex_hulls, distance_above, planes, without_slivers};
use super::repair::{Repair, repaired};
use super::shells::{Shell, shells};
use super::solid_query::{MeshSolid, SolidError};
use runtime::{CancelFlag, Cancelled};

/// Section `[decompose]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct DecomposeSettings {
    /// Maximum excess of a hull over the visual mesh, meters, 0.0001..0.01. Pieces beyond it are cut,
    /// pairs within it are merged. Smaller: closer fit, more hulls.
    pub tolerance_m: f64,
    /// Maximum number of hulls of a mesh, 1..256. If the tolerance requires more, hulls are merged further, those
    /// that add the least volume first. Larger: closer fit, slower contact.
    pub max_hulls: u32,
    /// Maximum excess of a hull that is merged because there are more than `max_hulls`, meters, 0.0005..1. If too many
    /// hulls remain, it is raised by halves. Smaller: gaps and holes stay open. Larger: less air in all hulls together.
    pub joined_excess_m: f64,
    /// Maximum number of pieces of all concave shells before merging, 1..512. The worst piece is cut next; each shell
    /// may have twelve. Larger: closer fit of irregular objects, slower.
    pub max_pieces: u32,
    /// Maximum number of corners of a hull, 8..255. GPU engines accept 64.
    pub max_vertices: u32,
    /// Minimum thickness of a hull, meters, 0..0.01. Thin sheets tunnel through other objects.
    pub min_thickness_m: f64,
    /// Spacing of the samples that measure the excess of hulls, meters, 0.001..0.02. Larger: faster,
    /// narrow gaps are missed.
    pub excess_spacing_m: f64,
}

/// The hulls of a mesh with measures of their fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decomposition {
    pub hulls: Vec<ConvexHull>,
    /// Largest excess of a hull over the visual mesh, meters.
    pub max_excess_m: f64,
    /// Sum of the volumes of the hulls (overlaps count twice) and of the shells, m^3.
    pub hull_volume_m3: f64,
    pub mesh_volume_m3: f64,
    /// Whether every shell of the input mesh was closed.
    pub watertight: bool,
    /// Changes made to the mesh before the decomposition.
    pub repair: Repair,
}

/// Failure of a decomposition.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecomposeError {
    #[error("decomposing: no part of the mesh has a convex hull with volume; repair or replace the mesh")]
    NoHull,
    #[error("decomposing: {0}")]
    Solid(#[from] SolidError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Convex hulls that cover the mesh and leave its cavities open.
///
/// # Errors
///
/// [`DecomposeError`] if the mesh encloses no volume or the computation was cancelled.
pub fn decompose(
    mesh: &TexturedMesh,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Decomposition, DecomposeError> {
    let subject = Subject::new(mesh, settings)?;
    subject.decompose(&Field::new(&subject.solid), settings, cancel)
}

/// As [`decompose`], with the measured fit of the hulls to the mesh.
///
/// # Errors
///
/// As [`decompose`].
pub fn decompose_and_fit(
    mesh: &TexturedMesh,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<(Decomposition, HullFit), DecomposeError> {
    let subject = Subject::new(mesh, settings)?;
    let field = Field::new(&subject.solid);
    let found = subject.decompose(&field, settings, cancel)?;
    let fit = fit(&subject.solid, &field, &found.hulls, cancel)?;
    Ok((found, fit))
}

/// A repaired mesh with its solid.
struct Subject {
    shells: Vec<Shell>,
    solid: MeshSolid,
    repair: Repair,
    /// Whether every input shell was closed.
    watertight: bool,
}

impl Subject {
    fn new(mesh: &TexturedMesh, settings: &DecomposeSettings) -> Result<Self, DecomposeError> {
        let given = shells(mesh);
        if given.is_empty() {
            return Err(DecomposeError::NoHull);
        }
        let watertight = given.iter().all(Shell::is_closed);
        let (shells, repair) = repaired(given, settings.min_thickness_m);
        let solid = MeshSolid::from_shells(&shells)?;
        Ok(Self { shells, solid, repair, watertight })
    }

    fn decompose(
        &self,
        field: &Field,
        settings: &DecomposeSettings,
        cancel: &CancelFlag,
    ) -> Result<Decomposition, DecomposeError> {
        let shells = &self.shells;
        let outward: Vec<usize> = (0..shells.len()).filter(|&k| shells[k].volume_m3() >= 0.0).collect();
        let covers: Vec<Cover> = outward.iter().map(|&k| Cover::of(&shells[k], settings)).collect();
        let concave: Vec<(usize, &Shell)> = outward
            .iter()
            .zip(&covers)
            .filter(|(_, cover)| matches!(cover, Cover::CutApart))
            .map(|(&k, _)| (k, &shells[k]))
            .collect();
        let revolutions: Vec<&Revolution> = covers.iter().filter_map(Cover::revolution).collect();
        let mut others: Vec<FittedHull> = covers.iter().filter_map(Cover::convex).cloned().collect();
        others.extend(cut_apart(&concave, field, settings, cancel)?);
        let join = |hulls: Vec<FittedHull>| {
            let pieces = without_enclosed(hulls.into_iter().chain(others.iter().cloned()).collect());
            merged(pieces, field, settings, cancel)
        };
        let mut joined = join(revolution_hulls_relaxed_separately(&revolutions, field, settings, cancel)?)?;
        let farthest_m = joined.iter().map(|f| f.excess_m).fold(0.0, f64::max);
        if !revolutions.is_empty() && farthest_m > BLOCKED * settings.joined_excess_m {
            let coarsely = join(revolution_hulls_relaxed_together(&revolutions, field, settings, cancel)?)?;
            let volume_m3 = |hulls: &[FittedHull]| hulls.iter().map(|f| f.hull.volume_m3()).sum::<f64>();
            if volume_m3(&coarsely) < volume_m3(&joined) {
                joined = coarsely;
            }
        }
        // What is round may become two hulls; there are as many as permitted at most.
        let may_halve = 2 * joined.len() <= settings.max_hulls as usize;
        let finished: Vec<FittedHull> = joined
            .into_par_iter()
            .map(|fitted_hull| finished(fitted_hull, may_halve, field, settings, cancel))
            .collect::<Result<Vec<_>, Cancelled>>()?
            .into_iter()
            .flatten()
            .collect();
        if finished.is_empty() {
            return Err(DecomposeError::NoHull);
        }
        let kept = without_enclosed(finished);
        let max_excess_m = kept.iter().map(|f| f.excess_m).fold(0.0, f64::max);
        let hulls: Vec<ConvexHull> = kept.into_iter().map(|f| f.hull).collect();
        Ok(Decomposition {
            max_excess_m,
            hull_volume_m3: hulls.iter().map(ConvexHull::volume_m3).sum(),
            mesh_volume_m3: shells.iter().map(Shell::volume_m3).sum(),
            watertight: self.watertight,
            repair: self.repair,
            hulls,
        })
    }
}

/// Cover of one shell by convex hulls.
enum Cover {
    /// By one hull; by none if it is flat.
    Convex(Option<FittedHull>),
    Revolution(Revolution),
    CutApart,
}

impl Cover {
    fn revolution(&self) -> Option<&Revolution> {
        if let Self::Revolution(revolution) = self { Some(revolution) } else { None }
    }

    fn convex(&self) -> Option<&FittedHull> {
        if let Self::Convex(hull) = self { hull.as_ref() } else { None }
    }

    fn of(shell: &Shell, settings: &DecomposeSettings) -> Self {
        if shell.is_closed() && !shell.is_convex() {
            return Revolution::recognize(shell).map_or(Self::CutApart, Self::Revolution);
        }
        let hull = convex_hull(&shell.points, usize::MAX, settings.min_thickness_m);
        Self::Convex(hull.map(|hull| FittedHull { hull, excess_m: 0.0 }))
    }
}

/// Number of hulls of a body of revolution before merging, per permitted hull.
const REVOLUTION_SURPLUS: usize = 3;
/// Factor of the tolerance by which merged hulls may exceed the mesh before a closed cavity is suspected: sectors of a
/// vase's belly that are merged upward first can no longer be merged sideways.
const BLOCKED: f64 = 2.0;
/// Factor by which the tolerance is relaxed if a body of revolution has too many hulls.
const RELAX: f64 = 1.2;
/// Tolerance beyond any wall thickness, where relaxation has no effect, meters.
const MAX_RELAXED_M: f64 = 0.02;

/// Hulls of bodies of revolution; the tolerance of each is relaxed until there are few enough of them to be merged.
fn revolution_hulls_relaxed_separately(
    revolutions: &[&Revolution],
    solid: &Field,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Vec<FittedHull>, Cancelled> {
    let hulls_of = |revolution: &&Revolution| {
        let mut tolerance_m = settings.tolerance_m;
        let mut highest = REVOLUTION_SURPLUS * settings.max_hulls as usize;
        loop {
            if let Some(hulls) = revolution.hulls(tolerance_m, highest, solid, settings, cancel)? {
                return Ok(hulls);
            }
            tolerance_m *= RELAX;
            if tolerance_m > MAX_RELAXED_M {
                highest = usize::MAX;
            }
        }
    };
    let hulls = revolutions.par_iter().map(hulls_of).collect::<Result<Vec<Vec<FittedHull>>, Cancelled>>()?;
    Ok(hulls.into_iter().flatten().collect())
}

/// Hulls of bodies of revolution; the tolerance of all is relaxed until nothing needs to be merged.
fn revolution_hulls_relaxed_together(
    revolutions: &[&Revolution],
    solid: &Field,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Vec<FittedHull>, Cancelled> {
    let mut tolerance_m = settings.tolerance_m;
    loop {
        let is_last = tolerance_m > MAX_RELAXED_M;
        let highest = if is_last { usize::MAX } else { settings.max_hulls as usize };
        let hulls = revolutions
            .par_iter()
            .map(|revolution| revolution.hulls(tolerance_m, highest, solid, settings, cancel))
            .collect::<Result<Vec<Option<Vec<FittedHull>>>, Cancelled>>()?;
        let all: Option<Vec<FittedHull>> = hulls
            .into_iter()
            .collect::<Option<Vec<Vec<FittedHull>>>>()
            .map(|hulls| hulls.into_iter().flatten().collect());
        if let Some(all) = all.filter(|all| all.len() <= highest) {
            return Ok(all);
        }
        tolerance_m *= RELAX;
    }
}

/// The final hull: limited number of corners, minimum thickness, no faces without area. A box or cylinder with rounded
/// edges has the hull of the box or cylinder, which engines take as one; anything else that is round has two hulls
/// where that is permitted; what has no volume has none.
fn finished(
    fitted_hull: FittedHull,
    may_halve: bool,
    solid: &Field,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Vec<FittedHull>, Cancelled> {
    let points = &fitted_hull.hull.points;
    let (max_vertices, min_thickness_m) = (settings.max_vertices as usize, settings.min_thickness_m);
    let squared = SimpleSolid::rounding(&fitted_hull.hull, settings.tolerance_m)
        .and_then(|solid| solid.hull(max_vertices / 2))
        .filter(|hull| hull.points.len() <= max_vertices);
    let found = match squared {
        Some(squared) => vec![squared],
        None if may_halve => convex_hulls(points, max_vertices, min_thickness_m),
        None => convex_hull(points, max_vertices, min_thickness_m).into_iter().collect(),
    };
    let with_excess = |hull: ConvexHull| -> Result<FittedHull, Cancelled> {
        if hull == fitted_hull.hull {
            return Ok(fitted_hull.clone());
        }
        let (spacing_m, known_m) = (settings.excess_spacing_m, fitted_hull.excess_m);
        let found = excess(&hull, solid, spacing_m, known_m, f64::INFINITY, cancel)?;
        Ok(FittedHull { hull, excess_m: found.distance_m.max(known_m) })
    };
    found.into_iter().map(without_slivers).map(with_excess).collect()
}

/// Drops hulls with all corners inside another hull.
fn without_enclosed(hulls: Vec<FittedHull>) -> Vec<FittedHull> {
    let faces: Vec<_> = hulls.iter().map(|f| planes(&f.hull)).collect();
    let volumes_m3: Vec<f64> = hulls.iter().map(|f| f.hull.volume_m3()).collect();
    let mut dropped = vec![false; hulls.len()];
    for a in 0..hulls.len() {
        dropped[a] = (0..hulls.len()).any(|b| {
            b != a
                && !dropped[b]
                // Some faces of a sliver may be too thin to have a plane.
                && volumes_m3[a] <= volumes_m3[b]
                && hulls[a].hull.points.iter().all(|&p| distance_above(&faces[b], p) <= 1e-9)
        });
    }
    hulls.into_iter().zip(dropped).filter(|(_, dropped)| !dropped).map(|(hull, _)| hull).collect()
}
