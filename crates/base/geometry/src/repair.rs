//! Repair of open, inconsistent or self-intersecting meshes into closed surfaces.
//!
//! Closed outward shells with little self-intersection stay bit-identical. For the others, vertices closer than a
//! small tolerance are welded, triangles are oriented like their neighbors, and small holes are filled. A surface
//! with a large opening (a bowl modeled as one sheet) is thickened inward, so that the opening stays. A closed
//! inverted shell that bounds no cavity is flipped. Shells that are still open or self-intersecting are rebuilt from
//! voxels (see `voxels`). All changes are reported.
//!
//! Object frame, meters. Deterministic. O(triangles), except for the search for self-intersections (n log n) and
//! voxels.

mod crossing;
mod triangle_soup;
mod voxels;
#[cfg(test)]
mod tests;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::crossing::crosses_itself;
use self::triangle_soup::TriangleSoup;
use self::voxels::{around_voxels, share_covered_wrong};
use super::shells::Shell;

/// Welding distance, share of the mesh's size.
const WELD_SHARE: f64 = 1e-5;
/// Largest area of a hole that is filled, share of the surface's area. A larger hole is an opening.
const HOLE_SHARE: f64 = 0.1;
/// Share of a closed surface's volume that may be enclosed twice or inverted, for example at the kink of a bent tube.
/// Beyond it the surface is rebuilt.
const CROSSING_SHARE: f64 = 0.01;

/// Changes made by the repair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Repair {
    /// Vertices welded to another one.
    pub corners_welded: u32,
    /// Flipped triangles, including those of inverted shells.
    pub triangles_turned: u32,
    pub holes_filled: u32,
    /// Open surfaces that were thickened.
    pub sheets_thickened: u32,
    /// Shells rebuilt from voxels.
    pub shells_remeshed: u32,
    /// Nominal bound of the deviation of rebuilt surfaces, meters.
    #[schemars(range(min = 0.0))]
    pub voxel_m: f64,
}

impl Repair {
    /// Whether the surface is unchanged.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// The repaired shells; sheets become `thickness_m` thick.
pub fn repaired(shells: Vec<Shell>, thickness_m: f64) -> (Vec<Shell>, Repair) {
    let mut repair = Repair::default();
    let size_m = extent_m(&shells);
    let (mut closed, open): (Vec<Shell>, Vec<Shell>) = shells.into_iter().partition(Shell::is_closed);
    if !open.is_empty() {
        let mut soup = TriangleSoup::of(&open);
        repair.corners_welded = soup.weld(WELD_SHARE * size_m);
        repair.triangles_turned = soup.turn_alike();
        for mut part in soup.into_shells() {
            repair.holes_filled += triangle_soup::fill_holes(&mut part, HOLE_SHARE);
            if !part.is_closed() && triangle_soup::thicken(&mut part, thickness_m) {
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

/// Flips closed inward shells that are in the box of no other shell.
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
