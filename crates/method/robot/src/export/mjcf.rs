//! MJCF: one file without meshes, with servos, contact options and a home pose.
//!
//! Each moving joint of the arm has a position servo; one more drives the gripper through a tendon to all fingers. Its
//! targets reach below closed, so that it presses thin objects with its greatest force, too.
//! Gravity does not act on the robot: its controller compensates it. Shapes that are seen are in group 2, those that
//! only collide in group 3. The tool frame is a site.

use nalgebra::Isometry3;

use super::numbers::{spaced, wxyz, xyz};
use super::{contact, excluded_pairs, model_name};
use crate::model::{
    Joint, Link, MovingJoint, MovingKind, PositionSource, Primitive, Robot, Shape, ShapeRole,
};
use markup::xml::XmlDocument;

/// Writes the robot as MJCF, its base at the origin of the world.
pub fn write_mjcf(robot: &Robot) -> String {
    let mut document = XmlDocument::new();
    document.comment(&robot.sources().join("; "));
    document.open("mujoco", &[("model", &model_name(robot))]);
    document.empty("compiler", &[("angle", "radian"), ("autolimits", "true")]);
    write_option(&mut document);
    write_defaults(&mut document, robot);
    document.open("asset", &[]);
    for material in robot.materials() {
        let [red, green, blue] = material.srgb;
        let rgba = spaced(&[red, green, blue, 1.0]);
        document.empty("material", &[("name", &material.name), ("rgba", &rgba)]);
    }
    document.close();
    document.open("worldbody", &[]);
    write_body(&mut document, robot, 0);
    document.close();
    write_contact(&mut document, robot);
    write_coupling(&mut document, robot);
    write_servos(&mut document, robot);
    write_home(&mut document, robot);
    document.finish()
}

/// Writes how contacts are solved, and memory for it: with MuJoCo's defaults, what is gripped creeps.
pub(super) fn write_option(document: &mut XmlDocument) {
    document.empty(
        "option",
        &[
            ("timestep", &spaced(&[contact::TIMESTEP_S])),
            ("integrator", "implicitfast"),
            ("cone", "elliptic"),
            ("impratio", &spaced(&[contact::IMPRATIO])),
            ("noslip_iterations", &contact::NOSLIP_ITERATIONS.to_string()),
        ],
    );
    // The iterations against slip need the square of the number of contact forces: with 225 contacts MuJoCo's own
    // 16 MB are not enough, and it ends the simulation.
    document.empty("size", &[("memory", "256M")]);
}

/// Friction is sliding, torsional and rolling; pads resist turning too.
fn write_defaults(document: &mut XmlDocument, robot: &Robot) {
    let friction =
        |sliding: f64| spaced(&[sliding, contact::TORSIONAL_FRICTION_M, contact::ROLLING_FRICTION_M]);
    let housing = friction(contact::HOUSING_FRICTION);
    let pad = friction(robot.gripper().pad_friction);
    let (solref, solimp) = (spaced(&contact::PAD_SOLREF), spaced(&contact::PAD_SOLIMP));
    let solmix = spaced(&[contact::PAD_SOLMIX]);
    document.open("default", &[]);
    for (class, attributes) in [
        ("visual", vec![("group", "2"), ("contype", "0"), ("conaffinity", "0")]),
        ("housing", vec![("group", "2"), ("friction", housing.as_str())]),
        ("collision", vec![("group", "3"), ("friction", housing.as_str())]),
        (
            "pad",
            vec![
                ("group", "2"),
                ("friction", pad.as_str()),
                ("condim", "4"),
                ("solref", solref.as_str()),
                ("solimp", solimp.as_str()),
                ("solmix", solmix.as_str()),
            ],
        ),
    ] {
        document.open("default", &[("class", class)]);
        document.empty("geom", &attributes);
        document.close();
    }
    document.close();
}

fn write_body(document: &mut XmlDocument, robot: &Robot, index: usize) {
    let link = &robot.links()[index];
    let pose = link.joint.as_ref().map_or_else(Isometry3::identity, |joint| joint.parent_from_joint);
    document.open(
        "body",
        &[
            ("name", &link.name),
            ("pos", &spaced(&xyz(&pose))),
            ("quat", &spaced(&wxyz(&pose.rotation))),
            ("gravcomp", "1"),
        ],
    );
    if let Some((joint, moving)) = link.joint.as_ref().and_then(|joint| Some((joint, joint.moving()?))) {
        write_joint(document, joint, moving);
    }
    write_inertia(document, link);
    for shape in &link.shapes {
        write_geom(document, robot, shape);
    }
    if robot.tool().link == index {
        let tool = robot.tool();
        let (position, turn) =
            (spaced(&xyz(&tool.link_from_tool)), spaced(&wxyz(&tool.link_from_tool.rotation)));
        document
            .empty("site", &[("name", &tool.name), ("pos", &position), ("quat", &turn), ("size", "0.005")]);
    }
    for (child, link) in robot.links().iter().enumerate() {
        if link.joint.as_ref().is_some_and(|joint| joint.parent == index) {
            write_body(document, robot, child);
        }
    }
    document.close();
}

fn write_joint(document: &mut XmlDocument, joint: &Joint, moving: &MovingJoint) {
    let kind = match moving.kind {
        MovingKind::Revolute => "hinge",
        MovingKind::Prismatic => "slide",
    };
    let drive = &moving.drive;
    document.empty(
        "joint",
        &[
            ("name", &joint.name),
            ("type", kind),
            ("axis", &spaced(moving.axis.as_slice())),
            ("range", &spaced(&[moving.limits.min_position, moving.limits.max_position])),
            ("damping", &spaced(&[drive.joint_damping])),
            ("frictionloss", &spaced(&[drive.joint_friction])),
            ("armature", &spaced(&[drive.armature])),
        ],
    );
}

fn write_inertia(document: &mut XmlDocument, link: &Link) {
    let Some(inertia) = &link.inertia else { return };
    let moment = |row: usize, column: usize| inertia.tensor_kg_m2[(row, column)];
    let full = [moment(0, 0), moment(1, 1), moment(2, 2), moment(0, 1), moment(0, 2), moment(1, 2)];
    document.empty(
        "inertial",
        &[
            ("pos", &spaced(inertia.center_m.as_slice())),
            ("mass", &spaced(&[inertia.mass_kg])),
            ("fullinertia", &spaced(&full)),
        ],
    );
}

fn write_geom(document: &mut XmlDocument, robot: &Robot, shape: &Shape) {
    let class = match shape.role {
        ShapeRole::Visual => "visual",
        _ if shape.is_pad => "pad",
        ShapeRole::Collision => "collision",
        ShapeRole::Both => "housing",
    };
    let (kind, size) = match shape.primitive {
        Primitive::Box { half_size_m } => ("box", spaced(half_size_m.as_slice())),
        Primitive::Cylinder { radius_m, half_length_m } => ("cylinder", spaced(&[radius_m, half_length_m])),
        Primitive::Capsule { radius_m, half_length_m } => ("capsule", spaced(&[radius_m, half_length_m])),
        Primitive::Sphere { radius_m } => ("sphere", spaced(&[radius_m])),
    };
    document.empty(
        "geom",
        &[
            ("class", class),
            ("type", kind),
            ("size", &size),
            ("pos", &spaced(&xyz(&shape.link_from_shape))),
            ("quat", &spaced(&wxyz(&shape.link_from_shape.rotation))),
            ("material", &robot.materials()[shape.material].name),
        ],
    );
}

fn write_contact(document: &mut XmlDocument, robot: &Robot) {
    document.open("contact", &[]);
    for (a, b) in excluded_pairs(robot) {
        let [a, b] = [a, b].map(|index| robot.links()[index].name.as_str());
        document.empty("exclude", &[("body1", a), ("body2", b)]);
    }
    document.close();
}

/// Couples the fingers twice: a tendon shares the force of the one servo equally, and an equality, which then carries
/// no load in a centered grip, keeps the fingers level.
fn write_coupling(document: &mut XmlDocument, robot: &Robot) {
    let Some(master) = robot.links()[robot.gripper().link].joint.as_ref() else { return };
    let followers = mimics(robot);
    document.open("tendon", &[]);
    document.open("fixed", &[("name", &master.name)]);
    let share = 1.0 / (1 + followers.len()) as f64;
    document.empty("joint", &[("joint", &master.name), ("coef", &spaced(&[share]))]);
    for (joint, multiplier, _) in &followers {
        document.empty("joint", &[("joint", joint), ("coef", &spaced(&[share / multiplier]))]);
    }
    document.close();
    document.close();
    document.open("equality", &[]);
    for (joint, multiplier, offset) in followers {
        document.empty(
            "joint",
            &[
                ("joint1", joint),
                ("joint2", &master.name),
                ("polycoef", &spaced(&[offset, multiplier, 0.0, 0.0, 0.0])),
                ("solref", &spaced(&contact::MIMIC_SOLREF)),
            ],
        );
    }
    document.close();
}

/// The joints that follow the gripper's joint: name, multiplier and offset.
fn mimics(robot: &Robot) -> Vec<(&str, f64, f64)> {
    let links = robot.links().iter().enumerate();
    links
        .filter(|(index, _)| *index != robot.gripper().link)
        .filter_map(|(_, link)| {
            let joint = link.joint.as_ref()?;
            match joint.moving()?.source {
                PositionSource::Gripper { multiplier, offset } => {
                    Some((joint.name.as_str(), multiplier, offset))
                }
                PositionSource::Arm(_) => None,
            }
        })
        .collect()
}

fn write_servos(document: &mut XmlDocument, robot: &Robot) {
    document.open("actuator", &[]);
    for link in robot.links() {
        let Some((joint, moving)) = link.joint.as_ref().and_then(|joint| Some((joint, joint.moving()?)))
        else {
            continue;
        };
        let limits = &moving.limits;
        let (transmission, force, lead) = match moving.source {
            PositionSource::Arm(_) => ("joint", limits.max_effort, 0.0),
            PositionSource::Gripper { .. } if robot.links()[robot.gripper().link].name == link.name => {
                // As far as the target is ahead of the fingers, so strong is the grip; the strongest is within reach.
                let force_n = robot.gripper().max_force_n;
                // The joint stops at closed, its target does not: thin objects are pressed as hard as wide ones.
                ("tendon", force_n * robot.fingers().count() as f64, robot.gripper_lead(force_n))
            }
            PositionSource::Gripper { .. } => continue,
        };
        document.empty(
            "position",
            &[
                ("name", &joint.name),
                (transmission, &joint.name),
                ("kp", &spaced(&[moving.drive.stiffness])),
                ("kv", &spaced(&[moving.drive.damping])),
                ("ctrlrange", &spaced(&[limits.min_position - lead, limits.max_position])),
                ("forcerange", &spaced(&[-force, force])),
            ],
        );
    }
    document.close();
}

/// Writes the home pose. `qpos` is in the order of bodies, depth first; `ctrl` in that of the servos above.
fn write_home(document: &mut XmlDocument, robot: &Robot) {
    let home = robot.home();
    let mut order = Vec::new();
    depth_first(robot, 0, &mut order);
    let position = |joint: &MovingJoint| robot.joint_position(joint, &home.positions, home.opening_m);
    let moving = |index: &usize| robot.links()[*index].joint.as_ref()?.moving();
    let positions: Vec<f64> = order.iter().filter_map(moving).map(position).collect();
    let follows = |joint: &MovingJoint, link: usize| {
        matches!(joint.source, PositionSource::Gripper { .. }) && link != robot.gripper().link
    };
    let servos = (0..robot.links().len()).filter_map(|index| Some((index, moving(&index)?)));
    let targets: Vec<f64> =
        servos.filter(|(index, joint)| !follows(joint, *index)).map(|(_, joint)| position(joint)).collect();
    document.open("keyframe", &[]);
    document.empty("key", &[("name", "home"), ("qpos", &spaced(&positions)), ("ctrl", &spaced(&targets))]);
    document.close();
}

fn depth_first(robot: &Robot, index: usize, order: &mut Vec<usize>) {
    order.push(index);
    for (child, link) in robot.links().iter().enumerate() {
        if link.joint.as_ref().is_some_and(|joint| joint.parent == index) {
            depth_first(robot, child, order);
        }
    }
}
