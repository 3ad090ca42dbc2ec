//! Classification of objects into catalog categories: guesses of the [`object_recognizer`](crate::object_recognizer),
//! checked by render-and-compare.
//!
//! Steps, each in its own file: [`observed`] reduces an object to a grid of some 40 cells. Its silhouette is
//! compared with the outlines of the guessed categories from all directions ([`views`], of meshes from
//! [`stock_mesh`]). They are placed at the object and moved, rotated and stretched until their outlines fit
//! ([`stance_fit`], rasterized by [`outline_raster`]). [`appearance`] measures how much of the color pattern their
//! parts and prints explain. [`decision`] weighs this evidence: one scale for the whole image, a score for each
//! candidate, and the confidence of the best one.
//!
//! Input: a reading in meters at a working scale that may be off by a third. The evidence does not depend on the
//! decision, so candidates can be left out afterwards. Deterministic. Cost: about 7 ms of one core for a
//! guess, and about 20 ms more for the first guess of a category, whose meshes are built.

mod appearance;
mod assignment;
mod decision;
mod named;
mod observed;
mod outline_raster;
mod settings;
mod stance_fit;
mod stock_mesh;
mod views;

pub use decision::{CategoryAssignment, Naming, assign_categories, vote};
pub use named::{NamedAssignment, NamedKind, NamedObject, assign_named, named_evidence};
pub use settings::CategoryFitSettings;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use self::appearance::Appearance;
use self::observed::{MaskedImage, Observation};
use self::outline_raster::{Raster, Stance};
use self::stance_fit::StanceFit;
use self::stock_mesh::{StockCategory, StockMesh, VARIANTS, stock_of};
use super::object_recognizer::CategoryGuess;
use super::reading::ImageReading;
use super::shape_fit::PosedPrimitive;
use catalog::SizeRange;
use geometry::Camera;
use imaging::{Image, Mask};
use runtime::{CancelFlag, Cancelled};

/// Evidence about one object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectEvidence {
    /// The guessed categories, each with its best stance.
    pub matches: Vec<CategoryMatch>,
    /// Natural logarithm of the probability that the recognizer leaves to everything else.
    pub log_other: f64,
    /// Overlap of the fitted primitive.
    pub solid_overlap: f64,
    /// Share of the outline that other objects may occlude.
    pub hidden_rim: f64,
    /// Area in cells of the grid, and the side of a cell in pixels.
    pub area_cells: f64,
    pub cell_px: f64,
}

/// A category's mesh fitted to an object.
#[derive(Clone, Debug, PartialEq)]
pub struct CategoryMatch {
    /// Name in the catalog.
    pub category: &'static str,
    /// Whether the mesh lies on its side. Only fits to the objects of a text try that.
    pub is_lying: bool,
    /// Natural logarithm of the recognizer's probability.
    pub log_guess: f64,
    /// Whether a mesh was fitted. If none covers the object, position and size are those of its primitive, and the
    /// values of the comparison are 0.
    pub is_fitted: bool,
    /// Seed of the catalog's recipe.
    pub variant: u64,
    /// Center of its base, yaw about +z, and extents, as if it stood on the table, meters.
    pub center: DVec2,
    pub yaw_rad: f64,
    pub size_m: DVec3,
    /// Intersection over union with the object's visible pixels, and the penalty of unusual proportions.
    pub overlap: f64,
    pub stray: f64,
    /// Natural logarithm of its mean extent relative to the category's typical one, and the half range of typical
    /// ones.
    pub oversize: f64,
    pub usual_spread: f64,
    /// Share of the color variance that a smooth ramp explains, and that mesh and ramp explain.
    pub by_ramp: f64,
    pub by_mesh: f64,
    /// Standard deviation of the colors, and distance to the category's typical ones; CIELAB.
    pub contrast: f64,
    pub off_palette: f64,
}

/// Collects the evidence for every object of a reading in meters. `image` is the one that was read, `guesses` are
/// the recognizer's for each object. Returns empty evidence if the settings disable naming.
///
/// # Errors
///
/// [`Cancelled`] if `cancel` was set.
pub fn evidence(
    image: &Image,
    reading: &ImageReading,
    guesses: &[Vec<CategoryGuess>],
    settings: &CategoryFitSettings,
    cancel: &CancelFlag,
) -> Result<Vec<ObjectEvidence>, Cancelled> {
    if settings.min_confidence >= 1.0 {
        return Ok(vec![ObjectEvidence::default(); reading.objects.len()]);
    }
    let masks: Vec<&Mask> = reading.objects.iter().map(|object| &object.mask).collect();
    let masked = MaskedImage { image, camera: &reading.camera, masks: &masks };
    (0..masks.len())
        .into_par_iter()
        .map(|index| object_evidence(&masked, reading, index, &guesses[index], settings, cancel))
        .collect()
}

fn object_evidence(
    masked: &MaskedImage,
    reading: &ImageReading,
    index: usize,
    guesses: &[CategoryGuess],
    settings: &CategoryFitSettings,
    cancel: &CancelFlag,
) -> Result<ObjectEvidence, Cancelled> {
    cancel.check()?;
    let solid = &reading.objects[index].solid;
    let Some(observed) = Observation::new(masked, index, solid) else { return Ok(ObjectEvidence::default()) };
    let support_scale = reading.support_scale(index);
    let camera = masked.camera;
    let Some(view_geometry) = ViewGeometry::new(camera, solid.center, solid.size.z) else {
        return Ok(ObjectEvidence::default());
    };
    let mut raster = Raster::default();
    let region = Region { observed: &observed, view: &view_geometry, camera, solid, support_scale };
    let guesses = &guesses[..guesses.len().min(settings.candidates as usize)];
    let mut matches: Vec<CategoryMatch> = Vec::with_capacity(guesses.len());
    for guess in guesses {
        cancel.check()?;
        matches.extend(region.guessed(guess, settings.max_oversize, &mut raster));
    }
    let guessed: f64 = guesses.iter().map(|guess| guess.probability).sum();
    Ok(ObjectEvidence {
        matches,
        log_other: (1.0 - guessed).max(MIN_PROBABILITY).ln(),
        solid_overlap: solid.overlap,
        hidden_rim: observed.hidden_rim,
        area_cells: f64::from(observed.area),
        cell_px: observed.grid.cell_px,
    })
}

/// Smallest probability that counts.
const MIN_PROBABILITY: f64 = 1e-3;

/// One object of the image and what its fits need.
struct Region<'a> {
    observed: &'a Observation,
    view: &'a ViewGeometry,
    camera: &'a Camera,
    solid: &'a PosedPrimitive,
    support_scale: f64,
}

impl Region<'_> {
    /// The best fit of a guessed category, or the guess with the place and size of the primitive.
    fn guessed(
        &self,
        guess: &CategoryGuess,
        max_oversize: f64,
        raster: &mut Raster,
    ) -> Option<CategoryMatch> {
        let log_guess = guess.probability.max(MIN_PROBABILITY).ln();
        let stock = stock_of(guess.category)?;
        let meshes = (0..VARIANTS).filter_map(|variant| stock.mesh(variant));
        let first = self.initial_match(stock, meshes, max_oversize);
        let fitted = first.and_then(|first| self.fitted(&first, raster));
        Some(CategoryMatch { log_guess, ..fitted.unwrap_or_else(|| self.unfitted(stock)) })
    }

    fn unfitted(&self, stock: &'static StockCategory) -> CategoryMatch {
        let Self { solid, support_scale, .. } = self;
        let (oversize, usual_spread) = oversize(*support_scale * solid.size, &stock.size);
        CategoryMatch {
            category: &stock.category.name,
            is_lying: false,
            log_guess: 0.0,
            is_fitted: false,
            variant: 0,
            center: solid.center,
            yaw_rad: solid.yaw_rad,
            size_m: solid.size,
            overlap: 0.0,
            stray: 0.0,
            oversize,
            usual_spread,
            by_ramp: 0.0,
            by_mesh: 0.0,
            contrast: 0.0,
            off_palette: 0.0,
        }
    }

    /// The mesh at its best stance; `None` if it covers too little of the object.
    fn fitted(&self, first: &InitialMatch, raster: &mut Raster) -> Option<CategoryMatch> {
        let fit = StanceFit { observed: self.observed, camera: self.camera, mesh: first.mesh };
        let stances = first.starts.iter().filter_map(|(yaw_rad, stretch)| {
            let stance = Stance {
                center: self.solid.center,
                yaw_rad: yaw_rad + self.view.azimuth_rad,
                stretch: DVec3::splat(*stretch),
            };
            fit.from(stance, raster)
        });
        let best = stances.max_by(|a, b| a.merit().total_cmp(&b.merit()))?;
        let palette = &first.category.palette;
        let seen =
            appearance::compare(self.observed, self.camera, first.mesh, palette, &best.stance, raster)?;
        Some(category_match(first, &best, &seen, self.support_scale))
    }
}

fn category_match(
    first: &InitialMatch,
    fitted: &stance_fit::FittedStance,
    seen: &Appearance,
    support_scale: f64,
) -> CategoryMatch {
    let StockCategory { category, size, .. } = first.category;
    let size_m = fitted.stance.stretch * first.mesh.size_m;
    let (oversize, usual_spread) = oversize(support_scale * size_m, size);
    CategoryMatch {
        category: &category.name,
        is_lying: first.mesh.is_lying,
        log_guess: 0.0,
        is_fitted: true,
        variant: first.mesh.variant,
        center: fitted.stance.center,
        yaw_rad: (fitted.stance.yaw_rad + PI).rem_euclid(TAU) - PI,
        size_m,
        overlap: fitted.overlap,
        stray: fitted.stray,
        oversize,
        usual_spread,
        by_ramp: seen.by_ramp,
        by_mesh: seen.by_mesh,
        contrast: seen.contrast,
        off_palette: seen.off_palette,
    }
}

/// Natural logarithm of a mean extent relative to that of usual sizes, and the half range of usual ones.
fn oversize(size_m: DVec3, usual: &SizeRange) -> (f64, f64) {
    let mean = |size: DVec3| size.max(DVec3::splat(1e-6)).to_array().map(f64::ln).iter().sum::<f64>() / 3.0;
    let (low, high) = (mean(usual.low_m), mean(usual.high_m));
    (mean(size_m) - 0.5 * (low + high), 0.5 * (high - low))
}

/// View of an object.
struct ViewGeometry {
    elevation_rad: f64,
    /// Azimuth of the direction away from the eye, relative to +y.
    azimuth_rad: f64,
    /// Meters across the view per pixel, at the object.
    m_per_px: f64,
}

impl ViewGeometry {
    fn new(camera: &Camera, center: DVec2, height_m: f64) -> Option<Self> {
        let center = center.extend(0.5 * height_m);
        let (_, depth) = camera.project(center)?;
        let away = center - camera.world_from_camera.translation_m;
        let elevation_rad = (-away.z).atan2(away.truncate().length());
        let azimuth_rad = away.y.atan2(away.x) - FRAC_PI_2;
        Some(Self { elevation_rad, azimuth_rad, m_per_px: depth / camera.fx })
    }
}

/// A category's mesh and its best yaws relative to the view.
struct InitialMatch<'a> {
    category: &'a StockCategory,
    mesh: &'a StockMesh,
    merit: f64,
    /// Yaw and scale.
    starts: Vec<(f64, f64)>,
}

/// Weight of the squared logarithm of an aspect ratio beyond the free range, and that range.
const ASPECT_PRICE: f64 = 0.6;
const FREE_ASPECT: f64 = 0.12;

impl Region<'_> {
    /// The mesh of the category with the best-matching outline; `None` if every size is off by more than
    /// `max_oversize` (natural logarithm).
    fn initial_match<'s>(
        &self,
        category: &'s StockCategory,
        meshes: impl Iterator<Item = &'s StockMesh>,
        max_oversize: f64,
    ) -> Option<InitialMatch<'s>> {
        let Self { observed, view: view_geometry, support_scale, .. } = self;
        let seen_m = view_geometry.m_per_px * (observed.high_px - observed.low_px);
        let seen_m = seen_m.max(DVec2::splat(1e-6));
        // No view is wider than the diagonal of the box, and none smaller than its shortest side allows.
        let (longest_m, slack) = (seen_m.max_element() * support_scale, max_oversize.exp());
        let size = &category.size;
        if longest_m > slack * size.high_m.length() || longest_m * slack < 0.5 * size.low_m.min_element() {
            return None;
        }
        let matches = meshes.filter_map(|mesh| {
            let mut evaluated: Vec<(f64, f64, f64)> = Vec::new();
            for view in mesh.views(view_geometry.elevation_rad) {
                let ratio = seen_m / DVec2::new(view.width_m, view.height_m).max(DVec2::splat(1e-6));
                let scale = (ratio.x * ratio.y).sqrt();
                if (scale * support_scale).ln().abs() > max_oversize + 0.2 {
                    continue;
                }
                let off = ((ratio.x / ratio.y).ln().abs() - FREE_ASPECT).max(0.0);
                let overlap = views::overlap(&view.bits, &observed.bits, &observed.hidden_bits);
                evaluated.push((overlap - ASPECT_PRICE * off * off, view.yaw_rad, scale));
            }
            evaluated.sort_by(|a, b| b.0.total_cmp(&a.0));
            let &(merit, yaw_rad, scale) = evaluated.first()?;
            let angle_to_best = |yaw: f64| {
                let turn = (yaw - yaw_rad).rem_euclid(TAU);
                turn.min(TAU - turn)
            };
            let mut starts = vec![(yaw_rad, scale)];
            // Most objects have the same outline from behind.
            let opposite = evaluated.iter().find(|(_, yaw, _)| angle_to_best(*yaw) > 0.6);
            starts.extend(opposite.map(|(_, yaw, scale)| (*yaw, *scale)));
            Some(InitialMatch { category, mesh, merit, starts })
        });
        matches.max_by(|a, b| a.merit.total_cmp(&b.merit))
    }
}

#[cfg(test)]
mod tests;
