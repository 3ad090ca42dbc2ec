//! Pose of the base of an arm: the place from which it reaches all grasps and goals best.

use geometry::polygon::convex_hull_2d;
use geometry::{DVec2, Outline, Pose};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use robot::collision::{ConvexPolyhedron, Obstacle};
use robot::model::Robot;
use robot::planning::{PlanOptions, Planner};

use super::motions::Motions;
use super::obstacles::{PlannerArms, polyhedra, stand};
use super::reach::Reach;
use super::refusal::BasePoint;
use super::scene::TaskScene;
use super::settings::ExecutionSettings;
use super::{BASES, Refusal};
use crate::frames::to_isometry;
use crate::link_meshes::STAND_M;

/// Places that are tried lie apart by this share of the reach.
const SPACING_SHARE: f64 = 0.1;
/// Maximum distance of a base from the edge of the table, meters.
const BEYOND_M: f64 = 0.3;
/// Objects are not nearer to the axis of the base than this share of the reach: 0.2 m for the Panda.
const CLEAR_SHARE: f64 = 0.185;
/// Minimum distance of the arm's axis from the objects and places of the task, as a share of the reach.
const TOO_NEAR_SHARE: f64 = 0.2;
/// Grasps of each object that are considered, and places where it is put down.
const GRASPS: usize = 6;
const PLACES: usize = 6;

/// Poses of the tool, any one of which is enough for one part of the work.
pub(crate) type Alternatives = Vec<Pose>;

/// A hull in the frame of its body, and `world_from_body`.
type Placed = (ConvexPolyhedron, Isometry3<f64>);

/// The places for a base that reach one pose of each of `work`: those on the first mount first, of each mount the best
/// [`BASES`]. What is not asked for is not computed.
pub(crate) fn bases<'a>(
    scene: &'a TaskScene,
    robot: &'a Robot,
    work: Vec<Alternatives>,
    settings: &'a ExecutionSettings,
) -> impl Iterator<Item = Isometry3<f64>> + 'a {
    settings.mounts_m.iter().flat_map(move |mount_m| bases_at(scene, robot, &work, *mount_m, settings))
}

/// The best [`BASES`] places for a base at this height that reach one pose of each of `work`, the best first: where the
/// worst manipulability is greatest. The base faces the work.
fn bases_at(
    scene: &TaskScene,
    robot: &Robot,
    work: &[Alternatives],
    mount_m: f64,
    settings: &ExecutionSettings,
) -> Vec<Isometry3<f64>> {
    let Ok(arms) = PlannerArms::new(robot) else { return Vec::new() };
    let (reach, solids, footprints) = (Reach::new(robot), solids_of(scene), footprints(scene));
    let reach_m = reach_m(robot);
    let at = |tool: &Pose| tool.translation_m.truncate();
    let points: Vec<DVec2> = work.iter().filter_map(|poses| poses.first().map(at)).collect();
    let center = points.iter().sum::<DVec2>() / points.len().max(1) as f64;
    let (low, high) = scene.outline.bounds();
    let (low, high) = (low - BEYOND_M, high + BEYOND_M);
    let spacing_m = SPACING_SHARE * reach_m;
    let counts = ((high - low) / spacing_m).ceil();
    let mut best: Vec<(f64, Isometry3<f64>)> = Vec::new();
    for i in 0..=counts.x as i32 {
        for j in 0..=counts.y as i32 {
            let place = low + spacing_m * DVec2::new(f64::from(i), f64::from(j));
            let in_reach =
                |pose: &Pose| (TOO_NEAR_SHARE * reach_m..0.95 * reach_m).contains(&at(pose).distance(place));
            if !work.iter().all(|poses| poses.iter().any(in_reach))
                || !has_room(scene, &footprints, place, CLEAR_SHARE * reach_m)
            {
                continue;
            }
            let toward = center - place;
            let base = Isometry3::from_parts(
                Translation3::new(place.x, place.y, mount_m),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), toward.y.atan2(toward.x)),
            );
            // Only what is better than the last of those that are kept counts.
            let floor = if best.len() == BASES { best[BASES - 1].0 } else { 0.0 };
            let worst = worst_of(&reach, &base, work, floor, settings);
            if worst > floor && home_is_free(&solids, robot, &arms, &base) {
                let rank = best.partition_point(|(other, _)| *other >= worst);
                best.insert(rank, (worst, base));
                best.truncate(BASES);
            }
        }
    }
    best.into_iter().map(|(_, base)| base).collect()
}

/// The worst manipulability of all parts of the work, each in the best of its poses; 0 if it is not above `floor`.
fn worst_of(
    reach: &Reach,
    base: &Isometry3<f64>,
    work: &[Alternatives],
    floor: f64,
    settings: &ExecutionSettings,
) -> f64 {
    let mut worst = f64::INFINITY;
    for poses in work {
        let mut best = floor;
        for pose in poses {
            best = best.max(manipulability_at(reach, base, pose, best, settings));
            // More does not change the worst.
            if best >= worst {
                break;
            }
        }
        if best <= floor {
            return 0.0;
        }
        worst = worst.min(best);
    }
    worst
}

/// The worst manipulability at a pose, before it, and above it; any number up to `floor` if it is not above that.
fn manipulability_at(
    reach: &Reach,
    base: &Isometry3<f64>,
    pose: &Pose,
    floor: f64,
    settings: &ExecutionSettings,
) -> f64 {
    let back = pose.rotation * geometry::DVec3::Z * -settings.approach_m;
    let up = geometry::DVec3::new(0.0, 0.0, settings.lift_m);
    let mut worst = f64::INFINITY;
    for offset in [geometry::DVec3::ZERO, back, up] {
        let moved = Pose { translation_m: pose.translation_m + offset, ..*pose };
        worst = worst.min(reach.manipulability(&(base.inverse() * to_isometry(&moved))));
        if worst <= floor {
            break;
        }
    }
    worst
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

/// Whether the base stands beside the table or on it, not on its edge, and this far from all objects seen from above.
fn has_room(scene: &TaskScene, footprints: &[Outline], place: DVec2, clear_m: f64) -> bool {
    let inside_m = scene.outline.depth_inside_m(place);
    let is_away = |footprint: &Outline| -footprint.depth_inside_m(place) > clear_m;
    inside_m.abs() > 0.5 * STAND_M && footprints.iter().all(is_away)
}

/// The outline of each object from above.
fn footprints(scene: &TaskScene) -> Vec<Outline> {
    let of = |object: &physics::Body| {
        let points = object.hulls.iter().flat_map(|hull| &hull.points);
        let above = points.map(|p| object.world_from_object.transform_point(*p).truncate());
        Outline::new(convex_hull_2d(&above.collect::<Vec<_>>())).ok()
    };
    scene.objects.iter().filter_map(of).collect()
}

/// Checks a given place for the base: the arm has to be free at home, and near the table.
///
/// # Errors
/// [`Refusal::BaseNotFree`] and [`Refusal::BaseTooFar`].
pub fn check_base(scene: &TaskScene, robot: &Robot, world_from_base: &Isometry3<f64>) -> Result<(), Refusal> {
    let point = world_from_base.translation.vector;
    let at = BasePoint { x_m: point.x, y_m: point.y, z_m: point.z };
    let (name, distance_m) = (robot.name().to_owned(), from_table_m(scene, world_from_base));
    if distance_m >= reach_m(robot) {
        return Err(Refusal::BaseTooFar { at, robot: name, distance_m, reach_m: reach_m(robot) });
    }
    let arms = PlannerArms::new(robot)?;
    let is_free = home_is_free(&solids_of(scene), robot, &arms, world_from_base);
    is_free.then_some(()).ok_or(Refusal::BaseNotFree { at, robot: name })
}

/// Whether the arm can wait at home, among solids in the world.
fn home_is_free(solids: &[Placed], robot: &Robot, arms: &PlannerArms, base: &Isometry3<f64>) -> bool {
    let base_from_world = base.inverse();
    let placed = |(solid, pose): &Placed| Obstacle::hull(base_from_world * pose, solid.clone()).ok();
    let blocks: Vec<_> = solids.iter().filter_map(placed).chain(stand(base)).collect();
    let options = PlanOptions { padding_m: 0.002, ..PlanOptions::default() };
    Planner::new(&arms.whole, &blocks, options).check_start(&robot.home().positions).is_ok()
}

/// The hulls of the table and of all objects.
fn solids_of(scene: &TaskScene) -> Vec<Placed> {
    let bodies = std::iter::once(&scene.table).chain(&scene.objects);
    let placed = bodies.flat_map(|body| {
        let pose = to_isometry(&body.world_from_object);
        polyhedra(&body.hulls).into_iter().map(move |solid| (solid, pose))
    });
    placed.collect()
}

/// The poses of the tool that have an object at one of its first places, by one of the first grasps.
pub(crate) fn tool_poses(places: &[Pose], grasps: &[crate::grasp::Grasp]) -> Alternatives {
    let grasps = grasps.iter().take(GRASPS).flat_map(|grasp| [*grasp, grasp.mirrored()]);
    let grasps: Vec<Pose> = grasps.map(|grasp| grasp.object_from_tool).collect();
    let places = places.iter().take(PLACES);
    places.flat_map(|place| grasps.iter().map(|object_from_tool| *place * *object_from_tool)).collect()
}

/// Whether the arm at its place reaches any point of the table.
pub(crate) fn reaches_table(motions: &Motions) -> bool {
    from_table_m(motions.scene, &motions.world_from_base) < reach_m(motions.robot)
}

/// Distance of a base from the edge of the table, seen from above, meters; negative on the table.
fn from_table_m(scene: &TaskScene, world_from_base: &Isometry3<f64>) -> f64 {
    let at = world_from_base.translation.vector;
    -scene.outline.depth_inside_m(DVec2::new(at.x, at.y))
}

#[cfg(test)]
mod tests {
    use geometry::DVec3;
    use geometry::shapes::block;

    use super::*;
    use crate::test_scenes::box_body;

    /// Regression: only the corners of an object had to be away from the base, which stood at the center of a board.
    #[test]
    fn a_base_stands_neither_on_a_board_nor_on_the_edge_of_the_table() {
        let outline = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)].map(DVec2::from);
        let top = block(DVec3::new(1.2, 0.8, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
        let board = block(DVec3::new(0.4, 0.4, 0.02));
        let scene = TaskScene {
            table: box_body("table", top, 10.0, Pose::IDENTITY),
            outline: Outline::new(outline.to_vec()).expect("a rectangle"),
            objects: vec![box_body("board_1", board, 1.0, Pose::IDENTITY)],
        };
        let footprints = footprints(&scene);
        let cases = [(0.0, false), (0.3, false), (0.4, true), (0.58, false), (0.65, false), (0.8, true)];
        for (x_m, expected) in cases {
            let found = has_room(&scene, &footprints, DVec2::new(x_m, 0.0), 0.14);
            assert_eq!(found, expected, "a base {x_m} m from the center of a board of 0.4 m");
        }
    }
}
