//! Noise of the stage inputs: each disturbance has an amplitude and its own random stream.
//!
//! The truth is unchanged; masks, sizes, colors, meshes and boxes are perturbed on the way to the stages. Every
//! draw uses a child of the scene's seed and the object's id, so the noise of an object does not depend on the
//! others. Boxes are perturbed by [`super::jittering_segmenter`], meshes by [`super::recording_mesh_generator`]
//! with [`meshes`].

pub mod camera;
pub mod light;
pub mod masks;
pub mod meshes;

use rand::RngExt;
use serde::{Deserialize, Serialize};

use embedded::image_generator::ImageGeneratorSettings;
use ports::{GeneratedReference, SyntheticGroundTruth};
use runtime::seed::{child_rng, child_seed};
use scene::{CameraKnowledge, MaskEdges};

/// Amplitudes; uniform distributions unless stated otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Maximum erosion of a mask boundary, pixels. It varies along the boundary between 0 and this, and never
    /// exceeds `mask_erosion_share` of the mask's half width.
    pub mask_erosion_px: f64,
    /// Maximum erosion as a share of the largest distance from the mask boundary.
    pub mask_erosion_share: f64,
    /// Number of round holes in each mask.
    pub mask_holes: u32,
    /// Maximum area of each hole, as a share of the mask area.
    pub mask_hole_share: f64,
    /// Shift of each side of a top-view box (the table's too), as a share of the box extent across it.
    pub box_share: f64,
    /// An estimated size is the true one times a log-uniform factor between 1 / (1 + this) and 1 + this; one per
    /// object.
    pub size_share: f64,
    /// Each mesh axis is stretched by its own factor, 1 plus or minus this.
    pub stretch_share: f64,
    /// Target share of triangles after decimation; creases and parts may prevent it.
    pub kept_triangles: f64,
    /// Approximate maximum displacement of vertices by decimation, as a share of the mesh's longest extent.
    pub mesh_off_share: f64,
    /// Each color channel of a material is multiplied by 1 plus or minus this.
    pub recolor_share: f64,
    /// Brightness changes linearly across the image by up to this share at its border.
    pub light_slope_share: f64,
    /// Each color channel of the image is multiplied by 1 plus or minus this.
    pub light_cast_share: f64,
    /// Maximum camera elevation, radians; it caps the generator's range, so that objects occlude each other.
    pub highest_elevation_rad: f64,
    /// Minimum visible share of every object's silhouette, where the generator finds such a view.
    pub min_visible_share: f64,
    /// Error of the camera's elevation, radians.
    pub elevation_rad: f64,
    /// Error of the camera's azimuth, radians.
    pub azimuth_rad: f64,
}

impl Noise {
    /// The noisy set.
    pub const NOISY: Self = Self {
        mask_erosion_px: 2.5,
        mask_erosion_share: 0.3,
        mask_holes: 3,
        mask_hole_share: 0.01,
        box_share: 0.03,
        size_share: 0.25,
        stretch_share: 0.05,
        kept_triangles: 0.33,
        mesh_off_share: 0.01,
        recolor_share: 0.2,
        light_slope_share: 0.15,
        light_cast_share: 0.06,
        highest_elevation_rad: 0.78,
        min_visible_share: 0.6,
        elevation_rad: 5.0 * DEGREE_RAD,
        azimuth_rad: 2.0 * DEGREE_RAD,
    };

    /// The noisy set with an exact camera; the difference to [`Self::NOISY`] is the cost of the camera error after
    /// refinement.
    pub const NOISY_EXACT_CAMERA: Self = Self { elevation_rad: 0.0, azimuth_rad: 0.0, ..Self::NOISY };

    /// The image generator's settings with lower cameras.
    pub fn image_generator(&self, settings: &ImageGeneratorSettings) -> ImageGeneratorSettings {
        let [low, high] = settings.elevation_rad;
        ImageGeneratorSettings {
            elevation_rad: [low, high.min(self.highest_elevation_rad).max(low)],
            min_visible_share: settings.min_visible_share.max(self.min_visible_share),
            ..settings.clone()
        }
    }

    /// The reference image as given to the stages. Its `truth` and its top view are unchanged.
    pub fn apply(&self, reference: &GeneratedReference, seed: u64) -> GeneratedReference {
        let mut noisy = reference.clone();
        light::relight(&mut noisy.image, self, seed, None);
        let whole_px = [f64::from(reference.image.width_px()), f64::from(reference.image.height_px())];
        let Some(SyntheticGroundTruth { known, alone, .. }) = &mut noisy.ground_truth else { return noisy };
        if self.elevation_rad > 0.0 || self.azimuth_rad > 0.0 {
            known.recognition.camera = camera::perturb(&known.recognition.camera, self, seed);
            known.recognition.camera_is = CameraKnowledge::Judged;
        }
        known.table_mask =
            masks::degrade(&known.table_mask, self, self.mask_holes, child_seed(seed, "mask table"));
        for object in &mut known.recognition.objects {
            let reach = (1.0 + self.size_share).ln();
            let mut rng = child_rng(seed, &format!("size {}", object.id));
            object.size_m *= (reach * rng.random_range(-1.0..1.0_f64)).exp();
        }
        if self.mask_erosion_px > 0.0 || self.mask_holes > 0 {
            known.mask_edges = MaskEdges::Rough;
        }
        for mask in &mut known.masks {
            let seed = child_seed(seed, &format!("mask {}", mask.id));
            mask.visible = masks::degrade(&mask.visible, self, self.mask_holes, seed);
        }
        for drawn in alone {
            let own_seed = child_seed(seed, &format!("alone {}", drawn.id));
            drawn.completion.silhouette = masks::degrade(&drawn.completion.silhouette, self, 0, own_seed);
            let region = light::CropRegion { part_px: drawn.completion.crop_px, whole_px };
            light::relight(&mut drawn.completion.image, self, seed, Some(region));
        }
        noisy
    }
}

const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;
