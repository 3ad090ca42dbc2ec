//! DRO, differentiable rotation optimization: the yaw at which an instance's mesh matches its outline in the image.
//!
//! Method: TabletopGen, section "pose", and the supplement. The mesh is placed on the instance's own viewing ray with
//! the full intrinsics. Its silhouette and the mask are cropped to their boxes, padded to squares and compared at 256
//! x 256: `loss = w_sil * L_sil + w_edge * L_edge` with
//!
//! - `L_sil = 1 - sum(S^ S) / sum(S + S^ - S S^)`, the soft intersection over union;
//! - `L_edge = sum(D_S E^) / sum(E^) / side`, the one-sided chamfer distance: `E^` the Sobel magnitude of the rendered
//!   silhouette, `D_S` the distance to the mask's contour.
//!
//! Pixels of other instances (`unknown`) and beyond the image carry no information: they have no weight, make no
//! contour, and a side of the box beyond which they reach does not constrain the crop.
//!
//! If an image is given, the paper solver's loss has the third term, `+ w_app * |Phi(I_render) - Phi(I_instance)|^2`,
//! in the coarse search and in the descent. `Phi` is always the classical descriptor
//! ([`super::appearance::descriptor`]) with its own weight, `descriptor_weight`, also if DINOv2's weights are present:
//! those score scenes and have no part in the descent. The whole solver then runs on the CPU, whatever GPU is given,
//! because this term is rendered there.
//!
//! Search, one of two ([`YawSolver`]):
//!
//! - golden: 72 yaws on coarse images, then golden sections around the 8 lowest minima, to the end for those that may
//!   still be the best, then yaw, position and size together (`polish.rs`), on hard silhouettes;
//! - paper: the published one, 72 yaws, then 140 steps of Adam from each of the 8 best, on silhouettes soft at the
//!   outline ([`soft_raster`]), which have derivatives.
//!
//! The object stands on the table or on its supporter (`support_height_m`), in the clean case to the millimeter. If a
//! part of it is hidden, golden also searches for its position (`occluded.rs`).
//!
//! The order of rotational symmetry is read from the coarse curve ([`symmetry`]) and from the mesh
//! ([`RotationalSymmetry`]); the common part is reported. If several poses have the same outline (a book, a labeled
//! jar) the image's colors and edges choose among them, if an image is given (`choice.rs`). The paper solver with
//! appearance in its loss has chosen already, and its symmetry is that of both. The remaining symmetry is reported and
//! does not change the chosen yaw.
//!
//! Guarantees: same input, same answer with any number of threads; accurate to about 0.3 degrees on a clean mask 100
//! pixels wide. Cost: golden needs some 150 silhouettes, three times that if a part is hidden. Paper needs 1192 soft
//! ones, takes at least 40 times as long and is no more accurate. On eight catalog objects (1,200 to 5,100 triangles,
//! one thread, the image given; `docs/results/solvers.md`, by the ignored test `solver_costs`) golden took
//! 0.01 to 0.07 s against 0.9 to 2.8 s of CPU time, with errors of 0.04 against 0.08 degrees in the median and of 0.20
//! against 0.54 at worst (a computer mouse). Golden is the default; paper serves for comparison. Blur makes the paper
//! solver's losses larger and its confidences lower, by 0.04 to 0.22 there, most for thin objects. Unsuitable for
//! objects across the image's border with less than half in view.

mod appearance_term;
mod choice;
pub(super) mod comparison;
pub(super) mod crop;
mod occluded;
mod moving_placement;
pub(super) mod outline_mesh;
mod gradient_descent;
mod image_edges;
mod placement;
mod polish;
pub(super) mod search;
mod settings;
mod support_height;
mod silhouette;
mod soft_comparison;
pub mod symmetry;

pub use settings::{YawSettings, YawSolver};
pub use support_height::support_height_m;

use std::f64::consts::TAU;

use glam::DVec2;
use rayon::prelude::*;

use super::appearance::SIDE_PX;
use appearance_term::AppearanceTerm;
use comparison::Comparison;
use crop::Crop;
use geometry::optimize::{golden_section, local_minima};
use geometry::pose::wrap_angle_rad;
use geometry::rotational_symmetry::RotationalSymmetry;
use geometry::{Camera, TexturedMesh};
use gradient_descent::DescentSettings;
use imaging::{Image, Mask};
use outline_mesh::OutlineMesh;
use polish::polished;
use runtime::{CancelFlag, Cancelled};
use search::{PoseCandidate, YawSearchResult};
use soft_comparison::SoftComparison;

/// Width of the interval at which the first refinement stops, in steps of the coarse search.
const ROUGH_SHARE: f64 = 0.2;

/// First step of the last refinement, in steps of the coarse search.
const POLISH_SHARE: f64 = 0.3;

/// Rounding bound of the appearance term, before weighting.
const INDIFFERENT: f64 = 0.002;

/// One instance: its mesh and its pixels in the image.
#[derive(Clone, Copy, Debug)]
pub struct YawProblem<'a> {
    /// Canonical frame, meters, at about its real size.
    pub mesh: &'a TexturedMesh,
    pub camera: &'a Camera,
    /// Visible pixels of the instance; as large as the camera's image.
    pub mask: &'a Mask,
    /// Pixels that may hide it: those of other instances. As large as the camera's image.
    pub unknown: &'a Mask,
    /// Height of its supporter above the table, world z, meters; 0 on the table itself.
    pub support_height_m: f64,
    /// The camera's image; where it is given its colors choose among poses with the same outline.
    pub image: Option<&'a Image>,
    /// A yaw that is stated in words. It decides between yaws that the symmetry of the shape makes equivalent.
    pub stated_yaw_rad: Option<f64>,
}

/// The estimated yaw with its confidence.
#[derive(Clone, Debug, PartialEq)]
pub struct YawEstimate {
    /// About world +z, in (-pi, pi]: of those with the same outline the one that the colors prefer, however
    /// slightly; [`Self::representative_yaw_rad`] where they prefer none.
    pub yaw_rad: f64,
    /// The yaw canonical for the symmetry: within half a period of 0; 0 where any angle does.
    pub representative_yaw_rad: f64,
    /// World position of the object's origin by its apparent size, meters; `None` if its viewing ray meets no
    /// supporting plane.
    pub seen_m: Option<DVec2>,
    /// Loss at that yaw, fine comparison. The paper solver's is that of blurred silhouettes, which is larger, plus the
    /// appearance term if it is part of the loss.
    pub loss: f64,
    /// (yaw, loss) of the coarse search, in the order of yaw from 0.
    pub curve: Vec<(f64, f64)>,
    /// (yaw, loss) of the refined candidates, best first.
    pub top: Vec<(f64, f64)>,
    /// Order of the rotational symmetry that shape, outline and, where an image is given, colors have in common:
    /// 1 = none, n = every 360/n degrees, 0 = any angle.
    pub symmetry_order: u32,
    /// Of the shape alone, with the axis, in the mesh's frame.
    pub shape_symmetry: RotationalSymmetry,
    /// Confidence 0..1: the outlines' agreement times the lead over the best other yaw, with appearance if it is part
    /// of the loss.
    pub confidence: f64,
}

/// Reason why no yaw could be estimated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum YawError {
    #[error("estimating a yaw: the instance's mask is empty; segment it again or leave the instance out")]
    EmptyMask,
    #[error("estimating a yaw: the mesh has no triangles; reconstruct it again")]
    EmptyMesh,
    #[error("estimating a yaw: the masks are not as large as the camera's image")]
    DifferentSizes,
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Finds the yaw whose silhouette fits the mask best.
///
/// # Errors
///
/// [`YawError`] if the mesh or the mask is empty or does not fit the camera, or the call is cancelled.
pub fn estimate_yaw(
    problem: &YawProblem,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<YawEstimate, YawError> {
    let camera = problem.camera;
    for mask in [problem.mask, problem.unknown] {
        if (mask.width_px(), mask.height_px()) != (camera.width_px, camera.height_px) {
            return Err(YawError::DifferentSizes);
        }
    }
    let mesh = OutlineMesh::new(problem.mesh, settings.outline_cells);
    if mesh.triangles.is_empty() {
        return Err(YawError::EmptyMesh);
    }
    let bbox = problem.mask.bbox_px().ok_or(YawError::EmptyMask)?;
    let fine_crop = Crop::new(problem.mask, problem.unknown, bbox, settings.fine_px as usize);
    let part_hidden = fine_crop.own_sides != [true; 4];
    let (YawSearchResult { curve, top }, colored) = match settings.solver {
        YawSolver::Golden => {
            let coarse_crop = Crop::new(problem.mask, problem.unknown, bbox, settings.coarse_px as usize);
            let coarse = Comparison::new(&mesh, camera, problem.support_height_m, &coarse_crop, settings);
            let fine = Comparison::new(&mesh, camera, problem.support_height_m, &fine_crop, settings);
            let found = if !part_hidden {
                by_golden_sections(&coarse, &fine, settings, cancel)?
            } else {
                occluded::joint_search(&coarse, &fine, settings, cancel)?
            };
            (found, None)
        }
        YawSolver::Paper => {
            let mut fine = SoftComparison::new(&mesh, camera, problem.support_height_m, &fine_crop, settings);
            if let Some(image) = problem.image.filter(|_| settings.descriptor_weight > 0.0) {
                let term = AppearanceTerm::new(problem, image, &mesh, bbox, fine.surface(), settings);
                fine = fine.with_appearance(term);
            }
            let found = by_descent(&fine, settings, cancel)?;
            let colored = fine.sees_colors().then(|| preferred(&fine, &found, settings));
            (found, colored)
        }
    };
    let step_rad = TAU / curve.len() as f64;
    let best = *top.first().ok_or(YawError::EmptyMesh)?;
    let (best_rad, loss) = (best.yaw_rad, best.loss);
    let outline_order = symmetry::order_of(&curve, settings);
    let (mut yaw_rad, mut symmetry_order) =
        (symmetry::representative(best_rad, outline_order), outline_order);
    if let Some(ColorChoice { yaw_rad: preferred_rad, .. }) = colored {
        yaw_rad = preferred_rad;
    } else if let Some(image) = problem.image {
        let plain = problem.mesh.without_textures();
        let colors =
            choice::Colors::new(problem, plain.as_ref(), image, &mesh, &fine_crop, SIDE_PX, settings);
        let place = best.place.filter(|_| part_hidden);
        let outlines = choice::Outlines { curve: &curve, top: &top, order: outline_order, place };
        let chosen = choice::choose(&colors, &outlines, settings, cancel)?;
        (yaw_rad, symmetry_order) = (chosen.yaw_rad, chosen.symmetry_order);
    }
    // What this camera cannot tell apart need not be the same: a symmetry is one of the shape too.
    let shape_symmetry = RotationalSymmetry::of(problem.mesh);
    let yaw_rad = wrap_angle_rad(match problem.stated_yaw_rad {
        Some(stated_rad) => shape_symmetry.nearest_equivalent_rad(yaw_rad, stated_rad),
        None => yaw_rad,
    });
    let seen_m = Comparison::new(&mesh, camera, problem.support_height_m, &fine_crop, settings)
        .standing_at(best.place.filter(|_| part_hidden))
        .seen_m(yaw_rad);
    let top: Vec<(f64, f64)> = top.iter().map(|c| (wrap_angle_rad(c.yaw_rad), c.loss)).collect();
    // Descents may all end at one yaw. Their curve is of the same loss and knows the other poses; that of the
    // golden sections is of a coarser one, but theirs begin at different minima.
    let poses = match settings.solver {
        YawSolver::Golden => top.clone(),
        YawSolver::Paper => [top.as_slice(), &curve].concat(),
    };
    let outline_loss = colored.map_or(loss, |colored| colored.outline_loss);
    let confidence = confidence(outline_loss, &poses, outline_order, step_rad, settings);
    let symmetry_order = shape_symmetry.order_with(symmetry_order);
    let representative_yaw_rad = symmetry::representative(yaw_rad, symmetry_order);
    Ok(YawEstimate {
        yaw_rad,
        representative_yaw_rad,
        seen_m,
        loss,
        curve,
        top,
        symmetry_order,
        shape_symmetry,
        confidence,
    })
}

fn by_golden_sections(
    coarse: &Comparison,
    fine: &Comparison,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<YawSearchResult, Cancelled> {
    let curve = coarse_curve(coarse, settings.coarse_yaws, cancel)?;
    let step_rad = TAU / curve.len() as f64;
    let refine = |around_rad: f64, reach_rad: f64, tolerance_rad: f64| {
        let (low, high) = (around_rad - reach_rad, around_rad + reach_rad);
        let loss = |yaw_rad| cancel.check().map(|()| fine.loss(yaw_rad));
        golden_section(low, high, tolerance_rad, loss)
    };
    // All of them roughly, then those that may still be the best, or as good, to the end.
    let rough_rad = ROUGH_SHARE * step_rad;
    let rough = local_minima(&curve, settings.keep as usize)
        .into_par_iter()
        .map(|yaw_rad| refine(yaw_rad, step_rad, rough_rad))
        .collect::<Result<Vec<_>, Cancelled>>()?;
    let lowest = rough.iter().map(|c| c.1).fold(f64::INFINITY, f64::min);
    let mut top = rough
        .into_par_iter()
        .map(|(yaw_rad, loss)| {
            if loss > lowest + 2.0 * settings.same_outline {
                return Ok((yaw_rad, loss));
            }
            refine(yaw_rad, rough_rad, settings.tolerance_rad)
        })
        .collect::<Result<Vec<_>, Cancelled>>()?;
    top.sort_by(|a, b| a.1.total_cmp(&b.1));
    let best = top.first().map_or(0.0, |c| c.1);
    let top = top
        .into_par_iter()
        .map(|(yaw_rad, loss)| {
            cancel.check()?;
            let candidate = PoseCandidate { yaw_rad, loss, place: None };
            let may_be_chosen = loss <= best + settings.same_outline;
            Ok(if may_be_chosen { polished(fine, candidate, POLISH_SHARE * step_rad) } else { candidate })
        })
        .collect::<Result<Vec<_>, Cancelled>>()?;
    Ok(YawSearchResult { curve, top })
}

fn by_descent(
    fine: &SoftComparison,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<YawSearchResult, Cancelled> {
    let effort = DescentSettings {
        coarse_yaws: settings.coarse_yaws.max(8),
        keep: settings.keep,
        ..DescentSettings::PUBLISHED
    };
    gradient_descent::search(&effort, |yaws_rad| fine.losses(yaws_rad, cancel))
}

fn coarse_curve(
    comparison: &Comparison,
    yaws: u32,
    cancel: &CancelFlag,
) -> Result<Vec<(f64, f64)>, Cancelled> {
    (0..yaws.max(8))
        .into_par_iter()
        .map(|k| {
            let yaw_rad = TAU * f64::from(k) / f64::from(yaws.max(8));
            cancel.check().map(|()| (yaw_rad, comparison.loss(yaw_rad)))
        })
        .collect()
}

/// Choice of a loss that includes colors.
#[derive(Clone, Copy)]
struct ColorChoice {
    yaw_rad: f64,
    /// The outline's part of the best loss.
    outline_loss: f64,
}

/// The best yaw; of poses that are the same to outline and colors the canonical one, if colors do not differ at all.
fn preferred(fine: &SoftComparison, found: &YawSearchResult, settings: &YawSettings) -> ColorChoice {
    let best_rad = found.top.first().map_or(0.0, |best| best.yaw_rad);
    let order = symmetry::order_of(&found.curve, settings);
    let same: Vec<f64> = match order {
        0 => found.curve.iter().map(|c| c.0).collect(),
        n => (0..n).map(|k| best_rad + TAU * f64::from(k) / f64::from(n)).collect(),
    };
    let colors: Vec<f64> = same.into_par_iter().map(|yaw_rad| fine.parts(yaw_rad).1).collect();
    let (low, high) =
        colors.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &c| (low.min(c), high.max(c)));
    let indifferent = order != 1 && high - low < INDIFFERENT;
    let yaw_rad = if indifferent { symmetry::representative(best_rad, order) } else { best_rad };
    ColorChoice { yaw_rad, outline_loss: fine.parts(best_rad).0 }
}

/// Confidence in the best yaw, 0..1: agreement of its outline times its lead over the best pose that differs from it.
/// `poses` (yaw and loss) begin with the best.
fn confidence(
    outline_loss: f64,
    poses: &[(f64, f64)],
    symmetry_order: u32,
    step_rad: f64,
    settings: &YawSettings,
) -> f64 {
    let Some(&(best_rad, best)) = poses.first() else { return 0.0 };
    let fit = (1.0 - outline_loss / settings.hopeless_loss).clamp(0.0, 1.0);
    if symmetry_order == 0 {
        return fit;
    }
    let lead = poses
        .iter()
        // Within two steps of the coarse search lies the same minimum.
        .filter(|c| symmetry::representative(c.0 - best_rad, symmetry_order).abs() > 2.0 * step_rad)
        .map(|c| c.1 - best)
        // Without another pose the lead is that over an outline that does not fit at all.
        .fold(settings.hopeless_loss, f64::min);
    fit * lead / (lead + settings.clear_lead)
}

#[cfg(test)]
pub(super) mod tests;
