//! Dropping bodies onto and into their supporters.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec2, DVec3};

use super::{ResolveError, Scene, depth_over_parent_m};
use crate::geometry::cast::{Supporter, drop_height, floor_hull};
use crate::geometry::collision_shape::CollisionShape;
use crate::geometry::{Interrupt, Pose};

/// Drops every body onto its supporter, supporters first. `nudges[k]` quarters of the way to the
/// supporter's middle are gone before body k is dropped (for contained ones: that many places are skipped).
pub(super) fn drop_all(
    scene: &Scene,
    poses: &mut [Pose],
    nudges: &[usize],
    log: &mut Vec<String>,
    interrupt: &Interrupt,
) -> Result<(), ResolveError> {
    let mut placed: Vec<usize> = vec![scene.tree.table];
    for &body in &scene.tree.order {
        let Some(support) = scene.tree.support[body] else { continue };
        interrupt.check()?;
        let parent = support.parent;
        // Things in the same group may lie below it; on the table itself neighbors are pushed apart instead.
        let below: Vec<usize> = placed
            .iter()
            .copied()
            .filter(|&other| {
                other == parent || (parent != scene.tree.table && scene.tree.is_below(other, parent))
            })
            .collect();
        let supporters: Vec<Supporter> = below.iter().map(|&other| scene.placed(other, poses)).collect();
        let pose = if support.inside && parent != scene.tree.table {
            into(scene, body, parent, &supporters, poses, nudges[body])
        } else {
            onto(scene, body, parent, &supporters, poses, nudges[body])
        };
        let before = poses[body];
        poses[body] = pose;
        let moved_m = (pose.translation_m - before.translation_m).truncate().length();
        if moved_m > 0.001 {
            let (name, to) = (scene.name(body), scene.name(parent));
            log.push(format!("{name} moved {:.0} mm to come to rest with {to}", 1e3 * moved_m));
        }
        placed.push(body);
    }
    Ok(())
}

fn middle_of(scene: &Scene, body: usize, poses: &[Pose]) -> DVec2 {
    let (low, high) = scene.shapes[body].bounds(&poses[body]);
    0.5 * (low + high).truncate()
}

fn onto(
    scene: &Scene,
    body: usize,
    parent: usize,
    supporters: &[Supporter],
    poses: &[Pose],
    nudges: usize,
) -> Pose {
    let mut pose = poses[body];
    let center = pose.transform_point(scene.problem.bodies[body].mass.center_of_mass_m).truncate();
    let to_middle = middle_of(scene, parent, poses) - center;
    let on_table = parent == scene.tree.table;
    let mut toward = if on_table { DVec2::ZERO } else { to_middle * (0.25 * nudges as f64).min(1.0) };
    if !on_table && depth_over_parent_m(scene, body, parent, poses) < 0.002 {
        // Its weight hangs over the edge: go in until it does not.
        let mut moved = poses.to_vec();
        for step in 1..=20 {
            toward = to_middle * (f64::from(step) / 20.0);
            moved[body].translation_m = poses[body].translation_m + toward.extend(0.0);
            if depth_over_parent_m(scene, body, parent, &moved) >= 0.002 {
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

/// Lowest point of the body after a drop there.
fn dropped(scene: &Scene, body: usize, rotation: DQuat, xy: DVec2, supporters: &[Supporter]) -> Option<Pose> {
    let z = drop_height(&scene.shapes[body], rotation, xy, supporters)?;
    Some(Pose { translation_m: xy.extend(z), rotation })
}

/// Height of the rim and of the deepest reachable point of the cavity.
fn rim_and_floor(scene: &Scene, parent: usize, poses: &[Pose]) -> (f64, f64) {
    let (low, high) = scene.shapes[parent].bounds(&poses[parent]);
    let middle = 0.5 * (low + high).truncate();
    let mut probe_hull = floor_hull(0.001, 0.002);
    probe_hull.points.iter_mut().for_each(|p| p.z += 0.002);
    let Ok(probe) = CollisionShape::new(&[probe_hull]) else { return (high.z, low.z) };
    let under = [scene.placed(parent, poses)];
    let reach = 0.25 * (high - low).truncate();
    let floor = (0..9)
        .filter_map(|k| {
            let at = middle + reach * DVec2::new(f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
            drop_height(&probe, DQuat::IDENTITY, at, &under)
        })
        .fold(high.z, f64::min);
    (high.z, floor)
}

/// Whether the body reaches into its container as far as it must, its weight above the container's outline.
pub(super) fn reaches_in(scene: &Scene, body: usize, parent: usize, poses: &[Pose]) -> bool {
    let (rim, floor) = rim_and_floor(scene, parent, poses);
    let (low, _) = scene.shapes[body].bounds(&poses[body]);
    let (parent_low, parent_high) = scene.shapes[parent].bounds(&poses[parent]);
    // The point that goes deepest must be between the walls, not beside them.
    let deepest = scene.shapes[body]
        .points(&poses[body])
        .fold(DVec3::INFINITY, |deep, p| if p.z < deep.z { p } else { deep });
    let between = deepest.x > parent_low.x
        && deepest.x < parent_high.x
        && deepest.y > parent_low.y
        && deepest.y < parent_high.y;
    between && low.z <= rim - scene.settings.container_depth_share * (rim - floor)
}

fn into(
    scene: &Scene,
    body: usize,
    parent: usize,
    supporters: &[Supporter],
    poses: &[Pose],
    skip: usize,
) -> Pose {
    let wanted = poses[body];
    let mut trial = poses.to_vec();
    let mut fits = |pose: Pose| {
        trial[body] = pose;
        reaches_in(scene, body, parent, &trial)
    };
    let (low, high) = scene.shapes[parent].bounds(&poses[parent]);
    let middle = 0.5 * (low + high).truncate();
    let offset = center_offset(scene, body, wanted.rotation);
    let around = |share: f64, count: u32| {
        let reach = share * 0.5 * (high - low).truncate();
        (0..count).map(move |k| middle + reach * DVec2::from_angle(TAU * f64::from(k) / f64::from(count)))
    };
    // As it is: where it is, then ever nearer to the middle, then around the middle.
    let own = wanted.translation_m.truncate() + offset;
    let nearer = (0..=4).map(|k| own.lerp(middle, 0.25 * f64::from(k)));
    let lying: Vec<DVec2> = nearer.chain(around(0.3, 6)).chain(around(0.55, 8)).collect();
    let mut skipped = 0;
    for at in lying {
        let Some(pose) = dropped(scene, body, wanted.rotation, at - offset, supporters) else { continue };
        if fits(pose) {
            if skipped == skip {
                return pose;
            }
            skipped += 1;
        }
    }
    // Stood up and leaning, as people put spoons into mugs; the flattest lean that goes in.
    let mut best: Option<Pose> = None;
    for lean_deg in [40.0, 32.0, 25.0, 19.0, 14.0, 9.0, 4.0, 0.0] {
        for rotation in leaning(scene, body, wanted.rotation, f64::to_radians(lean_deg)) {
            let foot = foot_offset(scene, body, rotation);
            let lean_toward = -(center_offset(scene, body, rotation) - foot).normalize_or_zero();
            let reach = 0.5 * (high - low).truncate().min_element();
            for share in [0.5, 0.3, 0.1, -0.15] {
                // The foot stands opposite to where it leans.
                let at = middle + lean_toward * (share * reach) - foot;
                let Some(pose) = dropped(scene, body, rotation, at, supporters) else { continue };
                if fits(pose) {
                    if skipped == skip {
                        return pose;
                    }
                    skipped += 1;
                    best = Some(pose);
                }
            }
        }
    }
    best.or_else(|| dropped(scene, body, wanted.rotation, middle - offset, supporters)).unwrap_or(wanted)
}

/// From the origin to the middle of the turned body's box, seen from above.
fn center_offset(scene: &Scene, body: usize, rotation: DQuat) -> DVec2 {
    let (low, high) = scene.shapes[body].bounds(&Pose { translation_m: DVec3::ZERO, rotation });
    0.5 * (low + high).truncate()
}

/// From the origin to the lowest point of the turned body, seen from above.
fn foot_offset(scene: &Scene, body: usize, rotation: DQuat) -> DVec2 {
    scene.shapes[body]
        .points(&Pose { translation_m: DVec3::ZERO, rotation })
        .fold(DVec3::INFINITY, |low, p| if p.z < low.z { p } else { low })
        .truncate()
}

/// Rotations that stand the body's longest axis up and lean it by `lean_rad` toward where that axis
/// pointed before: first with the end up that pointed away from the front edge's viewer, then the other.
fn leaning(scene: &Scene, body: usize, rotation: DQuat, lean_rad: f64) -> [DQuat; 2] {
    let (low, high) = scene.shapes[body].bounds(&Pose::IDENTITY);
    let size = high - low;
    let own = if size.x >= size.y && size.x >= size.z {
        DVec3::X
    } else if size.y >= size.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    [own, -own].map(|axis| {
        let now = rotation * axis;
        let flat = now.with_z(0.0).try_normalize().unwrap_or(DVec3::X);
        let target = DVec3::Z * lean_rad.cos() + flat * lean_rad.sin();
        let turn = if now.dot(target) < -1.0 + 1e-9 {
            DQuat::from_axis_angle(flat.cross(DVec3::Z).normalize_or(DVec3::Y), 2.0 * FRAC_PI_2)
        } else {
            DQuat::from_rotation_arc(now, target)
        };
        (turn * rotation).normalize()
    })
}
