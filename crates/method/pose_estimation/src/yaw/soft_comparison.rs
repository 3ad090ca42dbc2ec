//! Differentiable comparison of a mesh with a crop: the loss of one yaw and its derivative.
//!
//! The placement, the crop and the two terms are [`Comparison`]'s; the silhouette is blurred at its outline
//! ([`soft_raster`]) so that the loss has a derivative. Blurred, even the true silhouette differs from the mask: its
//! loss is not 0, and larger for thin objects.
//!
//! If an image is given, its appearance is a third term ([`AppearanceTerm`]); without it the loss is that of the
//! outline alone.
//!
//! Yaws are compared many at a time, in parallel.
//!
//! Guarantees: the same bits with any number of threads. Cost: that of a soft silhouette each.

use std::cell::RefCell;

use rayon::prelude::*;

use super::YawSettings;
use super::appearance_term::{AppearanceRoom, AppearanceTerm, NOTHING_IN_COMMON, ProjectedMesh};
use super::comparison::Comparison;
use super::crop::Crop;
use super::moving_placement::{MovingPixel, moving_points};
use super::outline_mesh::OutlineMesh;
use geometry::Camera;
use runtime::{CancelFlag, Cancelled};
use soft_raster::loss::{Dual, SoftTerms, Target, terms};
use soft_raster::{Grid, MovingPoint, SoftSilhouette, Surface};

/// A mesh to be compared with a crop.
pub struct SoftComparison<'a> {
    comparison: Comparison<'a>,
    surface: Surface,
    sigma_px2: f32,
    /// Color and edge terms, where the image's content is known.
    appearance: Option<AppearanceTerm>,
}

/// Working memory for comparisons.
#[derive(Default)]
struct Scratch {
    /// Of the mesh's vertices in the camera's image.
    pixels: Vec<MovingPixel>,
    /// Vertices in the crop.
    points: Vec<MovingPoint<1>>,
    drawn: SoftSilhouette<1>,
    appearance: AppearanceRoom,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl<'a> SoftComparison<'a> {
    /// `support_height_m` is that of what the object stands on, world z.
    pub fn new(
        mesh: &'a OutlineMesh,
        camera: &'a Camera,
        support_height_m: f64,
        crop: &'a Crop,
        settings: &YawSettings,
    ) -> Self {
        Self {
            comparison: Comparison::new(mesh, camera, support_height_m, crop, settings),
            surface: Surface::new(&mesh.triangles),
            sigma_px2: settings.soft_sigma_px2 as f32,
            appearance: None,
        }
    }

    /// The comparison with a third term in the loss.
    pub fn with_appearance(self, term: AppearanceTerm) -> Self {
        Self { appearance: Some(term), ..self }
    }

    /// The mesh's triangles.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    pub fn sees_colors(&self) -> bool {
        self.appearance.is_some()
    }

    /// [`Self::loss`] of every yaw.
    pub fn losses(&self, yaws_rad: &[f64], cancel: &CancelFlag) -> Result<Vec<(f64, f64)>, Cancelled> {
        yaws_rad.par_iter().map(|&yaw_rad| cancel.check().map(|()| self.loss(yaw_rad))).collect()
    }

    /// Weighted loss at that yaw and its derivative, per radian; the loss of no overlap if the mesh reaches behind the
    /// camera.
    pub fn loss(&self, yaw_rad: f64) -> (f64, f64) {
        let (outline, appearance) = self.terms(yaw_rad);
        let (loss, slope) = self.weighted(&outline);
        match (&self.appearance, appearance) {
            (Some(term), Some(found)) => {
                (loss + term.weight * found.value, slope + term.weight * found.slopes[0])
            }
            _ => (loss, slope),
        }
    }

    /// The outline's part of the loss at that yaw, and the appearance term before weighting, 0 without an image.
    pub fn parts(&self, yaw_rad: f64) -> (f64, f64) {
        let (outline, appearance) = self.terms(yaw_rad);
        (self.weighted(&outline).0, appearance.map_or(0.0, |found| found.value))
    }

    fn weighted(&self, terms: &SoftTerms<1>) -> (f64, f64) {
        let loss = terms.weighted(self.comparison.silhouette_weight, self.comparison.edge_weight);
        (loss.value, loss.slopes[0])
    }

    fn terms(&self, yaw_rad: f64) -> (SoftTerms<1>, Option<Dual<1>>) {
        // Taken out, not borrowed: drawing waits for other threads, and meanwhile this one may begin
        // another yaw.
        let mut scratch = SCRATCH.take();
        let hopeless = (SoftTerms::HOPELESS, self.appearance.as_ref().map(|_| NOTHING_IN_COMMON));
        let terms = self.terms_within(yaw_rad, &mut scratch).unwrap_or(hopeless);
        SCRATCH.set(scratch);
        terms
    }

    fn terms_within(&self, yaw_rad: f64, scratch: &mut Scratch) -> Option<(SoftTerms<1>, Option<Dual<1>>)> {
        let Scratch { pixels, points, drawn, appearance } = scratch;
        moving_points(&self.comparison, yaw_rad, pixels, points)?;
        drawn.draw(&self.surface, points, self.grid(), self.sigma_px2);
        let outline = terms(drawn, &self.target());
        let seen = ProjectedMesh { surface: &self.surface, pixels, points, silhouette: drawn, yaw_rad };
        Some((outline, self.appearance.as_ref().map(|term| term.compare(&seen, appearance))))
    }

    fn grid(&self) -> Grid {
        Grid::square(self.comparison.crop.side_px)
    }

    fn target(&self) -> Target<'a> {
        let crop = self.comparison.crop;
        Target {
            mask: &crop.mask,
            known: &crop.known,
            distance_px: &crop.distance_px,
            mask_area_px2: crop.mask_area,
            side_px: crop.side_px as f64,
        }
    }
}
