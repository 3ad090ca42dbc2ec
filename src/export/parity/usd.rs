//! Reads the stage and the props it references, from files or out of a package, from text or the crate format.

mod crate_layer;
mod text_layer;

use std::borrow::Cow;
use std::io::{Cursor, Read};

use glam::{DQuat, DVec3};
use zip::ZipArchive;

use crate::geometry::Pose;

use super::{Files, ReadBody, ReadResult, ReadScene, tensor};
use crate_layer::CrateLayer;
use text_layer::TextLayer;

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    match files.bytes("usd/scene.usdz") {
        Ok(package) => read_package(package),
        Err(_) => read_stage("scene.usda", |path| files.bytes(&format!("usd/{path}")).map(Cow::Borrowed)),
    }
}

/// The first file of a package is its root layer; readers map the files' content where it lies.
fn read_package(package: &[u8]) -> ReadResult<ReadScene> {
    let mut archive =
        ZipArchive::new(Cursor::new(package)).map_err(|error| format!("the package: {error}"))?;
    let mut contents: Vec<(String, Vec<u8>)> = Vec::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(|error| format!("the package: {error}"))?;
        let name = entry.name().map_err(|error| format!("the package: {error}"))?.into_owned();
        let begin = entry.data_start().unwrap_or_default();
        if entry.compressed_size() != entry.size() || begin == 0 || begin % 64 != 0 {
            return Err(format!("{name} is compressed in the package or begins at byte {begin}"));
        }
        let mut content = Vec::new();
        entry.read_to_end(&mut content).map_err(|error| format!("{name} in the package: {error}"))?;
        contents.push((name, content));
    }
    let (root, _) = contents.first().ok_or("the package is empty")?;
    read_stage(root, |path| {
        let found = contents.iter().find(|(name, _)| name == path);
        found.map(|(_, content)| content.into()).ok_or_else(|| format!("{path} is not in the package"))
    })
}

/// What is read of a layer. Prims are named by their paths.
trait Layer {
    /// Every prim.
    fn prims(&self) -> Vec<&str>;

    /// The layer that a prim references, as it is written there.
    fn reference(&self, prim: &str) -> ReadResult<Option<String>>;

    /// The numbers of an attribute one after another, rows one after another, quaternions as w, x, y, z; or `None`
    /// where the prim has no such attribute.
    fn numbers(&self, prim: &str, attribute: &str) -> ReadResult<Option<Vec<f64>>>;

    /// The text of an attribute.
    fn text(&self, prim: &str, attribute: &str) -> ReadResult<Option<String>>;
}

/// `content` gives a file by its path relative to the stage.
fn read_stage<'a>(root: &str, content: impl Fn(&str) -> ReadResult<Cow<'a, [u8]>>) -> ReadResult<ReadScene> {
    let mut scene = ReadScene::new();
    let root_bytes = content(root)?;
    let stage = opened(root, &root_bytes)?;
    for path in stage.prims() {
        let Some(reference) = stage.reference(path)? else { continue };
        let asset = reference.trim_start_matches("./");
        let name = path.rsplit('/').next().unwrap_or_default();
        let world_from_object = Pose {
            translation_m: vector(&*stage, path, "xformOp:translate")?,
            rotation: quaternion(&*stage, path, "xformOp:orient")?,
        };
        let enabled = stage.numbers(path, "physics:rigidBodyEnabled")?;
        let movable = enabled.is_none_or(|value| value == [1.0]);
        let bytes = content(asset)?;
        let prop = opened(asset, &bytes)?;
        scene.insert(name.to_owned(), read_prop(&*prop, name, world_from_object, movable)?);
    }
    Ok(scene)
}

fn opened<'a>(path: &str, bytes: &'a [u8]) -> ReadResult<Box<dyn Layer + 'a>> {
    let told = |reason: String| format!("{path}: {reason}");
    if path.ends_with(".usdc") {
        return Ok(Box::new(CrateLayer::open(bytes).map_err(told)?));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| told("is not UTF-8".to_owned()))?;
    Ok(Box::new(TextLayer::open(text)))
}

fn read_prop(prop: &dyn Layer, name: &str, world_from_object: Pose, movable: bool) -> ReadResult<ReadBody> {
    let root = format!("/{name}");
    let axes = quaternion(prop, &root, "physics:principalAxes")?;
    let colliders = format!("/{name}/colliders/hull_");
    let mut hulls: Vec<(usize, Vec<DVec3>)> = Vec::new();
    for path in prop.prims() {
        let Some(index) = path.strip_prefix(&colliders) else { continue };
        if prop.text(path, "physics:approximation")?.as_deref() != Some("convexHull") {
            return Err(format!("{path} is not approximated by its convex hull"));
        }
        let index = index.parse().map_err(|_| format!("{path} has no number"))?;
        let corners = numbers(prop, path, "points")?;
        hulls.push((index, corners.chunks_exact(3).map(DVec3::from_slice).collect()));
    }
    hulls.sort_by_key(|(index, _)| *index);
    let contact = format!("/{name}/Looks/Physics_material");
    Ok(ReadBody {
        mass_kg: number(prop, &root, "physics:mass")?,
        center_of_mass_m: vector(prop, &root, "physics:centerOfMass")?,
        inertia_tensor_kg_m2: tensor(vector(prop, &root, "physics:diagonalInertia")?, axes),
        dynamic_friction: number(prop, &contact, "physics:dynamicFriction")?,
        world_from_object,
        movable: Some(movable),
        hulls: hulls.into_iter().map(|(_, corners)| corners).collect(),
    })
}

fn numbers(layer: &dyn Layer, prim: &str, attribute: &str) -> ReadResult<Vec<f64>> {
    layer.numbers(prim, attribute)?.ok_or_else(|| format!("{prim}.{attribute} is missing"))
}

fn number(layer: &dyn Layer, prim: &str, attribute: &str) -> ReadResult<f64> {
    match numbers(layer, prim, attribute)?.as_slice() {
        &[value] => Ok(value),
        other => Err(format!("{prim}.{attribute} has {} numbers instead of one", other.len())),
    }
}

fn vector(layer: &dyn Layer, prim: &str, attribute: &str) -> ReadResult<DVec3> {
    match numbers(layer, prim, attribute)?.as_slice() {
        &[x, y, z] => Ok(DVec3::new(x, y, z)),
        other => Err(format!("{prim}.{attribute} has {} numbers instead of three", other.len())),
    }
}

fn quaternion(layer: &dyn Layer, prim: &str, attribute: &str) -> ReadResult<DQuat> {
    match numbers(layer, prim, attribute)?.as_slice() {
        &[w, x, y, z] => Ok(DQuat::from_xyzw(x, y, z, w).normalize()),
        other => Err(format!("{prim}.{attribute} has {} numbers instead of four", other.len())),
    }
}
