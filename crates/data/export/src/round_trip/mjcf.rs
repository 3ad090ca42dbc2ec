//! Reads `mjcf/scene.xml` and compares each movable body with the file of its own.

use std::collections::BTreeMap;

use glam::DVec3;

use geometry::{Pose, SimpleSolid, SimpleSolidKind};
use roxmltree::Node;

use super::xml_node::{self, XmlNode};
use super::{
    Files, ReadBody, ReadContact, ReadError, ReadHull, ReadResult, ReadScene, numbers, obj_hull,
    quaternion_wxyz, tensor, vector,
};

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    let document = xml_node::parse(files.text("mjcf/scene.xml")?)?;
    let root = document.root_element();
    let meshes = read_meshes(files, root.child("asset")?, "")?;
    // MuJoCo takes no shorter time constants than two steps.
    let stiffest_s = 2.0 * root.child("option")?.number("timestep")?;
    let mut scene = ReadScene::new();
    for body in root.child("worldbody")?.all("body") {
        let name = body.required("name")?;
        let pose = Pose {
            translation_m: vector(body.required("pos")?)?,
            rotation: quaternion_wxyz(body.required("quat")?)?,
        };
        let read = read_body(body, &meshes, pose, body.child("freejoint").is_ok(), stiffest_s)?;
        if read.movable == Some(true) {
            let own = read_object(files, name, pose, stiffest_s)?;
            let same = own.hulls == read.hulls
                && own.mass_kg == read.mass_kg
                && own.center_of_mass_m == read.center_of_mass_m
                && own.inertia_tensor_kg_m2 == read.inertia_tensor_kg_m2
                && own.contact == read.contact;
            if !same {
                let name = name.to_owned();
                return Err(ReadError::OtherThanOwn { whole: "scene", name, own: "file" });
            }
        }
        scene.insert(name.to_owned(), read);
    }
    Ok(scene)
}

/// The object of a file of its own, at the pose it has in the scene. Its sites must span its height.
fn read_object(
    files: &Files<'_>,
    name: &str,
    world_from_object: Pose,
    stiffest_s: f64,
) -> ReadResult<ReadBody> {
    let document = xml_node::parse(files.text(&format!("mjcf/{name}/{name}.xml"))?)?;
    let root = document.root_element();
    let meshes = read_meshes(files, root.child("asset")?, "../assets/")?;
    let outer = root.child("worldbody")?.child("body")?;
    let site = |wanted: &str| -> ReadResult<DVec3> {
        let found = outer.all("site").find(|site| site.attribute("name") == Some(wanted));
        vector(found.ok_or_else(|| ReadError::lacks(name, wanted))?.required("pos")?)
    };
    let (bottom, top, radius) = (site("bottom_site")?, site("top_site")?, site("horizontal_radius_site")?);
    if bottom.z >= top.z || radius.x <= 0.0 {
        return Err(ReadError::wrong(format!("the sites of {name}"), "enclose nothing"));
    }
    read_body(outer.child("body")?, &meshes, world_from_object, true, stiffest_s)
}

/// The texts of the meshes by name; they must be files below `folder` of the document.
fn read_meshes<'a, 'f>(
    files: &Files<'f>,
    assets: Node<'a, '_>,
    folder: &str,
) -> ReadResult<BTreeMap<&'a str, &'f str>> {
    let mut meshes = BTreeMap::new();
    for mesh in assets.all("mesh") {
        let file = mesh.required("file")?;
        let file = file.strip_prefix(folder).ok_or_else(|| ReadError::wrong(file, "is elsewhere"))?;
        meshes.insert(mesh.required("name")?, files.text(&format!("mjcf/assets/{file}"))?);
    }
    Ok(meshes)
}

/// A mesh, or a solid by its half sizes.
fn read_shape(geom: Node<'_, '_>, meshes: &BTreeMap<&str, &str>) -> ReadResult<ReadHull> {
    let kind = geom.required("type")?;
    if kind == "mesh" {
        let mesh = geom.required("mesh")?;
        return obj_hull(meshes.get(mesh).ok_or_else(|| ReadError::missing(format!("the mesh {mesh}")))?);
    }
    let size = numbers(geom.required("size")?)?;
    let kind = match (kind, size.as_slice()) {
        ("box", &[x, y, z]) => SimpleSolidKind::Box { half_m: DVec3::new(x, y, z) },
        ("cylinder", &[radius_m, half_length_m]) => SimpleSolidKind::Cylinder { radius_m, half_length_m },
        ("sphere", &[radius_m]) => SimpleSolidKind::Sphere { radius_m },
        ("capsule", &[radius_m, half_length_m]) => SimpleSolidKind::Capsule { radius_m, half_length_m },
        (solid, sizes) => {
            return Err(ReadError::SizeCount { solid: solid.to_owned(), sizes: sizes.len() });
        }
    };
    let object_from_solid = Pose {
        translation_m: vector(geom.required("pos")?)?,
        rotation: quaternion_wxyz(geom.required("quat")?)?,
    };
    Ok(ReadHull::Solid(SimpleSolid { kind, object_from_solid }))
}

fn read_body(
    body: Node<'_, '_>,
    meshes: &BTreeMap<&str, &str>,
    world_from_object: Pose,
    movable: bool,
    stiffest_s: f64,
) -> ReadResult<ReadBody> {
    let inertial = body.child("inertial")?;
    let axes = quaternion_wxyz(inertial.required("quat")?)?;
    let (mut hulls, mut friction) = (Vec::new(), DVec3::NAN);
    for geom in body.all("geom").filter(|geom| geom.attribute("contype") != Some("0")) {
        hulls.push(read_shape(geom, meshes)?);
        if geom.required("solref")?.split(' ').next().and_then(|word| word.parse().ok()) != Some(stiffest_s) {
            let contacts = format!("contacts of {}", body.required("name")?);
            return Err(ReadError::wrong(contacts, "are not the stiffest"));
        }
        let geom_friction = vector(geom.required("friction")?)?;
        if hulls.len() > 1 && geom_friction != friction {
            return Err(ReadError::wrong(
                format!("the hulls of {}", body.required("name")?),
                "rub differently",
            ));
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
