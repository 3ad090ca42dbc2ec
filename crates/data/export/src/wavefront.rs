//! Wavefront OBJ and MTL: visual meshes of URDF, SDF and MJCF, one file per material, and hulls.
//!
//! Frame and units are those of the mesh (z up, meters). Texture coordinate v increases upward, as in OBJ.

use std::fmt::Write;

use geometry::{ConvexHull, FaceGroup, Material, TexturedMesh};

use super::number::{push_direction, push_f32};
use super::{Body, BundleFile};

/// The geometry of a body as OBJ text and its textures as PNG, shared by the formats that reference them.
pub struct Wavefront {
    /// One entry per group of the visual mesh.
    visuals: Vec<GroupObj>,
    hulls: Vec<String>,
    library: String,
    /// PNG bytes by material; `None` for a material without texture.
    textures: Vec<Option<Vec<u8>>>,
}

/// The faces of one group, and the vertices they use.
struct GroupObj {
    vertices: String,
    faces: String,
}

impl Wavefront {
    pub fn of(body: &Body) -> Self {
        let visual = &body.visual;
        let texture =
            |material: &Material| material.base_color_texture.as_ref().map(|texture| texture.png().to_vec());
        Self {
            visuals: visual.groups.iter().map(|group| group_obj(visual, group)).collect(),
            hulls: body.hulls.iter().map(hull_obj).collect(),
            library: mtl(&visual.materials),
            textures: visual.materials.iter().map(texture).collect(),
        }
    }

    /// The faces of one group without a material.
    pub fn plain_visual(&self, group: usize) -> String {
        let GroupObj { vertices, faces } = &self.visuals[group];
        [vertices.as_str(), faces].concat()
    }

    /// Corners and faces of a hull.
    pub fn hull(&self, k: usize) -> &str {
        &self.hulls[k]
    }

    /// PNG of a material's texture.
    pub fn texture(&self, material: usize) -> Option<&[u8]> {
        self.textures[material].as_deref()
    }

    /// The files of a body below its folder: visual meshes, material libraries, textures and the hulls of these
    /// numbers. Their roles begin with `format`.
    pub fn files(
        &self,
        body: &Body,
        folder: &str,
        format: &str,
        hulls: impl Iterator<Item = usize>,
    ) -> Vec<BundleFile> {
        let role = |part: &str| format!("{format}_{part}");
        let materials = &body.visual.materials;
        let library = format!("{}.mtl", body.name);
        let mut files = Vec::with_capacity(self.visuals.len() + self.hulls.len() + materials.len() + 1);
        for (k, (group, obj)) in body.visual.groups.iter().zip(&self.visuals).enumerate() {
            let material = &materials[group.material].name;
            let GroupObj { vertices, faces } = obj;
            let text = format!("mtllib {library}\n{vertices}usemtl {material}\n{faces}");
            let path = format!("{folder}/{}", visual_file(k));
            files.push(BundleFile::text(path, text, &role("visual"), "model/obj"));
        }
        let text = self.library.clone();
        files.push(BundleFile::text(format!("{folder}/{library}"), text, &role("materials"), "model/mtl"));
        for (material, texture) in materials.iter().zip(&self.textures) {
            if let Some(png) = texture {
                let path = format!("{folder}/{}", texture_file(material));
                files.push(BundleFile::png(path, png.clone(), &role("texture")));
            }
        }
        for k in hulls {
            let path = format!("{folder}/{}", hull_file(k));
            files.push(BundleFile::text(path, self.hulls[k].clone(), &role("hull"), "model/obj"));
        }
        files
    }
}

/// Name of the file with the visual mesh's k-th group.
pub fn visual_file(k: usize) -> String {
    format!("visual_{k:02}.obj")
}

/// Name of the file with the k-th hull.
pub fn hull_file(k: usize) -> String {
    format!("hull_{k:02}.obj")
}

fn texture_file(material: &Material) -> String {
    format!("{}.png", material.name)
}

fn group_obj(mesh: &TexturedMesh, group: &FaceGroup) -> GroupObj {
    // Indices in the file start at 1; 0 marks a vertex without index.
    let mut numbers = vec![0_usize; mesh.positions.len()];
    let mut order = Vec::new();
    for &v in group.triangles.as_flattened() {
        if numbers[v as usize] == 0 {
            order.push(v as usize);
            numbers[v as usize] = order.len();
        }
    }
    let mut vertices = String::with_capacity(order.len() * 80);
    for &v in &order {
        push_row(&mut vertices, "v", &mesh.positions[v].as_vec3().to_array(), push_f32);
    }
    for &v in &order {
        push_row(&mut vertices, "vt", &mesh.uvs[v].to_array(), push_direction);
    }
    for &v in &order {
        push_row(&mut vertices, "vn", &mesh.normals[v].to_array(), push_direction);
    }
    let mut faces = String::with_capacity(group.triangles.len() * 40);
    for t in &group.triangles {
        let [a, b, c] = t.map(|v| numbers[v as usize]);
        writeln!(faces, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").expect("writing to a string cannot fail");
    }
    GroupObj { vertices, faces }
}

/// Corners and faces of a hull.
fn hull_obj(hull: &ConvexHull) -> String {
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

/// Material library.
fn mtl(materials: &[Material]) -> String {
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
