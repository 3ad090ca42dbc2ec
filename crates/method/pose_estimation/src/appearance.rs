//! Color agreement of a posed mesh with the image.
//!
//! The mesh is rendered small under a plain studio light with the camera's own intrinsics, cropped like the image. The
//! two are compared over the pixels both have, by the correlation of their colors and by that of their lines
//! ([`structure`]). Brightness and contrast drop out of the color correlation, so exposure and white balance do not
//! matter. The line correlation holds when a generator renders a white book green. The comparison tells a front from a
//! back with the same outline; it is too coarse to refine an angle.

pub mod descriptor;
mod structure;

use glam::{DVec2, Vec3};

use structure::Structure;

use super::yaw::comparison::Comparison;
use super::yaw::crop::Crop;
use geometry::{Camera, Pose, TexturedMesh};
use imaging::Image;
use render::{
    Background, Lighting, ObjectColors, PixelColors, RenderObject, RenderSettings, SceneCache, View,
};

/// Side of the compared images, pixels.
pub const SIDE_PX: usize = 64;

/// Share of the lines in the likeness, 0..1; the rest is the colors'. Measured on ten objects of each of nine kinds:
/// with meshes whose colors and textures differ from the image's, 28 yaws were wrong instead of 41 with colors alone;
/// with equal colors as many were right.
const STRUCTURE_SHARE: f64 = 0.8;

/// Share of the untextured mesh in the explained variance of the image, 0..1: a generated cover without counterpart in
/// the image outweighs neither a book's spine nor a mug's handle. On 256 single objects with other textures 30 yaws
/// were wrong, instead of 37 at 0 and 38 at 1, with the disagreements themselves weighted in this way. With the
/// explained variance weighted instead as many of 120 are wrong, except for stacks of paper, whose bare shape carries
/// no information.
const PLAIN_SHARE: f64 = 0.8;

/// A mesh seen at many yaws.
pub struct Model<'a>(ObjectColors<'a>);

impl<'a> Model<'a> {
    /// `plain`: the mesh without its textures, where that is to be compared as well.
    pub fn new(mesh: &'a TexturedMesh, plain: Option<&'a TexturedMesh>) -> Self {
        Self(ObjectColors::new(mesh, plain))
    }

    /// Colors of the mesh in that upright pose, and of the plain mesh, at the pixels that are wanted.
    fn colors(
        &self,
        world_from_object: &Pose,
        camera: Camera,
        is_wanted: &[bool],
    ) -> (PixelColors, Option<PixelColors>) {
        let (camera, lighting) = beside_camera(world_from_object, camera);
        self.0.at(lighting, Background::light(), &View::Perspective(camera), is_wanted)
    }
}

/// The whole image that meshes are compared with: the mesh in that upright pose.
pub(super) fn rendered(scene_cache: &SceneCache, world_from_object: &Pose, camera: Camera) -> Image {
    let (camera, lighting) = beside_camera(world_from_object, camera);
    scene_cache.color(lighting, Background::light(), &View::Perspective(camera))
}

/// A mesh in its own frame, for [`rendered`].
pub(super) fn scene_cache(mesh: &TexturedMesh) -> SceneCache<'_> {
    let settings = RenderSettings { supersampling: 1, shadow_map_px: 0, sky_directions: 0, sky_map_px: 32 };
    let object = RenderObject { mesh, world_from_object: Pose::IDENTITY, id: 1 };
    SceneCache::new(vec![object], &settings)
}

/// The camera in the object's frame, and the light that stands beside it. Light and mesh do not change when both turn
/// about the vertical, so the camera goes around the mesh instead.
fn beside_camera(world_from_object: &Pose, camera: Camera) -> (Camera, Lighting) {
    let object_from_camera = world_from_object.inverse() * camera.world_from_camera;
    let camera = Camera { world_from_camera: object_from_camera, ..camera };
    let mut lighting = Lighting::studio(camera.azimuth_rad() - 0.6, 0.9, 0.5);
    lighting.key_color *= 0.8;
    (camera, lighting)
}

/// The instance's colors as the image shows them, cropped like its mask.
pub struct ImageCrop {
    /// sRGB 0..255; `None` where the instance is not visible.
    colors: Vec<Option<Vec3>>,
    structure: Structure,
    /// Pixels of a render that [`Self::likeness`] depends on.
    is_compared: Vec<bool>,
}

impl ImageCrop {
    /// `crop_px` is the part of the camera's image that `image` shows: x0, y0, x1, y1.
    pub fn new(image: &Image, crop_px: [f64; 4], crop: &Crop) -> Self {
        let side = crop.side_px;
        let low = DVec2::new(crop_px[0], crop_px[1]);
        let size = DVec2::new(crop_px[2], crop_px[3]) - low;
        let own = DVec2::new(f64::from(image.width_px()), f64::from(image.height_px()));
        let points = (own.x / size.x / crop.scale).ceil().clamp(1.0, 6.0) as usize;
        let half = 0.5 * side as f64;
        // Pixels of the image under the points of the crop's columns, and of its rows; `None` beyond it.
        let under = |center_px: f64, low_px: f64, size_px: f64, own_px: f64| -> Vec<Option<u32>> {
            let at = |k: usize| {
                let offset = ((k % points) as f64 + 0.5) / points as f64;
                let p = ((k / points) as f64 + offset - half) / crop.scale + center_px;
                (p - low_px) / size_px * own_px
            };
            (0..side * points).map(at).map(|q| (0.0..own_px).contains(&q).then_some(q as u32)).collect()
        };
        let columns = under(crop.center_px.x, low.x, size.x, own.x);
        let rows = under(crop.center_px.y, low.y, size.y, own.y);
        let color_at = |x: usize, y: usize| {
            let (mut sum, mut count) = (Vec3::ZERO, 0.0);
            for v in rows[y * points..(y + 1) * points].iter().flatten() {
                for u in columns[x * points..(x + 1) * points].iter().flatten() {
                    let [r, g, b, a] = image.pixel(*u, *v);
                    if a >= 128 {
                        sum += Vec3::new(f32::from(r), f32::from(g), f32::from(b));
                        count += 1.0;
                    }
                }
            }
            (count > 0.0).then(|| sum / count)
        };
        let colors: Vec<Option<Vec3>> = (0..side * side)
            .map(|k| if crop.mask[k] > 0.75 { color_at(k % side, k / side) } else { None })
            .collect();
        let structure = Structure::new(&colors, side);
        let mut is_compared = structure.pixels_compared_with(side);
        is_compared.iter_mut().zip(&colors).for_each(|(compared, color)| *compared |= color.is_some());
        Self { colors, structure, is_compared }
    }

    /// sRGB 0..255 of the crop's pixels; `None` where the instance is not visible.
    pub fn colors(&self) -> &[Option<Vec3>] {
        &self.colors
    }

    /// Disagreement of colors and lines: 0 where they vary alike, 1 where they are uncorrelated, up to 2 where they
    /// are opposite. An image or a mesh of one flat color gives 1. `model` is the comparison's mesh in its colors. If
    /// the untextured mesh is compared as well, the disagreement is 1 less the shares of the image's variance that
    /// both explain, so a mesh that hardly resembles the image has little weight.
    pub fn disagreement(&self, model: &Model, comparison: &Comparison, yaw_rad: f64) -> f64 {
        let Some((origin, camera)) = comparison.crop_camera(yaw_rad) else { return 2.0 };
        let pose = Pose::upright(origin, yaw_rad);
        let side_px = camera.width_px as usize;
        let (textured, plain) = model.colors(&pose, camera, &self.is_compared);
        let textured = self.likeness(&textured, side_px);
        let Some(plain) = plain else { return 1.0 - textured };
        let plain = self.likeness(&plain, side_px);
        1.0 - (1.0 - PLAIN_SHARE) * explained(textured) - PLAIN_SHARE * explained(plain)
    }

    /// Correlation of colors and lines, -1..1, with the pixels of a render.
    fn likeness(&self, rendered: &PixelColors, side_px: usize) -> f64 {
        let rendered: Vec<Option<Vec3>> = rendered
            .iter()
            .map(|color| color.map(|[r, g, b]| Vec3::new(f32::from(r), f32::from(g), f32::from(b))))
            .collect();
        let pairs: Vec<(Vec3, Vec3)> =
            self.colors.iter().zip(&rendered).filter_map(|(seen, shown)| (*seen).zip(*shown)).collect();
        let colors = correlation(&pairs);
        let structure = self.structure.likeness(&Structure::new(&rendered, side_px));
        (1.0 - STRUCTURE_SHARE) * colors + STRUCTURE_SHARE * structure
    }
}

/// Share of the variance that goes with a correlation, negative where that is.
fn explained(correlation: f64) -> f64 {
    correlation * correlation.abs()
}

/// Correlation of the colors' deviations from their means, all channels together. Two gray levels of noise
/// count as nothing.
fn correlation(pairs: &[(Vec3, Vec3)]) -> f64 {
    correlation_above(pairs, 12.0)
}

/// Correlation of the deviations from the means, all components together; 0 where either varies by less than
/// `quiet` (the mean of its squares).
fn correlation_above(pairs: &[(Vec3, Vec3)], quiet: f64) -> f64 {
    if pairs.len() < 8 {
        return 0.0;
    }
    let scale = 1.0 / pairs.len() as f32;
    let (mean_a, mean_b) =
        pairs.iter().fold((Vec3::ZERO, Vec3::ZERO), |(a, b), pair| (a + pair.0 * scale, b + pair.1 * scale));
    let (mut ab, mut aa, mut bb) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (a, b) in pairs {
        let (a, b) = (*a - mean_a, *b - mean_b);
        ab += f64::from(a.dot(b));
        aa += f64::from(a.length_squared());
        bb += f64::from(b.length_squared());
    }
    let floor = quiet * pairs.len() as f64;
    if aa < floor || bb < floor { 0.0 } else { ab / (aa * bb).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlation_ignores_brightness_and_contrast() {
        let colors: Vec<Vec3> =
            (0..60).map(|k| Vec3::new((k * 37 % 200) as f32, (k * 11 % 90) as f32, k as f32)).collect();
        let pairs: Vec<(Vec3, Vec3)> = colors.iter().map(|&c| (c, c * 0.6 + 20.0)).collect();
        assert!((correlation(&pairs) - 1.0).abs() < 1e-4);
        let inverted: Vec<(Vec3, Vec3)> = colors.iter().map(|&c| (c, 255.0 - c)).collect();
        assert!((correlation(&inverted) + 1.0).abs() < 1e-4);
        let flat: Vec<(Vec3, Vec3)> = colors.iter().map(|&c| (c, Vec3::splat(90.0))).collect();
        assert_eq!(correlation(&flat), 0.0);
    }

    #[test]
    fn likeness_recognizes_cover_in_other_colors() {
        // Regression: a white book was stood on its front, because the mesh's cover was green and its back a plain
        // orange.
        let cover = |ink: f32, paper: f32| -> Vec<Option<Vec3>> {
            let in_title = |k: usize| {
                (10..14).contains(&(k / 32)) && (6..26).contains(&(k % 32)) && !k.is_multiple_of(3)
            };
            (0..32 * 32).map(|k| Some(Vec3::splat(if in_title(k) { ink } else { paper }))).collect()
        };
        let seen = Structure::new(&cover(30.0, 220.0), 32);
        let (recolored, plain) =
            (Structure::new(&cover(200.0, 60.0), 32), Structure::new(&cover(60.0, 60.0), 32));
        assert!(seen.likeness(&recolored) > 0.95, "{}", seen.likeness(&recolored));
        assert_eq!(seen.likeness(&plain), 0.0);
        let elsewhere: Vec<Option<Vec3>> = cover(30.0, 220.0).into_iter().rev().collect();
        assert!(seen.likeness(&Structure::new(&elsewhere, 32)) < 0.3);
    }
}
