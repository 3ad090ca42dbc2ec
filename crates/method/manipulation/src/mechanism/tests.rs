//! Mechanisms against the kinematics of their robots.

use geometry::convex_hull::{distance_above, planes};
use geometry::{DVec3, Pose};
use nalgebra::Point3;
use robot::kinematics::{link_poses, tool_pose};

use super::*;
use crate::frames::{from_vector, to_isometry, to_vector};

#[test]
fn parts_are_where_the_links_are() {
    for name in ["panda", "piper"] {
        let robot = Robot::built_in(name, None).expect("built in");
        let mechanism = Mechanism::of_robot(&robot);
        let (home, opening_m) = (&robot.home().positions, 0.03);
        let position = robot.gripper_position(opening_m);
        let poses = mechanism.base_from_parts(home, position);
        let expected = link_poses(&robot, home, opening_m);
        for (index, part) in mechanism.parts.iter().enumerate() {
            let link = robot.link_index(&part.name).expect("named after its link");
            assert!((poses[index].translation.vector - expected[link].translation.vector).norm() < 1e-9);
            assert!(poses[index].rotation.angle_to(&expected[link].rotation) < 1e-9);
        }
        let tool = poses[mechanism.tool_part] * mechanism.part_from_tool;
        assert!((tool.translation.vector - tool_pose(&robot, home).translation.vector).norm() < 1e-9);
        let mass_kg: f64 = mechanism.parts.iter().filter_map(|p| Some(p.mass.as_ref()?.mass())).sum();
        let of_links: f64 = robot.links().iter().filter_map(|l| Some(l.inertia?.mass_kg)).sum();
        assert!((mass_kg - of_links).abs() < 1e-9, "{name}: {mass_kg} is not {of_links}");
    }
}

#[test]
fn hulls_are_as_large_as_their_shapes() {
    let robot = Robot::built_in("panda", None).expect("built in");
    for link in robot.links() {
        for shape in link.shapes.iter().filter(|shape| shape.collides()) {
            let hull = hull_of(shape, &Isometry3::identity());
            let exact_m3 = shape.primitive.volume_m3();
            let share = hull.volume_m3() / exact_m3;
            assert!((0.9..1.0 + 1e-9).contains(&share), "{}: {share} of {exact_m3}", link.name);
            let faces = planes(&hull);
            let center = to_vector(&shape.link_from_shape.translation.vector);
            assert!(distance_above(&faces, center) < 0.0);
            for corner in &hull.points {
                let own = shape.link_from_shape.inverse() * Point3::from(from_vector(*corner));
                assert!(shape.primitive.signed_distance_m(&own).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn the_hand_holds_its_tool_at_the_asked_pose() {
    let robot = Robot::built_in("piper", None).expect("built in");
    let rotation = geometry::DQuat::from_rotation_x(2.0) * geometry::DQuat::from_rotation_z(0.3);
    let world_from_tool = to_isometry(&Pose { translation_m: DVec3::new(0.1, 0.2, 0.3), rotation });
    let hand = Mechanism::of_hand(&robot, &world_from_tool);
    let shift = [0.05, -0.1, 0.2];
    let pose = hand.base_from_parts(&shift, 0.01)[hand.tool_part] * hand.part_from_tool;
    let expected = world_from_tool.translation.vector + Vector3::new(0.05, -0.1, 0.2);
    assert!((pose.translation.vector - expected).norm() < 1e-9);
    assert!(pose.rotation.angle_to(&world_from_tool.rotation) < 1e-9);
}
