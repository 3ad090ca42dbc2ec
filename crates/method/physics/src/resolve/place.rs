//! Placement of bodies onto and into their supporters.

use glam::DVec2;

use super::drop::center_of;
use super::level::{MIN_DEPTH_OVER_PARENT_M, carriers_beside, depth_over_parent_m};
use super::tree::TABLE;
use super::{ResolveError, Scene, contain};
use geometry::Pose;
use geometry::drop_cast::{PosedShape, drop_height};
use runtime::CancelFlag;

/// Drops every body onto its supporter, supporters first; carried bodies move with it. Before body k is dropped it
/// moves `nudges[k]` quarters of the way to the supporter's center (contained bodies try other positions instead).
/// `seated` stores the pose of a body in its container (`container_from_body`), so that it is kept when the container
/// moves; begin with `None`s.
pub(super) fn drop_all(
    scene: &Scene,
    poses: &mut [Pose],
    nudges: &[usize],
    seated: &mut [Option<Pose>],
    log: &mut Vec<String>,
    cancel: &CancelFlag,
) -> Result<(), ResolveError> {
    let mut placed: Vec<usize> = vec![TABLE];
    for body in scene.tree.order() {
        cancel.check()?;
        let parent = scene.tree.parent(body);
        // Objects in the same group may lie below it; on the table itself neighbors are pushed apart instead.
        let below: Vec<usize> = placed
            .iter()
            .copied()
            .filter(|&other| other == parent || (parent != TABLE && scene.tree.is_below(other, parent)))
            .collect();
        let mut moves = Vec::with_capacity(1);
        if scene.tree.is_contained(body) && parent != TABLE {
            match seated[body] {
                Some(parent_from_body) => moves.push((body, poses[parent] * parent_from_body)),
                None => {
                    moves = contain::into(scene, body, parent, &below, poses, nudges[body], cancel)?;
                    for &(moved, pose) in &moves {
                        seated[moved] = Some(poses[parent].inverse() * pose);
                    }
                }
            }
        } else {
            let beside = carriers_beside(scene, body, poses).into_iter().filter(|k| !below.contains(k));
            let supporters: Vec<PosedShape> =
                below.iter().copied().chain(beside).map(|other| scene.placed(other, poses)).collect();
            moves.push((body, onto(scene, body, parent, &supporters, poses, nudges[body])));
        }
        for (moved, pose) in moves {
            let before = poses[moved];
            let motion = pose * before.inverse();
            for carried in scene.tree.branch(moved) {
                poses[carried] = motion * poses[carried];
            }
            poses[moved] = pose;
            let way_m = (pose.translation_m - before.translation_m).truncate().length();
            if way_m > 0.001 {
                let (name, to) = (scene.name(moved), scene.name(parent));
                log.push(format!("{name} moved {:.0} mm to come to rest with {to}", 1e3 * way_m));
            }
        }
        placed.push(body);
    }
    Ok(())
}

fn onto(
    scene: &Scene,
    body: usize,
    parent: usize,
    supporters: &[PosedShape],
    poses: &[Pose],
    nudges: usize,
) -> Pose {
    let mut pose = poses[body];
    let center = pose.transform_point(scene.problem.bodies[body].mass.center_of_mass_m).truncate();
    let to_center = center_of(scene, parent, poses) - center;
    let on_table = parent == TABLE;
    let mut toward = if on_table { DVec2::ZERO } else { to_center * (0.25 * nudges as f64).min(1.0) };
    if !on_table && depth_over_parent_m(scene, body, parent, poses) < MIN_DEPTH_OVER_PARENT_M {
        // The center of mass is beyond the supporter's edge: move inward until it is not.
        let mut moved = poses.to_vec();
        for step in 1..=20 {
            toward = to_center * (f64::from(step) / 20.0);
            moved[body].translation_m = poses[body].translation_m + toward.extend(0.0);
            if depth_over_parent_m(scene, body, parent, &moved) >= MIN_DEPTH_OVER_PARENT_M {
                break;
            }
        }
    }
    pose.translation_m += toward.extend(0.0);
    let xy = pose.translation_m.truncate();
    let shape = &scene.shapes[body];
    if let Some(z) = drop_height(shape, pose.rotation, xy, supporters) {
        pose.translation_m.z = z;
    }
    pose
}
