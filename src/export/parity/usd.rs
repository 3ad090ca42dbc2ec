//! Reads `usd/scene.usda` and the props it references: one attribute a line, blocks by their braces.

use std::collections::BTreeMap;

use crate::geometry::Pose;

use super::{Files, ReadBody, ReadResult, ReadScene, points, quaternion_wxyz, tensor, vector};

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    let mut scene = ReadScene::new();
    for (path, prim) in prims(files.text("usd/scene.usda")?) {
        let Some(reference) = prim.get("prepend references") else { continue };
        let asset = reference.trim_matches('@').trim_start_matches("./");
        let name = path.rsplit('/').next().unwrap_or_default();
        let world_from_object = Pose {
            translation_m: vector(attribute(&prim, "xformOp:translate")?)?,
            rotation: quaternion_wxyz(attribute(&prim, "xformOp:orient")?)?,
        };
        let movable = prim.get("physics:rigidBodyEnabled").is_none_or(|value| value == "1");
        let prop = prims(files.text(&format!("usd/{asset}"))?);
        scene.insert(name.to_owned(), read_prop(&prop, name, world_from_object, movable)?);
    }
    Ok(scene)
}

/// Attributes of a prim by name, without type and metadata.
type Prim = BTreeMap<String, String>;

fn read_prop(
    prims: &BTreeMap<String, Prim>,
    name: &str,
    world_from_object: Pose,
    movable: bool,
) -> ReadResult<ReadBody> {
    let prim = |path: String| prims.get(&path).ok_or_else(|| format!("{path} is missing"));
    let root = prim(format!("/{name}"))?;
    let axes = quaternion_wxyz(attribute(root, "physics:principalAxes")?)?;
    let contact = prim(format!("/{name}/Looks/Physics_material"))?;
    let number = |text: &str| text.parse::<f64>().map_err(|_| format!("{text:?} is no number"));
    let colliders = format!("/{name}/colliders/hull_");
    let mut hulls: Vec<(usize, Vec<glam::DVec3>)> = Vec::new();
    for (path, prim) in prims {
        let Some(index) = path.strip_prefix(&colliders) else { continue };
        if attribute(prim, "physics:approximation")? != "\"convexHull\"" {
            return Err(format!("{path} is not approximated by its convex hull"));
        }
        hulls.push((number(index)? as usize, points(attribute(prim, "points")?)?));
    }
    hulls.sort_by_key(|(index, _)| *index);
    Ok(ReadBody {
        mass_kg: number(attribute(root, "physics:mass")?)?,
        center_of_mass_m: vector(attribute(root, "physics:centerOfMass")?)?,
        inertia_tensor_kg_m2: tensor(vector(attribute(root, "physics:diagonalInertia")?)?, axes),
        dynamic_friction: number(attribute(contact, "physics:dynamicFriction")?)?,
        world_from_object,
        movable: Some(movable),
        hulls: hulls.into_iter().map(|(_, corners)| corners).collect(),
    })
}

fn attribute<'a>(prim: &'a Prim, name: &str) -> ReadResult<&'a str> {
    prim.get(name).map(String::as_str).ok_or_else(|| format!("{name} is missing"))
}

/// Every prim of a layer by path.
fn prims(text: &str) -> BTreeMap<String, Prim> {
    let mut found: BTreeMap<String, Prim> = BTreeMap::new();
    // `None` for a brace that opens a dictionary.
    let (mut open, mut path, mut announced) = (Vec::new(), String::new(), None);
    for line in text.lines().map(str::trim) {
        if let Some(definition) = line.strip_prefix("def ") {
            announced = definition.split('"').nth(1).map(|name| format!("{path}/{name}"));
            if let Some(prim) = &announced {
                found.entry(prim.clone()).or_default();
            }
        } else if line == "{" {
            open.push(path.clone());
            path = announced.take().unwrap_or_default();
        } else if line.ends_with("= {") {
            open.push(path.clone());
        } else if line == "}" {
            path = open.pop().unwrap_or_default();
        } else if let Some((declaration, value)) = line.split_once(" = ") {
            let owner = announced.as_ref().unwrap_or(&path);
            let name = if declaration.starts_with("prepend") {
                declaration
            } else {
                declaration.rsplit(' ').next().unwrap_or_default()
            };
            if let Some(prim) = found.get_mut(owner) {
                prim.insert(name.to_owned(), value.trim_end_matches(" (").to_owned());
            }
        }
    }
    found
}
