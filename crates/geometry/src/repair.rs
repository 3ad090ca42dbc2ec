//! Closed surfaces from meshes that are not closed, as generated and downloaded ones may be.
//!
//! Shells that are closed, look outward and do not cross themselves by much are left as they are, to the bit. Of the others
//! corners closer than a hair are welded, triangles are turned the way their neighbors look, small holes are filled,
//! a surface with a large opening (a bowl drawn as one sheet) is given a thickness to the inside so that the
//! opening stays, and a closed shell turned inside out that bounds no cavity is turned back. What is still
//! open then, or crosses itself, is drawn anew around its voxels (see `voxels`). What was done is reported.
//!
//! Object frame, meters. Deterministic. Linear in the triangles, but for the search of crossings (n log n) and voxels.

mod crossing;
mod soup;
mod voxels;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use self::crossing::crosses_itself;
use self::soup::Soup;
use self::voxels::{around_voxels, share_covered_wrong};
use super::shells::Shell;

/// Corners closer than this share of the mesh's size are one.
const WELD_SHARE: f64 = 1e-5;
/// A hole of at most this share of a surface's area is filled; a larger one is an opening.
const HOLE_SHARE: f64 = 0.1;
/// A closed surface may cross itself where a bent tube kinks; only one that encloses more than this share of its volume
/// twice, or inside out, is drawn anew.
const CROSSING_SHARE: f64 = 0.01;

/// What repairing changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Repair {
    /// Corners moved onto another one.
    pub corners_welded: u32,
    /// Triangles turned over, those of shells that were inside out included.
    pub triangles_turned: u32,
    pub holes_filled: u32,
    /// Open surfaces that were given a thickness.
    pub sheets_thickened: u32,
    /// Shells drawn anew around their voxels.
    pub shells_remeshed: u32,
    /// No surface point of a shell drawn anew is meant to be farther than this from where it was, meters.
    pub voxel_m: f64,
}

impl Repair {
    /// Whether the surface is as it was given.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// The shells closed; sheets become `thickness_m` thick.
pub fn repaired(shells: Vec<Shell>, thickness_m: f64) -> (Vec<Shell>, Repair) {
    let mut repair = Repair::default();
    let size_m = extent_m(&shells);
    let (mut closed, open): (Vec<Shell>, Vec<Shell>) = shells.into_iter().partition(Shell::is_closed);
    if !open.is_empty() {
        let mut soup = Soup::of(&open);
        repair.corners_welded = soup.weld(WELD_SHARE * size_m);
        repair.triangles_turned = soup.turn_alike();
        for mut part in soup.into_shells() {
            repair.holes_filled += soup::fill_holes(&mut part, HOLE_SHARE);
            if !part.is_closed() && soup::thicken(&mut part, thickness_m) {
                repair.sheets_thickened += 1;
            }
            closed.push(part);
        }
    }
    turn_out(&mut closed, &mut repair);
    let mut sound = Vec::with_capacity(closed.len());
    for shell in closed {
        let broken =
            !shell.is_closed() || (crosses_itself(&shell) && share_covered_wrong(&shell) > CROSSING_SHARE);
        match broken.then(|| around_voxels(&shell)).flatten() {
            Some((drawn, voxel_m)) => {
                sound.extend(drawn);
                repair.shells_remeshed += 1;
                repair.voxel_m = repair.voxel_m.max(voxel_m);
            }
            None => sound.push(shell),
        }
    }
    (sound, repair)
}

fn extent_m(shells: &[Shell]) -> f64 {
    shells
        .iter()
        .map(Shell::bounds)
        .reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
        .map_or(0.0, |(low, high)| (high - low).max_element())
}

/// Turns closed shells that look inward and lie in the box of no other shell.
fn turn_out(shells: &mut [Shell], repair: &mut Repair) {
    let boxes: Vec<_> = shells.iter().map(Shell::bounds).collect();
    for k in 0..shells.len() {
        let (low, high) = boxes[k];
        let in_another = (0..shells.len())
            .any(|other| other != k && boxes[other].0.cmple(low).all() && boxes[other].1.cmpge(high).all());
        if !in_another && shells[k].volume_m3() < 0.0 {
            shells[k].triangles.iter_mut().for_each(|t| t.swap(1, 2));
            repair.triangles_turned += shells[k].triangles.len() as u32;
        }
    }
}
