//! What the noisy set does to what the stages see, each disturbance with its amplitude and its own random stream.
//!
//! The truth stays what was painted; masks, sizes, colors, meshes and boxes are spoiled on the way to the stages.
//! Every draw comes from a child of the scene's seed and the object's name, so an object's noise does not depend on
//! the others. Boxes are spoiled by [`super::jittered_boxes`], meshes by [`super::watched_meshes`] with [`meshes`].

pub mod camera;
pub mod light;
pub mod masks;
pub mod meshes;

use rand::RngExt;
use serde::{Deserialize, Serialize};

use embedded::painter::PainterSettings;
use ports::{Painting, PaintingAside};
use runtime::seed::{child_rng, child_seed};
use scene::{CameraKnowledge, MaskEdges};

/// Amplitudes; uniform within them unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Deepest erosion of a mask's boundary, pixels; it varies along the boundary between none and this, and nowhere
    /// exceeds `mask_erosion_share` of the mask's half width.
    pub mask_erosion_px: f64,
    /// Of the largest distance from the mask's boundary.
    pub mask_erosion_share: f64,
    /// Round holes in each mask.
    pub mask_holes: u32,
    /// Area of each hole at most, as a share of the mask's.
    pub mask_hole_share: f64,
    /// Each side of a box on the top view (the table's too), as a share of the box's extent across it.
    pub box_share: f64,
    /// A believed size is the true one times a factor, log-uniform between 1 / (1 + this) and 1 + this; one per object.
    pub size_share: f64,
    /// Each axis of a mesh is stretched by a factor of its own, 1 plus or minus this.
    pub stretch_share: f64,
    /// A mesh is decimated to this share of its triangles, or as near to that as its creases and parts allow.
    pub kept_triangles: f64,
    /// Decimation moves corners by about this at most, as a share of the mesh's longest extent.
    pub mesh_off_share: f64,
    /// Each color channel of a material is multiplied by 1 plus or minus this.
    pub recolor_share: f64,
    /// Brightness of the picture changes linearly across it by up to this share at its border.
    pub light_slope_share: f64,
    /// Each color channel of the picture is multiplied by 1 plus or minus this.
    pub light_cast_share: f64,
    /// Highest elevation of the camera, radians; the painter's own range is cut there, so that things hide each other.
    pub highest_elevation_rad: f64,
    /// Every object shows at least this share of its silhouette, where the painter finds such a view.
    pub least_visible_share: f64,
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
        least_visible_share: 0.6,
        elevation_rad: 5.0 * DEGREE_RAD,
        azimuth_rad: 2.0 * DEGREE_RAD,
    };

    /// The noisy set with an exact camera: what the camera's error costs although it is refined is the difference.
    pub const NOISY_EXACT_CAMERA: Self = Self { elevation_rad: 0.0, azimuth_rad: 0.0, ..Self::NOISY };

    /// The painter's settings with lower cameras.
    pub fn painter(&self, settings: &PainterSettings) -> PainterSettings {
        let [low, high] = settings.elevation_rad;
        PainterSettings {
            elevation_rad: [low, high.min(self.highest_elevation_rad).max(low)],
            least_visible_share: settings.least_visible_share.max(self.least_visible_share),
            ..settings.clone()
        }
    }

    /// The painting as the stages get to see it. Its `truth` and its view from above stay.
    pub fn spoiled(&self, painting: &Painting, seed: u64) -> Painting {
        let mut spoiled = painting.clone();
        light::relight(&mut spoiled.picture, self, seed, None);
        let whole_px = [f64::from(painting.picture.width_px()), f64::from(painting.picture.height_px())];
        let Some(PaintingAside { known, alone, .. }) = &mut spoiled.aside else { return spoiled };
        if self.elevation_rad > 0.0 || self.azimuth_rad > 0.0 {
            known.recognition.camera = camera::misjudged(&known.recognition.camera, self, seed);
            known.recognition.camera_is = CameraKnowledge::Judged;
        }
        known.table_mask =
            masks::worn(&known.table_mask, self, self.mask_holes, child_seed(seed, "mask table"));
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
            mask.visible = masks::worn(&mask.visible, self, self.mask_holes, seed);
        }
        for drawn in alone {
            let own_seed = child_seed(seed, &format!("alone {}", drawn.id));
            drawn.completion.silhouette = masks::worn(&drawn.completion.silhouette, self, 0, own_seed);
            let shown = light::Shown { part_px: drawn.completion.shown_px, whole_px };
            light::relight(&mut drawn.completion.picture, self, seed, Some(shown));
        }
        spoiled
    }
}

const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;
