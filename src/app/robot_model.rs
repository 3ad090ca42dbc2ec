//! A robot as a model for viewers: a GLB file whose nodes are the links, each carried by its parent.

use geometry::Pose;
use manipulation::frames::to_pose;
use manipulation::link_meshes::link_meshes;
use mesh_io::gltf::{SceneNode, write_scene_glb};
use robot::model::{MovingJoint, MovingKind, PositionSource, Robot};
use serde_json::{Value, json};

/// A GLB file of the robot with all joints at zero. The extras of a link that moves are those of its joint: `joint`,
/// `kind` (`revolute` or `prismatic`), `axis` in the frame of the link, and either `arm_joint`, the index among the
/// positions of the arm, or `per_opening_m` and `offset`, by which the position follows from the opening of the
/// gripper. The transform of the link is that of the file times the rotation about the axis, or the way along it.
///
/// `None` for a robot that is not built in.
pub fn robot_glb(name: &str) -> Option<Vec<u8>> {
    Robot::built_in(name, None).ok().map(|robot| glb(&robot))
}

fn glb(robot: &Robot) -> Vec<u8> {
    let meshes = link_meshes(robot);
    let node = |(link, mesh)| {
        let link: &robot::model::Link = link;
        let joint = link.joint.as_ref();
        SceneNode {
            name: &link.name,
            extras: joint
                .and_then(|joint| joint.moving().map(|moving| extras(robot, &joint.name, moving)))
                .unwrap_or_else(|| json!({})),
            mesh,
            parent: joint.map(|joint| joint.parent),
            parent_from_node: joint.map_or(Pose::IDENTITY, |joint| to_pose(&joint.parent_from_joint)),
        }
    };
    let nodes: Vec<SceneNode<'_>> = robot.links().iter().zip(&meshes).map(node).collect();
    write_scene_glb(&nodes)
}

fn extras(robot: &Robot, name: &str, moving: &MovingJoint) -> Value {
    let kind = match moving.kind {
        MovingKind::Revolute => "revolute",
        MovingKind::Prismatic => "prismatic",
    };
    let axis: [f64; 3] = moving.axis.into_inner().into();
    match moving.source {
        PositionSource::Arm(index) => {
            json!({ "joint": name, "kind": kind, "axis": axis, "arm_joint": index })
        }
        PositionSource::Gripper { multiplier, offset } => json!({
            "joint": name,
            "kind": kind,
            "axis": axis,
            "per_opening_m": multiplier * robot.gripper_position(1.0),
            "offset": offset,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{DQuat, DVec3};
    use robot::kinematics::link_poses;
    use robot::model::library;

    /// The nodes of a file: name, parent, and pose with the joints at these positions, by the rule of the file alone.
    fn posed(glb: &[u8], positions: &[f64], opening_m: f64) -> Vec<(String, Pose)> {
        let length = u32::from_le_bytes(glb[12..16].try_into().expect("four bytes")) as usize;
        let document: Value = serde_json::from_slice(&glb[20..20 + length]).expect("JSON");
        let nodes = document["nodes"].as_array().expect("nodes");
        let numbers = |value: &Value| -> Vec<f64> {
            value
                .as_array()
                .expect("numbers")
                .iter()
                .map(|number| number.as_f64().expect("a number"))
                .collect()
        };
        let root = nodes.len() - 1;
        let mut parent_of = vec![None; root];
        for (index, node) in nodes.iter().enumerate().filter(|(index, _)| *index != root) {
            for child in node["children"].as_array().into_iter().flatten() {
                parent_of[child.as_u64().expect("an index") as usize] = Some(index);
            }
        }
        let mut poses: Vec<(String, Pose)> = Vec::new();
        for (node, parent) in nodes.iter().zip(parent_of) {
            let rest = Pose {
                translation_m: DVec3::from_slice(&numbers(&node["translation"])),
                rotation: DQuat::from_slice(&numbers(&node["rotation"])),
            };
            let extras = &node["extras"];
            let position = match (&extras["arm_joint"], &extras["per_opening_m"]) {
                (Value::Number(index), _) => positions[index.as_u64().expect("an index") as usize],
                (_, Value::Number(factor)) => {
                    factor.as_f64().expect("a number") * opening_m
                        + extras["offset"].as_f64().expect("a number")
                }
                _ => 0.0,
            };
            let moved = match extras["kind"].as_str() {
                Some("revolute") => Pose {
                    translation_m: DVec3::ZERO,
                    rotation: DQuat::from_axis_angle(DVec3::from_slice(&numbers(&extras["axis"])), position),
                },
                Some("prismatic") => Pose {
                    translation_m: DVec3::from_slice(&numbers(&extras["axis"])) * position,
                    rotation: DQuat::IDENTITY,
                },
                _ => Pose::IDENTITY,
            };
            let local = rest * moved;
            let pose = parent.map_or(local, |parent: usize| poses[parent].1 * local);
            poses.push((node["name"].as_str().expect("a name").to_owned(), pose));
        }
        poses
    }

    #[test]
    fn the_model_moves_as_the_kinematics_do() {
        for name in library::names() {
            let robot = Robot::built_in(name, None).expect("built in");
            let positions: Vec<f64> = (0..robot.dof()).map(|joint| 0.3 - 0.1 * joint as f64).collect();
            let opening_m = 0.6 * robot.gripper().max_opening_m;
            let expected = link_poses(&robot, &positions, opening_m);
            let found = posed(&glb(&robot), &positions, opening_m);
            assert_eq!(found.len(), expected.len());
            for ((link, found), expected) in found.iter().zip(&expected) {
                let expected = to_pose(expected);
                let away_m = (found.translation_m - expected.translation_m).length();
                let turned_rad = found.rotation.angle_between(expected.rotation);
                assert!(away_m < 1e-6 && turned_rad < 1e-6, "{name}: {link} is {away_m} m away");
            }
        }
    }
}
