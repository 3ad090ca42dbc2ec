//! Catalog mesh of a recognized object, in the colors of its image.
//!
//! Each visible part takes the mean color of the brighter half of its pixels, so that hidden surfaces match the visible
//! ones. Where a part has a print, its faces toward the camera take the image itself; only its hidden sides keep the
//! print of the catalog. Hidden parts keep the catalog's colors.

use std::sync::Arc;

use glam::DVec2;

use super::texture::Projection;
use catalog::Recipe;
use geometry::polygon::convex_hull_2d;
use geometry::{Camera, FaceGroup, Material, Pose, Rgb, TexturedMesh};
use imaging::Texture;
use imaging::srgb::{LINEAR_OF_SRGB, encode_srgb};
use ports::Completion;
use render::{RenderObject, View, render_geometry};
use scene::{CategoryStance, RecognizedObject};

/// Minimum number of pixels of a part that takes their color, and their minimum share of all.
const MIN_PX: usize = 12;
const MIN_SHARE: f64 = 0.004;

/// Name of the material that shows the image.
pub(super) const IMAGE_MATERIAL: &str = "image";

/// The mesh of the category in its recognized stance, canonical frame; `None` for an object without a category.
pub(super) fn as_category(object: &RecognizedObject) -> Option<(Arc<TexturedMesh>, &CategoryStance)> {
    let stance = object.seen_like.as_ref()?;
    let recipe = Recipe {
        category: object.category.clone(),
        size_m: stance.size_m,
        color: object.color,
        material: object.material.clone(),
        seed: stance.variant,
    };
    Some((catalog::build_cached(&recipe)?, stance))
}

/// Footprint on the table as if it stood there, counter-clockwise, meters.
pub(super) fn footprint(object: &RecognizedObject) -> Option<Vec<DVec2>> {
    let (mesh, stance) = as_category(object)?;
    let pose = Pose::upright(stance.center.extend(0.0), stance.yaw_rad);
    let points: Vec<DVec2> = mesh.positions.iter().map(|p| pose.transform_point(*p).truncate()).collect();
    Some(convex_hull_2d(&points))
}

/// The mesh in the image's colors; `texture_px` is the longer side of a texture cut from the image.
pub(super) fn dressed(
    object: &RecognizedObject,
    completion: &Completion,
    camera: &Camera,
    texture_px: u32,
) -> Option<TexturedMesh> {
    let (mesh, stance) = as_category(object)?;
    let pose = Pose::upright(stance.center.extend(0.0), stance.yaw_rad);
    let mut mesh = (*mesh).clone();
    let shown = part_colors(&mesh, &pose, completion, camera);
    for (material, color) in &shown {
        let material = &mut mesh.materials[*material];
        let worn = material.base_color_texture.as_ref().map_or([1.0; 3], |texture| {
            let [r, g, b, _] = texture.halved().last().unwrap_or(texture).pixel(0, 0);
            [r, g, b].map(|level| LINEAR_OF_SRGB[usize::from(level)])
        });
        let level = |k: usize| f32::from(encode_srgb((color[k] / worn[k].max(0.02)).min(1.0))) / 255.0;
        material.base_color = Rgb([level(0), level(1), level(2)]);
    }
    let is_print = |material: &usize| {
        let material = &mesh.materials[*material];
        // Textures with a relief are grain, which repeats.
        material.base_color_texture.is_some() && material.relief == 0.0 && material.opacity >= 1.0
    };
    let printed: Vec<usize> = shown.iter().map(|(material, _)| *material).filter(is_print).collect();
    let size = mesh.size_m();
    let projection = Projection { camera, completion, world_from_solid: pose, size, texture_px };
    take_image(&mut mesh, &printed, &projection);
    Some(mesh)
}

/// Faces of these materials toward the camera take the image.
fn take_image(mesh: &mut TexturedMesh, materials: &[usize], projection: &Projection) {
    let world_from_object = projection.world_from_solid;
    let eye = world_from_object.inverse().transform_point(projection.camera.world_from_camera.translation_m);
    let mut seen = Vec::new();
    for group in mesh.groups.iter_mut().filter(|group| materials.contains(&group.material)) {
        group.triangles.retain(|triangle| {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            let is_seen = (b - a).cross(c - a).dot(eye - (a + b + c) / 3.0) > 0.0;
            if is_seen {
                seen.push(*triangle);
            }
            !is_seen
        });
    }
    if seen.is_empty() {
        return;
    }
    for corner in seen.iter_mut().flatten() {
        let (position, normal) = (mesh.positions[*corner as usize], mesh.normals[*corner as usize]);
        *corner = mesh.positions.len() as u32;
        mesh.positions.push(position);
        mesh.normals.push(normal);
        mesh.uvs.push(projection.uv(position));
    }
    mesh.groups.retain(|group| !group.triangles.is_empty());
    mesh.groups.push(FaceGroup { material: mesh.materials.len(), triangles: seen });
    mesh.materials.push(Material::textured(IMAGE_MATERIAL, Texture::new(projection.texture()), 0.6));
}

/// Materials of the visible parts, each with the linear light of its pixels.
fn part_colors(
    mesh: &TexturedMesh,
    world_from_object: &Pose,
    completion: &Completion,
    camera: &Camera,
) -> Vec<(usize, [f32; 3])> {
    let parts: Vec<TexturedMesh> = mesh
        .groups
        .iter()
        .map(|group| TexturedMesh { groups: vec![group.clone()], ..mesh.clone() })
        .collect();
    let objects: Vec<RenderObject> = parts
        .iter()
        .zip(1_u32..)
        .map(|(mesh, id)| RenderObject { mesh, world_from_object: *world_from_object, id })
        .collect();
    let Some([left, top, right, bottom]) = completion.silhouette.bbox_px() else { return Vec::new() };
    let size = [right - left, bottom - top];
    let seen = render_geometry(&objects, &View::Perspective(*camera).window([left, top], size));
    let image = &completion.image;
    let [x0, y0, x1, y1] = completion.crop_px;
    let own = [f64::from(image.width_px()) / (x1 - x0), f64::from(image.height_px()) / (y1 - y0)];
    let mut own_colors: Vec<Vec<[f32; 3]>> = vec![Vec::new(); parts.len()];
    for (at, id) in seen.ids.iter().enumerate().filter(|(_, id)| **id > 0) {
        let (x, y) = (left + at as u32 % size[0], top + at as u32 / size[0]);
        let (u, v) = ((f64::from(x) + 0.5 - x0) * own[0], (f64::from(y) + 0.5 - y0) * own[1]);
        let inside =
            u >= 0.0 && v >= 0.0 && u < f64::from(image.width_px()) && v < f64::from(image.height_px());
        if !inside || !completion.silhouette.contains(x, y) {
            continue;
        }
        let [r, g, b, opacity] = image.pixel(u as u32, v as u32);
        if opacity >= 128 {
            own_colors[*id as usize - 1].push([r, g, b].map(|level| LINEAR_OF_SRGB[usize::from(level)]));
        }
    }
    let all: usize = own_colors.iter().map(Vec::len).sum();
    let lowest = MIN_PX.max((MIN_SHARE * all as f64) as usize);
    let shown = mesh.groups.iter().zip(own_colors).filter(|(_, colors)| colors.len() >= lowest);
    shown.map(|(group, colors)| (group.material, lit(colors))).collect()
}

/// Mean of the brighter half without the brightest pixels, linear light: shadows, insides of bowls and highlights
/// do not show the color of the part. Never empty.
fn lit(mut colors: Vec<[f32; 3]>) -> [f32; 3] {
    colors.sort_by(|a, b| a.iter().sum::<f32>().total_cmp(&b.iter().sum()));
    let from = colors.len() / 2;
    let to = (19 * colors.len() / 20).max(from + 1);
    let half = &colors[from..to];
    std::array::from_fn(|k| half.iter().map(|color| color[k]).sum::<f32>() / half.len() as f32)
}
