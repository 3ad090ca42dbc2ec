//! URDF: one file without meshes.
//!
//! A capsule is a cylinder and two spheres, since the format has no capsule. Position limits, velocity and effort are
//! stated; acceleration, jerk and servos have no place. The tool frame is a link of a milligram.

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};

use super::model_name;
use super::numbers::{rpy, spaced, xyz};
use crate::model::{Inertia, Joint, Link, MovingJoint, MovingKind, PositionSource, Primitive, Robot, Shape};
use markup::xml::XmlDocument;

/// Writes the robot as URDF. The root link is the base; a loader fixes it where it wants.
pub fn write_urdf(robot: &Robot) -> String {
    let mut document = XmlDocument::new();
    document.comment(&robot.sources().join("; "));
    document.open("robot", &[("name", &model_name(robot))]);
    write_elements(&mut document, robot);
    document.finish()
}

/// Writes materials, links and joints into the element of a robot.
pub(super) fn write_elements(document: &mut XmlDocument, robot: &Robot) {
    for material in robot.materials() {
        document.open("material", &[("name", &material.name)]);
        let [red, green, blue] = material.srgb;
        document.empty("color", &[("rgba", &spaced(&[red, green, blue, 1.0]))]);
        document.close();
    }
    for link in robot.links() {
        write_link(document, robot, link);
        if let Some(joint) = &link.joint {
            write_joint(document, robot, link, joint);
        }
    }
    let tool = robot.tool();
    write_frame(document, &tool.name);
    document.open("joint", &[("name", &format!("{}_joint", tool.name)), ("type", "fixed")]);
    document.empty("parent", &[("link", &robot.links()[tool.link].name)]);
    document.empty("child", &[("link", &tool.name)]);
    write_origin(document, &tool.link_from_tool);
    document.close();
}

fn write_link(document: &mut XmlDocument, robot: &Robot, link: &Link) {
    document.open("link", &[("name", &link.name)]);
    if link.shapes.iter().any(|shape| shape.is_pad) {
        document.open("contact", &[]);
        document.empty("lateral_friction", &[("value", &spaced(&[robot.gripper().pad_friction]))]);
        document.close();
    }
    if let Some(inertia) = &link.inertia {
        write_inertia(document, inertia);
    }
    for shape in &link.shapes {
        for (primitive, pose) in without_capsules(shape) {
            if shape.is_visible() {
                document.open("visual", &[]);
                write_geometry(document, &primitive, &pose);
                document.empty("material", &[("name", &robot.materials()[shape.material].name)]);
                document.close();
            }
            if shape.collides() {
                document.open("collision", &[]);
                write_geometry(document, &primitive, &pose);
                document.close();
            }
        }
    }
    document.close();
}

/// A link without a body. PyBullet gives links without inertia a kilogram, so that it states next to nothing.
fn write_frame(document: &mut XmlDocument, name: &str) {
    document.open("link", &[("name", name)]);
    let tensor_kg_m2 = Matrix3::identity() * 1e-9;
    write_inertia(document, &Inertia { mass_kg: 1e-6, center_m: Vector3::zeros(), tensor_kg_m2 });
    document.close();
}

fn write_inertia(document: &mut XmlDocument, inertia: &Inertia) {
    document.open("inertial", &[]);
    let center = spaced(inertia.center_m.as_slice());
    document.empty("origin", &[("xyz", &center), ("rpy", "0 0 0")]);
    document.empty("mass", &[("value", &spaced(&[inertia.mass_kg]))]);
    let moment = |row: usize, column: usize| spaced(&[inertia.tensor_kg_m2[(row, column)]]);
    document.empty(
        "inertia",
        &[
            ("ixx", &moment(0, 0)),
            ("ixy", &moment(0, 1)),
            ("ixz", &moment(0, 2)),
            ("iyy", &moment(1, 1)),
            ("iyz", &moment(1, 2)),
            ("izz", &moment(2, 2)),
        ],
    );
    document.close();
}

/// The shape itself, or a tube and two balls that together are the capsule.
fn without_capsules(shape: &Shape) -> Vec<(Primitive, Isometry3<f64>)> {
    let Primitive::Capsule { radius_m, half_length_m } = shape.primitive else {
        return vec![(shape.primitive, shape.link_from_shape)];
    };
    let end = |z: f64| shape.link_from_shape * Translation3::new(0.0, 0.0, z);
    vec![
        (Primitive::Cylinder { radius_m, half_length_m }, shape.link_from_shape),
        (Primitive::Sphere { radius_m }, end(half_length_m)),
        (Primitive::Sphere { radius_m }, end(-half_length_m)),
    ]
}

fn write_geometry(document: &mut XmlDocument, primitive: &Primitive, pose: &Isometry3<f64>) {
    write_origin(document, pose);
    document.open("geometry", &[]);
    match *primitive {
        Primitive::Box { half_size_m } => {
            document.empty("box", &[("size", &spaced((half_size_m * 2.0).as_slice()))]);
        }
        Primitive::Cylinder { radius_m, half_length_m } | Primitive::Capsule { radius_m, half_length_m } => {
            let (radius, length) = (spaced(&[radius_m]), spaced(&[2.0 * half_length_m]));
            document.empty("cylinder", &[("radius", &radius), ("length", &length)]);
        }
        Primitive::Sphere { radius_m } => document.empty("sphere", &[("radius", &spaced(&[radius_m]))]),
    }
    document.close();
}

fn write_origin(document: &mut XmlDocument, pose: &Isometry3<f64>) {
    document.empty("origin", &[("xyz", &spaced(&xyz(pose))), ("rpy", &spaced(&rpy(pose)))]);
}

fn write_joint(document: &mut XmlDocument, robot: &Robot, link: &Link, joint: &Joint) {
    let kind = joint.moving().map_or("fixed", |moving| match moving.kind {
        MovingKind::Revolute => "revolute",
        MovingKind::Prismatic => "prismatic",
    });
    document.open("joint", &[("name", &joint.name), ("type", kind)]);
    document.empty("parent", &[("link", &robot.links()[joint.parent].name)]);
    document.empty("child", &[("link", &link.name)]);
    write_origin(document, &joint.parent_from_joint);
    if let Some(moving) = joint.moving() {
        write_motion(document, robot, joint, moving);
    }
    document.close();
}

fn write_motion(document: &mut XmlDocument, robot: &Robot, joint: &Joint, moving: &MovingJoint) {
    document.empty("axis", &[("xyz", &spaced(moving.axis.as_slice()))]);
    let limits = &moving.limits;
    let [lower, upper] = [limits.min_position, limits.max_position].map(|value| spaced(&[value]));
    let [effort, velocity] = [limits.max_effort, limits.max_velocity].map(|value| spaced(&[value]));
    document.empty(
        "limit",
        &[("lower", &lower), ("upper", &upper), ("effort", &effort), ("velocity", &velocity)],
    );
    let [damping, friction] =
        [moving.drive.joint_damping, moving.drive.joint_friction].map(|value| spaced(&[value]));
    document.empty("dynamics", &[("damping", &damping), ("friction", &friction)]);
    let master = robot.links()[robot.gripper().link].joint.as_ref();
    if let (PositionSource::Gripper { multiplier, offset }, Some(master)) = (moving.source, master)
        && master.name != joint.name
    {
        let [multiplier, offset] = [multiplier, offset].map(|value| spaced(&[value]));
        document.empty("mimic", &[("joint", &master.name), ("multiplier", &multiplier), ("offset", &offset)]);
    }
}
