//! TSA, top-view spatial alignment: metric positions from one box per object in a top-view image.
//!
//! Method: TabletopGen, section "pose", and the supplement. With `r_phys = w / h` of a rotated object's footprint,
//! `r_img` the aspect ratio and `A_px` the area of its box,
//!
//! - `e = |ln r_phys - ln r_img|`, `RMA = A_px / (1 + (e / tau)^2)`: large boxes of a plausible shape score high;
//! - the *anchor* is the highest score, the table excluded; its size gives the scene's one scale `alpha = sqrt(w h /
//!   A_px)` in meters per pixel ([`TopViewScale::Anchor`], the paper's);
//! - or all objects vote on that scale, weighted by the plausibility of their shapes ([`TopViewScale::Consensus`],
//!   [`consensus`]);
//! - an object that deviates strongly from its box at that scale is rescaled to the box (in practice mostly the
//!   table), and every object is moved so that its rotated mesh's box and its box in the image have the same center.
//!   Votes that scatter more than their boxes' shapes explain come from inexact sizes; a consensus then also moves
//!   each size toward its box, as far as the box is more accurate.
//!
//! The footprint is that of the rotated mesh, not of its rotated box: [`footprint`] measures it. World origin: the
//! center of the table's box ([`TopViewOrigin::Table`], the paper's), or the best agreement of that center with the
//! positions seen by the reference camera ([`TopViewOrigin::Sightings`], [`sightings`]); +x to the right, +y up the
//! image (image y points down). The image must be orthographic. Exact up to the boxes: an error of a pixel in a box
//! moves its object by half a pixel, and in the anchor's box every object in proportion to its distance from the
//! center.

mod consensus;
mod settings;
mod sightings;

pub use consensus::{Consensus, Vote};
pub use settings::{TopViewOrigin, TopViewScale, TopViewSettings};
pub use sightings::Registration;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use self::sightings::{ByBoxes, Sighting};
use geometry::TexturedMesh;

/// Sizes are not corrected by less than a hundredth.
const NEGLIGIBLE_LOG_SCALE: f64 = 0.01;
/// Standard error of the logarithm of a scale that the request gives.
const GIVEN_SCALE_ERROR: f64 = 0.001;
/// Standard error of a box's sides as a share of its extent, if it cannot be measured.
const USUAL_BOX_SPREAD: f64 = 0.01;

/// A box on the image: x0, y0, x1, y1 in pixels, y down.
pub type BoxPx = [f64; 4];

/// Lowest and highest corner, relative to the object's origin, of a turned mesh seen from above, meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    pub low_m: DVec2,
    pub high_m: DVec2,
}

/// One object: its box in the image and its commonsense size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TopViewInstance {
    pub box_px: BoxPx,
    /// At its commonsense size, turned by its yaw.
    pub footprint: Footprint,
    /// Whether it may set the scale; false where its size or its yaw is a guess.
    pub may_anchor: bool,
    /// Center of its footprint as the reference camera sees it, world, meters, where that is known.
    pub seen_m: Option<DVec2>,
}

/// The boxes of a top view.
#[derive(Clone, Debug, PartialEq)]
pub struct TopViewProblem {
    pub table_box_px: BoxPx,
    /// Commonsense width and depth of the table top, meters.
    pub table_size_m: DVec2,
    pub instances: Vec<TopViewInstance>,
    /// Known scale of the image; overrules the anchor.
    pub meters_per_px: Option<f64>,
}

/// The estimated layout.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutEstimate {
    pub alpha_m_per_px: f64,
    /// Index of the instance that set the scale; `None` where it was given, where all voted on it, or where
    /// no instance could.
    pub anchor: Option<usize>,
    /// The consensus; `None` if there was no vote, or no instance could vote.
    pub consensus: Option<Consensus>,
    /// The registration with the reference camera's positions; `None` if there was none.
    pub registered: Option<Registration>,
    /// RMA score of each instance, square pixels.
    pub rma_scores: Vec<f64>,
    /// Width and depth of the table top by its box, meters.
    pub table_size_m: DVec2,
    /// Whether that differs strongly from its commonsense size.
    pub table_rescaled: bool,
    pub instances: Vec<InstanceLayout>,
}

/// Bounding box of an object seen from straight above, world, meters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoxFromAbove {
    pub center_m: DVec2,
    pub extent_m: DVec2,
}

/// Position and scale of one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstanceLayout {
    /// Factor on the commonsense size, the same for all axes; 1 unless `rescaled` or drawn toward the box by
    /// a consensus.
    pub scale: f64,
    /// World position of the object's origin.
    pub xy_m: DVec2,
    pub seen: BoxFromAbove,
    /// Whether the commonsense size deviated strongly from the box.
    pub rescaled: bool,
    /// `|ln r_phys - ln r_img|`: how little the box's shape is the footprint's.
    pub aspect_error: f64,
}

/// Reason why boxes give no layout.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TopViewError {
    #[error("aligning the top view: the table's box has no area; detect it again")]
    NoTableBox,
    #[error("aligning the top view: the box of instance {0} has no area; detect it again")]
    NoBox(usize),
    #[error("aligning the top view: instance {0} has no footprint; its mesh or its size is empty")]
    NoFootprint(usize),
    #[error("aligning the top view: {0} meters per pixel is no scale; give a positive number")]
    NoScale(f64),
}

/// Footprint of a canonical mesh turned by `yaw_rad` about +z.
pub fn footprint(mesh: &TexturedMesh, yaw_rad: f64) -> Footprint {
    let (sin, cos) = yaw_rad.sin_cos();
    let turned = mesh.positions.iter().map(|p| DVec2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y));
    let (low_m, high_m) =
        turned.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    if low_m.is_finite() {
        Footprint { low_m, high_m }
    } else {
        Footprint { low_m: DVec2::ZERO, high_m: DVec2::ZERO }
    }
}

/// Computes the layout from the boxes.
///
/// # Errors
///
/// [`TopViewError`] if a box, a footprint or the table's size is empty or not finite.
pub fn align_top_view(
    problem: &TopViewProblem,
    settings: &TopViewSettings,
) -> Result<LayoutEstimate, TopViewError> {
    let table_px = size(problem.table_box_px).ok_or(TopViewError::NoTableBox)?;
    let mut measured = Vec::with_capacity(problem.instances.len());
    for (index, instance) in problem.instances.iter().enumerate() {
        let box_px = size(instance.box_px).ok_or(TopViewError::NoBox(index))?;
        let extent_m = instance.footprint.high_m - instance.footprint.low_m;
        if !(extent_m.min_element() > 0.0 && extent_m.is_finite()) {
            return Err(TopViewError::NoFootprint(index));
        }
        let aspect_error = (extent_m.x / extent_m.y).ln() - (box_px.x / box_px.y).ln();
        measured.push(BoxFit { box_px, extent_m, aspect_error });
    }
    let rma_scores: Vec<f64> = measured.iter().map(|m| m.area_px() * m.believability(settings)).collect();
    let Scale { mut alpha, anchor, mut consensus } =
        scale_of(problem, &measured, &rma_scores, table_px, settings)?;
    let registered = match settings.origin {
        TopViewOrigin::Sightings => register(problem, alpha, consensus.as_ref(), table_px, settings),
        TopViewOrigin::Table => None,
    };
    if let Some(registered) = &registered {
        alpha = registered.log_alpha.exp();
        if let Some(consensus) = &mut consensus {
            consensus.log_alpha = registered.log_alpha;
            consensus.log_alpha_error = registered.log_alpha_error;
        }
    }
    let origin_m = registered.map_or(DVec2::ZERO, |registered| registered.origin_m);
    let table_center_px = center(problem.table_box_px);
    let instances = problem
        .instances
        .iter()
        .zip(&measured)
        .map(|(instance, measured)| {
            let off = (alpha / measured.alpha()).ln();
            let rescaled = off.abs() > settings.strong_deviation;
            let drawn = match &consensus {
                Some(consensus) if instance.may_anchor => toward_box(off, consensus),
                _ => 0.0,
            };
            let scale = if rescaled { off } else { drawn }.exp();
            let center_m = origin_m + alpha * upward(center(instance.box_px) - table_center_px);
            let own_center_m = 0.5 * (instance.footprint.low_m + instance.footprint.high_m);
            let aspect_error = measured.aspect_error.abs();
            let seen = BoxFromAbove { center_m, extent_m: alpha * measured.box_px };
            InstanceLayout { scale, xy_m: center_m - scale * own_center_m, seen, rescaled, aspect_error }
        })
        .collect();
    let table_size_m = alpha * table_px;
    let table_rescaled = (table_size_m / problem.table_size_m)
        .to_array()
        .iter()
        .any(|ratio| ratio.ln().abs().is_nan() || ratio.ln().abs() > settings.strong_deviation);
    Ok(LayoutEstimate {
        alpha_m_per_px: alpha,
        anchor,
        consensus,
        registered,
        rma_scores,
        table_size_m,
        table_rescaled,
        instances,
    })
}

/// A box with the footprint it should match.
struct BoxFit {
    box_px: DVec2,
    extent_m: DVec2,
    /// `ln r_phys - ln r_img`.
    aspect_error: f64,
}

impl BoxFit {
    fn area_px(&self) -> f64 {
        self.box_px.element_product()
    }

    /// Meters per pixel at which the footprint's area fills the box's.
    fn alpha(&self) -> f64 {
        (self.extent_m.element_product() / self.area_px()).sqrt()
    }

    /// Plausibility of the box: 1 for the footprint's shape, less for others.
    fn believability(&self, settings: &TopViewSettings) -> f64 {
        1.0 / (1.0 + (self.aspect_error / settings.tau).powi(2))
    }
}

/// Meters per pixel, and where they come from.
struct Scale {
    alpha: f64,
    anchor: Option<usize>,
    consensus: Option<Consensus>,
}

fn scale_of(
    problem: &TopViewProblem,
    measured: &[BoxFit],
    rma_scores: &[f64],
    table_px: DVec2,
    settings: &TopViewSettings,
) -> Result<Scale, TopViewError> {
    let (mut anchor, mut agreed) = (None, None);
    let alpha = match (problem.meters_per_px, settings.scale) {
        (Some(given), _) => Some(given),
        (None, TopViewScale::Anchor) => {
            anchor = highest(rma_scores, &problem.instances);
            anchor.map(|index| measured[index].alpha())
        }
        (None, TopViewScale::Consensus) => {
            let voters = measured.iter().zip(&problem.instances).filter(|(_, instance)| instance.may_anchor);
            let vote = |(measured, _): (&BoxFit, &TopViewInstance)| Vote {
                log_alpha: measured.alpha().ln(),
                log_aspect_error: measured.aspect_error,
                weight: measured.believability(settings),
            };
            agreed = consensus::consensus(&voters.map(vote).collect::<Vec<_>>(), settings.size_spread);
            agreed.map(|consensus| consensus.log_alpha.exp())
        }
    };
    let by_table = || (problem.table_size_m.element_product() / table_px.element_product()).sqrt();
    let alpha = alpha.unwrap_or_else(by_table);
    if !(alpha > 0.0 && alpha.is_finite()) {
        return Err(TopViewError::NoScale(alpha));
    }
    Ok(Scale { alpha, anchor, consensus: agreed })
}

/// Registers the boxes with the positions seen by the reference camera.
fn register(
    problem: &TopViewProblem,
    alpha: f64,
    consensus: Option<&Consensus>,
    table_px: DVec2,
    settings: &TopViewSettings,
) -> Option<Registration> {
    let table_center_px = center(problem.table_box_px);
    let sighting = |instance: &TopViewInstance| {
        let offset_px = upward(center(instance.box_px) - table_center_px);
        instance.seen_m.map(|seen_m| Sighting { offset_px, seen_m })
    };
    let sightings: Vec<Sighting> = problem.instances.iter().filter_map(sighting).collect();
    let log_alpha_error = match (problem.meters_per_px, consensus) {
        (Some(_), _) => GIVEN_SCALE_ERROR,
        (None, Some(consensus)) => consensus.log_alpha_error,
        (None, None) => settings.size_spread,
    };
    // The box's two sides err independently, and its center by their mean.
    let side_error = consensus.map_or(USUAL_BOX_SPREAD, |consensus| consensus.box_spread);
    let origin_error_m = (side_error / 2.0_f64.sqrt() * alpha * table_px).max(DVec2::splat(alpha));
    let boxes = ByBoxes { log_alpha: alpha.ln(), log_alpha_error, origin_error_m };
    sightings::register(&sightings, &boxes, settings.camera_spread)
}

/// The mean of commonsense and measured log size, each weighted by its accuracy; `off` is the measured one relative to
/// the other. Negligible corrections are 0.
fn toward_box(off: f64, consensus: &Consensus) -> f64 {
    let box_variance = consensus.box_spread.powi(2) + consensus.log_alpha_error.powi(2);
    let size_variance = consensus.size_spread.powi(2);
    let drawn = off * size_variance / (size_variance + box_variance).max(f64::MIN_POSITIVE);
    if drawn.abs() < NEGLIGIBLE_LOG_SCALE { 0.0 } else { drawn }
}

fn highest(scores: &[f64], instances: &[TopViewInstance]) -> Option<usize> {
    let mut best: Option<usize> = None;
    for (index, instance) in instances.iter().enumerate() {
        if instance.may_anchor && best.is_none_or(|b| scores[index] > scores[b]) {
            best = Some(index);
        }
    }
    best
}

fn size([x0, y0, x1, y1]: BoxPx) -> Option<DVec2> {
    let size = DVec2::new(x1 - x0, y1 - y0);
    (size.is_finite() && size.min_element() > 0.0).then_some(size)
}

/// An offset on the image, its y turned up.
fn upward(offset_px: DVec2) -> DVec2 {
    DVec2::new(offset_px.x, -offset_px.y)
}

fn center([x0, y0, x1, y1]: BoxPx) -> DVec2 {
    0.5 * DVec2::new(x0 + x1, y0 + y1)
}

#[cfg(test)]
mod tests;
