//! The gripper without its arm, moved by three stiff slides.

use nalgebra::{Isometry3, Unit, Vector3};
use rapier3d_f64::prelude::MassProperties;
use robot::model::{JointDrive, JointLimits, MovingKind, PositionSource, Robot};

use super::{Mechanism, Part, PartJoint};

/// Range of a slide each way, meters.
const STROKE_M: f64 = 2.0;
/// The mass of a slide, kilograms; it only has to be positive.
const SLIDE_KG: f64 = 1.0;
/// A slide yields by a micrometer to a load of 1 N.
const SLIDE: JointDrive =
    JointDrive { stiffness: 1e6, damping: 2e4, joint_damping: 0.0, joint_friction: 0.0, armature: 0.0 };
const SLIDE_LIMITS: JointLimits = JointLimits {
    min_position: -STROKE_M,
    max_position: STROKE_M,
    max_velocity: 1.0,
    max_acceleration: 10.0,
    max_jerk: 1e3,
    max_effort: 1e4,
};

impl Mechanism {
    /// The part that carries the tool with its fingers. Its base stands in the frame of the world; the configuration is
    /// how far the hand is from `world_from_tool` along x, y and z, meters, and its orientation stays.
    pub fn of_hand(robot: &Robot, world_from_tool: &Isometry3<f64>) -> Self {
        let whole = Self::of_robot(robot);
        let world_from_hand = world_from_tool * whole.part_from_tool.inverse();
        let mut parts = vec![Part::empty("world", None)];
        let mut new_index = vec![None; whole.parts.len()];
        for (joint, axis) in [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()].into_iter().enumerate()
        {
            let slide = |parent_from_joint: Isometry3<f64>, axis: Unit<Vector3<f64>>| PartJoint {
                parent: joint,
                parent_from_joint,
                kind: MovingKind::Prismatic,
                axis,
                limits: SLIDE_LIMITS,
                drive: SLIDE,
                source: PositionSource::Arm(joint),
            };
            let part = if joint < 2 {
                let ball = geometry::DVec3::splat(1e-3);
                Part {
                    mass: Some(MassProperties::new(geometry::DVec3::ZERO, SLIDE_KG, ball)),
                    ..Part::empty(["slide_x", "slide_y"][joint], Some(slide(Isometry3::identity(), axis)))
                }
            } else {
                // The frame of the last slide is that of the hand, so its axis is turned back.
                let axis = Unit::new_normalize(world_from_hand.rotation.inverse() * axis.into_inner());
                new_index[whole.tool_part] = Some(parts.len());
                Part { joint: Some(slide(world_from_hand, axis)), ..whole.parts[whole.tool_part].clone() }
            };
            parts.push(part);
        }
        let hand_part = parts.len() - 1;
        for finger in whole.fingers() {
            new_index[finger] = Some(parts.len());
            let mut part = whole.parts[finger].clone();
            if let Some(joint) = &mut part.joint {
                joint.parent = new_index[joint.parent].unwrap_or(hand_part);
            }
            parts.push(part);
        }
        let renumbered = |part: usize| new_index[part].unwrap_or(hand_part);
        Self {
            arm_parts: vec![1, 2, 3],
            finger_part: renumbered(whole.finger_part),
            following_parts: whole.following_parts.iter().map(|&(p, m, o)| (renumbered(p), m, o)).collect(),
            tool_part: hand_part,
            part_from_tool: whole.part_from_tool,
            part_of_link: whole.part_of_link.iter().map(|part| new_index[(*part)?]).collect(),
            parts,
        }
    }
}
