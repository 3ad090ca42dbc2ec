//! Partition of shells into nearly convex pieces by cuts.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::DecomposeSettings;
use super::cut::ranked_cuts;
use super::excess::{Excess, excess};
use super::field::Field;
use super::fitted_hull::FittedHull;
use super::piece::Piece;
use super::plane::Plane;
use crate::ConvexHull;
use crate::convex_hull::convex_hull;
use crate::shells::Shell;
use runtime::{CancelFlag, Cancelled};

/// The shell that a leaf is a part of.
#[derive(Clone, Copy)]
struct Whole {
    /// Index of the shell in the solid.
    shell: usize,
    volume_m3: f64,
}

struct Leaf {
    of: Whole,
    piece: Piece,
    hull: ConvexHull,
    excess: Excess,
    /// Air in the hull, m^3.
    air_m3: f64,
    /// Whether no cutting plane was found.
    is_final: bool,
}

/// Number of vertical planes through the center that cut a shell into twice as many sectors.
const SECTOR_PLANES: u32 = 4;
/// Air in the hulls after greedy cuts, share of the solid's volume, above which the cuts may have missed a cavity.
const STUCK: f64 = 0.05;
/// Minimum number of pieces for the comparison of greedy cuts with sectors.
const PROBE: usize = 12;
/// Excess, in tolerances, beyond which a piece is cut however little air its hull has.
const FAR: f64 = 4.0;
/// Air that is not worth a cut, in all pieces together, share of their shell's volume: the rest of an apple's dimple
/// would take thirty hulls.
const SLIGHT_AIR: f64 = 0.096;
/// Number of cuts of a piece for which hulls are built.
const CUTS_TRIED: usize = 8;
/// Weight of the remaining concavity relative to the remaining air in the score of a cut; concavity predicts later
/// cuts.
const FORESIGHT: f64 = 0.5;

/// Hulls of the pieces of closed shells. Shells come with their index in the solid.
///
/// The piece with the most air in its hull is cut next, alternating with the piece of the largest excess, over all
/// shells, until no piece is rough or there are `max_pieces` in total (each shell may have twelve in any case).
/// Greedy cuts fail on some shells: the wall of a woven basket is sliced into rings, and no single cut opens a ring.
/// Such a shell starts as eight sectors around its center, if that leaves less air.
pub(super) fn cut_apart(
    shells: &[(usize, &Shell)],
    solid: &Field,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Vec<FittedHull>, Cancelled> {
    let probe = PROBE.max(settings.max_pieces as usize / (4 * shells.len()).max(1));
    let partitioner = Partitioner { solid, settings, cancel };
    let begun: Vec<Vec<Leaf>> = shells
        .par_iter()
        .map(|&(index, shell)| partitioner.begin(index, shell, probe))
        .collect::<Result<_, Cancelled>>()?;
    let mut leaves: Vec<Leaf> = begun.into_iter().flatten().collect();
    partitioner.cut_into(settings.max_pieces as usize, &mut leaves)?;
    Ok(leaves.into_iter().map(|l| FittedHull { hull: l.hull, excess_m: l.excess.distance_m }).collect())
}

/// Planes that cut a shell into sectors, wider ones where it is wider.
fn sector_planes(shell: &Shell) -> Vec<Plane> {
    let (low, high) = shell.bounds();
    let (center, size) = (0.5 * (low + high), high - low);
    (0..SECTOR_PLANES)
        .map(|k| {
            let (sin, cos) = (PI * f64::from(k) / f64::from(SECTOR_PLANES)).sin_cos();
            Plane::through(center, DVec3::new(-sin * size.y, cos * size.x, 0.0).normalize_or(DVec3::X))
        })
        .collect()
}

struct Partitioner<'a> {
    solid: &'a Field<'a>,
    settings: &'a DecomposeSettings,
    cancel: &'a CancelFlag,
}

impl Partitioner<'_> {
    /// The piece with its hull; `None` if no hull can be built.
    fn leaf(&self, of: Whole, piece: Piece) -> Result<Option<Leaf>, Cancelled> {
        let hull = convex_hull(&piece.spanning_points(), usize::MAX, 0.0);
        hull.map(|hull| self.leaf_with(of, piece, hull)).transpose()
    }

    fn leaf_with(&self, of: Whole, piece: Piece, hull: ConvexHull) -> Result<Leaf, Cancelled> {
        let (spacing_m, known_m) = (self.settings.excess_spacing_m, 0.5 * self.settings.tolerance_m);
        let excess = excess(&hull, self.solid, spacing_m, known_m, f64::INFINITY, self.cancel)?;
        let air_m3 = hull.volume_m3() - piece.volume_m3();
        Ok(Leaf { of, piece, hull, excess, air_m3, is_final: false })
    }

    /// The first pieces of a shell: one, or sectors if greedy cuts fail.
    fn begin(&self, index: usize, shell: &Shell, probe: usize) -> Result<Vec<Leaf>, Cancelled> {
        let of = Whole { shell: index, volume_m3: shell.volume_m3() };
        let Some(whole) = self.leaf(of, Piece::new(shell))? else { return Ok(Vec::new()) };
        let air_m3 = |leaves: &[Leaf]| leaves.iter().map(|l| l.air_m3).sum::<f64>();
        let mut straight = vec![whole];
        self.cut_into(probe, &mut straight)?;
        if air_m3(&straight) <= STUCK * of.volume_m3 {
            return Ok(straight);
        }
        let mut sectors = self.sectors(of, shell)?;
        self.cut_into(probe, &mut sectors)?;
        Ok(if air_m3(&sectors) < air_m3(&straight) { sectors } else { straight })
    }

    fn sectors(&self, of: Whole, shell: &Shell) -> Result<Vec<Leaf>, Cancelled> {
        let is_inside = |p| self.solid.is_inside(of.shell, p);
        let mut pieces = vec![Piece::new(shell)];
        for plane in sector_planes(shell) {
            pieces = pieces
                .into_iter()
                .flat_map(|piece| match piece.split(&plane, is_inside) {
                    Some((below, above)) => vec![below, above],
                    None => vec![piece],
                })
                .collect();
        }
        let leaves: Vec<Option<Leaf>> =
            pieces.into_par_iter().map(|piece| self.leaf(of, piece)).collect::<Result<_, Cancelled>>()?;
        Ok(leaves.into_iter().flatten().collect())
    }

    /// Whether a piece needs more cuts: the excess of its hull is above the tolerance, and large or over much of the
    /// shell.
    fn is_rough(&self, leaf: &Leaf) -> bool {
        let excess_m = leaf.excess.distance_m;
        let slight_m3 = SLIGHT_AIR * leaf.of.volume_m3 / f64::from(self.settings.max_pieces);
        excess_m > FAR * self.settings.tolerance_m
            || (excess_m > self.settings.tolerance_m && leaf.air_m3 > slight_m3)
    }

    /// Cuts until no piece is rough or there are `max_pieces` pieces.
    fn cut_into(&self, max_pieces: usize, leaves: &mut Vec<Leaf>) -> Result<(), Cancelled> {
        while leaves.len() < max_pieces {
            let by_distance = leaves.len().is_multiple_of(2);
            let key = |leaf: &Leaf| if by_distance { leaf.excess.distance_m } else { leaf.air_m3 };
            let next = (0..leaves.len())
                .filter(|&k| !leaves[k].is_final && self.is_rough(&leaves[k]))
                .max_by(|&a, &b| key(&leaves[a]).total_cmp(&key(&leaves[b])));
            let Some(k) = next else { break };
            match self.best_halves(&leaves[k])? {
                Some(halves) => drop(leaves.splice(k..=k, halves)),
                None => leaves[k].is_final = true,
            }
        }
        Ok(())
    }

    /// The two parts of the best cut.
    fn best_halves(&self, leaf: &Leaf) -> Result<Option<[Leaf; 2]>, Cancelled> {
        let is_inside = |p| self.solid.is_inside(leaf.of.shell, p);
        let volume_m3 = leaf.hull.volume_m3();
        let tried = |(concavity_left, plane): &(f64, Plane)| {
            let (below, above) = leaf.piece.split_open(plane, is_inside)?;
            // A cut is rejected if no hull of a part can be built.
            let hulled = |piece: Piece| {
                let hull = convex_hull(&piece.spanning_points(), usize::MAX, 0.0)?;
                Some((piece, hull))
            };
            let (below, above) = (hulled(below)?, hulled(above)?);
            let saved_m3 = volume_m3 - below.1.volume_m3() - above.1.volume_m3();
            let air_left = 1.0 - saved_m3 / leaf.air_m3.max(1e-15);
            Some((air_left + FORESIGHT * concavity_left, *plane, below, above))
        };
        let ranked = ranked_cuts(&leaf.piece, leaf.excess.at, self.settings.tolerance_m);
        let all: Vec<_> = ranked.par_iter().take(CUTS_TRIED).map(tried).collect();
        let best = all.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, plane, mut below, mut above)) = best else { return Ok(None) };
        leaf.piece.close(&plane, &mut below.0, &mut above.0);
        let made = |(piece, hull)| self.leaf_with(leaf.of, piece, hull);
        let (below, above) = rayon::join(|| made(below), || made(above));
        Ok(Some([below?, above?]))
    }
}
