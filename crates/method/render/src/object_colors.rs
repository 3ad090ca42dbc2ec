//! Colors of objects at some pixels, without their backdrop, as [`SceneCache`](crate::SceneCache) renders them with one
//! sample for each pixel and no shadows. Cost: less than half of two images of 64 x 64 pixels, for both sets of colors.

use std::sync::Arc;

use super::forward::environment::Environment;
use super::forward::object_colors::shaded;
use super::forward::scene_buffers::SceneBuffers;
use super::forward::shade::Surroundings;
use super::forward::sky::OPEN_SKY;
use super::forward::surface_colors::SurfaceColors;
use super::{Background, Lighting, RenderObject, View};
use geometry::{Pose, TexturedMesh};

/// sRGB of each pixel, row by row from the top; `None` where no object shows or the pixel is not wanted.
pub type PixelColors = Vec<Option<[u8; 3]>>;

/// A mesh in its own frame with its colors and, if it has textures, the colors of the same mesh without them.
pub struct ObjectColors<'a> {
    scene_buffers: SceneBuffers<'a>,
    own: Arc<SurfaceColors<'a>>,
    plain: Option<SurfaceColors<'a>>,
}

impl<'a> ObjectColors<'a> {
    /// `plain` is the mesh without its textures: [`TexturedMesh::without_textures`].
    pub fn new(mesh: &'a TexturedMesh, plain: Option<&'a TexturedMesh>) -> Self {
        let object = |mesh| RenderObject { mesh, world_from_object: Pose::IDENTITY, id: 1 };
        let scene_buffers = SceneBuffers::new(vec![object(mesh)]);
        let own = Arc::new(SurfaceColors::new(&scene_buffers.objects));
        Self { scene_buffers, own, plain: plain.map(|plain| SurfaceColors::new(&[object(plain)])) }
    }

    /// Own and plain colors at the pixels where `is_wanted` is set, which lists all pixels of the view.
    pub fn at(
        &self,
        lighting: Lighting,
        background: Background,
        view: &View,
        is_wanted: &[bool],
    ) -> (PixelColors, Option<PixelColors>) {
        let Self { scene_buffers, own, plain } = self;
        let environment = Environment::new(scene_buffers, &OPEN_SKY, lighting, 0).in_room(background.room);
        let surroundings = Surroundings::new(scene_buffers, environment, background, own.clone());
        match plain {
            Some(plain) => {
                let [own, plain] = shaded(scene_buffers, &surroundings, [own, plain], view, is_wanted);
                (own, Some(plain))
            }
            None => {
                let [own] = shaded(scene_buffers, &surroundings, [own], view, is_wanted);
                (own, None)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{RenderSettings, SceneCache, TopView};
    use geometry::{Camera, Material, Rgb, shapes};
    use imaging::{Image, Texture};

    /// A textured ball, a plain block, and a pane of glass in front of both.
    fn mesh() -> TexturedMesh {
        let mut squares = Image::filled(32, 32, [200, 40, 30, 255]);
        (0..16).for_each(|y| (0..16).for_each(|x| squares.set_pixel(x, y, [240, 230, 90, 255])));
        let textured = Material {
            base_color_texture: Some(Texture::new(squares)),
            ..Material::plain("squares", Rgb([0.9; 3]), 0.4)
        };
        let glass = Material { opacity: 0.3, ..Material::plain("glass", Rgb::hex(0xa0f0c0), 0.1) };
        let mut mesh = TexturedMesh::default();
        mesh.add(shapes::sphere(0.06, 24), &textured);
        let steel = Material { metalness: 1.0, ..Material::plain("steel", Rgb([0.7; 3]), 0.3) };
        mesh.add(shapes::block(DVec3::splat(0.05)).translated(DVec3::new(0.08, 0.0, 0.0)), &steel);
        let pane = shapes::block(DVec3::new(0.2, 0.01, 0.03)).translated(DVec3::new(0.0, -0.12, 0.02));
        mesh.add(pane, &glass);
        mesh
    }

    #[test]
    fn object_colors_are_those_of_the_rendered_image() {
        let mesh = mesh();
        let plain = mesh.without_textures().expect("it has a texture");
        let settings =
            RenderSettings { supersampling: 1, shadow_map_px: 0, sky_directions: 0, sky_map_px: 32 };
        let (lighting, background) = (Lighting::studio(0.4, 0.9, 0.5), Background::light());
        let camera = Camera::orbit(64, 64, 0.5, DVec3::ZERO, 0.4, 0.6, 0.5);
        let (width_px, height_px, eye_z_m) = (80, 60, 0.5);
        let center_m = glam::DVec2::ZERO;
        let top = TopView { width_px, height_px, meters_per_px: 0.004, center_m, eye_z_m };
        let opaque = {
            let mut opaque = mesh.clone();
            opaque.groups.truncate(2);
            opaque
        };
        for mesh in [&mesh, &opaque] {
            let plain = TexturedMesh { groups: mesh.groups.clone(), ..plain.clone() };
            for view in [View::Perspective(camera), View::Orthographic(top)] {
                let pixels = (view.width_px() * view.height_px()) as usize;
                let is_wanted: Vec<bool> = (0..pixels).map(|k| k > pixels / 3 && k % 7 != 0).collect();
                let (own, bare) =
                    ObjectColors::new(mesh, Some(&plain)).at(lighting, background, &view, &is_wanted);
                let alone = ObjectColors::new(mesh, None).at(lighting, background, &view, &is_wanted);
                assert_eq!(alone, (own.clone(), None));
                for (mesh, found) in [(mesh, own), (&plain, bare.expect("two sets"))] {
                    let object = RenderObject { mesh, world_from_object: Pose::IDENTITY, id: 1 };
                    let frame = SceneCache::new(vec![object], &settings).render(lighting, background, &view);
                    assert!(frame.ids.contains(&0) && frame.ids.contains(&1));
                    let rgba = frame.color.as_rgba().chunks_exact(4);
                    let expected: PixelColors = rgba
                        .zip(&frame.ids)
                        .zip(&is_wanted)
                        .map(|((p, id), wanted)| (*id == 1 && *wanted).then(|| [p[0], p[1], p[2]]))
                        .collect();
                    assert_eq!(found, expected, "{view:?}");
                }
            }
        }
    }
}
