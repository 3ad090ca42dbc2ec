//! Convex decomposition: the collision geometry of a visual mesh.
//!
//! Each closed shell is looked at alone (a mug's handle, its body); open and broken ones are repaired first. A convex
//! one is its own hull and costs nothing. Any other is cut by planes, exactly: of the cuts that lessen its concavity
//! most that one is taken which leaves the least air in the hulls of the halves, until no piece's hull
//! sticks out of the mesh by more than the tolerance; then neighbors whose common hull stays within it are joined,
//! across shells too. Where that leaves too many, the pairs are joined that add the least volume. Cuts run
//! through the visual surface itself, not through voxels, so flat undersides stay flat at their height and
//! cavities and handles stay open. Hulls inside another vanish.
//!
//! The idea of cutting the mesh itself by planes until each part is nearly convex is that of CoACD (Wei et al.
//! 2022), with a greedy choice of planes instead of a tree search. As pieces lie in cells that do not overlap,
//! the sum of their hulls' volumes over the solid's tells how well they fit.
//!
//! Input: meters, object frame; output in the same frame. Guarantees: at most `max_vertices` corners a
//! hull, at least `min_thickness_m` thick, same bytes with any number of threads.

mod budget;
mod concavity;
mod cut;
mod depth;
mod excess;
mod field;
mod fit;
mod fitted;
mod merge;
mod partition;
mod piece;
mod plane;
mod profile;
mod turned;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::excess::excess;
use self::field::Field;
pub use self::fit::HullFit;
use self::fit::fit;
use self::fitted::Fitted;
use self::merge::merged;
use self::partition::cut_apart;
use self::turned::Turned;
use super::ConvexHull;
use super::TexturedMesh;
use super::convex_hull::{convex_hull, distance_above, planes};
use super::mesh_solid::{MeshSolid, SolidError};
use super::repair::{Repair, repaired};
use super::shells::{Shell, shells};
use runtime::{Interrupt, Interrupted};

/// Section `[decompose]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct DecomposeSettings {
    /// How far a hull may stick out of the visual mesh, meters, 0.0001..0.01. Pieces beyond it are cut,
    /// pairs within it are joined. Less: closer and more hulls.
    pub tolerance_m: f64,
    /// Most hulls of a mesh, 1..256. When the tolerance asks for more, hulls go on being joined, those
    /// that add the least volume first. More: closer fit, slower contact.
    pub max_hulls: u32,
    /// How far a hull may stick out that is joined because there are more than `max_hulls`, meters, 0.0005..1; where that
    /// leaves too many it is raised by halves. Less: gaps and holes stay open. More: less air in all hulls together.
    pub joined_excess_m: f64,
    /// Most pieces concave shells are cut into before joining, together, 1..512 (the worst is always cut
    /// next; each shell may have twelve). More: closer fit of lumpy things, slower.
    pub max_pieces: u32,
    /// Most corners of a hull, 8..255. 64 is what GPU engines accept.
    pub max_vertices: u32,
    /// Least thickness of a hull, meters, 0..0.01. Thin sheets tunnel through things.
    pub min_thickness_m: f64,
    /// Spacing of the samples that measure how far hulls stick out, meters, 0.001..0.02. More: faster,
    /// narrow gaps are overlooked.
    pub excess_spacing_m: f64,
}

/// The hulls of a mesh and how well they fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decomposition {
    pub hulls: Vec<ConvexHull>,
    /// Largest distance by which a hull sticks out of the visual mesh, meters.
    pub max_excess_m: f64,
    /// Sum of the hulls' volumes (overlaps count twice) and of the shells', m^3.
    pub hull_volume_m3: f64,
    pub mesh_volume_m3: f64,
    /// Whether every shell of the mesh was closed as it came.
    pub watertight: bool,
    /// What was done to the mesh before.
    pub repair: Repair,
}

/// Why a mesh has no hulls.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecomposeError {
    #[error("decomposing: no part of the mesh has a convex hull with volume; repair or replace the mesh")]
    NoHull,
    #[error("decomposing: {0}")]
    Solid(#[from] SolidError),
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Convex hulls that cover the mesh and leave its cavities open.
pub fn decompose(
    mesh: &TexturedMesh,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Decomposition, DecomposeError> {
    let subject = Subject::new(mesh, settings)?;
    subject.decompose(&Field::new(&subject.solid), settings, interrupt)
}

/// As [`decompose`], and how well the hulls stand for the mesh.
pub fn decompose_and_fit(
    mesh: &TexturedMesh,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<(Decomposition, HullFit), DecomposeError> {
    let subject = Subject::new(mesh, settings)?;
    let field = Field::new(&subject.solid);
    let found = subject.decompose(&field, settings, interrupt)?;
    let fit = fit(&subject.solid, &field, &found.hulls, interrupt)?;
    Ok((found, fit))
}

/// A mesh made ready: repaired, and as a solid.
struct Subject {
    shells: Vec<Shell>,
    solid: MeshSolid,
    repair: Repair,
    /// Whether every shell was closed as it came.
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
        interrupt: &Interrupt,
    ) -> Result<Decomposition, DecomposeError> {
        let shells = &self.shells;
        let outward: Vec<usize> = (0..shells.len()).filter(|&k| shells[k].volume_m3() >= 0.0).collect();
        let ways: Vec<Way> = outward.iter().map(|&k| Way::of(&shells[k], settings)).collect();
        let concave: Vec<(usize, &Shell)> = outward
            .iter()
            .zip(&ways)
            .filter(|(_, way)| matches!(way, Way::CutApart))
            .map(|(&k, _)| (k, &shells[k]))
            .collect();
        let turned: Vec<&Turned> = ways.iter().filter_map(Way::turned).collect();
        let mut others: Vec<Fitted> = ways.iter().filter_map(Way::convex).cloned().collect();
        others.extend(cut_apart(&concave, field, settings, interrupt)?);
        let join = |turned: Vec<Fitted>| {
            let pieces = without_enclosed(turned.into_iter().chain(others.iter().cloned()).collect());
            merged(pieces, field, settings, interrupt)
        };
        let mut joined = join(turned_closely(&turned, field, settings, interrupt)?)?;
        let farthest_m = joined.iter().map(|f| f.excess_m).fold(0.0, f64::max);
        if !turned.is_empty() && farthest_m > BLOCKED * settings.joined_excess_m {
            let coarsely = join(turned_coarsely(&turned, field, settings, interrupt)?)?;
            let volume_m3 = |hulls: &[Fitted]| hulls.iter().map(|f| f.hull.volume_m3()).sum::<f64>();
            if volume_m3(&coarsely) < volume_m3(&joined) {
                joined = coarsely;
            }
        }
        let finished: Vec<Fitted> = joined
            .into_par_iter()
            .map(|fitted| finished(fitted, field, settings, interrupt))
            .collect::<Result<Vec<_>, Interrupted>>()?
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

/// How a shell is covered.
enum Way {
    /// By one hull; none where it is flat.
    Convex(Option<Fitted>),
    Turned(Turned),
    CutApart,
}

impl Way {
    fn turned(&self) -> Option<&Turned> {
        if let Self::Turned(turned) = self { Some(turned) } else { None }
    }

    fn convex(&self) -> Option<&Fitted> {
        if let Self::Convex(hull) = self { hull.as_ref() } else { None }
    }

    fn of(shell: &Shell, settings: &DecomposeSettings) -> Self {
        if shell.is_closed() && !shell.is_convex() {
            return Turned::recognize(shell).map_or(Self::CutApart, Self::Turned);
        }
        let hull = convex_hull(&shell.points, usize::MAX, settings.min_thickness_m);
        Self::Convex(hull.map(|hull| Fitted { hull, excess_m: 0.0 }))
    }
}

/// Hulls of a turned body before joining, for one that there may be.
const TURNED_SURPLUS: usize = 3;
/// Joining that had to let hulls stick out this much farther than it should may have closed a cavity: sectors of a vase's belly
/// that are joined upward first cannot be joined sideways any more.
const BLOCKED: f64 = 2.0;
/// By how much the tolerance is relaxed where a turned body has too many hulls.
const RELAX: f64 = 1.2;
/// Past any wall relaxing does not help, meters.
const MOST_RELAXED_M: f64 = 0.02;

/// Hulls of turned bodies, for each the tolerance relaxed until there are few enough of them to be joined.
fn turned_closely(
    turned: &[&Turned],
    solid: &Field,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Fitted>, Interrupted> {
    let hulls_of = |turned: &&Turned| {
        let mut tolerance_m = settings.tolerance_m;
        let mut most = TURNED_SURPLUS * settings.max_hulls as usize;
        loop {
            if let Some(hulls) = turned.hulls(tolerance_m, most, solid, settings, interrupt)? {
                return Ok(hulls);
            }
            tolerance_m *= RELAX;
            if tolerance_m > MOST_RELAXED_M {
                most = usize::MAX;
            }
        }
    };
    let hulls = turned.par_iter().map(hulls_of).collect::<Result<Vec<Vec<Fitted>>, Interrupted>>()?;
    Ok(hulls.into_iter().flatten().collect())
}

/// Hulls of turned bodies, the tolerance of all relaxed until nothing needs to be joined.
fn turned_coarsely(
    turned: &[&Turned],
    solid: &Field,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Fitted>, Interrupted> {
    let mut tolerance_m = settings.tolerance_m;
    loop {
        let is_last = tolerance_m > MOST_RELAXED_M;
        let most = if is_last { usize::MAX } else { settings.max_hulls as usize };
        let hulls = turned
            .par_iter()
            .map(|turned| turned.hulls(tolerance_m, most, solid, settings, interrupt))
            .collect::<Result<Vec<Option<Vec<Fitted>>>, Interrupted>>()?;
        let all: Option<Vec<Fitted>> = hulls
            .into_iter()
            .collect::<Option<Vec<Vec<Fitted>>>>()
            .map(|hulls| hulls.into_iter().flatten().collect());
        if let Some(all) = all.filter(|all| all.len() <= most) {
            return Ok(all);
        }
        tolerance_m *= RELAX;
    }
}

/// The hull as it is handed out: few corners, not too thin.
fn finished(
    fitted: Fitted,
    solid: &Field,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Option<Fitted>, Interrupted> {
    let points = &fitted.hull.points;
    let Some(hull) = convex_hull(points, settings.max_vertices as usize, settings.min_thickness_m) else {
        return Ok(None);
    };
    if hull == fitted.hull {
        return Ok(Some(fitted));
    }
    let found = excess(&hull, solid, settings.excess_spacing_m, fitted.excess_m, f64::INFINITY, interrupt)?;
    Ok(Some(Fitted { hull, excess_m: found.distance_m.max(fitted.excess_m) }))
}

/// Drops hulls all of whose corners lie in another one.
fn without_enclosed(hulls: Vec<Fitted>) -> Vec<Fitted> {
    let faces: Vec<_> = hulls.iter().map(|f| planes(&f.hull)).collect();
    let volumes_m3: Vec<f64> = hulls.iter().map(|f| f.hull.volume_m3()).collect();
    let mut dropped = vec![false; hulls.len()];
    for a in 0..hulls.len() {
        dropped[a] = (0..hulls.len()).any(|b| {
            b != a
                && !dropped[b]
                // Of a sliver's faces some may be too thin to have a plane.
                && volumes_m3[a] <= volumes_m3[b]
                && hulls[a].hull.points.iter().all(|&p| distance_above(&faces[b], p) <= 1e-9)
        });
    }
    hulls.into_iter().zip(dropped).filter(|(_, dropped)| !dropped).map(|(hull, _)| hull).collect()
}
