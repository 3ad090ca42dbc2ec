//! Yaw of a partly hidden object, estimated jointly with its position.
//!
//! If a side of the object is hidden, its box is not the mask's. Fitting box to box then places the true yaw wrongly,
//! and its loss exceeds that of a wrong yaw at a fitting position. Therefore each yaw of the coarse search is moved on
//! its support to minimize the loss (a pattern search of the center's pixel), and the best are refined together with
//! position and size (Nelder and Mead 1965: yaw, center's pixel, logarithm of the zoom). Rendering into unknown pixels
//! costs nothing, so a small penalty holds the size near the commonsense one.
//!
//! Guarantees: the same bits with any number of threads. Cost: some 700 coarse and 250 fine silhouettes, three to four
//! times those of an object in full view.

use glam::DVec2;
use rayon::prelude::*;

use super::YawSettings;
use super::comparison::{Comparison, Place};
use super::search::{PoseCandidate, YawSearchResult};
use geometry::optimize::{local_minima, nelder_mead};
use runtime::{CancelFlag, Cancelled};

/// Steps of the pattern search, shares of the mask's longer side.
const STEPS: [f64; 2] = [0.06, 0.03];
/// Moves tried at each step's length.
const MOVES: usize = 2;
/// Share of the yaws, best first by the box fit, whose position is searched.
const MOVED_SHARE: f64 = 0.3;
/// Minima that are refined.
const REFINED: usize = 5;
/// Silhouettes of a refinement on coarse images, and of the further one on fine images.
const COARSE_EVALUATIONS: usize = 36;
const FINE_EVALUATIONS: usize = 50;
/// Penalty of a size off by a factor of e, loss units: 0.002 at a tenth, 0.01 at a quarter.
const SIZE_PENALTY: f64 = 0.2;

/// The coarse search and the refinement.
pub fn joint_search(
    coarse: &Comparison,
    fine: &Comparison,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<YawSearchResult, Cancelled> {
    let side_px = (coarse.crop.high_px - coarse.crop.low_px).max_element();
    let count = settings.coarse_yaws.max(8);
    let step_rad = std::f64::consts::TAU / f64::from(count);
    let fitted = (0..count)
        .into_par_iter()
        .map(|k| {
            cancel.check()?;
            Ok(fitted(coarse, step_rad * f64::from(k)))
        })
        .collect::<Result<Vec<PoseCandidate>, Cancelled>>()?;
    let mut losses: Vec<f64> = fitted.iter().map(|c| c.loss).collect();
    losses.sort_by(f64::total_cmp);
    let worth_moving = losses[(MOVED_SHARE * losses.len() as f64) as usize];
    let moved = fitted
        .into_par_iter()
        .map(|from| {
            cancel.check()?;
            Ok(if from.loss <= worth_moving { moved_about(coarse, from, side_px) } else { from })
        })
        .collect::<Result<Vec<PoseCandidate>, Cancelled>>()?;
    let curve: Vec<(f64, f64)> = moved.iter().map(|c| (c.yaw_rad, c.loss)).collect();
    let start = |yaw_rad: f64| moved.iter().find(|c| c.yaw_rad == yaw_rad).copied();
    let spread = [0.6 * step_rad, 0.02 * side_px, 0.02 * side_px, 0.02];
    let refine = |on: &Comparison, from: PoseCandidate, spread: [f64; 4], evaluations: usize| {
        let Some(place) = from.place else { return Ok(from) };
        cancel.check()?;
        let origin = [from.yaw_rad, place.center_px.x, place.center_px.y, place.log_zoom];
        let (found, loss) = nelder_mead(origin, spread, evaluations, |[yaw_rad, x, y, log_zoom]| {
            let place = Place { center_px: DVec2::new(x, y), log_zoom };
            penalized(on, yaw_rad, place)
        });
        let [yaw_rad, x, y, log_zoom] = found;
        Ok(PoseCandidate { yaw_rad, loss, place: Some(Place { center_px: DVec2::new(x, y), log_zoom }) })
    };
    let rough = local_minima(&curve, REFINED.min(settings.keep as usize))
        .into_par_iter()
        .filter_map(start)
        .map(|from| refine(coarse, from, spread, COARSE_EVALUATIONS))
        .collect::<Result<Vec<_>, Cancelled>>()?;
    let best = rough.iter().map(|c| c.loss).fold(f64::INFINITY, f64::min);
    let mut top = rough
        .into_par_iter()
        .map(|from| {
            let evaluations =
                if from.loss > best + 2.0 * settings.same_outline { 0 } else { FINE_EVALUATIONS };
            refine(fine, from, spread.map(|s| 0.4 * s), evaluations)
        })
        .collect::<Result<Vec<_>, Cancelled>>()?;
    top.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    Ok(YawSearchResult { curve, top })
}

/// The candidate whose box fits the unoccluded sides of the mask's box.
fn fitted(coarse: &Comparison, yaw_rad: f64) -> PoseCandidate {
    match coarse.fitted(yaw_rad) {
        Some(place) => PoseCandidate { yaw_rad, loss: penalized(coarse, yaw_rad, place), place: Some(place) },
        None => PoseCandidate { yaw_rad, loss: coarse.loss(yaw_rad), place: None },
    }
}

/// The minimum loss of a yaw over positions on the support.
fn moved_about(coarse: &Comparison, from: PoseCandidate, side_px: f64) -> PoseCandidate {
    let PoseCandidate { yaw_rad, mut loss, place: Some(mut place) } = from else { return from };
    for step in STEPS {
        for _ in 0..MOVES {
            let beside = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|direction| {
                let center_px = place.center_px + step * side_px * direction;
                let place = Place { center_px, ..place };
                (penalized(coarse, yaw_rad, place), place)
            });
            let best = beside.iter().fold((loss, place), |a, b| if b.0 < a.0 { *b } else { a });
            if best.0 >= loss {
                break;
            }
            (loss, place) = best;
        }
    }
    PoseCandidate { yaw_rad, loss, place: Some(place) }
}

fn penalized(comparison: &Comparison, yaw_rad: f64, place: Place) -> f64 {
    comparison.standing_at(Some(place)).loss(yaw_rad) + SIZE_PENALTY * place.log_zoom.powi(2)
}
