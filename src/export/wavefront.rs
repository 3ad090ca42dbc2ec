//! Wavefront OBJ and MTL: visual meshes of URDF and MJCF, one file per material, and hulls.
//!
//! Frame and units of the mesh as authored (z up, meters). v grows upward in the picture, as OBJ has it.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::geometry::{ConvexHull, FaceGroup, Material, TexturedMesh};

use super::number::{push_direction, push_f32};

/// The faces of one group with the vertices they use; `library` is the MTL file's name, if any.
pub fn group_obj(mesh: &TexturedMesh, group: &FaceGroup, library: Option<&str>) -> String {
    let mut vertices = BTreeMap::new();
    let mut order = Vec::new();
    for &v in group.triangles.as_flattened() {
        vertices.entry(v).or_insert_with(|| {
            order.push(v as usize);
            order.len()
        });
    }
    let mut text = String::with_capacity(order.len() * 80 + group.triangles.len() * 30);
    let name = &mesh.materials[group.material].name;
    if let Some(library) = library {
        writeln!(text, "mtllib {library}").expect("writing to a string cannot fail");
    }
    for &v in &order {
        push_row(&mut text, "v", &mesh.positions[v].as_vec3().to_array(), push_f32);
    }
    for &v in &order {
        push_row(&mut text, "vt", &mesh.uvs[v].to_array(), push_direction);
    }
    for &v in &order {
        push_row(&mut text, "vn", &mesh.normals[v].to_array(), push_direction);
    }
    if library.is_some() {
        writeln!(text, "usemtl {name}").expect("writing to a string cannot fail");
    }
    for t in &group.triangles {
        let [a, b, c] = t.map(|v| vertices[&v]);
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").expect("writing to a string cannot fail");
    }
    text
}

/// Corners and faces of a hull.
pub fn hull_obj(hull: &ConvexHull) -> String {
    let mut text = String::new();
    for point in &hull.points {
        push_row(&mut text, "v", &point.as_vec3().to_array(), push_f32);
    }
    for t in &hull.triangles {
        let [a, b, c] = t.map(|v| v + 1);
        writeln!(text, "f {a} {b} {c}").expect("writing to a string cannot fail");
    }
    text
}

/// Material library; `texture_file` names the picture of a material that has one.
pub fn mtl(materials: &[Material], texture_file: impl Fn(&Material) -> String) -> String {
    let mut text = String::new();
    for material in materials {
        let [r, g, b] = material.base_color.0;
        let shininess = (1.0 - material.roughness) * 200.0;
        let specular = 0.04 + 0.6 * material.metalness;
        writeln!(
            text,
            "newmtl {}\nKa 0 0 0\nKd {r} {g} {b}\nKs {specular} {specular} {specular}\nNs {shininess}\nd {}\nillum 2",
            material.name, material.opacity
        )
        .expect("writing to a string cannot fail");
        if material.base_color_texture.is_some() {
            writeln!(text, "map_Kd {}", texture_file(material)).expect("writing to a string cannot fail");
        }
        text.push('\n');
    }
    text
}

fn push_row(text: &mut String, key: &str, values: &[f32], push: fn(&mut String, f32)) {
    text.push_str(key);
    for &value in values {
        text.push(' ');
        push(text, value);
    }
    text.push('\n');
}
