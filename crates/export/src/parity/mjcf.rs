//! Reads `mjcf/scene.xml`.

use std::collections::BTreeMap;

use glam::DVec3;

use geometry::Pose;

use super::xml_tree::Element;
use super::{Files, ReadBody, ReadContact, ReadResult, ReadScene, points, quaternion_wxyz, tensor, vector};

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    let root = Element::parse(files.text("mjcf/scene.xml")?)?;
    let mut corners = BTreeMap::new();
    for mesh in root.child("asset")?.all("mesh") {
        match mesh.optional("vertex") {
            Some(vertex) => {
                corners.insert(mesh.attribute("name")?, points(vertex)?);
            }
            None => {
                files.bytes(&format!("mjcf/assets/{}", mesh.attribute("file")?))?;
            }
        }
    }
    let mut scene = ReadScene::new();
    for body in root.child("worldbody")?.all("body") {
        let inertial = body.child("inertial")?;
        let axes = quaternion_wxyz(inertial.attribute("quat")?)?;
        let (mut hulls, mut friction) = (Vec::new(), DVec3::NAN);
        for geom in body.all("geom").filter(|geom| geom.optional("contype") != Some("0")) {
            let mesh = geom.attribute("mesh")?;
            hulls.push(corners.get(mesh).cloned().ok_or_else(|| format!("the mesh {mesh} is missing"))?);
            let here = vector(geom.attribute("friction")?)?;
            if hulls.len() > 1 && here != friction {
                return Err(format!("the hulls of {} rub differently", body.attribute("name")?));
            }
            friction = here;
        }
        let read = ReadBody {
            mass_kg: inertial.number("mass")?,
            center_of_mass_m: vector(inertial.attribute("pos")?)?,
            inertia_tensor_kg_m2: tensor(vector(inertial.attribute("diaginertia")?)?, axes),
            contact: ReadContact {
                dynamic_friction: friction.x,
                static_friction: None,
                restitution: None,
                torsional_friction_m: Some(friction.y),
                rolling_friction_m: Some(friction.z),
            },
            world_from_object: Pose {
                translation_m: vector(body.attribute("pos")?)?,
                rotation: quaternion_wxyz(body.attribute("quat")?)?,
            },
            movable: Some(body.child("freejoint").is_ok()),
            hulls,
            visual: None,
            words: None,
        };
        scene.insert(body.attribute("name")?.to_owned(), read);
    }
    Ok(scene)
}
