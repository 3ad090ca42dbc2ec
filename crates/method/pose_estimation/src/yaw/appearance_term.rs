//! The paper's appearance term with the classical descriptor: `L_app = ||Phi(I_render) - Phi(I_instance)||^2` and its
//! derivative by yaw.
//!
//! `I_render` is the mesh with its texture under a studio light that stands beside the camera, drawn softly
//! ([`soft_raster::color`]) in the crop of the silhouette, at a quarter of its resolution (at half, yaws took up to
//! twice as long to compare); `I_instance` the image in
//! the same crop, faded in from the mask's own contour by the same function of the distance as the render from its
//! outline. `Phi` is [`crate::appearance::descriptor`]. Pixels of other instances and beyond the image
//! do not count on either side.
//!
//! Inputs: the DRO problem of an instance, and the silhouette at a yaw. Guarantees: the same bits always; the
//! derivative is that of the soft image, exact but where surfaces run through each other. Cost: about that of the
//! silhouette again. Not for choosing among meshes: light and shadows of the image are not modelled.

use glam::{DQuat, DVec3, Vec3};

use super::crop::Crop;
use super::moving_placement::MovingPixel;
use super::outline_mesh::OutlineMesh;
use super::{YawProblem, YawSettings};
use crate::appearance::ImageCrop;
use crate::appearance::descriptor::{Descriptor, DescriptorRoom, KnownPixels, describe};
use geometry::{Camera, Rgb};
use imaging::Image;
use render::Lighting;
use soft_raster::color::{ColorInput, MovingDirection, MovingKey, SoftImage, StudioLight};
use soft_raster::loss::Dual;
use soft_raster::{Grid, MovingPoint, ShadingMaterials, SoftSilhouette, Surface};

/// Silhouette pixels along a pixel of the compared images.
const SHRINK: usize = 4;

/// Distance of two unit descriptors without anything in common, squared: of a mesh behind the camera.
pub const NOTHING_IN_COMMON: Dual<1> = Dual { value: 2.0, slopes: [0.0] };

/// The instance's descriptor and the mesh's colors.
pub struct AppearanceTerm {
    shading: ShadingMaterials,
    pixels: KnownPixels,
    instance: Descriptor<0>,
    toward_key_in_world: DVec3,
    /// Of the term in the loss.
    pub weight: f64,
}

/// Working memory for comparisons.
#[derive(Default)]
pub struct AppearanceRoom {
    keys: Vec<MovingKey<1>>,
    image: SoftImage<1>,
    descriptor: DescriptorRoom<1>,
}

/// A projected mesh at a yaw.
pub struct ProjectedMesh<'a> {
    pub surface: &'a Surface,
    /// Vertices in the camera's image, and in the crop.
    pub pixels: &'a [MovingPixel],
    pub points: &'a [MovingPoint<1>],
    pub silhouette: &'a SoftSilhouette<1>,
    pub yaw_rad: f64,
}

impl AppearanceTerm {
    /// `mesh` is that of the problem, `surface` its triangles, `bbox` the box of its mask, `image` the camera's.
    pub fn new(
        problem: &YawProblem,
        image: &Image,
        mesh: &OutlineMesh,
        bbox: [u32; 4],
        surface: &Surface,
        settings: &YawSettings,
    ) -> Self {
        let camera = problem.camera;
        let crop = Crop::new(problem.mask, problem.unknown, bbox, settings.fine_px as usize / SHRINK);
        let grid = Grid::square(crop.side_px);
        let pixels = KnownPixels::new(grid, crop.known.clone());
        let instance = instance(image, camera, &crop, settings.soft_sigma_px2);
        Self {
            shading: ShadingMaterials::new(problem.mesh, &mesh.faces, surface),
            instance: describe(&instance, &pixels, &mut DescriptorRoom::default()),
            pixels,
            toward_key_in_world: Lighting::studio(camera.azimuth_rad() - 0.6, 0.9, 0.5).toward_key,
            weight: settings.descriptor_weight,
        }
    }

    /// The term before weighting, and its derivative, per radian.
    pub fn compare(&self, seen: &ProjectedMesh, room: &mut AppearanceRoom) -> Dual<1> {
        room.keys.clear();
        room.keys.extend(seen.pixels.iter().map(MovingPixel::key));
        let toward_key = DQuat::from_rotation_z(-seen.yaw_rad) * self.toward_key_in_world;
        let light = StudioLight {
            toward_key: MovingDirection {
                at: toward_key.as_vec3(),
                slopes: [(-DVec3::Z.cross(toward_key)).as_vec3()],
            },
            up: MovingDirection { at: Vec3::Z, slopes: [Vec3::ZERO] },
        };
        room.image.draw(&ColorInput {
            surface: seen.surface,
            points: seen.points,
            keys: &room.keys,
            shading: &self.shading,
            light: &light,
            silhouette: seen.silhouette,
            shrink: SHRINK,
        });
        describe(&room.image, &self.pixels, &mut room.descriptor).squared_distance(&self.instance)
    }
}

/// The instance in the image, as a soft image of the crop.
fn instance(image: &Image, camera: &Camera, crop: &Crop, sigma_px2: f64) -> SoftImage<0> {
    let crop_px = [0.0, 0.0, f64::from(camera.width_px), f64::from(camera.height_px)];
    let cropped = ImageCrop::new(image, crop_px, crop);
    let mut planes: [Vec<f32>; 4] = std::array::from_fn(|_| vec![0.0; crop.side_px * crop.side_px]);
    for (at, color) in cropped.colors().iter().enumerate() {
        let Some(color) = color else { continue };
        // The contour is a line of pixels inside; the outline is half a pixel outside of it.
        let distance_px = SHRINK as f64 * (f64::from(crop.distance_px[at]) + 0.5);
        let coverage = 1.0 / (1.0 + (-distance_px * distance_px / sigma_px2).exp());
        let weight = (2.0 * coverage - 1.0) as f32;
        let linear = Rgb((*color / 255.0).to_array()).to_linear();
        for (plane, value) in planes.iter_mut().zip(linear.map(|c| weight * c.sqrt())) {
            plane[at] = value;
        }
        planes[3][at] = weight;
    }
    SoftImage::of_planes(Grid::square(crop.side_px), planes, [])
}
