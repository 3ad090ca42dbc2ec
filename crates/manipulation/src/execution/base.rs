//! Where the base of an arm stands: at the place from which it reaches all grasps and goals best.

use geometry::{DVec2, Pose};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use robot::model::Robot;
use robot::planning::{PlanOptions, Planner};

use super::motions::Motions;
use super::obstacles::{PlannerArms, obstacles};
use super::reach::Reach;
use super::scene::TaskScene;
use super::settings::ExecutionSettings;
use crate::frames::to_isometry;

/// Places that are tried lie apart by this share of the reach.
const SPACING_SHARE: f64 = 0.1;
/// How far beyond the edge of the table a base may stand, meters.
const BEYOND_M: f64 = 0.3;
/// The base stands on the table by this, or off it by as much, meters.
const BASE_RADIUS_M: f64 = 0.08;
/// Objects are not nearer to the axis of the base than this, meters.
const CLEAR_M: f64 = 0.2;
/// What the arm works at is not nearer to its axis than this, meters.
const TOO_NEAR_M: f64 = 0.22;
/// Grasps of each object that are considered.
const GRASPS: usize = 3;

/// Poses of the tool, any one of which is enough for one part of the work.
pub(crate) type Alternatives = Vec<Pose>;

/// The places for a base that reach one pose of each of `work`, the best first: where the least manipulability is
/// greatest. The base faces the work.
pub(crate) fn bases(
    scene: &TaskScene,
    robot: &Robot,
    work: &[Alternatives],
    settings: &ExecutionSettings,
) -> Vec<Isometry3<f64>> {
    let Ok(arms) = PlannerArms::new(robot) else { return Vec::new() };
    let reach = Reach::new(robot);
    let reach_m = reach_m(robot);
    let at = |tool: &Pose| tool.translation_m.truncate();
    let points: Vec<DVec2> = work.iter().filter_map(|poses| poses.first().map(at)).collect();
    let center = points.iter().sum::<DVec2>() / points.len().max(1) as f64;
    let (low, high) = scene.outline.bounds();
    let (low, high) = (low - BEYOND_M, high + BEYOND_M);
    let spacing_m = SPACING_SHARE * reach_m;
    let counts = ((high - low) / spacing_m).ceil();
    let mut ranked: Vec<(f64, Isometry3<f64>)> = Vec::new();
    for i in 0..=counts.x as i32 {
        for j in 0..=counts.y as i32 {
            let place = low + spacing_m * DVec2::new(f64::from(i), f64::from(j));
            let in_reach = |p: &DVec2| (TOO_NEAR_M..0.95 * reach_m).contains(&p.distance(place));
            if !points.iter().all(in_reach) || !has_room(scene, place) {
                continue;
            }
            let toward = center - place;
            let base = Isometry3::from_parts(
                Translation3::new(place.x, place.y, settings.mount_m),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), toward.y.atan2(toward.x)),
            );
            let mut worst = f64::INFINITY;
            for poses in work {
                worst = worst.min(best_of(&reach, &base, poses, settings));
                if worst == 0.0 {
                    break;
                }
            }
            if worst > 0.0 && home_is_free(scene, robot, &arms, &base) {
                ranked.push((worst, base));
            }
        }
    }
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.into_iter().map(|(_, base)| base).collect()
}

/// The greatest manipulability at any of the poses: the least of those at the pose, before it, and above it.
fn best_of(reach: &Reach, base: &Isometry3<f64>, poses: &[Pose], settings: &ExecutionSettings) -> f64 {
    let worst = |pose: &Pose| {
        let back = pose.rotation * geometry::DVec3::Z * -settings.approach_m;
        let up = geometry::DVec3::new(0.0, 0.0, settings.lift_m);
        let mut worst = f64::INFINITY;
        for offset in [geometry::DVec3::ZERO, back, up] {
            let moved = Pose { translation_m: pose.translation_m + offset, ..*pose };
            worst = worst.min(reach.manipulability(&(base.inverse() * to_isometry(&moved))));
            if worst == 0.0 {
                break;
            }
        }
        worst
    };
    poses.iter().take(2 * GRASPS).map(worst).fold(0.0, f64::max)
}

/// No point of the tool is farther from the first joint than this.
pub(crate) fn reach_m(robot: &Robot) -> f64 {
    let along = |link: &usize| {
        let joint = robot.links()[*link].joint.as_ref();
        joint.map_or(0.0, |joint| joint.parent_from_joint.translation.vector.norm())
    };
    let chain: f64 = robot.arm_links().iter().skip(1).map(along).sum();
    chain + robot.tool().link_from_tool.translation.vector.norm()
}

/// Whether the base stands beside the table, or on it and away from all objects.
fn has_room(scene: &TaskScene, place: DVec2) -> bool {
    let inside_m = scene.outline.depth_inside_m(place);
    let away = |object: &physics::Body| {
        let corners = object.hulls.iter().flat_map(|hull| &hull.points);
        corners
            .into_iter()
            .all(|p| object.world_from_object.transform_point(*p).truncate().distance(place) > CLEAR_M)
    };
    !(-BASE_RADIUS_M..=BASE_RADIUS_M).contains(&inside_m) && scene.objects.iter().all(away)
}

/// Whether the arm can wait at home.
fn home_is_free(scene: &TaskScene, robot: &Robot, arms: &PlannerArms, base: &Isometry3<f64>) -> bool {
    let base_from_world = base.inverse();
    let bodies = std::iter::once(&scene.table).chain(&scene.objects);
    let blocks: Vec<_> = bodies
        .flat_map(|body| obstacles(&body.hulls, &(base_from_world * to_isometry(&body.world_from_object))))
        .collect();
    let options = PlanOptions { padding_m: 0.002, ..PlanOptions::default() };
    Planner::new(&arms.whole, &blocks, options).check_start(&robot.home().positions).is_ok()
}

/// The poses of the tool that pick an object up, and those that put it down, for the first grasps.
pub(crate) fn tool_poses(world_from_object: &Pose, grasps: &[crate::grasp::Grasp]) -> Alternatives {
    let first = grasps.iter().take(GRASPS);
    first
        .flat_map(|grasp| [*grasp, grasp.mirrored()])
        .map(|g| *world_from_object * g.object_from_tool)
        .collect()
}

/// Whether the arm at its place reaches any point of the table.
pub(crate) fn reaches_table(motions: &Motions) -> bool {
    let at = motions.world_from_base.translation.vector;
    -motions.scene.outline.depth_inside_m(DVec2::new(at.x, at.y)) < reach_m(motions.robot)
}
