//! Cutting one shell into nearly convex pieces.

use super::DecomposeSettings;
use super::cut::ranked_cuts;
use super::excess::{Excess, excess};
use super::field::Field;
use super::fitted::Fitted;
use super::piece::Piece;
use crate::geometry::convex_hull::convex_hull;
use crate::geometry::shells::Shell;
use crate::geometry::{ConvexHull, Interrupt, Interrupted};

struct Leaf {
    piece: Piece,
    hull: ConvexHull,
    excess: Excess,
    /// No plane was found that cuts it.
    whole: bool,
}

/// Hulls of the pieces of a closed shell: always the piece whose hull sticks out the farthest is cut next,
/// until none exceeds the tolerance or there are `most` pieces. `index` is the shell's in the solid.
pub(super) fn cut_apart(
    shell: &Shell,
    index: usize,
    solid: &Field,
    settings: &DecomposeSettings,
    most: usize,
    interrupt: &Interrupt,
) -> Result<Vec<Fitted>, Interrupted> {
    let spacing_m = settings.excess_spacing_m;
    // A piece nobody can build a hull of is no piece: the cut that makes it is not taken.
    let leaf = |piece: Piece| -> Result<Option<Leaf>, Interrupted> {
        let Some(hull) = convex_hull(&piece.spanning_points(), usize::MAX, 0.0) else {
            return Ok(None);
        };
        let known_m = 0.5 * settings.tolerance_m;
        let excess = excess(&hull, solid, spacing_m, known_m, f64::INFINITY, interrupt)?;
        Ok(Some(Leaf { piece, hull, excess, whole: false }))
    };
    let is_inside = |p| solid.is_inside(index, p);
    let mut leaves: Vec<Leaf> = leaf(Piece::new(shell))?.into_iter().collect();
    while leaves.len() < most {
        let worst = (0..leaves.len())
            .filter(|&k| !leaves[k].whole && leaves[k].excess.distance_m > settings.tolerance_m)
            .max_by(|&a, &b| leaves[a].excess.distance_m.total_cmp(&leaves[b].excess.distance_m));
        let Some(k) = worst else { break };
        leaves[k].whole = true;
        for plane in ranked_cuts(&leaves[k].piece, leaves[k].excess.at, settings.tolerance_m) {
            let Some((below, above)) = leaves[k].piece.split(&plane, is_inside) else { continue };
            if let (Some(below), Some(above)) = (leaf(below)?, leaf(above)?) {
                leaves.splice(k..=k, [below, above]);
                break;
            }
        }
    }
    Ok(leaves.into_iter().map(|l| Fitted { hull: l.hull, excess_m: l.excess.distance_m }).collect())
}
