//! `urdf/`: one robot description per body, and the whole scene as one fixed assembly.
//!
//! Meshes are in meters, scale 1, with paths relative to the description or, on request, to a ROS 2 package. Inertia is
//! the solid's full tensor about its center of mass. Every hull is a `<collision>` of its own: a mesh, or the box,
//! cylinder or sphere that it stands for (URDF has no capsule). Friction is in `<contact>` (PyBullet) and `<gazebo>`
//! tags; both hold the dynamic coefficient.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use geometry::{Pose, SimpleSolid, SimpleSolidKind};
use markup::xml::XmlDocument;
use scene::Scene;

use super::number::spaced;
use super::wavefront::{Wavefront, hull_file, visual_file};
use super::{Body, BundleFile, ExportSettings, UrdfPaths, ros_package};

/// Namespace of the elements and attributes that hold a user's label and the mark of a stand-in where the format has no
/// place for them. Loaders ignore them.
pub const LABEL_NAMESPACE: &str = "https://tabletopgen.invalid/label/1";

/// All files under `urdf/`.
pub fn write(
    scene: &Scene,
    bodies: &[Body],
    wavefronts: &[Wavefront],
    settings: &ExportSettings,
) -> Vec<BundleFile> {
    let package =
        (settings.urdf == UrdfPaths::Ros2).then(|| format!("package://{}/", ros_package::name(scene)));
    let both = bodies.par_iter().zip(wavefronts);
    let mut files: Vec<BundleFile> =
        both.flat_map_iter(|(body, obj)| body_files(body, obj, package.as_deref())).collect();
    let assembly = assembly(bodies, package.as_deref().unwrap_or_default());
    files.push(BundleFile::text("urdf/scene.urdf", assembly, "urdf_scene", "application/xml"));
    if package.is_some() {
        files.extend(ros_package::files(scene, bodies, settings));
    }
    files
}

fn body_files(body: &Body, wavefront: &Wavefront, package: Option<&str>) -> Vec<BundleFile> {
    let folder = format!("urdf/{}", body.name);
    let mut document = XmlDocument::new();
    open_robot(&mut document, &body.name);
    write_label(&mut document, body);
    let meshes = package.map_or_else(String::new, |package| format!("{package}{}/", body.name));
    write_link(&mut document, body, "", &meshes);
    write_gazebo(&mut document, body);
    let path = format!("{folder}/{}.urdf", body.name);
    let mut files = vec![BundleFile::text(path, document.finish(), "urdf", "application/xml")];
    let meshes = (0..body.hulls.len()).filter(|&k| solid_of(body, k).is_none());
    files.extend(wavefront.files(body, &folder, "urdf", meshes));
    files
}

/// The solid that a hull stands for, where URDF knows it.
fn solid_of(body: &Body, hull: usize) -> Option<&SimpleSolid> {
    body.solids[hull].as_ref().filter(|solid| !matches!(solid.kind, SimpleSolidKind::Capsule { .. }))
}

fn open_robot(document: &mut XmlDocument, name: &str) {
    document.open("robot", &[("name", name), ("xmlns:tabletopgen", LABEL_NAMESPACE)]);
}

fn write_label(document: &mut XmlDocument, body: &Body) {
    let mut attributes = vec![("link", body.name.as_str()), ("text", &body.label)];
    attributes.extend(body.marks());
    document.empty("tabletopgen:label", &attributes);
}

/// A link named as the body. Names of shapes start with `named`, as no name of an assembly repeats; meshes lie in
/// `folder`.
fn write_link(document: &mut XmlDocument, body: &Body, named: &str, folder: &str) {
    document.open("link", &[("name", &body.name)]);
    document.open("contact", &[]);
    for (name, value) in [
        ("lateral_friction", body.friction.dynamic_coefficient),
        ("rolling_friction", body.rolling_friction_m),
        ("spinning_friction", body.torsional_friction_m),
        ("restitution", body.restitution),
    ] {
        document.empty(name, &[("value", &spaced(&[value]))]);
    }
    document.close();
    let center = spaced(&body.mass.center_of_mass_m.to_array());
    document.open("inertial", &[]);
    document.empty("origin", &[("xyz", &center), ("rpy", "0 0 0")]);
    document.empty("mass", &[("value", &spaced(&[body.mass.mass_kg]))]);
    let tensor = body.inertia_tensor_kg_m2();
    let moment =
        |row: usize, column: usize| spaced(&[0.5 * (tensor.col(column)[row] + tensor.col(row)[column])]);
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
    for k in 0..body.visual.groups.len() {
        let (name, file) = (format!("{named}visual_{k:02}"), format!("{folder}{}", visual_file(k)));
        write_mesh(document, "visual", &name, &file);
    }
    for k in 0..body.hulls.len() {
        let name = format!("{named}hull_{k:02}");
        match solid_of(body, k) {
            Some(solid) => write_solid(document, &name, solid),
            None => write_mesh(document, "collision", &name, &format!("{folder}{}", hull_file(k))),
        }
    }
    document.close();
}

fn write_mesh(document: &mut XmlDocument, element: &'static str, name: &str, file: &str) {
    document.open(element, &[("name", name)]);
    document.empty("origin", &[("xyz", "0 0 0"), ("rpy", "0 0 0")]);
    document.open("geometry", &[]);
    document.empty("mesh", &[("filename", file), ("scale", "1 1 1")]);
    document.close();
    document.close();
}

fn write_solid(document: &mut XmlDocument, name: &str, solid: &SimpleSolid) {
    document.open("collision", &[("name", name)]);
    let (xyz, rpy) = origin(&solid.object_from_solid);
    document.empty("origin", &[("xyz", &spaced(&xyz.to_array())), ("rpy", &spaced(&rpy.to_array()))]);
    document.open("geometry", &[]);
    match solid.kind {
        SimpleSolidKind::Box { half_m } => {
            document.empty("box", &[("size", &spaced(&(2.0 * half_m).to_array()))]);
        }
        SimpleSolidKind::Cylinder { radius_m, half_length_m }
        | SimpleSolidKind::Capsule { radius_m, half_length_m } => {
            let (radius, length) = (spaced(&[radius_m]), spaced(&[2.0 * half_length_m]));
            document.empty("cylinder", &[("radius", &radius), ("length", &length)]);
        }
        SimpleSolidKind::Sphere { radius_m } => {
            document.empty("sphere", &[("radius", &spaced(&[radius_m]))]);
        }
    }
    document.close();
    document.close();
}

fn write_gazebo(document: &mut XmlDocument, body: &Body) {
    let value = spaced(&[body.friction.dynamic_coefficient]);
    document.open("gazebo", &[("reference", &body.name)]);
    document.text_element("mu1", &value);
    document.text_element("mu2", &value);
    document.close();
}

/// Every body fixed to the link `world` at its pose; the folders of meshes lie in `folder`.
fn assembly(bodies: &[Body], folder: &str) -> String {
    let mut document = XmlDocument::new();
    open_robot(&mut document, "scene");
    document.empty("link", &[("name", "world")]);
    for body in bodies {
        write_label(&mut document, body);
        write_link(&mut document, body, &format!("{}_", body.name), &format!("{folder}{}/", body.name));
        document.open("joint", &[("name", &format!("world_to_{}", body.name)), ("type", "fixed")]);
        document.empty("parent", &[("link", "world")]);
        document.empty("child", &[("link", &body.name)]);
        let (xyz, rpy) = origin(&body.world_from_object);
        document.empty("origin", &[("xyz", &spaced(&xyz.to_array())), ("rpy", &spaced(&rpy.to_array()))]);
        document.close();
        write_gazebo(&mut document, body);
    }
    document.finish()
}

/// Position and roll, pitch, yaw about the fixed x, y, z axes in that order, radians.
pub fn origin(pose: &Pose) -> (DVec3, DVec3) {
    let m = DMat3::from_quat(pose.rotation.normalize());
    let cosine = m.x_axis.x.hypot(m.x_axis.y);
    // The arc sine would lose half of the digits near 90 degrees.
    let pitch_rad = (-m.x_axis.z).atan2(cosine);
    let rpy = if cosine > 1e-8 {
        DVec3::new(m.y_axis.z.atan2(m.z_axis.z), pitch_rad, m.x_axis.y.atan2(m.x_axis.x))
    } else {
        // Gimbal lock at pitch +-90 degrees: only the difference of roll and yaw is determined.
        DVec3::new(0.0, pitch_rad, (-m.y_axis.x).atan2(m.y_axis.y))
    };
    (pose.translation_m, rpy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn roll_pitch_yaw_reproduce_the_rotation(x in -1.0..1.0_f64, y in -1.0..1.0_f64, z in -1.0..1.0_f64, w in 0.1..1.0_f64) {
            let rotation = DQuat::from_xyzw(x, y, z, w).normalize();
            let (_, rpy) = origin(&Pose { translation_m: DVec3::ZERO, rotation });
            let back = DQuat::from_rotation_z(rpy.z) * DQuat::from_rotation_y(rpy.y) * DQuat::from_rotation_x(rpy.x);
            prop_assert!(back.angle_between(rotation) < 1e-6);
        }
    }

    /// Regression: a bottle that lay on its side was read back turned by 20 microradians.
    #[test]
    fn roll_pitch_yaw_are_exact_near_gimbal_lock() {
        for off_rad in [0.0, 1e-12, 1e-9, 1e-8, 1e-7, 1e-5, 1e-3] {
            let pitch_rad = std::f64::consts::FRAC_PI_2 - off_rad;
            for (yaw_rad, roll_rad) in [(0.4, 0.0), (-1.2, 0.7), (2.9, -2.0)] {
                let rotation = DQuat::from_rotation_z(yaw_rad)
                    * DQuat::from_rotation_y(pitch_rad)
                    * DQuat::from_rotation_x(roll_rad);
                let (_, rpy) = origin(&Pose { translation_m: DVec3::ZERO, rotation });
                let back = DQuat::from_rotation_z(rpy.z)
                    * DQuat::from_rotation_y(rpy.y)
                    * DQuat::from_rotation_x(rpy.x);
                let turned_rad = 2.0 * (back.conjugate() * rotation).xyz().length();
                assert!(turned_rad < 1e-7, "{off_rad} {yaw_rad} {roll_rad}: {turned_rad}");
            }
        }
    }

    #[test]
    fn roll_pitch_yaw_handle_gimbal_lock() {
        for sign in [-1.0, 1.0] {
            let rotation =
                DQuat::from_rotation_z(0.4) * DQuat::from_rotation_y(sign * std::f64::consts::FRAC_PI_2);
            let (_, rpy) = origin(&Pose { translation_m: DVec3::ZERO, rotation });
            let back =
                DQuat::from_rotation_z(rpy.z) * DQuat::from_rotation_y(rpy.y) * DQuat::from_rotation_x(rpy.x);
            assert!(back.angle_between(rotation) < 1e-4);
        }
    }
}
