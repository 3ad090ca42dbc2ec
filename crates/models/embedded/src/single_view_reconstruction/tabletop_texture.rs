//! Texture of a tabletop from a photograph: the image rectified onto the plane of the top. Where the top is covered, it
//! is filled in from what shows of it. The light of the image stays in the texture, as on objects.

use std::collections::HashMap;

use glam::{DVec2, Vec2};

use super::neighboring_texture;
use super::top_view::{mask_of, rectified, view_of};
use catalog::BuiltTable;
use geometry::{FaceGroup, Material, Outline, TexturedMesh};
use imaging::distance_transform::distance_transform;
use imaging::{Image, Texture};
use ports::TablePhotograph;
use render::TopView;
use runtime::{CancelFlag, Cancelled};

/// Name of the material that shows the image.
const MATERIAL: &str = "tabletop_photograph";
/// The top keeps the catalog's finish where less of it shows, as a share of its area.
const MIN_SHOWN: f64 = 0.15;
/// Strip along the edge of the top that may show what is beside it, as a share of the top's shorter side.
const UNSURE_EDGE: f64 = 0.02;
/// Surroundings of objects that are mixed with them or lie in their contact shadow, a share of the image's longer side.
const UNSURE_RIM: f32 = 0.006;
/// Largest distance of the top's faces from its plane, meters.
const FLATNESS_M: f64 = 1e-4;
/// Roughness of the photographed surface: that of sealed wood.
const ROUGHNESS: f32 = 0.55;

/// The table with the photographed top; `None` where too little of the top shows. `longer_px` is the longer side of the
/// texture.
pub(crate) fn with_photographed_top(
    built: &BuiltTable,
    photograph: &TablePhotograph,
    longer_px: u32,
    cancel: &CancelFlag,
) -> Result<Option<TexturedMesh>, Cancelled> {
    let view = view_of(&built.outline_m, 0.0, longer_px);
    let Some(texture) = texture(&built.outline_m, photograph, &view, cancel)? else { return Ok(None) };
    let material = Material::textured(MATERIAL, Texture::new(texture), ROUGHNESS);
    Ok(Some(with_material_on_top(&built.mesh, &material, &built.outline_m)))
}

/// The rectified image, with everything else than the bare top filled in.
fn texture(
    outline: &Outline,
    photograph: &TablePhotograph,
    view: &TopView,
    cancel: &CancelFlag,
) -> Result<Option<Image>, Cancelled> {
    let TablePhotograph { image, camera, bare_top } = photograph;
    let mut top = rectified(image, camera, view, cancel)?;
    let (width, height) = (view.width_px as usize, view.height_px as usize);
    let others: Vec<bool> = bare_top.bits().iter().map(|is_bare| !is_bare).collect();
    let to_others = distance_transform(&others, image.width_px() as usize, image.height_px() as usize);
    let rim_px = UNSURE_RIM * image.width_px().max(image.height_px()) as f32;
    let shows = |index: usize| {
        let (x, y) = (index % width, index / width);
        let p = view.world_from_pixel(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
        let Some((pixel, _)) = camera.project(p.extend(0.0)) else { return false };
        let inside = pixel.x >= 0.0
            && pixel.y >= 0.0
            && pixel.x < f64::from(image.width_px())
            && pixel.y < f64::from(image.height_px());
        inside && to_others[pixel.y as usize * image.width_px() as usize + pixel.x as usize] > rim_px
    };
    let inside = mask_of(outline, view);
    let outside: Vec<bool> = inside.bits().iter().map(|inside| !inside).collect();
    let to_outside_px = distance_transform(&outside, width, height);
    // The texture ends where the top is widest.
    let to_edge_px = |index: usize| {
        let (x, y) = (index % width, index / width);
        let to_border = (x + 1).min(width - x).min(y + 1).min(height - y);
        to_outside_px[index].min(to_border as f32)
    };
    let (low, high) = outline.bounds();
    let unsure_px = (UNSURE_EDGE * (high - low).min_element() / view.meters_per_px) as f32;
    let visible: Vec<bool> =
        (0..width * height).map(|index| to_edge_px(index) > unsure_px && shows(index)).collect();
    let shown = visible.iter().filter(|visible| **visible).count();
    if (shown as f64) < MIN_SHOWN * inside.area_px() as f64 {
        return Ok(None);
    }
    // Beyond the edge, too: mip levels mix what is beside it.
    let hidden: Vec<bool> = visible.iter().map(|visible| !visible).collect();
    for (index, [r, g, b]) in neighboring_texture::filled(&top, &visible, &hidden, cancel)? {
        let (x, y) = (index as u32 % view.width_px, index as u32 / view.width_px);
        top.set_pixel(x, y, [r, g, b, 255]);
    }
    Ok(Some(top))
}

/// The mesh, its level faces at the height of the top in that material, whose texture spans the outline's bounds.
fn with_material_on_top(mesh: &TexturedMesh, material: &Material, outline: &Outline) -> TexturedMesh {
    let (low, high) = outline.bounds();
    let is_top = |triangle: &[u32; 3]| {
        triangle
            .iter()
            .all(|v| mesh.positions[*v as usize].z.abs() < FLATNESS_M && mesh.normals[*v as usize].z > 0.9)
    };
    let (mut top, mut rest) = (part(mesh, is_top), part(mesh, |triangle| !is_top(triangle)));
    let triangles = top.triangles().collect();
    top.groups = vec![FaceGroup { material: 0, triangles }];
    top.materials = vec![material.clone()];
    for (uv, position) in top.uvs.iter_mut().zip(&top.positions) {
        let share = (position.truncate() - low) / (high - low);
        *uv = share.as_vec2().clamp(Vec2::ZERO, Vec2::ONE);
    }
    rest.append(top);
    rest
}

/// The triangles that are chosen, with their vertices alone.
fn part(mesh: &TexturedMesh, is_chosen: impl Fn(&[u32; 3]) -> bool) -> TexturedMesh {
    let mut chosen = TexturedMesh { materials: mesh.materials.clone(), ..TexturedMesh::default() };
    let mut places: HashMap<u32, u32> = HashMap::new();
    for group in &mesh.groups {
        let triangles: Vec<[u32; 3]> = group.triangles.iter().copied().filter(&is_chosen).collect();
        let vertices = triangles.iter().flatten();
        vertices.for_each(|&v| {
            places.entry(v).or_insert_with(|| {
                chosen.positions.push(mesh.positions[v as usize]);
                chosen.normals.push(mesh.normals[v as usize]);
                chosen.uvs.push(mesh.uvs[v as usize]);
                chosen.positions.len() as u32 - 1
            });
        });
        if !triangles.is_empty() {
            let triangles = triangles.into_iter().map(|triangle| triangle.map(|v| places[&v])).collect();
            chosen.groups.push(FaceGroup { material: group.material, triangles });
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use catalog::build_outlined_table;
    use geometry::Camera;
    use imaging::Mask;

    /// A camera above a table, and its image of a top of stripes that run away from it, with something on it.
    fn photograph(outline: &Outline) -> TablePhotograph {
        let camera = Camera::orbit(640, 480, 0.9, glam::DVec3::ZERO, 0.2, 0.9, 1.8);
        let mut image = Image::filled(640, 480, [10, 10, 200, 255]);
        let mut bare_top = Mask::empty(640, 480);
        for (x, y) in (0..480).flat_map(|y| (0..640).map(move |x| (x, y))) {
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some(p) = camera.meet_plane(pixel, 0.0).map(|p| p.truncate()) else { continue };
            if outline.contains(p) {
                image.set_pixel(x, y, stripe(p));
                bare_top.set(x, y, true);
            }
            if (p - DVec2::new(0.1, 0.05)).length() < 0.12 {
                image.set_pixel(x, y, [0, 220, 0, 255]);
                bare_top.set(x, y, false);
            }
        }
        TablePhotograph { image: Arc::new(image), camera, bare_top }
    }

    fn stripe(p: DVec2) -> [u8; 4] {
        if (p.x / 0.1).floor().rem_euclid(2.0) < 0.5 { [200, 150, 90, 255] } else { [120, 80, 40, 255] }
    }

    #[test]
    fn top_shows_photograph_without_what_covers_it() {
        let corners = [(-0.5, -0.3), (0.5, -0.3), (0.5, 0.3), (-0.5, 0.3)].map(|(x, y)| DVec2::new(x, y));
        let edge = Outline::new(corners.to_vec()).expect("an outline");
        let built = build_outlined_table(&edge, 0.7, 4, None, None, 1).expect("a table");
        let photograph = photograph(&built.outline_m);
        let cancel = CancelFlag::default();
        let mesh =
            with_photographed_top(&built, &photograph, 400, &cancel).expect("not stopped").expect("shows");
        assert_eq!(mesh.triangle_count(), built.mesh.triangle_count());
        let used: std::collections::BTreeSet<u32> = mesh.triangles().flatten().collect();
        assert_eq!(used.len(), mesh.positions.len(), "every vertex has a face");
        let material =
            mesh.materials.iter().position(|material| material.name == MATERIAL).expect("a photograph");
        let group = mesh.groups.iter().find(|group| group.material == material).expect("faces");
        assert!(group.triangles.iter().flatten().all(|v| mesh.positions[*v as usize].z.abs() < FLATNESS_M));
        let texture = mesh.materials[material].base_color_texture.as_ref().expect("a texture");
        let (low, high) = built.outline_m.bounds();
        // Stripes where the texture coordinates put them; green is nowhere, and blue neither.
        let (mut right, mut all) = (0, 0);
        let (width, height) = (texture.width_px(), texture.height_px());
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let [r, g, b, _] = texture.pixel(x, y);
            assert!(r > b && r >= g, "{x} {y}: {:?}", [r, g, b]);
            let share = DVec2::new(
                (f64::from(x) + 0.5) / f64::from(width),
                1.0 - (f64::from(y) + 0.5) / f64::from(height),
            );
            let want = stripe(low + share * (high - low));
            right += u32::from(r.abs_diff(want[0]) < 40);
            all += 1;
        }
        assert!(f64::from(right) > 0.85 * f64::from(all), "{right} of {all}");
    }

    #[test]
    fn top_that_hardly_shows_keeps_its_finish() {
        let corners = [(-0.5, -0.3), (0.5, -0.3), (0.5, 0.3), (-0.5, 0.3)].map(|(x, y)| DVec2::new(x, y));
        let edge = Outline::new(corners.to_vec()).expect("an outline");
        let built = build_outlined_table(&edge, 0.7, 4, None, None, 1).expect("a table");
        let mut photograph = photograph(&built.outline_m);
        photograph.bare_top = Mask::from_fn(640, 480, |x, _| x > 600);
        let made =
            with_photographed_top(&built, &photograph, 200, &CancelFlag::default()).expect("not stopped");
        assert!(made.is_none());
    }
}
