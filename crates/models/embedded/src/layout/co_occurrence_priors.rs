//! Co-occurrence priors: usual relative positions and yaws of categories that the text leaves open.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;
use rand::RngExt;

use super::habits::{Frame, PRIORS, names, share_a_use};
use super::spatial_constraints::{RIGHT, RelativePosition, SpatialConstraint};
use super::{LayoutObject, ObjectGeometry};
use catalog::Facing;
use runtime::seed::Rng;
use scene::SupportTree;

/// Largest number of objects without relations that stand beside each other for their use.
const MAX_GATHERED: usize = 4;

/// Adds soft constraints from the priors for objects without a relation of the text.
pub(super) fn add_soft_constraints(
    objects: &[LayoutObject],
    supports: &SupportTree,
    constraints: &mut Vec<SpatialConstraint>,
) {
    let same_surface = |a: usize, b: usize| supports.supporter(a).parent == supports.supporter(b).parent;
    let of = |name: &str, near: usize| -> Vec<usize> {
        (0..objects.len()).filter(|&k| names(name, objects[k].category) && same_surface(k, near)).collect()
    };
    // For each object, how many of those of its use stand beside each other up to it.
    let mut gathered = vec![1; objects.len()];
    for from in 0..objects.len() {
        if supports.supporter(from).is_container() {
            continue;
        }
        let is_placed =
            objects[from].relations.iter().any(|(kind, target)| target.is_none() && !kind.is_support());
        let habitual = habitual_constraint(objects, from, is_placed, of, constraints);
        constraints.extend(habitual);
        let constrained = constraints.iter().any(|l| l.from == from);
        if !constrained && !is_placed {
            // Beside the last one before it that is used together with it; a table is no row of goods.
            let is_mate = |to: &usize| {
                same_surface(from, *to) && share_a_use(objects[from].category, objects[*to].category)
            };
            if let Some(to) = (0..from).rev().find(is_mate)
                && gathered[to] < MAX_GATHERED
            {
                gathered[from] = gathered[to] + 1;
                constraints.push(soft(from, to, RelativePosition::Beside, false));
            }
        }
    }
    add_spoons_beyond_knives(objects, constraints);
}

fn soft(from: usize, to: usize, position: RelativePosition, in_target_frame: bool) -> SpatialConstraint {
    SpatialConstraint { from, to, position, in_target_frame, hard: false, distance_m: None }
}

/// Soft constraint of one object from the first prior that has a target for it. `of` lists the objects of a name on the
/// surface of an object; `known` are the constraints so far.
fn habitual_constraint(
    objects: &[LayoutObject],
    from: usize,
    is_placed: bool,
    of: impl Fn(&str, usize) -> Vec<usize>,
    known: &[SpatialConstraint],
) -> Option<SpatialConstraint> {
    let category = objects[from].category;
    let stated: Vec<&SpatialConstraint> = known.iter().filter(|l| l.from == from && l.hard).collect();
    let rank = of(&category.name, from).iter().position(|&k| k == from).unwrap_or(0);
    for prior in PRIORS.iter().filter(|prior| prior.objects.iter().any(|name| names(name, category))) {
        let position = prior.position.relative();
        let in_target_frame = prior.frame == Frame::Target;
        // "Next to the plate" leaves the side open; other relations determine it.
        let beside = stated.iter().find(|l| {
            l.position == RelativePosition::Beside
                && prior.of.iter().any(|name| names(name, objects[l.to].category))
        });
        if let Some(constraint) = beside {
            return Some(soft(from, constraint.to, position, in_target_frame));
        }
        if stated.is_empty() && !is_placed {
            let others =
                |name: &String| of(name, from).into_iter().filter(|&k| k != from).collect::<Vec<_>>();
            let targets = prior.of.iter().map(others).find(|present| !present.is_empty());
            let Some(targets) = targets else { continue };
            // One object for each target in its frame; surplus objects stay unconstrained.
            let target = targets.get(rank).or(if in_target_frame { None } else { targets.last() });
            let Some(&to) = target else { continue };
            let is_mutual = known.iter().any(|l| l.from == to && l.to == from);
            if !is_mutual {
                return Some(soft(from, to, position, in_target_frame));
            }
        }
    }
    None
}

/// Adds soft constraints for spoons: right of the knife, where both are right of a plate.
fn add_spoons_beyond_knives(objects: &[LayoutObject], constraints: &mut Vec<SpatialConstraint>) {
    let right_of_plate = |constraint: &&SpatialConstraint, category: &str| {
        constraint.position == RIGHT
            && constraint.in_target_frame
            && objects[constraint.from].category.name == category
            && objects[constraint.to].category.name == "plate"
    };
    let knives: Vec<(usize, usize)> =
        constraints.iter().filter(|c| right_of_plate(c, "knife")).map(|c| (c.from, c.to)).collect();
    let spoons: Vec<SpatialConstraint> =
        constraints.iter().filter(|c| right_of_plate(c, "spoon")).copied().collect();
    for spoon in spoons {
        if let Some((knife, _)) = knives.iter().find(|(_, plate)| *plate == spoon.to) {
            constraints.push(SpatialConstraint { to: *knife, hard: false, distance_m: None, ..spoon });
        }
    }
}

/// Samples the yaw of an object.
pub(super) struct YawSampler<'a> {
    pub object: &'a ObjectGeometry<'a>,
    /// Yaw of the reference object: the fork's plate, the place setting, or a neighbor of the same category.
    pub reference_yaw_rad: Option<f64>,
    /// Half the depth of the surface, meters; gives the distance of the viewer.
    pub half_depth_m: f64,
    pub jitter_rad: f64,
    /// Whether objects that face the viewer may also face sideways (in late attempts).
    pub allow_sideways: bool,
}

impl YawSampler<'_> {
    /// A random yaw for the object at `xy_m`.
    pub fn yaw_rad(&self, xy_m: DVec2, rng: &mut Rng) -> f64 {
        let jitter = self.jitter_rad * (rng.random_range(-1.0..1.0_f64) + rng.random_range(-1.0..1.0_f64));
        if let Some(yaw_rad) = self.reference_yaw_rad {
            return yaw_rad + jitter;
        }
        match self.object.category.facing {
            Facing::Viewer => {
                // Rotated by half the angle toward a viewer in front of the center.
                let away = xy_m.y + self.half_depth_m + 0.45;
                let sideways = if self.allow_sideways {
                    [0.0, FRAC_PI_2, -FRAC_PI_2][rng.random_range(0..3)]
                } else {
                    0.0
                };
                0.5 * (-xy_m.x).atan2(away) + sideways + jitter
            }
            Facing::Aligned => jitter,
            Facing::Any if self.object.slenderness() > 1.8 => {
                // Long objects mostly point away from the viewer or lie crosswise.
                let base = if self.object.long_in_y() { 0.0 } else { FRAC_PI_2 };
                let turn = match rng.random_range(0..10) {
                    0..=5 => rng.random_range(-0.45..0.45),
                    6..=7 => FRAC_PI_2 + rng.random_range(-0.4..0.4),
                    _ => rng.random_range(-PI..PI),
                };
                base + turn
            }
            Facing::Any => rng.random_range(-PI..PI),
        }
    }
}
