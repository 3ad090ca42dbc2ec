//! Which category of the catalog a thing in a picture is of, by rendering the catalog and comparing.
//!
//! Steps, each in its own file: [`observed`] reduces a thing to a grid of some 40 cells; outlines of every category of
//! plausible size from all around ([`views`], of meshes from [`stock_mesh`]) are held against its silhouette; the best
//! are stood where the thing stands and moved, turned and stretched until their outlines fit ([`stance_fit`], drawn by
//! [`outline_raster`]); [`appearance`] says what their parts and prints explain of the colors. That is the evidence.
//! [`decision`] weighs it: one scale for the whole picture, a score for each candidate, and how sure the best one is.
//!
//! In: a reading in meters at a working scale that may be off by a third. The evidence does not depend on the decision, so
//! that candidates can be left out afterwards. Deterministic. Cost: about 50 ms of one core a thing, and once a
//! process some two seconds for the catalog's meshes and their outlines.

mod appearance;
mod decision;
mod observed;
mod outline_raster;
mod settings;
mod stance_fit;
mod stock_mesh;
mod views;

pub use decision::{Named, Naming, names};
pub use settings::CategoryFitSettings;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use self::appearance::Appearance;
use self::observed::{Observed, Shown};
use self::outline_raster::{Raster, Stance};
use self::stance_fit::StanceFit;
use self::stock_mesh::{StockCategory, StockMesh, VARIANTS, stock};
use super::reading::PictureReading;
use geometry::Camera;
use imaging::{Image, Mask};
use runtime::{Interrupt, Interrupted};

/// What was found out about a thing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThingEvidence {
    /// The categories that look most like it, each with its best stance.
    pub looks: Vec<CategoryLook>,
    /// Overlap of the simple solid that it was read as.
    pub solid_overlap: f64,
    /// Share of its rim along which something else may hide it.
    pub hidden_rim: f64,
    /// Its area in cells of the grid, and the side of a cell in pixels.
    pub area_cells: f64,
    pub cell_px: f64,
}

/// A category stood where a thing stands.
#[derive(Clone, Debug, PartialEq)]
pub struct CategoryLook {
    /// Name in the catalog.
    pub category: &'static str,
    /// Seed of the catalog's recipe.
    pub variant: u64,
    /// Middle of its base and turn about +z, extents; as if it stood on the table, meters.
    pub center: DVec2,
    pub yaw_rad: f64,
    pub size_m: DVec3,
    /// Intersection over union with the thing's pixels, hidden ones left out, and the price of strange proportions.
    pub overlap: f64,
    pub stray: f64,
    /// Overlap of the outlines before anything was moved, each stretched to its box.
    pub first_overlap: f64,
    /// Natural logarithm of its mean extent against the category's usual one where it stands, and how far the usual
    /// ones reach to either side.
    pub oversize: f64,
    pub usual_spread: f64,
    /// Share of the colors' variance that a smooth ramp explains, and that the mesh explains with it.
    pub by_ramp: f64,
    pub by_mesh: f64,
    /// Standard deviation of the colors, and distance to the category's usual ones; CIELAB.
    pub contrast: f64,
    pub off_palette: f64,
}

/// Looks at every thing of a reading in meters. `picture` is the one that was read. Finds nothing where nothing would be named.
pub fn evidence(
    picture: &Image,
    reading: &PictureReading,
    settings: &CategoryFitSettings,
    interrupt: &Interrupt,
) -> Result<Vec<ThingEvidence>, Interrupted> {
    if settings.least_confidence >= 1.0 {
        return Ok(vec![ThingEvidence::default(); reading.objects.len()]);
    }
    let masks: Vec<&Mask> = reading.objects.iter().map(|object| &object.mask).collect();
    let shown = Shown { picture, camera: &reading.camera, masks: &masks };
    (0..masks.len())
        .into_par_iter()
        .map(|index| looked_at(&shown, reading, index, settings, interrupt))
        .collect()
}

fn looked_at(
    shown: &Shown,
    reading: &PictureReading,
    index: usize,
    settings: &CategoryFitSettings,
    interrupt: &Interrupt,
) -> Result<ThingEvidence, Interrupted> {
    interrupt.check()?;
    let solid = &reading.objects[index].solid;
    let Some(observed) = Observed::new(shown, index, solid) else { return Ok(ThingEvidence::default()) };
    let nearer = reading.nearer(index);
    let camera = shown.camera;
    let Some(sight) = Sight::new(camera, solid.center, solid.size.z) else {
        return Ok(ThingEvidence::default());
    };
    let mut raster = Raster::default();
    let mut looks: Vec<CategoryLook> = Vec::new();
    for first in first_looks(&observed, &sight, nearer, settings, interrupt)? {
        interrupt.check()?;
        let fit = StanceFit { observed: &observed, camera, mesh: first.mesh };
        let stances = first.starts.iter().filter_map(|(yaw_rad, stretch)| {
            let stance = Stance {
                center: solid.center,
                yaw_rad: yaw_rad + sight.azimuth_rad,
                stretch: DVec3::splat(*stretch),
            };
            fit.from(stance, &mut raster)
        });
        let best = stances.max_by(|a, b| a.merit().total_cmp(&b.merit()));
        let Some(best) = best else { continue };
        let Some(appearance) = appearance::compared(
            &observed,
            camera,
            first.mesh,
            &first.category.palette,
            &best.stance,
            &mut raster,
        ) else {
            continue;
        };
        looks.push(look(&first, &best, &appearance, nearer));
    }
    Ok(ThingEvidence {
        looks,
        solid_overlap: solid.overlap,
        hidden_rim: observed.hidden_rim,
        area_cells: f64::from(observed.area),
        cell_px: observed.grid.cell_px,
    })
}

fn look(first: &FirstLook, fitted: &stance_fit::Fitted, seen: &Appearance, nearer: f64) -> CategoryLook {
    let category = first.mesh.category;
    let size_m = fitted.stance.stretch * first.mesh.size_m;
    let usual = |size: DVec3| size.to_array().map(f64::ln).iter().sum::<f64>() / 3.0;
    let (low, high) = (usual(category.size.low_m), usual(category.size.high_m));
    CategoryLook {
        category: &category.name,
        variant: first.mesh.variant,
        center: fitted.stance.center,
        yaw_rad: (fitted.stance.yaw_rad + PI).rem_euclid(TAU) - PI,
        size_m,
        overlap: fitted.overlap,
        stray: fitted.stray,
        first_overlap: first.overlap,
        oversize: usual(nearer * size_m) - 0.5 * (low + high),
        usual_spread: 0.5 * (high - low),
        by_ramp: seen.by_ramp,
        by_mesh: seen.by_mesh,
        contrast: seen.contrast,
        off_palette: seen.off_palette,
    }
}

/// How a thing is looked at.
struct Sight {
    elevation_rad: f64,
    /// Of the direction away from the eye, against +y.
    azimuth_rad: f64,
    /// Meters across the view a pixel, at the thing.
    m_per_px: f64,
}

impl Sight {
    fn new(camera: &Camera, center: DVec2, height_m: f64) -> Option<Self> {
        let middle = center.extend(0.5 * height_m);
        let (_, depth) = camera.project(middle)?;
        let away = middle - camera.world_from_camera.translation_m;
        let elevation_rad = (-away.z).atan2(away.truncate().length());
        let azimuth_rad = away.y.atan2(away.x) - FRAC_PI_2;
        Some(Self { elevation_rad, azimuth_rad, m_per_px: depth / camera.fx })
    }
}

/// A category's mesh and the yaws, relative to the view, at which it looks most like a thing.
struct FirstLook {
    category: &'static StockCategory,
    mesh: &'static StockMesh,
    overlap: f64,
    merit: f64,
    /// Yaw and scale.
    starts: Vec<(f64, f64)>,
}

/// Price of an aspect that is off (natural logarithm, squared) beyond what proportions may stray.
const ASPECT_PRICE: f64 = 0.6;
const FREE_ASPECT: f64 = 0.12;

/// The meshes whose outlines look most like the thing, best first.
fn first_looks(
    observed: &Observed,
    sight: &Sight,
    nearer: f64,
    settings: &CategoryFitSettings,
    interrupt: &Interrupt,
) -> Result<Vec<FirstLook>, Interrupted> {
    let seen_m = sight.m_per_px * (observed.high_px - observed.low_px);
    let seen_m = seen_m.max(DVec2::splat(1e-6));
    let mut first: Vec<FirstLook> = Vec::new();
    for category in stock() {
        let size = &category.category.size;
        // No view is wider than the box's diagonal, and none smaller than its shortest side allows.
        let longest_m = seen_m.max_element() * nearer;
        let slack = settings.most_oversize.exp();
        if longest_m > slack * size.high_m.length() || longest_m * slack < 0.5 * size.low_m.min_element() {
            continue;
        }
        interrupt.check()?;
        let looks = (0..VARIANTS).filter_map(|variant| {
            let mesh = category.mesh(variant)?;
            let mut judged: Vec<(f64, f64, f64, f64)> = Vec::new();
            for view in mesh.views(sight.elevation_rad) {
                let ratio = seen_m / DVec2::new(view.width_m, view.height_m).max(DVec2::splat(1e-6));
                let scale = (ratio.x * ratio.y).sqrt();
                if (scale * nearer).ln().abs() > settings.most_oversize + 0.2 {
                    continue;
                }
                let off = ((ratio.x / ratio.y).ln().abs() - FREE_ASPECT).max(0.0);
                let overlap = views::overlap(&view.bits, &observed.bits, &observed.hidden_bits);
                judged.push((overlap - ASPECT_PRICE * off * off, overlap, view.yaw_rad, scale));
            }
            judged.sort_by(|a, b| b.0.total_cmp(&a.0));
            let &(merit, overlap, yaw_rad, scale) = judged.first()?;
            let apart = |yaw: f64| {
                let turn = (yaw - yaw_rad).rem_euclid(TAU);
                turn.min(TAU - turn)
            };
            let mut starts = vec![(yaw_rad, scale)];
            // From behind most things have the outline that they have from before.
            let opposite = judged.iter().find(|(_, _, yaw, _)| apart(*yaw) > 0.6);
            starts.extend(opposite.map(|(_, _, yaw, scale)| (*yaw, *scale)));
            Some(FirstLook { category, mesh, overlap, merit, starts })
        });
        // Of a category's variants the one that looks most like it.
        first.extend(looks.max_by(|a, b| a.merit.total_cmp(&b.merit)));
    }
    first.sort_by(|a, b| b.merit.total_cmp(&a.merit));
    first.truncate(settings.candidates as usize);
    Ok(first)
}

#[cfg(test)]
mod tests;
