//! Classification of objects into catalog categories by render-and-compare.
//!
//! Steps, each in its own file: [`observed`] reduces an object to a grid of some 40 cells. Its silhouette is
//! compared with the outlines of every category of plausible size from all directions ([`views`], of meshes from
//! [`stock_mesh`]). The best are placed at the object and moved, rotated and stretched until their outlines fit
//! ([`stance_fit`], rasterized by [`outline_raster`]). [`appearance`] measures how much of the color pattern their
//! parts and prints explain. [`decision`] weighs this evidence: one scale for the whole image, a score for each
//! candidate, and the confidence of the best one.
//!
//! Input: a reading in meters at a working scale that may be off by a third. The evidence does not depend on the
//! decision, so candidates can be left out afterwards. Deterministic. Cost: about 50 ms of one core an object, and
//! once a process some two seconds for the catalog's meshes and their outlines.

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
use self::stock_mesh::{StockCategory, StockMesh, VARIANTS, stock};
use super::reading::ImageReading;
use geometry::Camera;
use imaging::{Image, Mask};
use runtime::{CancelFlag, Cancelled};

/// Evidence about one object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectEvidence {
    /// The best-matching categories, each with its best stance.
    pub matches: Vec<CategoryMatch>,
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
    /// Seed of the catalog's recipe.
    pub variant: u64,
    /// Center of its base, yaw about +z, and extents, as if it stood on the table, meters.
    pub center: DVec2,
    pub yaw_rad: f64,
    pub size_m: DVec3,
    /// Intersection over union with the object's visible pixels, and the penalty of unusual proportions.
    pub overlap: f64,
    pub stray: f64,
    /// Overlap of the outlines before the fit, each stretched to its box.
    pub first_overlap: f64,
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

/// Collects the evidence for every object of a reading in meters. `image` is the one that was read. Returns empty
/// evidence if the settings disable naming.
///
/// # Errors
///
/// [`Cancelled`] if `cancel` was set.
pub fn evidence(
    image: &Image,
    reading: &ImageReading,
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
        .map(|index| object_evidence(&masked, reading, index, settings, cancel))
        .collect()
}

fn object_evidence(
    masked: &MaskedImage,
    reading: &ImageReading,
    index: usize,
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
    let region =
        Region { observed: &observed, view: &view_geometry, camera, center: solid.center, support_scale };
    let mut matches: Vec<CategoryMatch> = Vec::new();
    for first in initial_matches(&region, settings, cancel)? {
        cancel.check()?;
        matches.extend(region.fitted(&first, &mut raster));
    }
    Ok(ObjectEvidence {
        matches,
        solid_overlap: solid.overlap,
        hidden_rim: observed.hidden_rim,
        area_cells: f64::from(observed.area),
        cell_px: observed.grid.cell_px,
    })
}

/// One object of the image and what its fits need.
struct Region<'a> {
    observed: &'a Observation,
    view: &'a ViewGeometry,
    camera: &'a Camera,
    center: DVec2,
    support_scale: f64,
}

impl Region<'_> {
    /// The mesh at its best stance; `None` if it covers too little of the object.
    fn fitted(&self, first: &InitialMatch, raster: &mut Raster) -> Option<CategoryMatch> {
        let fit = StanceFit { observed: self.observed, camera: self.camera, mesh: first.mesh };
        let stances = first.starts.iter().filter_map(|(yaw_rad, stretch)| {
            let stance = Stance {
                center: self.center,
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
    let usual = |size: DVec3| size.to_array().map(f64::ln).iter().sum::<f64>() / 3.0;
    let (low, high) = (usual(size.low_m), usual(size.high_m));
    CategoryMatch {
        category: &category.name,
        is_lying: first.mesh.is_lying,
        variant: first.mesh.variant,
        center: fitted.stance.center,
        yaw_rad: (fitted.stance.yaw_rad + PI).rem_euclid(TAU) - PI,
        size_m,
        overlap: fitted.overlap,
        stray: fitted.stray,
        first_overlap: first.overlap,
        oversize: usual(support_scale * size_m) - 0.5 * (low + high),
        usual_spread: 0.5 * (high - low),
        by_ramp: seen.by_ramp,
        by_mesh: seen.by_mesh,
        contrast: seen.contrast,
        off_palette: seen.off_palette,
    }
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
    overlap: f64,
    merit: f64,
    /// Yaw and scale.
    starts: Vec<(f64, f64)>,
}

/// Weight of the squared logarithm of an aspect ratio beyond the free range, and that range.
const ASPECT_PRICE: f64 = 0.6;
const FREE_ASPECT: f64 = 0.12;

/// The candidates with the best-matching outlines, best first.
fn initial_matches(
    region: &Region,
    settings: &CategoryFitSettings,
    cancel: &CancelFlag,
) -> Result<Vec<InitialMatch<'static>>, Cancelled> {
    let mut first: Vec<InitialMatch> = Vec::new();
    for category in stock().iter().filter(|stock| stock.category.is_image_candidate) {
        cancel.check()?;
        // The best-matching variant of each category.
        let meshes = (0..VARIANTS).filter_map(|variant| category.mesh(variant));
        first.extend(region.initial_match(category, meshes, settings.max_oversize));
    }
    first.sort_by(|a, b| b.merit.total_cmp(&a.merit));
    first.truncate(settings.candidates as usize);
    Ok(first)
}

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
            let mut evaluated: Vec<(f64, f64, f64, f64)> = Vec::new();
            for view in mesh.views(view_geometry.elevation_rad) {
                let ratio = seen_m / DVec2::new(view.width_m, view.height_m).max(DVec2::splat(1e-6));
                let scale = (ratio.x * ratio.y).sqrt();
                if (scale * support_scale).ln().abs() > max_oversize + 0.2 {
                    continue;
                }
                let off = ((ratio.x / ratio.y).ln().abs() - FREE_ASPECT).max(0.0);
                let overlap = views::overlap(&view.bits, &observed.bits, &observed.hidden_bits);
                evaluated.push((overlap - ASPECT_PRICE * off * off, overlap, view.yaw_rad, scale));
            }
            evaluated.sort_by(|a, b| b.0.total_cmp(&a.0));
            let &(merit, overlap, yaw_rad, scale) = evaluated.first()?;
            let angle_to_best = |yaw: f64| {
                let turn = (yaw - yaw_rad).rem_euclid(TAU);
                turn.min(TAU - turn)
            };
            let mut starts = vec![(yaw_rad, scale)];
            // Most objects have the same outline from behind.
            let opposite = evaluated.iter().find(|(_, _, yaw, _)| angle_to_best(*yaw) > 0.6);
            starts.extend(opposite.map(|(_, _, yaw, scale)| (*yaw, *scale)));
            Some(InitialMatch { category, mesh, overlap, merit, starts })
        });
        matches.max_by(|a, b| a.merit.total_cmp(&b.merit))
    }
}

#[cfg(test)]
mod tests;
