//! One body as a USD prop: rigid body on the root, a visual mesh, one collider mesh per hull.
//!
//! Points of the visual mesh are welded by position, so its topology is closed where the surface is;
//! normals and texture coordinates are per face corner.

use std::collections::BTreeMap;

use crate::export::number::push_direction;
use crate::export::{Body, ExportSettings};
use crate::geometry::{ConvexHull, TexturedMesh};
use crate::scene::Scene;

use super::layer::{Layer, push_tuple, push_tuple_f32, quoted, tuple};
use super::look::{PHYSICS_MATERIAL, write_looks};

/// The text of `<name>.usda`.
pub fn write_prop(scene: &Scene, body: &Body, settings: &ExportSettings) -> String {
    let mut layer = Layer::new(&body.name, |layer| write_metadata(layer, scene, body, settings));
    let metadata = [
        "prepend apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\", \"SemanticsLabelsAPI:class\"]"
            .to_owned(),
        format!("assetInfo = {{ string name = {} }}", quoted(&body.name)),
        format!("displayName = {}", quoted(&body.label)),
        "kind = \"component\"".to_owned(),
    ];
    let metadata: Vec<&str> = metadata.iter().map(String::as_str).collect();
    layer.prim("Xform", &body.name, &metadata, |layer| {
        let mass = &body.mass;
        let axes = mass.principal_axes_xyzw.normalize();
        let in_f32 = |values: &[f64]| {
            let mut text = String::new();
            push_tuple_f32(&mut text, &values.iter().map(|value| *value as f32).collect::<Vec<_>>());
            text
        };
        layer.line(&format!("point3f physics:centerOfMass = {}", in_f32(&mass.center_of_mass_m.to_array())));
        let inertia = in_f32(&mass.inertia_diagonal_kg_m2.to_array());
        layer.line(&format!("float3 physics:diagonalInertia = {inertia}"));
        layer.line(&format!("float physics:mass = {}", mass.mass_kg as f32));
        layer.line(&format!("quatf physics:principalAxes = {}", in_f32(&[axes.w, axes.x, axes.y, axes.z])));
        layer.line("bool physics:rigidBodyEnabled = 1");
        layer.line(&format!("token[] semantics:labels:class = [{}]", quoted(&body.category)));
        write_visual(layer, body);
        layer.prim("Xform", "colliders", &[], |layer| {
            for (k, hull) in body.hulls.iter().enumerate() {
                write_hull(layer, &body.name, k, hull);
            }
        });
        write_looks(layer, body);
    });
    layer.finish()
}

fn write_metadata(layer: &mut Layer, scene: &Scene, body: &Body, settings: &ExportSettings) {
    let instance = scene.instances.iter().find(|instance| instance.name.as_str() == body.name);
    let licence = instance.map_or(settings.licence.as_str(), |instance| &instance.provenance.licence);
    let identity = |layer: &mut Layer| {
        layer.line(&format!("string asset_name = {}", quoted(&body.name)));
        layer.line("string asset_type = \"prop\"");
        layer.line("string source_file = \"scene.json\"");
        layer.line(&format!("string usd_date_generated = {}", quoted(&settings.date)));
    };
    layer.block("customLayerData", |layer| {
        layer.block("dictionary SimReady_Metadata", |layer| {
            layer.line(&format!("string author = {}", quoted(&settings.author)));
            identity(layer);
            layer.line(&format!("string asset_license = {}", quoted(licence)));
            layer.line(&format!("string category = {}", quoted(&body.category)));
            layer.line("int rigid_body_count = 1");
            layer.line(&format!("float3 asset_extents = {}", tuple(&body.visual.size_m().to_array())));
            layer.line(&format!("double mass = {}", body.mass.mass_kg));
        });
        identity(layer);
        layer.line(&format!("string label = {}", quoted(&body.label)));
        layer.line(&format!("string scene = {}", quoted(&scene.id)));
    });
}

fn write_visual(layer: &mut Layer, body: &Body) {
    let mesh = &body.visual;
    let (points, point_of_vertex) = welded(mesh);
    let looks = format!("/{}/Looks", body.name);
    let metadata = ["prepend apiSchemas = [\"MaterialBindingAPI\"]"];
    layer.prim("Mesh", "visual", &metadata, |layer| {
        layer.line(&format!("rel material:binding = <{looks}/{}>", mesh.materials[0].name));
        layer.line("uniform token orientation = \"rightHanded\"");
        layer.line("uniform token subdivisionScheme = \"none\"");
        write_points(layer, &points);
        let corners = || mesh.triangles().flatten();
        let point_indices = corners().map(|v| point_of_vertex[v as usize]);
        write_faces(layer, mesh.triangle_count(), point_indices);
        let face_varying = " (\n            interpolation = \"faceVarying\"\n        )";
        let normals = corners().map(|v| mesh.normals[v as usize].to_array());
        let push_normal = |text: &mut String, normal: [f32; 3]| {
            push_tuple(text, &normal, |text, value| push_direction(text, *value));
        };
        layer.array("normal3f[] normals", normals, push_normal, face_varying);
        let push_uv = |text: &mut String, uv: [f32; 2]| {
            push_tuple(text, &uv, |text, value| push_direction(text, *value));
        };
        let (uvs, uv_of_vertex) = distinct_uvs(mesh);
        layer.array("texCoord2f[] primvars:st", uvs, push_uv, face_varying);
        let uv_indices = corners().map(|v| uv_of_vertex[v as usize]);
        layer.array("int[] primvars:st:indices", uv_indices, |text, k| text.push_str(&k.to_string()), "");
        if mesh.groups.len() > 1 {
            layer.line("uniform token subsetFamily:materialBind:familyType = \"partition\"");
            write_subsets(layer, mesh, &looks);
        }
    });
}

fn write_subsets(layer: &mut Layer, mesh: &TexturedMesh, looks: &str) {
    let mut first = 0;
    for group in &mesh.groups {
        let name = &mesh.materials[group.material].name;
        let faces = first..first + group.triangles.len();
        first = faces.end;
        let metadata = ["prepend apiSchemas = [\"MaterialBindingAPI\"]"];
        layer.prim("GeomSubset", &format!("faces_{name}"), &metadata, |layer| {
            layer.line("uniform token elementType = \"face\"");
            layer.line("uniform token familyName = \"materialBind\"");
            layer.array("int[] indices", faces, |text, k| text.push_str(&k.to_string()), "");
            layer.line(&format!("rel material:binding = <{looks}/{name}>"));
        });
    }
}

fn write_hull(layer: &mut Layer, body: &str, index: usize, hull: &ConvexHull) {
    let schemas = "prepend apiSchemas = [\"PhysicsCollisionAPI\", \"PhysicsMeshCollisionAPI\", \
                   \"MaterialBindingAPI\"]";
    layer.prim("Mesh", &format!("hull_{index:02}"), &[schemas], |layer| {
        layer.line("uniform token purpose = \"guide\"");
        layer.line("bool physics:collisionEnabled = 1");
        layer.line("uniform token physics:approximation = \"convexHull\"");
        layer.line(&format!("rel material:binding:physics = </{body}/Looks/{PHYSICS_MATERIAL}>"));
        layer.line("uniform token orientation = \"rightHanded\"");
        layer.line("uniform token subdivisionScheme = \"none\"");
        let points: Vec<[f32; 3]> = hull.points.iter().map(|p| p.as_vec3().to_array()).collect();
        write_points(layer, &points);
        write_faces(layer, hull.triangles.len(), hull.triangles.iter().flatten().copied());
        let normals = hull.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| hull.points[v as usize]);
            (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array()
        });
        let push_normal = |text: &mut String, normal: [f32; 3]| {
            push_tuple(text, &normal, |text, value| push_direction(text, *value));
        };
        let uniform = " (\n            interpolation = \"uniform\"\n        )";
        layer.array("normal3f[] normals", normals, push_normal, uniform);
    });
}

/// Points and the box they fill. The box is taken from the very numbers that are printed.
fn write_points(layer: &mut Layer, points: &[[f32; 3]]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let push = |text: &mut String, point: [f32; 3]| push_tuple_f32(text, &point);
    layer.array("float3[] extent", [low, high], push, "");
    layer.array("point3f[] points", points.iter().copied(), push, "");
}

fn write_faces(layer: &mut Layer, count: usize, indices: impl Iterator<Item = u32>) {
    layer.array(
        "int[] faceVertexCounts",
        std::iter::repeat_n(3, count),
        |text, k: i32| text.push_str(&k.to_string()),
        "",
    );
    layer.array("int[] faceVertexIndices", indices, |text, k| text.push_str(&k.to_string()), "");
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
        let uv = mesh.uvs[v as usize].to_array();
        let index = *known.entry(uv.map(f32::to_bits)).or_insert_with(|| {
            uvs.push(uv);
            uvs.len() as u32 - 1
        });
        uv_of_vertex[v as usize] = index;
    }
    (uvs, uv_of_vertex)
}
