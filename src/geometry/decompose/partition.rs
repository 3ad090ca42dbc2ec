//! Cutting shells into nearly convex pieces.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::DecomposeSettings;
use super::cut::ranked_cuts;
use super::excess::{Excess, excess};
use super::field::Field;
use super::fitted::Fitted;
use super::piece::Piece;
use super::plane::Plane;
use crate::geometry::convex_hull::convex_hull;
use crate::geometry::shells::Shell;
use crate::geometry::{ConvexHull, Interrupt, Interrupted};

struct Leaf {
    /// Index of its shell in the solid.
    shell: usize,
    piece: Piece,
    hull: ConvexHull,
    excess: Excess,
    /// No plane was found that cuts it.
    whole: bool,
}

/// Vertical planes through the middle that cut a shell into sectors.
const SECTOR_PLANES: u32 = 4;

/// An excess of this many tolerances means that the greedy cuts found no way to open a cavity.
const STUCK: f64 = 4.0;

/// Hulls of the pieces of closed shells, see [`greedy`]. Where cutting the worst piece leads nowhere (the wall of
/// a woven basket is sliced into rings, and no single cut opens a ring), every shell starts as eight sectors
/// around its middle; the better of the two is taken.
pub(super) fn cut_apart(
    shells: &[(usize, &Shell)],
    solid: &Field,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Fitted>, Interrupted> {
    let worst_m = |found: &[Fitted]| found.iter().map(|f| f.excess_m).fold(0.0, f64::max);
    let straight = greedy(shells, false, solid, settings, interrupt)?;
    if worst_m(&straight) <= STUCK * settings.tolerance_m {
        return Ok(straight);
    }
    let by_sectors = greedy(shells, true, solid, settings, interrupt)?;
    Ok(if worst_m(&by_sectors) < worst_m(&straight) { by_sectors } else { straight })
}

/// Planes that cut a shell into sectors, wider ones where it is wider.
fn sector_planes(shell: &Shell) -> Vec<Plane> {
    let (low, high) = shell.bounds();
    let (middle, size) = (0.5 * (low + high), high - low);
    (0..SECTOR_PLANES)
        .map(|k| {
            let (sin, cos) = (PI * f64::from(k) / f64::from(SECTOR_PLANES)).sin_cos();
            Plane::through(middle, DVec3::new(-sin * size.y, cos * size.x, 0.0).normalize_or(DVec3::X))
        })
        .collect()
}

/// Always the piece whose hull the piece whose hull sticks out the farthest is cut next, of whichever shell it is, until none exceeds the
/// tolerance or there are `max_pieces` of all together. Shells come with their index in the solid.
fn greedy(
    shells: &[(usize, &Shell)],
    sectors: bool,
    solid: &Field,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Fitted>, Interrupted> {
    let spacing_m = settings.excess_spacing_m;
    // A piece nobody can build a hull of is no piece: the cut that makes it is not taken.
    let leaf = |shell: usize, piece: Piece| -> Result<Option<Leaf>, Interrupted> {
        let Some(hull) = convex_hull(&piece.spanning_points(), usize::MAX, 0.0) else {
            return Ok(None);
        };
        let known_m = 0.5 * settings.tolerance_m;
        let excess = excess(&hull, solid, spacing_m, known_m, f64::INFINITY, interrupt)?;
        Ok(Some(Leaf { shell, piece, hull, excess, whole: false }))
    };
    let whole: Vec<Option<Leaf>> = shells
        .par_iter()
        .map(|&(index, shell)| leaf(index, Piece::new(shell)))
        .collect::<Result<_, Interrupted>>()?;
    let mut leaves: Vec<Leaf> = whole.into_iter().flatten().collect();
    for &(index, shell) in shells.iter().filter(|_| sectors) {
        let is_inside = |p| solid.is_inside(index, p);
        for plane in sector_planes(shell) {
            let mut next = Vec::with_capacity(2 * leaves.len());
            for whole in leaves {
                let parts = (whole.shell == index).then(|| whole.piece.split(&plane, is_inside)).flatten();
                match parts
                    .map(|(below, above)| Ok((leaf(index, below)?, leaf(index, above)?)))
                    .transpose()?
                {
                    Some((Some(below), Some(above))) => next.extend([below, above]),
                    _ => next.push(whole),
                }
            }
            leaves = next;
        }
    }
    while leaves.len() < settings.max_pieces as usize {
        let worst = (0..leaves.len())
            .filter(|&k| !leaves[k].whole && leaves[k].excess.distance_m > settings.tolerance_m)
            .max_by(|&a, &b| leaves[a].excess.distance_m.total_cmp(&leaves[b].excess.distance_m));
        let Some(k) = worst else { break };
        leaves[k].whole = true;
        let shell = leaves[k].shell;
        let is_inside = |p| solid.is_inside(shell, p);
        for plane in ranked_cuts(&leaves[k].piece, leaves[k].excess.at, settings.tolerance_m) {
            let Some((below, above)) = leaves[k].piece.split(&plane, is_inside) else { continue };
            let (below, above) = rayon::join(|| leaf(shell, below), || leaf(shell, above));
            if let (Some(below), Some(above)) = (below?, above?) {
                leaves.splice(k..=k, [below, above]);
                break;
            }
        }
    }
    Ok(leaves.into_iter().map(|l| Fitted { hull: l.hull, excess_m: l.excess.distance_m }).collect())
}
