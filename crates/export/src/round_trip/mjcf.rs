//! Reads `mjcf/scene.xml` and compares each movable body with the file of its own.

use std::collections::BTreeMap;

use glam::DVec3;

use geometry::Pose;
use roxmltree::Node;

use super::xml_node::{self, XmlNode};
use super::{Files, ReadBody, ReadContact, ReadResult, ReadScene, points, quaternion_wxyz, tensor, vector};

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    let document = xml_node::parse(files.text("mjcf/scene.xml")?)?;
    let root = document.root_element();
    let corners = read_meshes(files, root.child("asset")?, "")?;
    let mut scene = ReadScene::new();
    for body in root.child("worldbody")?.all("body") {
        let name = body.required("name")?;
        let pose = Pose {
            translation_m: vector(body.required("pos")?)?,
            rotation: quaternion_wxyz(body.required("quat")?)?,
        };
        let read = read_body(body, &corners, pose, body.child("freejoint").is_ok())?;
        if read.movable == Some(true) {
            let own = read_object(files, name, pose)?;
            let same = own.hulls == read.hulls
                && own.mass_kg == read.mass_kg
                && own.center_of_mass_m == read.center_of_mass_m
                && own.inertia_tensor_kg_m2 == read.inertia_tensor_kg_m2
                && own.contact == read.contact;
            if !same {
                return Err(format!("the scene's {name} is not the one of its own file"));
            }
        }
        scene.insert(name.to_owned(), read);
    }
    Ok(scene)
}

/// The object of a file of its own, at the pose it has in the scene. Its sites must span its height.
fn read_object(files: &Files<'_>, name: &str, world_from_object: Pose) -> ReadResult<ReadBody> {
    let document = xml_node::parse(files.text(&format!("mjcf/{name}/{name}.xml"))?)?;
    let root = document.root_element();
    let corners = read_meshes(files, root.child("asset")?, "../assets/")?;
    let outer = root.child("worldbody")?.child("body")?;
    let site = |wanted: &str| -> ReadResult<DVec3> {
        let found = outer.all("site").find(|site| site.attribute("name") == Some(wanted));
        vector(found.ok_or_else(|| format!("{name} has no {wanted}"))?.required("pos")?)
    };
    let (bottom, top, radius) = (site("bottom_site")?, site("top_site")?, site("horizontal_radius_site")?);
    if bottom.z >= top.z || radius.x <= 0.0 {
        return Err(format!("the sites of {name} enclose nothing"));
    }
    read_body(outer.child("body")?, &corners, world_from_object, true)
}

/// Corners of the inline meshes by name; the others must be files below `folder` of the document.
fn read_meshes<'a>(
    files: &Files<'_>,
    assets: Node<'a, '_>,
    folder: &str,
) -> ReadResult<BTreeMap<&'a str, Vec<DVec3>>> {
    let mut corners = BTreeMap::new();
    for mesh in assets.all("mesh") {
        match mesh.attribute("vertex") {
            Some(vertex) => {
                corners.insert(mesh.required("name")?, points(vertex)?);
            }
            None => {
                let file = mesh.required("file")?;
                let file = file.strip_prefix(folder).ok_or_else(|| format!("{file} is elsewhere"))?;
                files.bytes(&format!("mjcf/assets/{file}"))?;
            }
        }
    }
    Ok(corners)
}

fn read_body(
    body: Node<'_, '_>,
    corners: &BTreeMap<&str, Vec<DVec3>>,
    world_from_object: Pose,
    movable: bool,
) -> ReadResult<ReadBody> {
    let inertial = body.child("inertial")?;
    let axes = quaternion_wxyz(inertial.required("quat")?)?;
    let (mut hulls, mut friction) = (Vec::new(), DVec3::NAN);
    for geom in body.all("geom").filter(|geom| geom.attribute("contype") != Some("0")) {
        let mesh = geom.required("mesh")?;
        hulls.push(corners.get(mesh).cloned().ok_or_else(|| format!("the mesh {mesh} is missing"))?);
        let geom_friction = vector(geom.required("friction")?)?;
        if hulls.len() > 1 && geom_friction != friction {
            return Err(format!("the hulls of {} rub differently", body.required("name")?));
        }
        friction = geom_friction;
    }
    Ok(ReadBody {
        mass_kg: inertial.number("mass")?,
        center_of_mass_m: vector(inertial.required("pos")?)?,
        inertia_tensor_kg_m2: tensor(vector(inertial.required("diaginertia")?)?, axes),
        contact: ReadContact {
            dynamic_friction: friction.x,
            static_friction: None,
            restitution: None,
            torsional_friction_m: Some(friction.y),
            rolling_friction_m: Some(friction.z),
        },
        world_from_object,
        movable: Some(movable),
        hulls,
        visual: None,
        labels: None,
    })
}
