//! One body as a USD prop: rigid body on the root, a visual mesh, one collider mesh per hull.
//!
//! Points of the visual mesh are welded by position, so its topology is closed where the surface is;
//! normals and texture coordinates are per face corner.

use std::collections::BTreeMap;

use crate::export::number::direction;
use crate::export::{Body, ExportSettings};
use crate::geometry::{ConvexHull, TexturedMesh};
use crate::scene::Scene;

use super::layer::{Interpolation, Layer, Path, Prim};
use super::look::{LOOKS, PHYSICS_MATERIAL, looks};
use super::value::{Dictionary, Quaternion, Value};

/// The layer of one body.
pub fn prop(scene: &Scene, body: &Body, settings: &ExportSettings) -> Layer {
    let schemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI", "SemanticsLabelsAPI:class"];
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
    root.add(visual(body));
    let mut colliders = Prim::new("Xform", "colliders");
    for (k, hull) in body.hulls.iter().enumerate() {
        colliders.add(collider(&body.name, k, hull));
    }
    root.add(colliders);
    root.add(looks(body));
    Layer { custom_data: custom_data(scene, body, settings), root }
}

fn custom_data(scene: &Scene, body: &Body, settings: &ExportSettings) -> Dictionary {
    let instance = scene.instances.iter().find(|instance| instance.name.as_str() == body.name);
    let licence = instance.map_or(settings.licence.as_str(), |instance| &instance.provenance.licence);
    // SimReady wants these twice, inside its own dictionary and beside it.
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
        .with("rigid_body_count", Value::Int(1))
        .with("asset_extents", Value::Float3(body.visual.size_m().as_vec3().to_array()))
        .with("mass", Value::Double(body.mass.mass_kg));
    with_identity(Dictionary::default().with_dictionary("SimReady_Metadata", metadata))
        .with("label", Value::string(&body.label))
        .with("scene", Value::string(&scene.id))
}

fn visual(body: &Body) -> Prim {
    let mesh = &body.visual;
    let (points, point_of_vertex) = welded(mesh);
    let mut prim = Prim::new("Mesh", "visual").with_schemas(&["MaterialBindingAPI"]);
    prim.relate("material:binding", Path::prim(&[&body.name, LOOKS, &mesh.materials[0].name]));
    prim.set_uniform("orientation", Value::token("rightHanded"));
    prim.set_uniform("subdivisionScheme", Value::token("none"));
    set_points(&mut prim, points);
    let corners = || mesh.triangles().flatten();
    set_faces(&mut prim, mesh.triangle_count(), corners().map(|v| point_of_vertex[v as usize]));
    let normals = corners().map(|v| mesh.normals[v as usize].to_array().map(direction)).collect();
    prim.set_interpolated("normals", Value::Normal3fs(normals), Interpolation::FaceVarying);
    let (uvs, uv_of_vertex) = distinct_uvs(mesh);
    prim.set_interpolated("primvars:st", Value::TexCoord2fs(uvs), Interpolation::FaceVarying);
    prim.set("primvars:st:indices", indices(corners().map(|v| uv_of_vertex[v as usize])));
    if mesh.groups.len() > 1 {
        prim.set_uniform("subsetFamily:materialBind:familyType", Value::token("partition"));
        subsets(body).into_iter().for_each(|subset| prim.add(subset));
    }
    prim
}

/// The faces of each material.
fn subsets(body: &Body) -> Vec<Prim> {
    let mut first = 0;
    let mut subsets = Vec::new();
    for group in &body.visual.groups {
        let name = &body.visual.materials[group.material].name;
        let faces = first..first + group.triangles.len() as u32;
        first = faces.end;
        let mut subset =
            Prim::new("GeomSubset", &format!("faces_{name}")).with_schemas(&["MaterialBindingAPI"]);
        subset.set_uniform("elementType", Value::token("face"));
        subset.set_uniform("familyName", Value::token("materialBind"));
        subset.set("indices", indices(faces));
        subset.relate("material:binding", Path::prim(&[&body.name, LOOKS, name]));
        subsets.push(subset);
    }
    subsets
}

fn collider(body: &str, index: usize, hull: &ConvexHull) -> Prim {
    let schemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "MaterialBindingAPI"];
    let mut prim = Prim::new("Mesh", &format!("hull_{index:02}")).with_schemas(&schemas);
    prim.set_uniform("purpose", Value::token("guide"));
    prim.set("physics:collisionEnabled", Value::Bool(true));
    prim.set_uniform("physics:approximation", Value::token("convexHull"));
    prim.relate("material:binding:physics", Path::prim(&[body, LOOKS, PHYSICS_MATERIAL]));
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

/// Points and the box they fill. The box is taken from the very numbers that are written.
fn set_points(prim: &mut Prim, points: Vec<[f32; 3]>) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for point in &points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    prim.set("extent", Value::Float3s(vec![low, high]));
    prim.set("points", Value::Point3fs(points));
}

fn set_faces(prim: &mut Prim, count: usize, point_indices: impl Iterator<Item = u32>) {
    prim.set("faceVertexCounts", Value::Ints(vec![3; count]));
    prim.set("faceVertexIndices", indices(point_indices));
}

/// USD counts with signs.
fn indices(indices: impl Iterator<Item = u32>) -> Value {
    Value::Ints(indices.map(|index| index as i32).collect())
}

/// Distinct positions in order of first appearance in a triangle, and each vertex's number among them.
fn welded(mesh: &TexturedMesh) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut known = BTreeMap::new();
    let mut points = Vec::new();
    let mut point_of_vertex = vec![0; mesh.positions.len()];
    for v in mesh.triangles().flatten() {
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
fn distinct_uvs(mesh: &TexturedMesh) -> (Vec<[f32; 2]>, Vec<u32>) {
    let mut known = BTreeMap::new();
    let mut uvs = Vec::new();
    let mut uv_of_vertex = vec![0; mesh.uvs.len()];
    for v in mesh.triangles().flatten() {
        let uv = mesh.uvs[v as usize].to_array().map(direction);
        let index = *known.entry(uv.map(f32::to_bits)).or_insert_with(|| {
            uvs.push(uv);
            uvs.len() as u32 - 1
        });
        uv_of_vertex[v as usize] = index;
    }
    (uvs, uv_of_vertex)
}
