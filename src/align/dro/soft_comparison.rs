//! A mesh against a crop, softly: the loss of one yaw and its derivative.
//!
//! The placement, the crop and the two terms are [`Comparison`]'s; the silhouette is blurred at its outline
//! ([`crate::render::soft`]) so that the loss has a derivative. Blurred, even the true silhouette differs
//! from the mask: its loss is not 0, and larger for thin objects.
//!
//! Guarantees: the same bits with any number of threads. Cost: that of a soft silhouette.

use std::cell::RefCell;

use super::DroSettings;
use super::comparison::Comparison;
use super::crop::Crop;
use super::moving_placement::{MovingPixel, moving_points};
use super::outline_mesh::OutlineMesh;
use crate::geometry::Camera;
use crate::render::soft::loss::{SoftTerms, Target, terms};
use crate::render::soft::{Grid, MovingPoint, SoftSilhouette, Surface};

/// A mesh to be compared with a crop.
pub struct SoftComparison<'a> {
    comparison: Comparison<'a>,
    surface: Surface,
    sigma_px2: f32,
}

/// What one comparison after another works in.
#[derive(Default)]
struct Scratch {
    /// Of the mesh's vertices in the camera's picture.
    pixels: Vec<MovingPixel>,
    /// The same in the crop.
    points: Vec<MovingPoint<1>>,
    drawn: SoftSilhouette<1>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl<'a> SoftComparison<'a> {
    /// `seat_height_m` is that of what the object stands on, world z.
    pub fn new(
        mesh: &'a OutlineMesh,
        camera: &'a Camera,
        seat_height_m: f64,
        crop: &'a Crop,
        settings: &DroSettings,
    ) -> Self {
        Self {
            comparison: Comparison::new(mesh, camera, seat_height_m, crop, settings),
            surface: Surface::new(&mesh.triangles),
            sigma_px2: settings.soft_sigma_px2 as f32,
        }
    }

    /// Weighted loss at that yaw and its derivative, per radian; a mesh that reaches behind the camera has
    /// nothing in common.
    pub fn loss(&self, yaw_rad: f64) -> (f64, f64) {
        // Taken out, not borrowed: drawing waits for other threads, and meanwhile this one may begin
        // another yaw.
        let mut scratch = SCRATCH.take();
        let terms = self.terms(yaw_rad, &mut scratch).unwrap_or(SoftTerms::HOPELESS);
        SCRATCH.set(scratch);
        let loss = terms.weighted(self.comparison.silhouette_weight, self.comparison.edge_weight);
        (loss.value, loss.slopes[0])
    }

    fn terms(&self, yaw_rad: f64, scratch: &mut Scratch) -> Option<SoftTerms<1>> {
        let Scratch { pixels, points, drawn } = scratch;
        moving_points(&self.comparison, yaw_rad, pixels, points)?;
        let crop = self.comparison.crop;
        drawn.draw(&self.surface, points, Grid::square(crop.side_px), self.sigma_px2);
        let target = Target {
            mask: &crop.mask,
            known: &crop.known,
            distance_px: &crop.distance_px,
            mask_area_px2: crop.mask_area,
            side_px: crop.side_px as f64,
        };
        Some(terms(drawn, &target))
    }
}
