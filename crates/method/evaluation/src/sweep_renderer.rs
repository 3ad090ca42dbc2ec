//! Images of the views of a sweep, in the studio of a bundle's previews.
//!
//! Quality is that of `tabletopgen render --quality fast` ([`RenderSettings::MOTION`]): smooth edges and the shadow of
//! the key light, none of the sky. Background and light are equal in all views of all scenes, so that scores compare
//! scenes and not studios; a light that an edit gave to a scene is not used. Always on the CPU.

use imaging::Image;
use render::{Background, Lighting, RenderSettings, SceneCache, View};

use crate::sweep::{Sweep, SweepView, SweptScene, points_m};

/// Azimuth of the key light, radians: to the left of a viewer at the front edge.
const KEY_AZIMUTH_RAD: f64 = -0.7;
/// Elevation of the key light, radians.
const KEY_ELEVATION_RAD: f64 = 0.95;
/// Softness of the key light, 0..1.
const KEY_SOFTNESS: f64 = 0.6;

/// A scene ready to be rendered from every place of its sweep.
pub struct SweepRenderer<'a> {
    cache: SceneCache<'a>,
    sweep: Sweep,
    size_px: [u32; 2],
    /// Lowest point of table and objects in the world, meters.
    floor_z_m: f64,
}

impl<'a> SweepRenderer<'a> {
    /// Prepares a scene and its sweep for images of that width and height in pixels.
    pub fn new(scene: &SweptScene<'a>, sweep: Sweep, size_px: [u32; 2]) -> Self {
        let objects: Vec<_> = std::iter::once(scene.table).chain(scene.objects.iter().copied()).collect();
        let heights = objects.iter().flat_map(points_m).map(|point| point.z);
        let floor_z_m = heights.fold(f64::INFINITY, f64::min);
        Self { cache: SceneCache::new(objects, &RenderSettings::MOTION), sweep, size_px, floor_z_m }
    }

    /// The image of a view.
    pub fn image(&self, view: &SweepView) -> Image {
        let lighting = Lighting::studio(KEY_AZIMUTH_RAD, KEY_ELEVATION_RAD, KEY_SOFTNESS);
        let camera = self.sweep.camera(view, self.size_px);
        let background = Background::light_with_floor(self.floor_z_m);
        self.cache.color(lighting, background, &View::Perspective(camera))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{DVec3, Material, Pose, Rgb, TexturedMesh, shapes};

    #[test]
    fn nearer_views_show_the_object_larger() {
        let mesh = |size_m: DVec3, color: u32| {
            let mut mesh = TexturedMesh::default();
            mesh.add(shapes::block(size_m), &Material::plain("plain", Rgb::hex(color), 0.5));
            mesh
        };
        let table = (mesh(DVec3::new(0.8, 0.8, 0.02), 0xe0_e0_e0), Pose::upright(DVec3::Z * -0.02, 0.0));
        let object = (mesh(DVec3::splat(0.2), 0xc0_10_10), Pose::IDENTITY);
        let meshes = [table, object];
        let scene = SweptScene::of(&meshes).expect("a table");
        let sweep = Sweep::around(&scene).expect("a sweep");
        let renderer = SweepRenderer::new(&scene, sweep, [96, 64]);
        let red = |view: &SweepView| {
            let image = renderer.image(view);
            assert_eq!((image.width_px(), image.height_px()), (96, 64));
            image.as_rgba().chunks_exact(4).filter(|p| p[0] / 2 > p[1]).count()
        };
        for elevation_deg in [90, 40, 0] {
            let [near, far] = [1.0, 2.5].map(|distance_radii| SweepView { elevation_deg, distance_radii });
            assert!(red(&near) > 2 * red(&far) && red(&far) > 5, "{elevation_deg} degrees");
        }
    }
}
