//! Reads `urdf/scene.urdf` for poses and `urdf/<name>/<name>.urdf` for bodies; with `urdf/package.xml`, paths are in
//! that package.

use glam::{DMat3, DQuat, DVec3};

use geometry::{Pose, SimpleSolid, SimpleSolidKind};
use roxmltree::Node;

use super::xml_node::{self, XmlNode};
use super::{Files, ReadBody, ReadContact, ReadError, ReadHull, ReadResult, ReadScene, obj_hull, vector};

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    let package = package(files)?;
    let document = xml_node::parse(files.text("urdf/scene.urdf")?)?;
    let assembly = document.root_element();
    let mut scene = ReadScene::new();
    for joint in assembly.all("joint") {
        let name = joint.child("child")?.required("link")?;
        let world_from_object = read_origin(joint)?;
        let document = xml_node::parse(files.text(&format!("urdf/{name}/{name}.urdf"))?)?;
        let robot = document.root_element();
        let body = read_link(
            files,
            robot.child("link")?,
            &format!("urdf/{name}"),
            package.as_deref(),
            world_from_object,
        )?;
        // Gazebo reads friction from its own elements.
        let gazebo = robot.child("gazebo")?;
        for direction in ["mu1", "mu2"] {
            if gazebo.child(direction)?.text_number()? != body.contact.dynamic_friction {
                return Err(ReadError::wrong(name, "rubs otherwise in Gazebo"));
            }
        }
        let placed = assembly.all("link").find(|link| link.attribute("name") == Some(name));
        let placed = placed.ok_or_else(|| ReadError::lacks("the assembly", format!("link {name}")))?;
        let assembled = read_link(files, placed, "urdf", package.as_deref(), world_from_object)?;
        let same = assembled.hulls == body.hulls
            && assembled.mass_kg == body.mass_kg
            && assembled.center_of_mass_m == body.center_of_mass_m
            && assembled.inertia_tensor_kg_m2 == body.inertia_tensor_kg_m2
            && assembled.contact == body.contact;
        if !same {
            let name = name.to_owned();
            return Err(ReadError::OtherThanOwn { whole: "assembly", name, own: "file" });
        }
        scene.insert(name.to_owned(), body);
    }
    Ok(scene)
}

/// Prefix of paths in the ROS 2 package that the folder is; `None` where it is no package.
pub(super) fn package(files: &Files<'_>) -> ReadResult<Option<String>> {
    let Ok(text) = files.text("urdf/package.xml") else { return Ok(None) };
    Ok(Some(format!("package://{}/", xml_node::parse(text)?.root_element().child("name")?.content())))
}

/// The file of a mesh that a description in `folder` names.
pub(super) fn mesh_file(file: &str, folder: &str, package: Option<&str>) -> ReadResult<String> {
    match package {
        Some(package) => file
            .strip_prefix(package)
            .map(|below| format!("urdf/{below}"))
            .ok_or_else(|| ReadError::OutsidePackage { file: file.to_owned(), package: package.to_owned() }),
        None => Ok(format!("{folder}/{file}")),
    }
}

/// The pose of an element's origin: position, and roll, pitch, yaw about the fixed axes.
fn read_origin(element: Node<'_, '_>) -> ReadResult<Pose> {
    let origin = element.child("origin")?;
    let rpy = vector(origin.required("rpy")?)?;
    Ok(Pose {
        translation_m: vector(origin.required("xyz")?)?,
        rotation: DQuat::from_rotation_z(rpy.z)
            * DQuat::from_rotation_y(rpy.y)
            * DQuat::from_rotation_x(rpy.x),
    })
}

/// The box, cylinder or sphere of a collision; `None` where it is a mesh.
fn read_solid(collision: Node<'_, '_>) -> ReadResult<Option<SimpleSolid>> {
    let geometry = collision.child("geometry")?;
    let kind = if let Ok(shape) = geometry.child("box") {
        SimpleSolidKind::Box { half_m: 0.5 * vector(shape.required("size")?)? }
    } else if let Ok(shape) = geometry.child("cylinder") {
        let (radius_m, half_length_m) = (shape.number("radius")?, 0.5 * shape.number("length")?);
        SimpleSolidKind::Cylinder { radius_m, half_length_m }
    } else if let Ok(shape) = geometry.child("sphere") {
        SimpleSolidKind::Sphere { radius_m: shape.number("radius")? }
    } else {
        return Ok(None);
    };
    Ok(Some(SimpleSolid { kind, object_from_solid: read_origin(collision)? }))
}

fn read_link(
    files: &Files<'_>,
    link: Node<'_, '_>,
    folder: &str,
    package: Option<&str>,
    world_from_object: Pose,
) -> ReadResult<ReadBody> {
    let inertial = link.child("inertial")?;
    let origin = inertial.child("origin")?;
    if vector(origin.required("rpy")?)? != DVec3::ZERO {
        return Err(ReadError::wrong("inertia", "is not along the link's axes"));
    }
    let inertia = inertial.child("inertia")?;
    let [xx, xy, xz, yy, yz, zz] =
        ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| inertia.number(name));
    let (xx, xy, xz, yy, yz, zz) = (xx?, xy?, xz?, yy?, yz?, zz?);
    let mesh_path = |element: Node<'_, '_>| -> ReadResult<String> {
        let mesh = element.child("geometry")?.child("mesh")?;
        if vector(mesh.attribute("scale").unwrap_or("1 1 1"))? != DVec3::ONE {
            return Err(ReadError::wrong(format!("a mesh of {}", link.required("name")?), "is scaled"));
        }
        mesh_file(mesh.required("filename")?, folder, package)
    };
    for visual in link.all("visual") {
        files.bytes(&mesh_path(visual)?)?;
    }
    let contact = link.child("contact")?;
    let surface = |name: &str| contact.child(name)?.number("value");
    let shape = |collision: Node<'_, '_>| -> ReadResult<ReadHull> {
        match read_solid(collision)? {
            Some(solid) => Ok(ReadHull::Solid(solid)),
            None => obj_hull(files.text(&mesh_path(collision)?)?),
        }
    };
    let hulls: ReadResult<Vec<_>> = link.all("collision").map(shape).collect();
    Ok(ReadBody {
        mass_kg: inertial.child("mass")?.number("value")?,
        center_of_mass_m: vector(origin.required("xyz")?)?,
        inertia_tensor_kg_m2: DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
        contact: ReadContact {
            dynamic_friction: surface("lateral_friction")?,
            static_friction: None,
            restitution: Some(surface("restitution")?),
            rolling_friction_m: Some(surface("rolling_friction")?),
            torsional_friction_m: Some(surface("spinning_friction")?),
        },
        world_from_object,
        movable: None,
        hulls: hulls?,
        visual: None,
        labels: None,
    })
}
