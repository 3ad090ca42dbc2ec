//! Placement in a container: an apple in a bowl, the third croissant in the basket, a pen that leans in its holder.
//!
//! Positions are tried one after the other, first with the object's own orientation and near the wanted position, then
//! upright and leaning. The object is dropped there and simulated under gravity with all other objects fixed. If that
//! fails, it is simulated together with the other contents of the container (the third apple pushes the first two
//! aside). A position is accepted if every moved object then reaches in, is carried by its contacts and overlaps
//! nothing: hulls of few corners lie inside round meshes by up to a millimeter, so that two fruits whose hulls touch
//! may overlap, turned otherwise they do not. Heaped objects thus have their three contacts, and leaning ones touch
//! floor and rim, before the whole scene is settled.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;

use super::drop::{center_of, dropped};
use super::{ResolveError, Scene};
use crate::metrics::world_box;
use crate::support::carriers;
use crate::{Body, SettleSettings, settle, support_by_hulls};
use geometry::Pose;
use geometry::collide::{PlacedSolid, penetration};
use geometry::collision_shape::CollisionShape;
use geometry::drop_cast::{PosedShape, drop_height, floor_hull, slid_in_height};
use runtime::seed::child_rng;
use runtime::{CancelFlag, Cancelled};

/// Longest time an object is given to come to rest in its container, seconds.
const RELAX_S: f64 = 1.5;

/// Places tried under gravity before the best one is taken.
const TRIES: usize = 10;

/// Cost of a body that nothing carries, as a depth of overlap, meters: more than any overlap of objects at rest.
const UNSUPPORTED_M: f64 = 0.1;

/// Clearance around an object that is slid in below a handle, meters.
const SLIDING_GAP_M: f64 = 0.0005;

/// A contained object reaches no farther below its container's lowest point than a contact is soft, meters.
const BELOW_BOTTOM_M: f64 = 0.0005;

/// Angles between an upright object and the vertical, degrees: the flattest feasible one is taken.
const LEANS_DEG: [f64; 8] = [40.0, 32.0, 25.0, 19.0, 14.0, 9.0, 4.0, 0.0];

/// Probe lowered into a container to find its bottom: 2 mm wide, its lowest point at its origin.
fn probe() -> Option<CollisionShape> {
    let mut hull = floor_hull(0.001, 0.002);
    hull.points.iter_mut().for_each(|p| p.z += 0.002);
    CollisionShape::new(&[hull]).ok()
}

/// Height of the rim and of the deepest reachable point of the cavity.
fn rim_and_floor(scene: &Scene, parent: usize, poses: &[Pose]) -> (f64, f64) {
    let (low, high) = scene.shapes[parent].bounds(&poses[parent]);
    let midpoint = 0.5 * (low + high).truncate();
    let Some(probe) = probe() else { return (high.z, low.z) };
    let under = [scene.placed(parent, poses)];
    let reach = 0.25 * (high - low).truncate();
    let floor = (0..9)
        .filter_map(|k| {
            let at = midpoint + reach * DVec2::new(f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
            drop_height(&probe, DQuat::IDENTITY, at, &under)
        })
        .fold(high.z, f64::min);
    (high.z, floor)
}

/// Open and deep part of a container, seen from above: a mug's cup without its handle. World xy, meters.
struct Cavity {
    midpoint: DVec2,
    /// Half its extents.
    half: DVec2,
}

/// Probes on a grid; those that go down at least half as deep as the deepest show the cavity. The whole box where none
/// does.
fn cavity(scene: &Scene, parent: usize, poses: &[Pose]) -> Cavity {
    // Odd, so that one probe goes down the center.
    const PROBES: u32 = 13;
    let (low, high) = scene.shapes[parent].bounds(&poses[parent]);
    let whole = Cavity { midpoint: 0.5 * (low + high).truncate(), half: 0.5 * (high - low).truncate() };
    let Some(probe) = probe() else { return whole };
    let under = [scene.placed(parent, poses)];
    let step = (high - low).truncate() / f64::from(PROBES);
    let depths: Vec<(DVec2, f64)> = (0..PROBES * PROBES)
        .filter_map(|k| {
            let cell = DVec2::new(f64::from(k % PROBES), f64::from(k / PROBES)) + 0.5;
            let at = low.truncate() + step * cell;
            drop_height(&probe, DQuat::IDENTITY, at, &under).map(|z| (at, high.z - z))
        })
        .collect();
    let deepest = depths.iter().map(|(_, depth)| *depth).fold(0.0, f64::max);
    let deep = depths.iter().filter(|(_, depth)| *depth >= 0.5 * deepest).map(|(at, _)| *at);
    let (near, far) =
        deep.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(near, far), at| (near.min(at), far.max(at)));
    if near.x > far.x {
        return whole;
    }
    Cavity { midpoint: 0.5 * (near + far), half: 0.5 * (far - near + step) }
}

/// Whether the body reaches into its container as far as required, its center of mass above the container's outline.
pub(super) fn reaches_in(scene: &Scene, body: usize, parent: usize, poses: &[Pose]) -> bool {
    let (rim, floor) = rim_and_floor(scene, parent, poses);
    let (low, _) = scene.shapes[body].bounds(&poses[body]);
    let (parent_low, parent_high) = scene.shapes[parent].bounds(&poses[parent]);
    // The point that goes deepest must be between the walls, neither beside them nor, through a handle's loop, below.
    let deepest = scene.shapes[body]
        .points(&poses[body])
        .fold(DVec3::INFINITY, |deep, p| if p.z < deep.z { p } else { deep });
    let between = deepest.x > parent_low.x
        && deepest.x < parent_high.x
        && deepest.y > parent_low.y
        && deepest.y < parent_high.y
        && deepest.z > parent_low.z - BELOW_BOTTOM_M;
    between && low.z <= rim - scene.settings.container_depth_share * (rim - floor)
}

/// Poses for the body in its container among the bodies `below`, and for those of them that share the
/// container and make room. `nudges` counts how often a place failed: so many good places are passed over,
/// and places are shaken.
pub(super) fn into(
    scene: &Scene,
    body: usize,
    parent: usize,
    below: &[usize],
    poses: &[Pose],
    nudges: usize,
    cancel: &CancelFlag,
) -> Result<Vec<(usize, Pose)>, ResolveError> {
    let supporters: Vec<PosedShape> = below.iter().map(|&other| scene.placed(other, poses)).collect();
    let heap: Vec<usize> = scene.tree.container_mates(body).filter(|k| below.contains(k)).collect();
    let mut trial = poses.to_vec();
    let mut fits = |moved: &[(usize, Pose)]| {
        moved.iter().for_each(|&(k, pose)| trial[k] = pose);
        moved.iter().all(|&(k, _)| reaches_in(scene, k, parent, &trial))
    };
    let (mut skipped, mut best) = (0, None::<(f64, Vec<(usize, Pose)>)>);
    // Existing contents stay fixed first and yield second; after a failure the order is reversed.
    let mut ways = vec![&[][..], &heap[..]];
    ways.dedup();
    if nudges % 2 == 1 {
        ways.reverse();
    }
    for yielding in ways {
        let mut tries = 0;
        for (rotation, xy) in places(scene, body, parent, poses, nudges) {
            cancel.check()?;
            let Some(mut pose) = dropped(scene, body, rotation, xy, &supporters) else { continue };
            // A yielding heap may carry the body on top at first.
            let may_sink = !yielding.is_empty() && falls_in(scene, body, parent, poses, &pose);
            if !fits(&[(body, pose)]) && !may_sink {
                match slid_in(scene, body, parent, pose, &supporters, poses) {
                    Some(below_handle) if fits(&[(body, below_handle)]) => pose = below_handle,
                    _ => continue,
                }
            }
            if skipped < nudges.min(4) {
                skipped += 1;
                best.get_or_insert_with(|| (f64::NEG_INFINITY, vec![(body, pose)]));
                continue;
            }
            let (calm, margin_m) = relaxed(scene, body, yielding, below, poses, pose, cancel)?;
            if !fits(&calm) {
                best.get_or_insert_with(|| (f64::NEG_INFINITY, vec![(body, pose)]));
            } else if margin_m >= 0.0 {
                let depth_m = deepest_overlap_m(scene, &calm, below, poses, cancel)?;
                if depth_m <= 0.0 {
                    return Ok(calm);
                }
                // An overlap of a millimeter is better than no support, and a shallow one better than a deep one.
                if best.as_ref().is_none_or(|(known, _)| -depth_m > *known) {
                    best = Some((-depth_m, calm));
                }
            } else if best.as_ref().is_none_or(|(known, _)| margin_m - UNSUPPORTED_M > *known) {
                best = Some((margin_m - UNSUPPORTED_M, calm));
            }
            tries += 1;
            if tries == TRIES {
                break;
            }
        }
    }
    let wanted = poses[body];
    let midpoint = center_of(scene, parent, poses) - center_offset(scene, body, wanted.rotation);
    Ok(best.map(|(_, found)| found).unwrap_or_else(|| {
        let fallback = dropped(scene, body, wanted.rotation, midpoint, &supporters).unwrap_or(wanted);
        vec![(body, fallback)]
    }))
}

/// The lowest free place straight below `above`: in a basket with a handle, under the handle.
fn slid_in(
    scene: &Scene,
    body: usize,
    parent: usize,
    above: Pose,
    supporters: &[PosedShape],
    poses: &[Pose],
) -> Option<Pose> {
    let (floor, rim) = scene.shapes[parent].bounds(&poses[parent]);
    let z_m = slid_in_height(&scene.shapes[body], &above, (floor.z, rim.z), supporters, SLIDING_GAP_M)?;
    Some(Pose { translation_m: above.translation_m.with_z(z_m), rotation: above.rotation })
}

/// Whether what lies at `pose` is above the inside of the container: its weight well within the walls.
fn falls_in(scene: &Scene, body: usize, parent: usize, poses: &[Pose], pose: &Pose) -> bool {
    let (low, high) = scene.shapes[parent].bounds(&poses[parent]);
    let (midpoint, half) = (0.5 * (low + high).truncate(), 0.5 * (high - low).truncate());
    let center = pose.transform_point(scene.problem.bodies[body].mass.center_of_mass_m).truncate();
    ((center - midpoint) / half).length() < 0.6
}

/// Resting poses of the body and of the bodies in `yielding`, starting from `pose`, while the others stand still; and
/// the least support margin among them, meters (negative while something still moves).
fn relaxed(
    scene: &Scene,
    body: usize,
    yielding: &[usize],
    below: &[usize],
    poses: &[Pose],
    pose: Pose,
    cancel: &CancelFlag,
) -> Result<(Vec<(usize, Pose)>, f64), ResolveError> {
    let at = |k: usize, pose: Pose, fixed: bool| Body {
        world_from_object: pose,
        fixed,
        ..scene.problem.bodies[k].clone()
    };
    let mut bodies: Vec<Body> =
        below.iter().map(|&other| at(other, poses[other], !yielding.contains(&other))).collect();
    bodies.push(at(body, pose, false));
    let settings = SettleSettings { duration_s: RELAX_S, ..scene.settle.clone() };
    let settled = settle(&bodies, &settings, cancel)?;
    let members: Vec<usize> = below.iter().copied().chain([body]).collect();
    let free: Vec<usize> = (0..members.len()).filter(|&k| !bodies[k].fixed).collect();
    let calm: Vec<(usize, Pose)> = free.iter().map(|&k| (members[k], settled.poses[k])).collect();
    if !settled.at_rest {
        return Ok((calm, -1.0));
    }
    let solids: Vec<PlacedSolid> = members
        .iter()
        .zip(&settled.poses)
        .map(|(&k, pose)| PlacedSolid { solid: scene.problem.solids[k], world_from_object: *pose })
        .collect();
    let mut min_m = f64::INFINITY;
    for &k in &free {
        let all = carriers(scene.problem.supports, members[k]);
        let present: Vec<usize> = (0..members.len()).filter(|&other| all.contains(&members[other])).collect();
        let finding = support_by_hulls(&solids, &bodies, k, &present, scene.certify);
        min_m = min_m.min(finding.margin_m);
    }
    Ok((calm, min_m))
}

/// The deepest overlap of the visual meshes of what moved with each other, with the container and with its contents, as
/// far as it counts as a collision, meters; 0 without one.
fn deepest_overlap_m(
    scene: &Scene,
    moved: &[(usize, Pose)],
    below: &[usize],
    poses: &[Pose],
    cancel: &CancelFlag,
) -> Result<f64, Cancelled> {
    let placed = |body: usize| {
        let pose = moved.iter().find(|(k, _)| *k == body).map_or(poses[body], |(_, pose)| *pose);
        PlacedSolid { solid: scene.problem.solids[body], world_from_object: pose }
    };
    let rule = scene.certify.collision_rule();
    let mut deepest_m: f64 = 0.0;
    for (number, &(body, _)) in moved.iter().enumerate() {
        let own = placed(body);
        let (low, high) = world_box(&own);
        let is_tested = |other: &usize| *other != body && !moved[..number].iter().any(|(k, _)| k == other);
        let others = below.iter().copied().chain(moved.iter().map(|(k, _)| *k)).filter(is_tested);
        for other in others.collect::<BTreeSet<usize>>() {
            let other = placed(other);
            let (other_low, other_high) = world_box(&other);
            if (low - other_high).max(other_low - high).max_element() < 0.0 {
                let found = penetration(&own, &other, &rule, cancel)?;
                deepest_m = deepest_m.max(found.map_or(0.0, |overlap| overlap.depth_m));
            }
        }
    }
    Ok(deepest_m)
}

/// Rotations and positions (of the origin, seen from above) to try, best first.
fn places(scene: &Scene, body: usize, parent: usize, poses: &[Pose], nudges: usize) -> Vec<(DQuat, DVec2)> {
    let wanted = poses[body];
    let Cavity { midpoint, half } = cavity(scene, parent, poses);
    let mut rng = child_rng(nudges as u64, scene.name(body));
    // The first attempt is exact; later ones are shaken by up to a tenth of the container and 30 degrees.
    let mut shaken = |rotation: DQuat, xy: DVec2| {
        if nudges == 0 {
            return (rotation, xy);
        }
        let mut draw = |highest: f64| rng.random_range(-highest..highest);
        (
            DQuat::from_rotation_z(draw(PI / 6.0)) * rotation,
            xy + 0.2 * half * DVec2::new(draw(0.5), draw(0.5)),
        )
    };
    let around = |share: f64, count: u32| {
        (0..count)
            .map(move |k| midpoint + share * half * DVec2::from_angle(TAU * f64::from(k) / f64::from(count)))
    };
    let offset = center_offset(scene, body, wanted.rotation);
    // With its own orientation: at its own position, then ever nearer to the center, then around the center.
    let own = wanted.translation_m.truncate() + offset;
    let mut places: Vec<(DQuat, DVec2)> = (0..=4)
        .map(|k| own.lerp(midpoint, 0.25 * f64::from(k)))
        .chain(around(0.3, 6))
        .chain(around(0.55, 8))
        .map(|at| shaken(wanted.rotation, at - offset))
        .collect();
    // Upright and leaning, as a spoon in a mug, the heavy end down first.
    for lean_deg in LEANS_DEG {
        for rotation in leaning(scene, body, wanted.rotation, f64::to_radians(lean_deg)) {
            let foot = foot_offset(scene, body, rotation);
            let lean_toward = (center_offset(scene, body, rotation) - foot).normalize_or_zero();
            for share in [0.5, 0.3, 0.1, -0.15] {
                // The foot stands opposite to where it leans.
                let at = midpoint - lean_toward * (share * half.min_element()) - foot;
                places.push(shaken(rotation, at));
            }
        }
    }
    places
}

/// From the origin to the center of the turned body's box, seen from above.
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
/// pointed before: first with the heavy end down, then the other.
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
    let center = scene.problem.bodies[body].mass.center_of_mass_m - 0.5 * (low + high);
    let light_end = if center.dot(own) > 0.0 { -own } else { own };
    [light_end, -light_end].map(|axis| {
        let now = rotation * axis;
        let flat = now.with_z(0.0).try_normalize().unwrap_or(DVec3::X);
        let target = DVec3::Z * lean_rad.cos() + flat * lean_rad.sin();
        let turn = if now.dot(target) < -1.0 + 1e-9 {
            DQuat::from_axis_angle(flat.cross(DVec3::Z).normalize_or(DVec3::Y), PI)
        } else {
            DQuat::from_rotation_arc(now, target)
        };
        (turn * rotation).normalize()
    })
}
