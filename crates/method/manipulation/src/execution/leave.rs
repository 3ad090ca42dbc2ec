//! Motion of the hand away from an object that it has put down.
//!
//! The retreat from a place is as long as the way to a grasp, and passes neighbors closely. Beside tall neighbors the
//! hand is then still nearer to them than a task allows at its end. So it goes on, straight, until it is far enough:
//! the shortest way of those back along the fingers and those up that it passes and the arm reaches.

use geometry::{DVec3, Pose};
use nalgebra::Isometry3;

use super::motions::Motions;
use super::obstacles::Surroundings;
use crate::frames::{from_vector, to_pose};

/// Ways are tried in steps of this length up to the greatest, meters.
const STEP_M: f64 = 0.02;
const MAX_WAY_M: f64 = 0.5;

/// Whether the hand, with its tool at a pose, is at least `gap_m` from all objects and touches no table.
pub(crate) fn is_away(
    motions: &Motions,
    around: &Surroundings,
    world_from_tool: &Pose,
    opening_m: f64,
    gap_m: f64,
) -> bool {
    let hand = motions.hand.solids(opening_m, true);
    around.are_passed(&hand, world_from_tool, DVec3::ZERO, gap_m)
}

/// A straight way of the opened hand from a configuration to where it is `gap_m` from all objects in these poses.
/// `None` if there is none, or none is needed.
pub(crate) fn way_out(
    motions: &Motions,
    at: &[f64],
    opening_m: f64,
    poses: &[Pose],
    gap_m: f64,
) -> Option<Vec<Vec<f64>>> {
    let scene = motions.scene;
    let around = Surroundings::new(&scene.table, &scene.objects, poses, &[]);
    let base_from_tool: Isometry3<f64> = robot::kinematics::tool_pose(motions.robot, at);
    let world_from_tool = to_pose(&(motions.world_from_base * base_from_tool));
    let away = |pose: &Pose| is_away(motions, &around, pose, opening_m, gap_m);
    if away(&world_from_tool) {
        return None;
    }
    let hand = motions.hand.solids(opening_m, true);
    let directions = [-(world_from_tool.rotation * DVec3::Z), DVec3::Z];
    let count = (MAX_WAY_M / STEP_M).round() as usize;
    let ways = (1..=count).flat_map(|k| directions.map(|direction| k as f64 * STEP_M * direction));
    ways.filter(|way| {
        let end = Pose { translation_m: world_from_tool.translation_m + *way, ..world_from_tool };
        // The hand may be as close already as its retreat went past the neighbors.
        away(&end) && around.are_passed(&hand, &end, -*way, 0.5 * motions.settings.hand_gap_m)
    })
    .find_map(|way| motions.straight_past(poses, at, from_vector(way)))
}

#[cfg(test)]
mod tests {
    use geometry::shapes::block;
    use geometry::{DVec2, Outline};
    use physics::Body;
    use robot::model::Robot;

    use super::*;
    use crate::execution::{ExecutionSettings, TaskScene};
    use crate::test_scenes::box_body;

    const GAP_M: f64 = 0.02;

    /// A table with a wall of this height, whose side is at `y_m`.
    fn beside_wall(height_m: f64, y_m: f64) -> TaskScene {
        let corners = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)].map(DVec2::from);
        let top = block(DVec3::new(1.2, 0.8, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
        let wall = block(DVec3::new(0.06, 0.04, height_m));
        let place = Pose::upright(DVec3::new(0.3, y_m + 0.02, 0.0), 0.0);
        TaskScene {
            table: Body { fixed: true, ..box_body("table", top, 10.0, Pose::IDENTITY) },
            outline: Outline::new(corners.to_vec()).expect("a rectangle"),
            objects: vec![box_body("wall_1", wall, 0.5, place)],
        }
    }

    #[test]
    fn the_hand_rises_past_a_tall_neighbor_and_stays_where_it_is_far_or_cannot_pass() {
        let robot = Robot::built_in("panda", None).expect("built in");
        let settings: ExecutionSettings = test_settings::section("execution");
        let (at, opening_m) = (&robot.home().positions, robot.home().opening_m);
        let base = Isometry3::translation(0.0, 0.0, 0.05);
        let home = to_pose(&(base * robot::kinematics::tool_pose(&robot, at)));
        let hand = crate::grasp::HandShape::new(&robot).solids(opening_m, true);
        let side_m = hand.iter().flatten().map(|p| home.transform_point(*p).y).fold(0.0, f64::max);
        let low_m = hand.iter().flatten().map(|p| home.transform_point(*p).z).fold(1.0, f64::min);
        for (above_m, beside_m, rises) in [(0.15, 0.01, true), (0.15, 0.03, false), (1.5, 0.01, false)] {
            let scene = beside_wall(low_m + above_m, side_m + beside_m);
            let motions = Motions::new(&scene, &robot, base, &settings).expect("an arm");
            let way = way_out(&motions, at, opening_m, &scene.poses(), GAP_M);
            assert_eq!(way.is_some(), rises, "wall {above_m} m above the pads, {beside_m} m beside the hand");
            let Some(end) = way.as_ref().and_then(|way| way.last()) else { continue };
            let end = to_pose(&(base * robot::kinematics::tool_pose(&robot, end)));
            let around = Surroundings::new(&scene.table, &scene.objects, &scene.poses(), &[]);
            assert!(is_away(&motions, &around, &end, opening_m, GAP_M));
            let risen = end.translation_m - home.translation_m;
            assert!(risen.truncate().length() < 1e-4 && (0.02..0.2).contains(&risen.z), "{risen}");
        }
    }
}
