//! One body as a USD prop: rigid body on the root, a visual mesh per material, one collider per hull (a mesh, or the
//! box, cylinder, sphere or capsule that the hull stands for), a grasp where one is known, and a variant set for each
//! simulator with schemas of its own.
//!
//! Points of a visual mesh are welded by position, so its topology is closed where the surface is; normals and
//! texture coordinates are per face corner.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::body::STAND_IN;
use crate::number::direction;
use crate::{Body, ExportSettings};
use geometry::parallel_grasp::ParallelGrasp;
use geometry::{ConvexHull, FaceGroup, SimpleSolid, SimpleSolidKind, TexturedMesh};
use scene::Scene;

use super::layer::{Interpolation, Layer, Path, Prim, VariantSet};
use super::material::{display_color, materials};
use super::prim_names::{COLLIDERS, MATERIALS, PHYSICS_MATERIAL, VISUAL, hull_name};
use super::simulator_schemas::Simulator;
use super::value::{Dictionary, Quaternion, Value};

/// The layer of one body.
pub fn prop(scene: &Scene, body: &Body, settings: &ExportSettings) -> Layer {
    let schemas = [
        "PhysicsRigidBodyAPI",
        "PhysicsMassAPI",
        "SemanticsLabelsAPI:class",
        "SemanticsLabelsAPI:wikidata_qcode",
    ];
    let mut root = Prim::new("Xform", &body.name).with_schemas(&schemas);
    root.asset_info = Dictionary::default().with("name", Value::string(&body.name));
    root.display_name = Some(body.label.as_str().into());
    root.kind = Some("component");
    let mass = &body.mass;
    let axes = Quaternion::from(mass.principal_axes_xyzw.normalize());
    root.set("physics:centerOfMass", Value::Point3f(mass.center_of_mass_m.as_vec3().to_array()));
    root.set("physics:diagonalInertia", Value::Float3(mass.inertia_diagonal_kg_m2.as_vec3().to_array()));
    root.set("physics:mass", Value::Float(mass.mass_kg as f32));
    root.set("physics:principalAxes", Value::Quatf(axes.in_f32()));
    root.set("physics:rigidBodyEnabled", Value::Bool(true));
    root.set("semantics:labels:class", Value::tokens(&[&body.category]));
    root.set("semantics:labels:wikidata_qcode", Value::tokens(&[&body.wikidata_item]));
    for (mark, value) in body.marks() {
        let value = if mark == STAND_IN { Value::Bool(true) } else { Value::string(value) };
        root.set_custom(&format!("tabletopgen:{mark}"), value);
    }
    root.variant_sets = Simulator::ALL.map(Simulator::variant_set).into();
    root.add(visual(body));
    if let Some(grasp) = &body.grasp {
        root.add(grasp_line(grasp));
    }
    let mut colliders = Prim::new("Xform", COLLIDERS);
    for (k, (hull, solid)) in body.hulls.iter().zip(&body.solids).enumerate() {
        let prim = match solid {
            Some(solid) => solid_collider(k, solid),
            None => hull_collider(k, hull),
        };
        colliders.add(completed(prim, &body.name));
    }
    root.add(colliders);
    root.add(materials(body));
    Layer { custom_data: custom_data(scene, body, settings), root }
}

fn custom_data(scene: &Scene, body: &Body, settings: &ExportSettings) -> Dictionary {
    let instance = scene.instances.iter().find(|instance| instance.name.as_str() == body.name);
    let licence = instance.map_or(settings.licence.as_str(), |instance| &instance.provenance.licence);
    // SimReady requires these entries twice: inside its own dictionary and beside it.
    let with_identity = |dictionary: Dictionary| {
        dictionary
            .with("asset_name", Value::string(&body.name))
            .with("asset_type", Value::string("prop"))
            .with("source_file", Value::string("scene.json"))
            .with("usd_date_generated", Value::string(&settings.date))
    };
    let metadata = with_identity(Dictionary::default().with("author", Value::string(&settings.author)))
        .with("asset_license", Value::string(licence))
        .with("category", Value::string(&body.category))
        .with("qcode", Value::string(&body.wikidata_item))
        .with("rigid_body_count", Value::Int(1))
        .with("asset_extents", Value::Float3(body.visual.size_m().as_vec3().to_array()))
        .with("mass", Value::Double(body.mass.mass_kg))
        .with_dictionary("Variants", Dictionary::default().with_dictionary("Physics", simulators(body)));
    with_identity(Dictionary::default().with_dictionary("SimReady_Metadata", metadata))
        .with("label", Value::string(&body.label))
        .with("scene", Value::string(&scene.id))
}

/// Variant set of each simulator and the option that enables it, as SimReady's metadata describes them.
fn simulators(body: &Body) -> Dictionary {
    let prim = Path::prim(&[&body.name]).to_string();
    Simulator::ALL.into_iter().fold(Dictionary::default(), |all, simulator| {
        let activation = Dictionary::default()
            .with("activateOption", Value::string(VariantSet::ENABLED))
            .with("prim", Value::string(&prim))
            .with("variantSetName", Value::string(simulator.variant_set_name()));
        all.with_dictionary(simulator.variant_set_name(), activation)
    })
}

/// The line along which a parallel gripper closes, from one contact to the other.
fn grasp_line(grasp: &ParallelGrasp) -> Prim {
    let mut prim = Prim::new("BasisCurves", "grasp_identifier_00");
    prim.set_uniform("purpose", Value::token("guide"));
    prim.set_uniform("type", Value::token("linear"));
    prim.set("curveVertexCounts", Value::Ints(vec![2]));
    let points = grasp.contacts_m.map(|point| point.as_vec3().to_array());
    let half = 0.5 * GRASP_LINE_WIDTH_M;
    let (low, high) = box_of(&points);
    prim.set("extent", Value::Float3s(vec![low.map(|v| v - half), high.map(|v| v + half)]));
    prim.set("points", Value::Point3fs(points.into()));
    prim.set_interpolated("widths", Value::Floats(vec![GRASP_LINE_WIDTH_M]), Interpolation::Constant);
    prim
}

/// Width of the grasp line, meters.
const GRASP_LINE_WIDTH_M: f32 = 0.001;

/// One mesh per material, because not every reader supports `GeomSubset`.
fn visual(body: &Body) -> Prim {
    let mut parts = Prim::new("Xform", VISUAL);
    body.visual.groups.iter().for_each(|group| parts.add(part(body, group)));
    parts
}

fn part(body: &Body, group: &FaceGroup) -> Prim {
    let (mesh, material) = (&body.visual, &body.visual.materials[group.material]);
    let (points, point_of_vertex) = welded(mesh, group);
    let mut prim = Prim::new("Mesh", &material.name).with_schemas(&["MaterialBindingAPI"]);
    prim.relate("material:binding", Path::prim(&[&body.name, MATERIALS, &material.name]));
    prim.set_uniform("orientation", Value::token("rightHanded"));
    prim.set_uniform("subdivisionScheme", Value::token("none"));
    set_points(&mut prim, points);
    let corners = || group.triangles.iter().flatten();
    set_faces(&mut prim, group.triangles.len(), corners().map(|v| point_of_vertex[*v as usize]));
    let normals = corners().map(|v| mesh.normals[*v as usize].to_array().map(direction)).collect();
    prim.set_interpolated("normals", Value::Normal3fs(normals), Interpolation::FaceVarying);
    let color = Value::Color3fs(vec![display_color(material)]);
    prim.set_interpolated("primvars:displayColor", color, Interpolation::Constant);
    let (uvs, uv_of_vertex) = distinct_uvs(mesh, group);
    prim.set_interpolated("primvars:st", Value::TexCoord2fs(uvs), Interpolation::FaceVarying);
    prim.set("primvars:st:indices", indices(corners().map(|v| uv_of_vertex[*v as usize])));
    prim
}

/// Adds the properties that all colliders have.
fn completed(mut prim: Prim, body: &str) -> Prim {
    prim.set_uniform("purpose", Value::token("guide"));
    prim.set("physics:collisionEnabled", Value::Bool(true));
    prim.relate("material:binding:physics", Path::prim(&[body, MATERIALS, PHYSICS_MATERIAL]));
    prim
}

/// A solid about its own center; a box is a scaled cube, as USD knows no other.
fn solid_collider(index: usize, solid: &SimpleSolid) -> Prim {
    let (type_name, size) = match solid.kind {
        SimpleSolidKind::Box { .. } => ("Cube", vec![("size", 1.0)]),
        SimpleSolidKind::Cylinder { radius_m, half_length_m } => {
            ("Cylinder", vec![("radius", radius_m), ("height", 2.0 * half_length_m)])
        }
        SimpleSolidKind::Sphere { radius_m } => ("Sphere", vec![("radius", radius_m)]),
        SimpleSolidKind::Capsule { radius_m, half_length_m } => {
            ("Capsule", vec![("radius", radius_m), ("height", 2.0 * half_length_m)])
        }
    };
    let schemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"];
    let mut prim = Prim::new(type_name, &hull_name(index)).with_schemas(&schemas);
    if size.len() > 1 {
        prim.set_uniform("axis", Value::token("Z"));
    }
    for (name, value) in size {
        prim.set(name, Value::Double(value));
    }
    let is_box = type_name == "Cube";
    let half = if is_box { DVec3::splat(0.5) } else { solid.half_size_m() };
    prim.set("extent", Value::Float3s([-half, half].map(|corner| corner.as_vec3().to_array()).into()));
    let pose = &solid.object_from_solid;
    let mut order = vec!["xformOp:translate", "xformOp:orient"];
    prim.set("xformOp:orient", Value::Quatd(pose.rotation.into()));
    if is_box {
        prim.set("xformOp:scale", Value::Float3((2.0 * solid.half_size_m()).as_vec3().to_array()));
        order.push("xformOp:scale");
    }
    prim.set("xformOp:translate", Value::Double3(pose.translation_m.to_array()));
    prim.set_uniform("xformOpOrder", Value::tokens(&order));
    prim
}

fn hull_collider(index: usize, hull: &ConvexHull) -> Prim {
    let schemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"];
    let mut prim = Prim::new("Mesh", &hull_name(index)).with_schemas(&schemas);
    prim.set_uniform("physics:approximation", Value::token("convexHull"));
    prim.set_uniform("orientation", Value::token("rightHanded"));
    prim.set_uniform("subdivisionScheme", Value::token("none"));
    set_points(&mut prim, hull.points.iter().map(|p| p.as_vec3().to_array()).collect());
    set_faces(&mut prim, hull.triangles.len(), hull.triangles.iter().flatten().copied());
    let normals = hull.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| hull.points[v as usize]);
        (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array().map(direction)
    });
    prim.set_interpolated("normals", Value::Normal3fs(normals.collect()), Interpolation::Uniform);
    prim
}

/// Sets points and extent. The extent is computed from the single-precision values that are written.
fn set_points(prim: &mut Prim, points: Vec<[f32; 3]>) {
    let (low, high) = box_of(&points);
    prim.set("extent", Value::Float3s(vec![low, high]));
    prim.set("points", Value::Point3fs(points));
}

/// Lowest and highest of each coordinate.
fn box_of(points: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    (low, high)
}

fn set_faces(prim: &mut Prim, count: usize, point_indices: impl Iterator<Item = u32>) {
    prim.set("faceVertexCounts", Value::Ints(vec![3; count]));
    prim.set("faceVertexIndices", indices(point_indices));
}

/// Indices as the signed integers of USD.
fn indices(indices: impl Iterator<Item = u32>) -> Value {
    Value::Ints(indices.map(|index| index as i32).collect())
}

/// Distinct positions in order of first use by a triangle, and each vertex's index among them.
fn welded(mesh: &TexturedMesh, group: &FaceGroup) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut known = BTreeMap::new();
    let mut points = Vec::new();
    let mut point_of_vertex = vec![0; mesh.positions.len()];
    for &v in group.triangles.iter().flatten() {
        let position = mesh.positions[v as usize].as_vec3().to_array();
        let index = *known.entry(position.map(f32::to_bits)).or_insert_with(|| {
            points.push(position);
            points.len() as u32 - 1
        });
        point_of_vertex[v as usize] = index;
    }
    (points, point_of_vertex)
}

/// As [`welded`], for texture coordinates.
fn distinct_uvs(mesh: &TexturedMesh, group: &FaceGroup) -> (Vec<[f32; 2]>, Vec<u32>) {
    let mut known = BTreeMap::new();
    let mut uvs = Vec::new();
    let mut uv_of_vertex = vec![0; mesh.uvs.len()];
    for &v in group.triangles.iter().flatten() {
        let uv = mesh.uvs[v as usize].to_array().map(direction);
        let index = *known.entry(uv.map(f32::to_bits)).or_insert_with(|| {
            uvs.push(uv);
            uvs.len() as u32 - 1
        });
        uv_of_vertex[v as usize] = index;
    }
    (uvs, uv_of_vertex)
}
