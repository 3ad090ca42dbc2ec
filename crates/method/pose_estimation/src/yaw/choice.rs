//! Choice among poses with the same outline by the image's colors.
//!
//! A book, a keyboard, a labeled jar have the same outline after half a turn or at any angle; their colors differ. If
//! the outline has clear minima, colors choose among them, together with the share of the outline on image edges. If
//! the outline is equally good over a stretch of yaws (a jar, a mug with its handle hidden), colors are compared along
//! the whole stretch. The chosen yaw has the lowest value, however small the difference. Only without any difference
//! it is the canonical one. Whether the poses differ *clearly* decides the remaining symmetry.

use std::f64::consts::TAU;
use std::sync::Arc;

use rayon::prelude::*;

use super::comparison::{Comparison, Place};
use super::crop::Crop;
use super::image_edges::ImageEdges;
use super::outline_mesh::OutlineMesh;
use super::search::PoseCandidate;
use super::{YawProblem, YawSettings, symmetry};
use crate::appearance::{ImageCrop, Model};
use geometry::TexturedMesh;
use geometry::optimize::golden_section;
use geometry::pose::wrap_angle_rad;
use imaging::Image;
use runtime::{CancelFlag, Cancelled};

/// Yaws tried at first if the outline carries no information.
const TURNS: usize = 36;

/// Share of a turn without a break from which on yaws that are as good are a stretch and not a minimum.
const STRETCH: f64 = 1.0 / 12.0;

/// Share of the range of color disagreement up to which a yaw agrees.
const AGREE: f64 = 0.35;

/// Rounding bound of the color disagreement.
const INDIFFERENT: f64 = 0.004;

/// Two yaws closer than this are one candidate, radians.
const SAME_YAW_RAD: f64 = 0.05;

/// Turn by which the outline's loss must have risen to either side of a minimum, radians, and by how much.
const RELIEF_RAD: f64 = 0.13;
const RELIEF: f64 = 0.002;

/// Width of the interval at which the refinement by colors stops, radians.
const COLOR_TOLERANCE_RAD: f64 = 0.012;

/// Maximum number of yaws of a stretch that are compared on finer images, and the largest excess of their value over
/// the best.
const MAX_FINE_COMPARISONS: usize = 4;
const CLOSE: f64 = 0.004;

/// An instance's colors, cropped to a side of so many pixels.
pub struct Colors<'a> {
    problem: &'a YawProblem<'a>,
    image: &'a Image,
    outline: &'a OutlineMesh,
    settings: &'a YawSettings,
    model: Arc<Model<'a>>,
    crop: Crop,
    cropped: ImageCrop,
    /// The refinement's crop, fine enough to compare outlines with edges.
    fine: &'a Crop,
    edges: Arc<ImageEdges>,
}

/// Result of the outline search.
pub struct Outlines<'a> {
    /// (yaw, loss) over the whole turn, evenly.
    pub curve: &'a [(f64, f64)],
    /// Refined, best first.
    pub top: &'a [PoseCandidate],
    /// Order of its symmetry.
    pub order: u32,
    /// Placement at any yaw if a part of the object is hidden; otherwise approximately the placement whose box fits
    /// the mask's.
    pub place: Option<Place>,
}

/// The chosen yaw and the order of the symmetry that outline and colors share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    pub yaw_rad: f64,
    pub symmetry_order: u32,
}

/// A yaw with its outline loss and its color disagreement.
#[derive(Clone, Copy)]
struct ScoredYaw {
    yaw_rad: f64,
    loss: f64,
    disagreement: f64,
}

impl<'a> Colors<'a> {
    /// `plain` is the problem's mesh without its textures, if it has any, `outline` its outline, `image` its image,
    /// `fine` the refinement's crop.
    pub fn new(
        problem: &'a YawProblem<'a>,
        plain: Option<&'a TexturedMesh>,
        image: &'a Image,
        outline: &'a OutlineMesh,
        fine: &'a Crop,
        side_px: usize,
        settings: &'a YawSettings,
    ) -> Self {
        let model = Arc::new(Model::new(problem.mesh, plain));
        let (crop, cropped) = cropped(problem, image, bbox_px(fine), side_px);
        let edges = Arc::new(ImageEdges::new(image, problem.camera, fine));
        Self { problem, image, outline, settings, model, crop, cropped, fine, edges }
    }

    /// Returns the comparison of colors on twice as many pixels each way.
    fn sharper(&self) -> Self {
        let (crop, cropped) = cropped(self.problem, self.image, bbox_px(self.fine), 2 * self.crop.side_px);
        Self { crop, cropped, model: self.model.clone(), edges: self.edges.clone(), ..*self }
    }

    fn comparison(&self, place: Option<Place>) -> Comparison<'_> {
        self.comparison_on(&self.crop, place)
    }

    fn comparison_on<'c>(&'c self, crop: &'c Crop, place: Option<Place>) -> Comparison<'c> {
        let YawProblem { camera, support_height_m, .. } = *self.problem;
        Comparison::new(self.outline, camera, support_height_m, crop, self.settings).standing_at(place)
    }

    /// The outline's loss on images of this size.
    fn loss(&self, yaw_rad: f64, place: Option<Place>) -> f64 {
        self.comparison(place).loss(yaw_rad)
    }

    /// Of colors, plus the share of the outline that lies on no edge of the image.
    fn disagreement(&self, candidate: &PoseCandidate, cancel: &CancelFlag) -> Result<f64, Cancelled> {
        cancel.check()?;
        let PoseCandidate { yaw_rad, place, .. } = *candidate;
        let colors = self.cropped.disagreement(&self.model, &self.comparison(place), yaw_rad);
        Ok(colors + self.comparison_on(self.fine, place).off_edges(yaw_rad, &self.edges))
    }

    fn score(&self, candidate: &PoseCandidate, cancel: &CancelFlag) -> Result<ScoredYaw, Cancelled> {
        let disagreement = self.disagreement(candidate, cancel)?;
        Ok(ScoredYaw { yaw_rad: candidate.yaw_rad, loss: candidate.loss, disagreement })
    }
}

/// The box of a crop's mask.
fn bbox_px(crop: &Crop) -> [u32; 4] {
    [crop.low_px.x, crop.low_px.y, crop.high_px.x, crop.high_px.y].map(|side| side as u32)
}

/// Mask and image, cropped alike.
fn cropped(problem: &YawProblem, image: &Image, bbox: [u32; 4], side_px: usize) -> (Crop, ImageCrop) {
    let camera = problem.camera;
    let crop = Crop::new(problem.mask, problem.unknown, bbox, side_px);
    let crop_px = [0.0, 0.0, f64::from(camera.width_px), f64::from(camera.height_px)];
    let colors = ImageCrop::new(image, crop_px, &crop);
    (crop, colors)
}

impl ScoredYaw {
    fn value(&self, settings: &YawSettings) -> f64 {
        self.loss + settings.appearance_weight * self.disagreement
    }
}

/// The yaw that outline and colors prefer.
pub fn choose(
    colors: &Colors,
    outlines: &Outlines,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<Choice, Cancelled> {
    let stretches = as_good(outlines, settings);
    if !stretches.is_empty() {
        return along(colors, outlines, &stretches, settings, cancel);
    }
    if outlines.order == 1 {
        among(colors, outlines, settings, cancel)
    } else {
        turned(colors, outlines, settings, cancel)
    }
}

/// The yaws of the curve whose outline is as good as the best, if they make up a stretch.
fn as_good(outlines: &Outlines, settings: &YawSettings) -> Vec<f64> {
    let curve = outlines.curve;
    let lowest = curve.iter().map(|c| c.1).fold(f64::INFINITY, f64::min);
    let good: Vec<bool> = curve.iter().map(|c| c.1 <= lowest + settings.same_outline).collect();
    let (mut run, mut longest) = (0, 0);
    for k in 0..2 * good.len() {
        run = if good[k % good.len()] { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    if (longest.min(good.len()) as f64) < STRETCH * good.len() as f64 {
        return Vec::new();
    }
    curve.iter().zip(&good).filter(|(_, good)| **good).map(|(c, _)| c.0).collect()
}

/// Colors along stretches of yaws, then between the neighbors of the best.
fn along(
    colors: &Colors,
    outlines: &Outlines,
    yaws: &[f64],
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<Choice, Cancelled> {
    let best = outlines.top[0];
    let step_rad = TAU / outlines.curve.len() as f64;
    let loss_at = |yaw_rad: f64| {
        let at = yaw_rad.rem_euclid(TAU) / step_rad;
        let value = |k: usize| outlines.curve[k % outlines.curve.len()].1;
        value(at as usize) * (1.0 - at.fract()) + value(at as usize + 1) * at.fract()
    };
    let fitted = |yaw_rad: f64| colors.comparison(None).fitted(yaw_rad);
    // Offset of the best pose from the box fit: the other yaws get the same, unless a part is hidden.
    let off = best.place.zip(fitted(best.yaw_rad)).map(|(place, fitted)| place.beside(fitted));
    let place_at = |yaw_rad: f64| {
        outlines.place.or_else(|| off.zip(fitted(yaw_rad)).map(|(off, fitted)| fitted.moved(off)))
    };
    let score_at = |colors: &Colors, yaw_rad: f64| {
        colors.score(&PoseCandidate { yaw_rad, loss: loss_at(yaw_rad), place: place_at(yaw_rad) }, cancel)
    };
    let score = |yaw_rad: f64| score_at(colors, yaw_rad);
    let stride = yaws.len().div_ceil(TURNS);
    let mut scored =
        yaws.par_iter().step_by(stride).map(|&yaw_rad| score(yaw_rad)).collect::<Result<Vec<_>, _>>()?;
    let even = scored.len();
    let (low, high) = range(scored.iter().map(|l| l.disagreement));
    if high - low >= settings.flat_appearance {
        // Detail may vary faster than that (slats, letters): test the yaws in between, next to those that agree.
        let agree = low + AGREE * (high - low);
        let agrees: Vec<bool> = scored.iter().map(|l| l.disagreement <= agree).collect();
        let between = yaws.par_iter().enumerate().filter(|(k, _)| {
            let before = k / stride;
            k % stride != 0 && (agrees[before] || agrees[(before + 1) % agrees.len()])
        });
        scored.extend(between.map(|(_, &yaw_rad)| score(yaw_rad)).collect::<Result<Vec<_>, _>>()?);
    }
    let whole_turn = yaws.len() == outlines.curve.len();
    let symmetry_order = if !whole_turn {
        1
    } else if high - low < settings.flat_appearance {
        0
    } else {
        let curve: Vec<(f64, f64)> = scored.iter().take(even).map(|l| (l.yaw_rad, l.disagreement)).collect();
        symmetry::periodic_order(&curve, 2.0 * settings.periodic_share)
    };
    if high - low < INDIFFERENT {
        let yaw_rad = symmetry::representative(best.yaw_rad, if whole_turn { 0 } else { outlines.order });
        return Ok(Choice { yaw_rad, symmetry_order });
    }
    scored.sort_by(|a, b| a.value(settings).total_cmp(&b.value(settings)));
    let reach_rad = if scored.len() > even { step_rad } else { stride as f64 * step_rad };
    let sharp = colors.sharper();
    let sharply = |yaw_rad: f64| {
        let place = place_at(yaw_rad);
        let candidate = PoseCandidate { yaw_rad, loss: sharp.loss(yaw_rad, place), place };
        Ok((yaw_rad, sharp.score(&candidate, cancel)?.value(settings)))
    };
    let mut best_yaws: Vec<f64> = Vec::new();
    for l in scored.iter().filter(|l| l.value(settings) <= scored[0].value(settings) + CLOSE) {
        let apart = |yaw_rad: &f64| wrap_angle_rad(yaw_rad - l.yaw_rad).abs() > 1.5 * reach_rad;
        if best_yaws.len() < MAX_FINE_COMPARISONS && best_yaws.iter().all(apart) {
            best_yaws.push(l.yaw_rad);
        }
    }
    // Between neighbors the curve is not smooth: half steps first, then golden sections.
    let around = lowest(best_yaws.into_par_iter().map(sharply).collect::<Result<_, _>>()?);
    let beside = [-1.0, -0.5, 0.5, 1.0].map(|share| around.0 + share * reach_rad);
    let beside = lowest(beside.into_par_iter().map(sharply).collect::<Result<_, _>>()?);
    let around = if beside.1 < around.1 { beside } else { around };
    let (from, to) = (around.0 - 0.5 * reach_rad, around.0 + 0.5 * reach_rad);
    let found = golden_section(from, to, COLOR_TOLERANCE_RAD, |yaw_rad| Ok(sharply(yaw_rad)?.1))?;
    let yaw_rad = if found.1 <= around.1 { found.0 } else { around.0 };
    // Colors are compared on small images; a minimum of the outline is sharper where it is no mere facet.
    let off = |c: &&PoseCandidate| wrap_angle_rad(c.yaw_rad - yaw_rad).abs();
    let rises = |c: &&PoseCandidate| {
        let beside = [-RELIEF_RAD, RELIEF_RAD].map(|turn_rad| loss_at(c.yaw_rad + turn_rad));
        beside[0].min(beside[1]) > loss_at(c.yaw_rad) + RELIEF
    };
    let near = outlines.top.iter().filter(|c| off(c) < SAME_YAW_RAD && rises(c));
    let refined = near.min_by(|a, b| off(a).total_cmp(&off(b)));
    Ok(Choice { yaw_rad: refined.map_or(yaw_rad, |c| c.yaw_rad), symmetry_order })
}

/// Colors of the outline's candidates.
fn among(
    colors: &Colors,
    outlines: &Outlines,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<Choice, Cancelled> {
    let best = outlines.top[0];
    let mut chosen = (best.yaw_rad, f64::INFINITY);
    for candidate in outlines.top.iter().filter(|c| c.loss <= best.loss + settings.same_outline) {
        // Colors add to the loss: no outline from here on can be chosen.
        if candidate.loss >= chosen.1 {
            break;
        }
        let value = colors.score(candidate, cancel)?.value(settings);
        if value < chosen.1 {
            chosen = (candidate.yaw_rad, value);
        }
    }
    Ok(Choice { yaw_rad: chosen.0, symmetry_order: 1 })
}

/// Colors of the poses that the outline's symmetry makes one.
fn turned(
    colors: &Colors,
    outlines: &Outlines,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<Choice, Cancelled> {
    let (best, order) = (outlines.top[0], outlines.order.max(1));
    let step_rad = TAU / f64::from(order);
    let mut scored = Vec::new();
    for k in 0..order {
        let yaw_rad = best.yaw_rad + f64::from(k) * step_rad;
        // Take the refined candidate if there is one: a symmetry holds to within noise, not to the bit.
        let off = |c: &&PoseCandidate| wrap_angle_rad(c.yaw_rad - yaw_rad).abs();
        let refined = outlines.top.iter().filter(|c| off(c) < SAME_YAW_RAD);
        let candidate = refined.min_by(|a, b| a.loss.total_cmp(&b.loss)).copied();
        scored.push(colors.score(&candidate.unwrap_or(PoseCandidate { yaw_rad, ..best }), cancel)?);
    }
    let n = scored.len();
    let apart = |a: &ScoredYaw, b: &ScoredYaw| (a.disagreement - b.disagreement).abs();
    let alike =
        |m: usize| (0..n).all(|k| apart(&scored[k], &scored[(k + n / m) % n]) < settings.flat_appearance);
    let left = (1..=n).rev().find(|m| n.is_multiple_of(*m) && alike(*m)).unwrap_or(1);
    let (low, high) = range(scored.iter().map(|l| l.disagreement));
    let chosen = scored.iter().min_by(|a, b| a.value(settings).total_cmp(&b.value(settings)));
    let yaw_rad = match chosen {
        Some(chosen) if high - low >= INDIFFERENT => chosen.yaw_rad,
        _ => symmetry::representative(best.yaw_rad, order),
    };
    Ok(Choice { yaw_rad, symmetry_order: left as u32 })
}

/// The pair with the lowest second number; infinite where there is none.
fn lowest(pairs: Vec<(f64, f64)>) -> (f64, f64) {
    pairs.into_iter().fold((0.0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a })
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}
