//! The arm of a robot, as the checks see it.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::arm::{Arm, ArmBody, ArmError, ArmJoint, JointMotion, Sphere};
use crate::model::ArmSpheres;
use crate::model::Robot;
use crate::model::link::{MovingKind, PositionSource};
use crate::model::sphere_model::SphereModel;

impl Arm {
    /// The arm of `robot` with the pads of its gripper `opening_m` apart. Each link with spheres is a body, in the
    /// order of the links.
    ///
    /// # Errors
    /// If the robot has more joints or bodies than the checks handle.
    pub fn of_robot(robot: &Robot, opening_m: f64) -> Result<Self, ArmError> {
        let model = ArmSpheres::new(robot, opening_m);
        let mut joints = Vec::new();
        // For each link the moving frame that it is fixed to, and its pose there.
        let mut fixed: Vec<(usize, Isometry3<f64>)> = Vec::with_capacity(robot.links().len());
        for link in robot.links() {
            let Some(joint) = &link.joint else {
                fixed.push((0, Isometry3::identity()));
                continue;
            };
            let (frame, frame_from_parent) = fixed[joint.parent];
            let frame_from_joint = frame_from_parent * joint.parent_from_joint;
            fixed.push(match joint.moving() {
                None => (frame, frame_from_joint),
                Some(moving) => match moving.source {
                    PositionSource::Gripper { .. } => {
                        let position = robot.joint_position(moving, &[], opening_m);
                        (frame, frame_from_joint * moving.displacement(position))
                    }
                    PositionSource::Arm(_) => {
                        // The checks move joints about or along z.
                        let half_turn =
                            || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
                        let axis_from_z = UnitQuaternion::rotation_between(&Vector3::z(), &moving.axis)
                            .unwrap_or_else(half_turn);
                        let motion = match moving.kind {
                            MovingKind::Revolute => JointMotion::Turn,
                            MovingKind::Prismatic => JointMotion::Slide,
                        };
                        let parent_from_joint = frame_from_joint * axis_from_z;
                        joints.push(ArmJoint { parent_from_joint, motion, limits: moving.limits });
                        let back = Isometry3::from_parts(Translation3::identity(), axis_from_z.inverse());
                        (joints.len(), back)
                    }
                },
            });
        }
        let mut bodies: Vec<ArmBody> = Vec::new();
        let mut body_of_link = vec![None; robot.links().len()];
        for spheres in model.spheres().chunk_by(|a, b| a.link == b.link) {
            let link = spheres[0].link;
            let (frame, frame_from_link) = fixed[link];
            body_of_link[link] = Some(bodies.len());
            let placed = spheres.iter().map(|sphere| Sphere {
                center_m: frame_from_link * Point3::from(sphere.center_m.map(f64::from)),
                radius_m: f64::from(sphere.radius_m),
            });
            bodies.push(ArmBody { frame, spheres: placed.collect() });
        }
        let pairs = model.self_collision_pairs().iter();
        let pairs = pairs.filter_map(|&(a, b)| Some((body_of_link[a]?, body_of_link[b]?)));
        let pairs = pairs.filter(|&(a, b)| bodies[a].frame != bodies[b].frame).collect();
        Self::new(joints, bodies, pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::link_poses;

    #[test]
    fn every_sphere_is_where_the_kinematics_put_it() {
        for name in ["panda", "piper"] {
            let robot = Robot::built_in(name, None).expect("built in");
            let arm = Arm::of_robot(&robot, 0.03).expect("an arm");
            let positions: Vec<f64> = robot
                .limits()
                .iter()
                .enumerate()
                .map(|(k, l)| l.min_position + (0.2 + 0.1 * k as f64) * (l.max_position - l.min_position))
                .collect();
            let poses = link_poses(&robot, &positions, 0.03);
            let frames = arm.frames(&positions);
            let placed =
                arm.bodies().iter().flat_map(|b| b.spheres.iter().map(|s| frames[b.frame] * s.center_m));
            let model = ArmSpheres::new(&robot, 0.03);
            let expected =
                model.spheres().iter().map(|s| poses[s.link] * Point3::from(s.center_m.map(f64::from)));
            assert_eq!(arm.bodies().iter().map(|b| b.spheres.len()).sum::<usize>(), model.spheres().len());
            for (ours, theirs) in placed.zip(expected) {
                assert!((ours - theirs).norm() < 1e-9, "{name}: {ours} is not {theirs}");
            }
        }
    }
}
