//! Objects that a text names, found among the objects of an image.
//!
//! [`named_evidence`] fits the meshes of every named kind to every object of the image, also kinds that no image
//! alone would suggest: all of the catalog, stand-ins in the size of their noun, slim meshes on their side.
//! [`assign_named`] then assigns the image's objects to the named ones jointly ([`assignment`](super::assignment)),
//! each at most once, so that counts bound the result. The benefit of a pair is the logarithm of an odds ratio: the
//! score of the fit ([`decision`](super::decision): outline, pattern, palette, size) and of the color, against all
//! other explanations of the object, with a prior for what the text names. Objects that fit nothing named better than
//! anything else stay unassigned; so do named objects that the image does not show.
//!
//! The scale of the image is the one of maximum joint likelihood, as in [`decision`](super::decision).

use rayon::prelude::*;

use super::assignment::maximize;
use super::decision::{log_sum, scales, score, score_of_fit};
use super::observed::{MaskedImage, Observation};
use super::outline_raster::Raster;
use super::stock_mesh::{StockCategory, StockMesh, VARIANTS, stock_of};
use super::{CategoryFitSettings, CategoryMatch, ObjectEvidence, Region, ViewGeometry};
use crate::object_recognizer::CategoryGuess;
use crate::pixels::{distance, lab_of_srgb};
use crate::reading::ImageReading;
use catalog::{Category, SizeRange};
use geometry::Rgb;
use imaging::{Image, Mask};
use runtime::{CancelFlag, Cancelled};

/// A kind of object that the text names.
#[derive(Clone, Copy, Debug)]
pub struct NamedKind {
    /// A category of the catalog, or the hidden category of a stand-in.
    pub category: &'static Category,
    /// Extents of small and large specimens, meters; a narrow range where the text states the size.
    pub size: SizeRange,
}

/// An object that the text names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedObject {
    /// Index of its kind.
    pub kind: usize,
    pub color: Option<Rgb>,
}

/// Named objects of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedAssignment {
    /// For each object of the image the index of the named object that it is.
    pub objects: Vec<Option<usize>>,
    /// Logarithm of the most likely scale: from the image's lengths to typical ones, with the opposite sign.
    pub log_scale: f64,
}

/// Prior odds of a named object against another explanation, natural logarithm. Set by hand: it makes up for the
/// categories of the catalog that the text leaves out.
const NAMED_PRIOR: f64 = 2.5;

/// Weight of shape, colors and size of a named kind, times that of a guess: the recognizer, which has seen shapes, may
/// not know this one. Set by hand.
const NAMED_FIT: f64 = 3.0;

/// Smallest probability of a guess for what the text names: the recognizer may not know an object of that kind.
const MIN_OF_NAMED: f64 = 0.02;

/// Benefit of a kind whose mesh cannot be compared: at the border of the image, or hidden.
const UNSEEN: f64 = -12.0;

/// Distance of colors that is one standard deviation, CIELAB with half the lightness, and the maximum number of them.
const COLOR_SIGMA: f32 = 14.0;
const MAX_COLOR_SIGMAS: f32 = 3.0;

/// Maximum error of the scale for named kinds, natural logarithm; the score decides about the rest.
const MAX_OVERSIZE: f64 = 1.2;

/// The best fit of each kind to each object of a reading in meters: `[object][kind]`. `guesses` are the recognizer's
/// for each object.
///
/// # Errors
///
/// [`Cancelled`] if `cancel` was set.
pub fn named_evidence(
    image: &Image,
    reading: &ImageReading,
    guesses: &[Vec<CategoryGuess>],
    kinds: &[NamedKind],
    settings: &CategoryFitSettings,
    cancel: &CancelFlag,
) -> Result<Vec<Vec<Option<CategoryMatch>>>, Cancelled> {
    let stocks: Vec<Stock> = kinds.iter().map(Stock::of).collect();
    let masks: Vec<&Mask> = reading.objects.iter().map(|object| &object.mask).collect();
    let masked = MaskedImage { image, camera: &reading.camera, masks: &masks };
    let max_oversize = settings.max_oversize.max(MAX_OVERSIZE);
    let fits = |index: usize| {
        let mut fits = fits_of_object(&masked, reading, index, &stocks, max_oversize, cancel)?;
        for (fit, kind) in fits.iter_mut().zip(kinds) {
            let guess = guesses[index].iter().find(|guess| guess.category.name == kind.category.name);
            let probability = guess.map_or(0.0, |guess| guess.probability);
            fit.iter_mut().for_each(|fit| fit.log_guess = probability.max(MIN_OF_NAMED).ln());
        }
        Ok(fits)
    };
    (0..masks.len()).into_par_iter().map(fits).collect()
}

fn fits_of_object(
    masked: &MaskedImage,
    reading: &ImageReading,
    index: usize,
    stocks: &[Stock],
    max_oversize: f64,
    cancel: &CancelFlag,
) -> Result<Vec<Option<CategoryMatch>>, Cancelled> {
    let mut fits: Vec<Option<CategoryMatch>> = vec![None; stocks.len()];
    let (solid, camera) = (&reading.objects[index].solid, masked.camera);
    let Some(observed) = Observation::new(masked, index, solid) else { return Ok(fits) };
    let Some(view) = ViewGeometry::new(camera, solid.center, solid.size.z) else { return Ok(fits) };
    let support_scale = reading.support_scale(index);
    let region = Region { observed: &observed, view: &view, camera, solid, support_scale };
    let mut raster = Raster::default();
    for (fit, stock) in fits.iter_mut().zip(stocks) {
        cancel.check()?;
        let first = region.initial_match(stock.get(), stock.meshes(), max_oversize);
        *fit = first.and_then(|first| region.fitted(&first, &mut raster));
    }
    Ok(fits)
}

/// The meshes of a kind: those of the process, or its own.
enum Stock {
    Shared(&'static StockCategory),
    Own(Box<StockCategory>),
}

impl Stock {
    fn of(kind: &NamedKind) -> Self {
        match stock_of(kind.category).filter(|stock| stock.size == kind.size) {
            Some(shared) => Self::Shared(shared),
            None => Self::Own(Box::new(StockCategory::new(kind.category, kind.size))),
        }
    }

    fn get(&self) -> &StockCategory {
        match self {
            Self::Shared(stock) => stock,
            Self::Own(stock) => stock,
        }
    }

    fn meshes(&self) -> impl Iterator<Item = &StockMesh> {
        let upright = (0..VARIANTS).filter_map(move |variant| self.get().mesh(variant));
        upright.chain(self.get().lying_mesh())
    }
}

/// Assigns the objects of the image to the named ones. `evidence` is of all categories
/// ([`evidence`](super::evidence)), `fits` of the named kinds, `colors` are the mean colors of the image's objects.
pub fn assign_named(
    evidence: &[ObjectEvidence],
    fits: &[Vec<Option<CategoryMatch>>],
    colors: &[Rgb],
    named: &[NamedObject],
) -> NamedAssignment {
    let color_costs: Vec<Vec<f64>> = colors
        .iter()
        .map(|seen| named.iter().map(|object| color_cost(*seen, object.color)).collect())
        .collect();
    let at_scale = |log_scale: f64| {
        let unnamed: Vec<f64> = evidence.iter().map(|found| log_sum(found, log_scale)).collect();
        let benefits: Vec<Vec<f64>> = fits
            .iter()
            .enumerate()
            .map(|(region, fits)| {
                let of_kind: Vec<f64> = fits
                    .iter()
                    .map(|fit| match fit {
                        Some(fit) => {
                            score(fit, log_scale) + (NAMED_FIT - 1.0) * score_of_fit(fit, log_scale)
                                - unnamed[region]
                        }
                        None => UNSEEN,
                    })
                    .collect();
                let benefit = |(index, object): (usize, &NamedObject)| {
                    NAMED_PRIOR + of_kind[object.kind] - color_costs[region][index]
                };
                named.iter().enumerate().map(benefit).collect()
            })
            .collect();
        let (objects, total) = maximize(&benefits, named.len());
        (objects, total + unnamed.iter().sum::<f64>())
    };
    let mut best = (NamedAssignment { objects: vec![None; fits.len()], log_scale: 0.0 }, f64::NEG_INFINITY);
    for (log_scale, prior) in scales() {
        let (objects, total) = at_scale(log_scale);
        if total + prior > best.1 {
            best = (NamedAssignment { objects, log_scale }, total + prior);
        }
    }
    best.0
}

/// Minus the logarithm of the likelihood of a color for what the text calls another.
fn color_cost(seen: Rgb, stated: Option<Rgb>) -> f64 {
    let Some(stated) = stated else { return 0.0 };
    // Light and shadow change lightness more than hue.
    let squeezed = |color: Rgb| {
        let [lightness, a, b] = lab_of_srgb(color);
        [0.5 * lightness, a, b]
    };
    let sigmas = (distance(squeezed(seen), squeezed(stated)) / COLOR_SIGMA).min(MAX_COLOR_SIGMAS);
    0.5 * f64::from(sigmas * sigmas)
}

#[cfg(test)]
mod tests;
