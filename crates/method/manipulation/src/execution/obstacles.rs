//! Obstacles of the arm: scenes and held objects as the planner and the exact checks see them.

use geometry::contact_hull::ContactHull;
use geometry::convex_hull::convex_hull;
use geometry::{ConvexHull, DVec3, Pose};
use nalgebra::{Isometry3, Point3};
use physics::Body;
use robot::collision::{Arm, ArmBody, ArmError, ConvexPolyhedron, Obstacle, Sphere};
use robot::kinematics::tool_pose;
use robot::model::Robot;

use crate::frames::{from_vector, to_isometry};
use crate::link_meshes::STAND_M;
use crate::swept::Swept;

/// Spheres that cover a held object have about this radius at most, meters.
const MAX_SPHERE_M: f64 = 0.02;
/// Maximum radius of these spheres where a held object is close to something, meters: small spheres stick out less, and
/// take longer.
const MAX_CLOSE_SPHERE_M: f64 = 0.006;
/// Minimum number of cells along the longest side of a held object.
const CELLS: f64 = 4.0;
/// Between the lowest link of a robot and the stand below it, meters.
const BASE_GAP_M: f64 = 0.02;

/// Hulls as the planner takes them. A hull that is not exactly convex is replaced by one that is.
pub(crate) fn polyhedra(hulls: &[ConvexHull]) -> Vec<ConvexPolyhedron> {
    let solid = |hull: &ConvexHull| {
        let points = hull.points.iter().map(|p| Point3::from(from_vector(*p))).collect();
        ConvexPolyhedron::new(points, hull.triangles.clone()).ok()
    };
    let convex = |hull: &ConvexHull| solid(hull).or_else(|| solid(&convex_hull(&hull.points, 64, 5e-4)?));
    hulls.iter().filter_map(convex).collect()
}

/// Hulls as obstacles in the frame of the robot's base.
pub(crate) fn obstacles(hulls: &[ConvexHull], base_from_object: &Isometry3<f64>) -> Vec<Obstacle> {
    let solids = polyhedra(hulls).into_iter();
    solids.filter_map(|solid| Obstacle::hull(*base_from_object, solid).ok()).collect()
}

/// The stand under a base that is high above the table, in the frame of the base; its lowest link is left some room.
pub(crate) fn stand(world_from_base: &Isometry3<f64>) -> Option<Obstacle> {
    let height_m = world_from_base.translation.vector.z - BASE_GAP_M;
    let column = geometry::shapes::block(DVec3::new(STAND_M, STAND_M, height_m));
    let column = column.translated(DVec3::new(0.0, 0.0, -BASE_GAP_M - height_m));
    let hull = ConvexHull { points: column.positions, triangles: column.triangles };
    let is_high = height_m > BASE_GAP_M;
    is_high.then(|| obstacles(&[hull], &Isometry3::identity()).pop()).flatten()
}

/// Solids of the hand or of what it holds, in the frame of the tool, against hulls in their poses.
pub(crate) struct Surroundings {
    bodies: Vec<(Vec<ContactHull>, Pose)>,
}

impl Surroundings {
    /// The table and the objects in these poses, without those that `skipped` names by index.
    pub fn new(table: &Body, objects: &[Body], poses: &[Pose], skipped: &[usize]) -> Self {
        let hulls = |body: &Body| body.hulls.iter().map(ContactHull::new).collect();
        let kept = objects.iter().enumerate().filter(|(index, _)| !skipped.contains(index));
        let bodies = kept.map(|(index, body)| (hulls(body), poses[index]));
        Self { bodies: std::iter::once((hulls(table), table.world_from_object)).chain(bodies).collect() }
    }

    /// Whether solids pass everything at a distance of `gap_m` on their straight way from `begin`, relative to the end
    /// and in the frame of the world, to where the tool is at `world_from_tool`. The table, which hands come close to,
    /// is only not touched.
    pub fn are_passed(
        &self,
        solids: &[Vec<DVec3>],
        world_from_tool: &Pose,
        begin: DVec3,
        gap_m: f64,
    ) -> bool {
        let offset = world_from_tool.rotation.inverse() * begin;
        let swept: Vec<Swept> =
            solids.iter().map(|corners| Swept::along(corners, world_from_tool, offset)).collect();
        self.bodies.iter().enumerate().all(|(index, (hulls, pose))| {
            let gap_m = if index == 0 { 0.0 } else { gap_m };
            hulls.iter().all(|hull| swept.iter().all(|solid| !solid.is_near(hull, pose, gap_m)))
        })
    }
}

/// The arms that are planned with.
pub(crate) struct PlannerArms {
    /// With the gripper opened as far as it goes.
    pub whole: Arm,
    /// Without the hand: where the hand is near objects, its exact shapes are checked instead of its spheres.
    pub without_hand: Arm,
    hand_bodies: Vec<usize>,
    hand_frame: usize,
}

impl PlannerArms {
    /// # Errors
    /// If the robot has more joints or bodies than the planner handles.
    pub fn new(robot: &Robot) -> Result<Self, ArmError> {
        let whole = Arm::of_robot(robot, robot.gripper().max_opening_m)?;
        let links = robot.links();
        let colliding: Vec<usize> =
            (0..links.len()).filter(|&k| links[k].shapes.iter().any(|shape| shape.collides())).collect();
        let is_finger = |link: usize| {
            let moving = links[link].joint.as_ref().and_then(|joint| joint.moving());
            moving.is_some_and(|m| matches!(m.source, robot::model::PositionSource::Gripper { .. }))
        };
        let is_hand = |body: &usize| {
            colliding.get(*body).is_some_and(|&link| link == robot.tool().link || is_finger(link))
        };
        let hand_bodies: Vec<usize> = (0..whole.bodies().len()).filter(is_hand).collect();
        let kept: Vec<usize> = (0..whole.bodies().len()).filter(|b| !hand_bodies.contains(b)).collect();
        let renumbered = |body: usize| kept.iter().position(|&other| other == body);
        let pairs = whole.pairs().iter().filter_map(|&(a, b)| Some((renumbered(a)?, renumbered(b)?)));
        let bodies = kept.iter().map(|&body| whole.bodies()[body].clone()).collect();
        let without_hand = Arm::new(whole.joints().to_vec(), bodies, pairs.collect())?;
        let hand_frame = whole.dof();
        Ok(Self { without_hand, hand_bodies, hand_frame, whole })
    }

    /// The arm with an object in its hand.
    ///
    /// # Errors
    /// If the arm has too many bodies.
    pub fn holding(
        &self,
        robot: &Robot,
        hulls: &[ConvexHull],
        tool_from_object: &Pose,
    ) -> Result<Arm, ArmError> {
        self.holding_covered(robot, hulls, tool_from_object, MAX_SPHERE_M)
    }

    /// Arm with an object in its hand that is close to something: covered with small spheres.
    ///
    /// # Errors
    /// As [`Self::holding`].
    pub fn holding_closely(
        &self,
        robot: &Robot,
        hulls: &[ConvexHull],
        tool_from_object: &Pose,
    ) -> Result<Arm, ArmError> {
        self.holding_covered(robot, hulls, tool_from_object, MAX_CLOSE_SPHERE_M)
    }

    fn holding_covered(
        &self,
        robot: &Robot,
        hulls: &[ConvexHull],
        tool_from_object: &Pose,
        max_sphere_m: f64,
    ) -> Result<Arm, ArmError> {
        let home = &robot.home().positions;
        let frames = self.whole.frames(home);
        let frame_from_tool = frames[self.hand_frame].inverse() * tool_pose(robot, home);
        let frame_from_object = frame_from_tool * to_isometry(tool_from_object);
        let spheres = spheres(hulls, max_sphere_m).into_iter().map(|(center, radius_m)| Sphere {
            center_m: frame_from_object * Point3::from(from_vector(center)),
            radius_m,
        });
        let held = ArmBody { frame: self.hand_frame, spheres: spheres.collect() };
        self.whole.holding(held, &self.hand_bodies)
    }
}

/// Spheres that cover hulls: one for each cell of a grid that meets one.
fn spheres(hulls: &[ConvexHull], max_sphere_m: f64) -> Vec<(DVec3, f64)> {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let points = hulls.iter().flat_map(|hull| &hull.points);
    let (low, high) = points.fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
    let size = high - low;
    let cell_m = (size.max_element() / CELLS).min(2.0 * max_sphere_m / 3.0_f64.sqrt()).max(2e-3);
    let counts = (size / cell_m).ceil().max(DVec3::ONE);
    let step = size / counts;
    let radius_m = 0.5 * step.length();
    let planes: Vec<_> = hulls.iter().map(geometry::convex_hull::planes).collect();
    let mut spheres = Vec::new();
    for i in 0..counts.x as i32 {
        for j in 0..counts.y as i32 {
            for k in 0..counts.z as i32 {
                let center = low + step * (DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + 0.5);
                let meets = |faces: &Vec<(DVec3, f64)>| {
                    geometry::convex_hull::distance_above(faces, center) < radius_m
                };
                if planes.iter().any(meets) {
                    spheres.push((center, radius_m));
                }
            }
        }
    }
    spheres
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{block, hull};

    #[test]
    fn spheres_cover_an_object() {
        let hulls = [hull(&block(DVec3::new(0.2, 0.03, 0.01)))];
        for (max_sphere_m, max_count) in [(MAX_SPHERE_M, 80), (MAX_CLOSE_SPHERE_M, 400)] {
            let cover = spheres(&hulls, max_sphere_m);
            assert!(cover.len() < max_count, "{}", cover.len());
            assert!(cover.iter().all(|(_, radius_m)| *radius_m <= max_sphere_m + 1e-9));
            for i in 0..=20 {
                let p = DVec3::new(-0.1 + 0.01 * f64::from(i), 0.015, 0.01);
                assert!(cover.iter().any(|(center, radius_m)| center.distance(p) <= radius_m + 1e-9), "{p}");
            }
        }
    }

    #[test]
    fn the_hand_is_left_out() {
        for name in ["panda", "piper"] {
            let robot = Robot::built_in(name, None).expect("built in");
            let arms = PlannerArms::new(&robot).expect("an arm");
            assert_eq!(arms.hand_bodies.len(), 3);
            assert_eq!(arms.without_hand.bodies().len() + 3, arms.whole.bodies().len());
            let held =
                arms.holding(&robot, &[hull(&block(DVec3::splat(0.04)))], &Pose::IDENTITY).expect("held");
            assert_eq!(held.bodies().len(), arms.whole.bodies().len() + 1);
        }
    }
}
