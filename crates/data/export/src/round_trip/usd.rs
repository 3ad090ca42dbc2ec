//! Reads the USD stage and its props, from files or from a package, in the text or the crate format.

mod crate_layer;
mod text_layer;

pub use crate_layer::LayerError;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use glam::{DQuat, DVec3};
use zip::ZipArchive;

use geometry::{Pose, SimpleSolid, SimpleSolidKind};
use scene::StandIn;

use super::{Files, ReadBody, ReadContact, ReadError, ReadHull, ReadLabels, ReadResult, ReadScene, tensor};
use crate_layer::CrateLayer;
use text_layer::TextLayer;

pub fn read(files: &Files<'_>) -> ReadResult<ReadScene> {
    match files.bytes("usd/scene.usdz") {
        Ok(package) => read_package(package),
        Err(_) => read_stage("scene.usda", |path| files.bytes(&format!("usd/{path}")).map(Cow::Borrowed)),
    }
}

/// Reads a package. Its first file is the root layer; content must be uncompressed and aligned to 64 bytes.
fn read_package(package: &[u8]) -> ReadResult<ReadScene> {
    let mut archive = ZipArchive::new(Cursor::new(package))?;
    let mut contents: Vec<(String, Vec<u8>)> = Vec::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index)?;
        let name = entry.name()?.into_owned();
        let begin = entry.data_start().unwrap_or_default();
        if entry.compressed_size() != entry.size() || begin == 0 || begin % 64 != 0 {
            return Err(ReadError::PackageAlignment { name, begin });
        }
        let mut content = Vec::new();
        match entry.read_to_end(&mut content) {
            Ok(_) => contents.push((name, content)),
            Err(error) => return Err(ReadError::PackageEntry { name, error }),
        }
    }
    let (root, _) = contents.first().ok_or_else(|| ReadError::wrong("the package", "is empty"))?;
    read_stage(root, |path| {
        let found = contents.iter().find(|(name, _)| name == path);
        found
            .map(|(_, content)| content.into())
            .ok_or_else(|| ReadError::wrong(path, "is not in the package"))
    })
}

/// Read access to a layer. Prims are named by their paths.
trait Layer {
    /// Every prim.
    fn prims(&self) -> Vec<&str>;

    /// The asset path that a prim references, as written.
    fn reference(&self, prim: &str) -> ReadResult<Option<String>>;

    /// The numbers of an attribute, flattened row by row, quaternions as w, x, y, z. `None` if the prim has no such
    /// attribute.
    fn numbers(&self, prim: &str, attribute: &str) -> ReadResult<Option<Vec<f64>>>;

    /// The text of an attribute; the first element of a list of texts.
    fn text(&self, prim: &str, attribute: &str) -> ReadResult<Option<String>>;

    /// The text or number of a metadata field. The fields of the layer itself have the empty path.
    fn field(&self, prim: &str, field: &str) -> ReadResult<Option<String>>;

    /// Whether a schema is applied to a prim.
    fn has_schema(&self, prim: &str, schema: &str) -> ReadResult<bool>;

    /// The target path of a relationship.
    fn target(&self, prim: &str, relationship: &str) -> ReadResult<Option<String>>;

    /// The asset path that the variant `Enabled` of a variant set loads, as written.
    fn payload(&self, prim: &str, variant_set: &str) -> ReadResult<Option<String>>;
}

/// Reads the stage and its props. `content` returns a file by its path relative to the stage.
fn read_stage<'a>(root: &str, content: impl Fn(&str) -> ReadResult<Cow<'a, [u8]>>) -> ReadResult<ReadScene> {
    let mut scene = ReadScene::new();
    let root_bytes = content(root)?;
    let stage = opened(root, &root_bytes)?;
    check_units(root, &*stage)?;
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
        check_units(asset, &*prop)?;
        let mut body = read_prop(&*prop, name, world_from_object, movable)?;
        let folder = asset.rsplit_once('/').map_or("", |(folder, _)| folder);
        let hulls = body.hulls.len();
        let [rolling, torsional] = read_simulator_layers(&*prop, name, hulls, |path| {
            content(&format!("{folder}/{}", path.trim_start_matches("./")))
        })?;
        body.contact.rolling_friction_m = Some(rolling);
        body.contact.torsional_friction_m = Some(torsional);
        scene.insert(name.to_owned(), body);
    }
    Ok(scene)
}

fn opened<'a>(path: &str, bytes: &'a [u8]) -> ReadResult<Box<dyn Layer + 'a>> {
    let error = |reason: LayerError| ReadError::from(reason).within(path);
    if path.ends_with(".usdc") {
        return Ok(Box::new(CrateLayer::open(bytes).map_err(error)?));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| error(LayerError::NotUtf8))?;
    Ok(Box::new(TextLayer::open(text)))
}

/// Fails unless the layer is z up, in meters and kilograms.
fn check_units(path: &str, layer: &dyn Layer) -> ReadResult<()> {
    for (field, wanted) in [("upAxis", "Z"), ("metersPerUnit", "1"), ("kilogramsPerUnit", "1")] {
        let found = layer.field("", field)?;
        if found.as_deref() != Some(wanted) {
            return Err(ReadError::Field { path: path.to_owned(), field, found, wanted });
        }
    }
    Ok(())
}

/// Rolling and torsional friction (meters) from the layers of the single simulators. Each layer must name every
/// collider.
fn read_simulator_layers<'a>(
    prop: &dyn Layer,
    name: &str,
    hulls: usize,
    content: impl Fn(&str) -> ReadResult<Cow<'a, [u8]>>,
) -> ReadResult<[f64; 2]> {
    let root = format!("/{name}");
    let contact = format!("/{name}/Looks/Physics_material");
    let mut coefficients: Vec<[f64; 2]> = Vec::new();
    for (program, schema, attributes) in [
        ("Newton", "NewtonCollisionAPI", Some(["newton:rollingFriction", "newton:torsionalFriction"])),
        ("MuJoCo", "MjcCollisionAPI", Some(["mjc:rollingfriction", "mjc:torsionalfriction"])),
        ("PhysX", "PhysxCollisionAPI", None),
    ] {
        let path = prop.payload(&root, program)?;
        let path = path.ok_or_else(|| ReadError::lacks(name, format!("variant {program}")))?;
        let bytes = content(&path)?;
        let layer = opened(&path, &bytes)?;
        for hull in 0..hulls {
            let collider = format!("/{name}/colliders/hull_{hull:02}");
            if !layer.has_schema(&collider, schema)? {
                let name = name.to_owned();
                return Err(ReadError::NoCollider { layer: path, name, collider, program });
            }
            if program == "Newton" && number(&*layer, &collider, "newton:contactGap")? != 0.0 {
                let name = name.to_owned();
                return Err(ReadError::DistantContacts { layer: path, name, collider });
            }
        }
        if let Some([rolling, torsional]) = attributes {
            coefficients.push([number(&*layer, &contact, rolling)?, number(&*layer, &contact, torsional)?]);
        }
    }
    match coefficients.as_slice() {
        // Newton's coefficients are in single precision.
        &[newton, mujoco] if (0..2).all(|k| (newton[k] - mujoco[k]).abs() < 1e-6) => Ok(mujoco),
        _ => Err(ReadError::ProgramsDiffer { name: name.to_owned(), found: coefficients }),
    }
}

fn read_prop(prop: &dyn Layer, name: &str, world_from_object: Pose, movable: bool) -> ReadResult<ReadBody> {
    let root = format!("/{name}");
    for schema in ["PhysicsRigidBodyAPI", "PhysicsMassAPI"] {
        if !prop.has_schema(&root, schema)? {
            return Err(ReadError::NoSchema { prim: root, schema });
        }
    }
    let contact = format!("/{name}/Looks/Physics_material");
    let axes = quaternion(prop, &root, "physics:principalAxes")?;
    let colliders = format!("/{name}/colliders/hull_");
    let mut hulls: Vec<(usize, ReadHull)> = Vec::new();
    for path in prop.prims() {
        let Some(index) = path.strip_prefix(&colliders) else { continue };
        let enabled = prop.numbers(path, "physics:collisionEnabled")?;
        if !prop.has_schema(path, "PhysicsCollisionAPI")? || enabled.is_some_and(|value| value != [1.0]) {
            return Err(ReadError::wrong(path, "does not collide"));
        }
        if prop.target(path, "material:binding:physics")?.as_deref() != Some(contact.as_str()) {
            return Err(ReadError::NotBound { collider: path.to_owned(), material: contact });
        }
        let index = index.parse().map_err(|_| ReadError::lacks(path, "number"))?;
        hulls.push((index, read_shape(prop, path)?));
    }
    hulls.sort_by_key(|(index, _)| *index);
    if !prop.has_schema(&contact, "PhysicsMaterialAPI")? {
        return Err(ReadError::NoSchema { prim: contact, schema: "PhysicsMaterialAPI" });
    }
    let word = |attribute: &str| {
        prop.text(&root, attribute)?.ok_or_else(|| ReadError::missing(format!("{root}.{attribute}")))
    };
    Ok(ReadBody {
        mass_kg: number(prop, &root, "physics:mass")?,
        center_of_mass_m: vector(prop, &root, "physics:centerOfMass")?,
        inertia_tensor_kg_m2: tensor(vector(prop, &root, "physics:diagonalInertia")?, axes),
        contact: ReadContact {
            dynamic_friction: number(prop, &contact, "physics:dynamicFriction")?,
            static_friction: Some(number(prop, &contact, "physics:staticFriction")?),
            restitution: Some(number(prop, &contact, "physics:restitution")?),
            rolling_friction_m: None,
            torsional_friction_m: None,
        },
        world_from_object,
        movable: Some(movable),
        hulls: hulls.into_iter().map(|(_, hull)| hull).collect(),
        visual: Some(read_visuals(prop, &format!("{root}/visual/"))?),
        labels: Some(ReadLabels {
            label: prop.field(&root, "displayName")?.unwrap_or_default(),
            category: word("semantics:labels:class")?,
            wikidata_item: word("semantics:labels:wikidata_qcode")?,
            stand_in: match prop.numbers(&root, "tabletopgen:stand_in")?.as_deref() {
                Some([1.0]) => Some(StandIn {
                    stands_for: prop.text(&root, "tabletopgen:stands_for")?.unwrap_or_default(),
                    shown_as: prop.text(&root, "tabletopgen:shown_as")?.unwrap_or_default(),
                }),
                _ => None,
            },
        }),
    })
}

/// The mesh or the solid of a collider. Meshes must be approximated by their hulls, cubes scaled from unit size, and
/// axes z.
fn read_shape(prop: &dyn Layer, path: &str) -> ReadResult<ReadHull> {
    let type_name = prop.field(path, "typeName")?.unwrap_or_default();
    if type_name == "Mesh" {
        if prop.text(path, "physics:approximation")?.as_deref() != Some("convexHull") {
            return Err(ReadError::wrong(path, "is not approximated by its convex hull"));
        }
        let corners = numbers(prop, path, "points")?;
        return Ok(ReadHull::Corners(corners.chunks_exact(3).map(DVec3::from_slice).collect()));
    }
    let measure = |name: &str| number(prop, path, name);
    let kind = match type_name.as_str() {
        "Cube" if measure("size")? == 1.0 => {
            SimpleSolidKind::Box { half_m: 0.5 * vector(prop, path, "xformOp:scale")? }
        }
        "Sphere" => SimpleSolidKind::Sphere { radius_m: measure("radius")? },
        "Cylinder" | "Capsule" if prop.text(path, "axis")?.as_deref() != Some("Z") => {
            return Err(ReadError::wrong(format!("the axis of {path}"), "is not z"));
        }
        "Cylinder" => SimpleSolidKind::Cylinder {
            radius_m: measure("radius")?,
            half_length_m: 0.5 * measure("height")?,
        },
        "Capsule" => {
            SimpleSolidKind::Capsule { radius_m: measure("radius")?, half_length_m: 0.5 * measure("height")? }
        }
        _ => return Err(ReadError::ColliderKind { path: path.to_owned(), kind: type_name }),
    };
    let object_from_solid = Pose {
        translation_m: vector(prop, path, "xformOp:translate")?,
        rotation: quaternion(prop, path, "xformOp:orient")?,
    };
    Ok(ReadHull::Solid(SimpleSolid { kind, object_from_solid }))
}

/// Triangles of the meshes directly below a prim, by name.
fn read_visuals(prop: &dyn Layer, above: &str) -> ReadResult<BTreeMap<String, Vec<[DVec3; 3]>>> {
    let prims = prop.prims();
    let parts = prims.iter().filter_map(|path| Some((*path, path.strip_prefix(above)?)));
    parts.map(|(path, name)| Ok((name.to_owned(), read_visual(prop, path)?))).collect()
}

/// Triangles of a mesh.
fn read_visual(prop: &dyn Layer, path: &str) -> ReadResult<Vec<[DVec3; 3]>> {
    let points = numbers(prop, path, "points")?;
    let (counts, indices) =
        (numbers(prop, path, "faceVertexCounts")?, numbers(prop, path, "faceVertexIndices")?);
    if counts.iter().any(|count| *count != 3.0) || indices.len() != 3 * counts.len() {
        return Err(ReadError::wrong(path, "has faces that are no triangles"));
    }
    let corner = |index: &f64| {
        let row = points.get(3 * *index as usize..3 * *index as usize + 3);
        row.map(DVec3::from_slice).ok_or_else(|| ReadError::lacks(path, format!("point {index}")))
    };
    let corners: Vec<DVec3> = indices.iter().map(corner).collect::<ReadResult<_>>()?;
    Ok(corners.as_chunks::<3>().0.to_vec())
}

fn numbers(layer: &dyn Layer, prim: &str, attribute: &str) -> ReadResult<Vec<f64>> {
    layer.numbers(prim, attribute)?.ok_or_else(|| ReadError::missing(format!("{prim}.{attribute}")))
}

fn miscounted(prim: &str, attribute: &str, found: &[f64], wanted: &'static str) -> ReadError {
    ReadError::NumberCount { attribute: format!("{prim}.{attribute}"), found: found.len(), wanted }
}

fn number(layer: &dyn Layer, prim: &str, attribute: &str) -> ReadResult<f64> {
    match numbers(layer, prim, attribute)?.as_slice() {
        &[value] => Ok(value),
        other => Err(miscounted(prim, attribute, other, "one")),
    }
}

fn vector(layer: &dyn Layer, prim: &str, attribute: &str) -> ReadResult<DVec3> {
    match numbers(layer, prim, attribute)?.as_slice() {
        &[x, y, z] => Ok(DVec3::new(x, y, z)),
        other => Err(miscounted(prim, attribute, other, "three")),
    }
}

fn quaternion(layer: &dyn Layer, prim: &str, attribute: &str) -> ReadResult<DQuat> {
    match numbers(layer, prim, attribute)?.as_slice() {
        &[w, x, y, z] => Ok(DQuat::from_xyzw(x, y, z, w).normalize()),
        other => Err(miscounted(prim, attribute, other, "four")),
    }
}
