//! Reads `mjcf/scene.xml`.

use std::collections::BTreeMap;

use glam::DVec3;

use geometry::Pose;

use super::xml_node::{self, XmlNode};
use super::{Files, ReadBody, ReadContact, ReadResult, ReadScene, points, quaternion_wxyz, tensor, vector};

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    let document = xml_node::parse(files.text("mjcf/scene.xml")?)?;
    let root = document.root_element();
    let mut corners = BTreeMap::new();
    for mesh in root.child("asset")?.all("mesh") {
        match mesh.attribute("vertex") {
            Some(vertex) => {
                corners.insert(mesh.required("name")?, points(vertex)?);
            }
            None => {
                files.bytes(&format!("mjcf/assets/{}", mesh.required("file")?))?;
            }
        }
    }
    let mut scene = ReadScene::new();
    for body in root.child("worldbody")?.all("body") {
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
        let read = ReadBody {
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
            world_from_object: Pose {
                translation_m: vector(body.required("pos")?)?,
                rotation: quaternion_wxyz(body.required("quat")?)?,
            },
            movable: Some(body.child("freejoint").is_ok()),
            hulls,
            visual: None,
            labels: None,
        };
        scene.insert(body.required("name")?.to_owned(), read);
    }
    Ok(scene)
}
