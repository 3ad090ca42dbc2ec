//! The view-independent buffer of the kernels, uploaded once.
//!
//! It holds vertices (point, normal and texture position, world frame), triangles, shading materials, textures with
//! their mipmaps, the sky's occlusion maps, and two tables: linear light of sRGB bytes and the sampling pattern of
//! penumbras. Layouts are those of scene.wgsl and the files that read them.

use glam::Mat3A;

use super::words::Words;
use crate::forward::light_map;
use crate::forward::scene_buffers::{SceneBuffers, TriangleFilter};
use crate::forward::shade::object_from_world;
use crate::forward::shading_materials::ShadingMaterials;
use crate::forward::sky::Sky;
use imaging::srgb::LINEAR_OF_SRGB;

/// Offsets and lengths of the lists in the buffer.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneLayout {
    pub triangles: u32,
    pub triangles_at: u32,
    pub materials_at: u32,
    pub sky: SkyLayout,
    pub sky_of_rooms: SkyLayout,
    pub disks_at: u32,
    pub linear_of_srgb_at: u32,
    pub has_glass: bool,
}

/// Directions of a sky.
#[derive(Clone, Copy, Debug, Default)]
pub struct SkyLayout {
    pub directions: u32,
    pub directions_at: u32,
}

const ONE_SIDED: u32 = 1;
const TRANSPARENT: u32 = 2;

/// The buffer's content.
pub fn scene_words(
    scene_buffers: &SceneBuffers,
    sky: &Sky,
    sky_of_rooms: Option<&Sky>,
) -> (Words, SceneLayout) {
    let mut words = Words::default();
    let mut layout =
        SceneLayout { triangles: scene_buffers.triangles.len() as u32, ..SceneLayout::default() };
    for (object, first) in scene_buffers.objects.iter().zip(&scene_buffers.first_vertex) {
        let world_from_object = Mat3A::from_quat(object.world_from_object.rotation.as_quat());
        let mesh = object.mesh;
        for (k, (normal, uv)) in mesh.normals.iter().zip(&mesh.uvs).enumerate() {
            let point = scene_buffers.points_in_world[*first as usize + k];
            let normal = world_from_object * *normal;
            words.push_floats([point.x, point.y, point.z, normal.x, normal.y, normal.z, uv.x, uv.y]);
        }
    }
    let materials = ShadingMaterials::new(&scene_buffers.objects);
    let mut flags = vec![0; scene_buffers.triangles.len()];
    let glass = scene_buffers.drawn(TriangleFilter::Transparent, &scene_buffers.all());
    (0..glass.len()).for_each(|place| flags[glass.at(place) as usize] |= TRANSPARENT);
    layout.has_glass = glass.len() > 0;
    layout.triangles_at = words.count();
    for ((triangle, facing), flags) in scene_buffers.triangles.iter().zip(scene_buffers.facings()).zip(flags)
    {
        let one_sided = if triangle.one_sided { ONE_SIDED } else { 0 };
        words.push(triangle.vertices.into_iter().chain([flags | one_sided]));
        words.push_floats(facing.to_array());
        words.push([materials.number(triangle.object as usize, triangle.material as usize) as u32]);
    }
    // Textures precede materials, which hold their offsets; the level list follows each texture's images.
    let textures: Vec<u32> =
        materials.textures.iter().map(|texture| push_texture(&mut words, texture)).collect();
    layout.materials_at = words.count();
    for (index, object) in scene_buffers.objects.iter().enumerate() {
        for material in materials.of_object(index) {
            words.push_vector(material.base_color, material.roughness);
            words.push_floats([material.metalness, material.opacity]);
            words.push([material.texture.map_or(0, |texture| textures[texture]), object.id]);
            words.push_rows(object_from_world(object));
            words.push_floats([material.relief]);
        }
    }
    layout.disks_at = words.count();
    words.push_floats(light_map::sampling_patterns());
    layout.linear_of_srgb_at = words.count();
    words.push_floats(LINEAR_OF_SRGB.iter().copied());
    layout.sky = push_sky(&mut words, sky);
    layout.sky_of_rooms = sky_of_rooms.map_or(layout.sky, |sky| push_sky(&mut words, sky));
    (words, layout)
}

/// Full-size area in texels, number of levels, and of each level its first texel, width and height: where that lies.
/// Never 0, since vertices come first.
fn push_texture(words: &mut Words, texture: &imaging::Texture) -> u32 {
    let levels: Vec<_> = std::iter::once(&**texture).chain(texture.halved()).collect();
    let mut table = Vec::with_capacity(3 * levels.len());
    for level in &levels {
        table.extend([words.count(), level.width_px(), level.height_px()]);
        words.push_texels(level.as_rgba());
    }
    let at = words.count();
    words.push_floats([(levels[0].width_px() * levels[0].height_px()) as f32]);
    words.push([levels.len() as u32]);
    words.push(table);
    at
}

/// Of each direction 20 words; the maps' keys before them.
fn push_sky(words: &mut Words, sky: &Sky) -> SkyLayout {
    let maps: Vec<_> = sky.maps().collect();
    let keys_at: Vec<u32> = maps
        .iter()
        .map(|map| {
            let at = words.count();
            words.push_keys(map.keys);
            at
        })
        .collect();
    let (directions_at, directions) = (words.count(), maps.len() as u32);
    for (map, keys_at) in maps.iter().zip(keys_at) {
        words.push_vector(map.toward, map.texel_m);
        words.push_rows(map.texel_from_world);
        words.push([map.width as u32, map.height as u32, keys_at, 0]);
    }
    SkyLayout { directions, directions_at }
}
