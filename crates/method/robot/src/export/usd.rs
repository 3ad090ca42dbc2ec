//! USD, as text: an articulation with position drives.
//!
//! Links are siblings below the root, placed where they are at position zero of all joints; the base is fixed to the
//! world. Every joint moves along or about z of its frames. Lengths are meters; limits and stiffness of joints that
//! turn are in degrees, as the format wants. The format has no standard coupling of joints: each finger has its own
//! drive with its share of the servo's stiffness, and both take the same target, which may be below closed. Limits of
//! velocity and armature are in the schema of PhysX.

mod prims;

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use self::prims::{Layer, real};
use super::numbers::{tuple, wxyz, xyz};
use super::{contact, excluded_pairs, model_name};
use crate::kinematics::link_poses;
use crate::model::{
    Inertia, Joint, Link, MovingJoint, MovingKind, PositionSource, Primitive, Robot, Shape, ShapeRole,
};

/// Writes the robot as a USD layer, its base at the origin.
pub fn write_usd(robot: &Robot) -> String {
    let name = model_name(robot);
    let mut layer = Layer::new(&name, &robot.sources().join("; "));
    layer.open("Xform", &name, &["PhysicsArticulationRootAPI"]);
    write_materials(&mut layer, robot);
    let poses = link_poses(robot, &vec![0.0; robot.dof()], 0.0);
    for (index, pose) in poses.iter().enumerate() {
        write_link(&mut layer, robot, &name, index, pose);
    }
    layer.open("Scope", "joints", &[]);
    layer.open("PhysicsFixedJoint", "base_joint", &[]);
    layer.line(&format!("rel physics:body1 = </{name}/{}>", robot.links()[0].name));
    layer.close();
    for link in robot.links() {
        if let Some(joint) = &link.joint {
            write_joint(&mut layer, robot, &name, link, joint);
        }
    }
    layer.close();
    layer.close();
    layer.finish()
}

fn write_materials(layer: &mut Layer, robot: &Robot) {
    let name = model_name(robot);
    layer.open("Scope", "materials", &[]);
    for material in robot.materials() {
        layer.open("Material", &material.name, &[]);
        layer.line(&format!(
            "token outputs:surface.connect = </{name}/materials/{}/surface.outputs:surface>",
            material.name
        ));
        layer.open("Shader", "surface", &[]);
        layer.line("uniform token info:id = \"UsdPreviewSurface\"");
        layer.line(&format!("color3f inputs:diffuseColor = {}", tuple(&material.srgb.map(linear))));
        layer.line("float inputs:roughness = 0.5");
        layer.line("token outputs:surface");
        layer.close();
        layer.close();
    }
    for (material, friction) in
        [("pad_contact", robot.gripper().pad_friction), ("housing_contact", contact::HOUSING_FRICTION)]
    {
        layer.open("Material", material, &["PhysicsMaterialAPI"]);
        for kind in ["dynamic", "static"] {
            layer.line(&format!("float physics:{kind}Friction = {}", real(friction)));
        }
        layer.line("float physics:restitution = 0");
        layer.close();
    }
    layer.close();
}

/// A channel of sRGB as linear light.
fn linear(channel: f64) -> f64 {
    if channel <= 0.04045 { channel / 12.92 } else { ((channel + 0.055) / 1.055).powf(2.4) }
}

fn write_link(layer: &mut Layer, robot: &Robot, root: &str, index: usize, pose: &Isometry3<f64>) {
    let link = &robot.links()[index];
    let excluded: Vec<String> = excluded_pairs(robot)
        .into_iter()
        .filter(|(a, _)| *a == index)
        .map(|(_, b)| format!("</{root}/{}>", robot.links()[b].name))
        .collect();
    let mut schemas = vec!["PhysicsRigidBodyAPI"];
    schemas.extend(link.inertia.is_some().then_some("PhysicsMassAPI"));
    schemas.extend((!excluded.is_empty()).then_some("PhysicsFilteredPairsAPI"));
    layer.open("Xform", &link.name, &schemas);
    if !excluded.is_empty() {
        layer.line(&format!("rel physics:filteredPairs = [{}]", excluded.join(", ")));
    }
    if let Some(inertia) = &link.inertia {
        write_inertia(layer, inertia);
    }
    layer.pose(pose);
    for (k, shape) in link.shapes.iter().enumerate() {
        write_shape(layer, robot, root, k, shape);
    }
    let tool = robot.tool();
    if tool.link == index {
        layer.open("Xform", &tool.name, &[]);
        layer.pose(&tool.link_from_tool);
        layer.close();
    }
    layer.close();
}

fn write_inertia(layer: &mut Layer, inertia: &Inertia) {
    let eigen = inertia.tensor_kg_m2.symmetric_eigen();
    let mut axes: Matrix3<f64> = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes = -axes;
    }
    let axes = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    layer.line(&format!("float physics:mass = {}", real(inertia.mass_kg)));
    layer.line(&format!("point3f physics:centerOfMass = {}", tuple(inertia.center_m.as_slice())));
    layer.line(&format!("float3 physics:diagonalInertia = {}", tuple(eigen.eigenvalues.as_slice())));
    layer.line(&format!("quatf physics:principalAxes = {}", tuple(&wxyz(&axes))));
}

fn write_shape(layer: &mut Layer, robot: &Robot, root: &str, k: usize, shape: &Shape) {
    let prim = match shape.primitive {
        Primitive::Box { .. } => "Cube",
        Primitive::Cylinder { .. } => "Cylinder",
        Primitive::Capsule { .. } => "Capsule",
        Primitive::Sphere { .. } => "Sphere",
    };
    let mut schemas = vec!["MaterialBindingAPI"];
    schemas.extend(shape.collides().then_some("PhysicsCollisionAPI"));
    layer.open(prim, &format!("shape_{k}"), &schemas);
    let half = shape.primitive.half_extents_m();
    match shape.primitive {
        Primitive::Box { .. } => layer.line("double size = 2"),
        Primitive::Cylinder { radius_m, half_length_m } | Primitive::Capsule { radius_m, half_length_m } => {
            layer.line("uniform token axis = \"Z\"");
            layer.line(&format!("double height = {}", real(2.0 * half_length_m)));
            layer.line(&format!("double radius = {}", real(radius_m)));
        }
        Primitive::Sphere { radius_m } => layer.line(&format!("double radius = {}", real(radius_m))),
    }
    let is_box = matches!(shape.primitive, Primitive::Box { .. });
    let extent = if is_box { Vector3::repeat(1.0) } else { half };
    let [low, high] = [-extent, extent].map(|corner| tuple(corner.as_slice()));
    layer.line(&format!("float3[] extent = [{low}, {high}]"));
    if shape.role == ShapeRole::Collision {
        layer.line("uniform token purpose = \"guide\"");
    }
    let material = &robot.materials()[shape.material].name;
    layer.line(&format!("rel material:binding = </{root}/materials/{material}>"));
    if shape.collides() {
        let contact = if shape.is_pad { "pad_contact" } else { "housing_contact" };
        layer.line(&format!("rel material:binding:physics = </{root}/materials/{contact}>"));
    }
    layer.pose_and_scale(&shape.link_from_shape, is_box.then_some(half));
    layer.close();
}

fn write_joint(layer: &mut Layer, robot: &Robot, root: &str, link: &Link, joint: &Joint) {
    let (kind, schemas): (_, &[&str]) = match joint.moving().map(|moving| moving.kind) {
        None => ("PhysicsFixedJoint", &[]),
        Some(MovingKind::Revolute) => ("PhysicsRevoluteJoint", &["PhysicsDriveAPI:angular", "PhysxJointAPI"]),
        Some(MovingKind::Prismatic) => {
            ("PhysicsPrismaticJoint", &["PhysicsDriveAPI:linear", "PhysxJointAPI"])
        }
    };
    layer.open(kind, &joint.name, schemas);
    layer.line(&format!("rel physics:body0 = </{root}/{}>", robot.links()[joint.parent].name));
    layer.line(&format!("rel physics:body1 = </{root}/{}>", link.name));
    let link_from_turned = joint.moving().map_or_else(UnitQuaternion::identity, |moving| {
        let half_turn = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        UnitQuaternion::rotation_between(&Vector3::z(), &moving.axis).unwrap_or_else(half_turn)
    });
    let parent_rotation = joint.parent_from_joint.rotation * link_from_turned;
    layer.line(&format!("point3f physics:localPos0 = {}", tuple(&xyz(&joint.parent_from_joint))));
    layer.line(&format!("quatf physics:localRot0 = {}", tuple(&wxyz(&parent_rotation))));
    layer.line("point3f physics:localPos1 = (0, 0, 0)");
    layer.line(&format!("quatf physics:localRot1 = {}", tuple(&wxyz(&link_from_turned))));
    if let Some(moving) = joint.moving() {
        write_motion(layer, robot, moving);
    }
    layer.close();
}

/// Limits and drive; angles are in degrees, and torques per degree.
fn write_motion(layer: &mut Layer, robot: &Robot, moving: &MovingJoint) {
    let (name, unit) = match moving.kind {
        MovingKind::Revolute => ("angular", 1f64.to_degrees()),
        MovingKind::Prismatic => ("linear", 1.0),
    };
    let (force, share) = match moving.source {
        PositionSource::Arm(_) => (moving.limits.max_effort, 1.0),
        PositionSource::Gripper { .. } => (robot.gripper().max_force_n, 1.0 / robot.fingers().count() as f64),
    };
    let home = robot.home();
    let target = robot.joint_position(moving, &home.positions, home.opening_m);
    layer.line("uniform token physics:axis = \"Z\"");
    for (key, value) in [
        ("physics:lowerLimit", moving.limits.min_position * unit),
        ("physics:upperLimit", moving.limits.max_position * unit),
        ("physxJoint:maxJointVelocity", moving.limits.max_velocity * unit),
        ("physxJoint:armature", moving.drive.armature),
        ("physxJoint:jointFriction", moving.drive.joint_friction),
    ] {
        layer.line(&format!("float {key} = {}", real(value)));
    }
    layer.line(&format!("uniform token drive:{name}:physics:type = \"force\""));
    for (key, value) in [
        ("stiffness", share * moving.drive.stiffness / unit),
        ("damping", share * moving.drive.damping / unit),
        ("maxForce", force),
        ("targetPosition", target * unit),
    ] {
        layer.line(&format!("float drive:{name}:physics:{key} = {}", real(value)));
    }
}
