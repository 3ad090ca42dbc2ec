//! The yaw of an object of which a part is hidden: where it stands is searched for with it.
//!
//! Where something hides a side of the object, its box is not the mask's, and fitting box to box puts the true
//! yaw in a wrong place: its loss is then larger than that of a wrong yaw in a place that suits it. So each yaw
//! of the coarse search is moved about on its support for the least loss (a pattern search of the middle's
//! pixel), and the best are refined together with place and size (Nelder and Mead 1965: yaw, middle's pixel,
//! logarithm of the zoom). What is rendered where the picture is unknown costs nothing, so size is held near
//! the commonsense one by a small penalty.
//!
//! Guarantees: the same bits with any number of threads. Cost: some 700 coarse and 250 fine
//! silhouettes, three to four times those of an object in full view.

use glam::DVec2;
use rayon::prelude::*;

use super::DroSettings;
use super::comparison::{Comparison, Place};
use super::search::{Candidate, Found, candidates};
use super::simplex::least;
use runtime::{Interrupt, Interrupted};

/// Steps of the pattern search, shares of the mask's longer side.
const STEPS: [f64; 2] = [0.06, 0.03];
/// Moves tried at each step's length.
const MOVES: usize = 2;
/// Share of the yaws, the best before they are moved, that are moved about.
const MOVED_SHARE: f64 = 0.3;
/// Minima that are refined.
const REFINED: usize = 5;
/// Silhouettes of a refinement on coarse pictures, and of the further one on fine pictures.
const ROUGH_LOOKS: usize = 36;
const FURTHER_LOOKS: usize = 50;
/// Penalty of a size off by a factor of e, loss units: 0.002 at a tenth, 0.01 at a quarter.
const SIZE_PENALTY: f64 = 0.2;

/// The coarse search and the refinement.
pub fn by_moving_about(
    coarse: &Comparison,
    fine: &Comparison,
    settings: &DroSettings,
    interrupt: &Interrupt,
) -> Result<Found, Interrupted> {
    let side_px = (coarse.crop.high_px - coarse.crop.low_px).max_element();
    let count = settings.coarse_yaws.max(8);
    let step_rad = std::f64::consts::TAU / f64::from(count);
    let fitted = (0..count)
        .into_par_iter()
        .map(|k| {
            interrupt.check()?;
            Ok(fitted(coarse, step_rad * f64::from(k)))
        })
        .collect::<Result<Vec<Candidate>, Interrupted>>()?;
    let mut losses: Vec<f64> = fitted.iter().map(|c| c.loss).collect();
    losses.sort_by(f64::total_cmp);
    let worth_moving = losses[(MOVED_SHARE * losses.len() as f64) as usize];
    let moved = fitted
        .into_par_iter()
        .map(|from| {
            interrupt.check()?;
            Ok(if from.loss <= worth_moving { moved_about(coarse, from, side_px) } else { from })
        })
        .collect::<Result<Vec<Candidate>, Interrupted>>()?;
    let curve: Vec<(f64, f64)> = moved.iter().map(|c| (c.yaw_rad, c.loss)).collect();
    let start = |yaw_rad: f64| moved.iter().find(|c| c.yaw_rad == yaw_rad).copied();
    let spread = [0.6 * step_rad, 0.02 * side_px, 0.02 * side_px, 0.02];
    let refine = |on: &Comparison, from: Candidate, spread: [f64; 4], looks: usize| {
        let Some(place) = from.place else { return Ok(from) };
        interrupt.check()?;
        let origin = [from.yaw_rad, place.middle_px.x, place.middle_px.y, place.log_zoom];
        let (found, loss) = least(origin, spread, looks, |[yaw_rad, x, y, log_zoom]| {
            let place = Place { middle_px: DVec2::new(x, y), log_zoom };
            penalized(on, yaw_rad, place)
        });
        let [yaw_rad, x, y, log_zoom] = found;
        Ok(Candidate { yaw_rad, loss, place: Some(Place { middle_px: DVec2::new(x, y), log_zoom }) })
    };
    let rough = candidates(&curve, REFINED.min(settings.keep as usize))
        .into_par_iter()
        .filter_map(start)
        .map(|from| refine(coarse, from, spread, ROUGH_LOOKS))
        .collect::<Result<Vec<_>, Interrupted>>()?;
    let best = rough.iter().map(|c| c.loss).fold(f64::INFINITY, f64::min);
    let mut top = rough
        .into_par_iter()
        .map(|from| {
            let looks = if from.loss > best + 2.0 * settings.same_outline { 0 } else { FURTHER_LOOKS };
            refine(fine, from, spread.map(|s| 0.4 * s), looks)
        })
        .collect::<Result<Vec<_>, Interrupted>>()?;
    top.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    Ok(Found { curve, top })
}

/// The yaw where its box fits what is the object's own of the mask's.
fn fitted(coarse: &Comparison, yaw_rad: f64) -> Candidate {
    match coarse.fitted(yaw_rad) {
        Some(place) => Candidate { yaw_rad, loss: penalized(coarse, yaw_rad, place), place: Some(place) },
        None => Candidate { yaw_rad, loss: coarse.loss(yaw_rad), place: None },
    }
}

/// The least loss of a yaw with the object moved about on its support.
fn moved_about(coarse: &Comparison, from: Candidate, side_px: f64) -> Candidate {
    let Candidate { yaw_rad, mut loss, place: Some(mut place) } = from else { return from };
    for step in STEPS {
        for _ in 0..MOVES {
            let beside = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|direction| {
                let middle_px = place.middle_px + step * side_px * direction;
                let place = Place { middle_px, ..place };
                (penalized(coarse, yaw_rad, place), place)
            });
            let best = beside.iter().fold((loss, place), |a, b| if b.0 < a.0 { *b } else { a });
            if best.0 >= loss {
                break;
            }
            (loss, place) = best;
        }
    }
    Candidate { yaw_rad, loss, place: Some(place) }
}

fn penalized(comparison: &Comparison, yaw_rad: f64, place: Place) -> f64 {
    comparison.standing_at(Some(place)).loss(yaw_rad) + SIZE_PENALTY * place.log_zoom.powi(2)
}
