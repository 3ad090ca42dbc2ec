//! Final joint refinement of yaw, position and size, around a pose whose box fits the mask's.
//!
//! The mask's box is known to the pixel, and a pixel of 40 is a size error of 2 percent; the yaw of a slightly wrong
//! box is slightly wrong too. Nelder-Mead over yaw, the center's pixel and the logarithm of the zoom finds the pose
//! that covers the mask best. The candidate keeps its previous loss: a thin object's loss falls with any fit, and
//! candidates are compared by what their yaws explain. Cost: 45 fine silhouettes.

use glam::DVec2;

use super::comparison::{Comparison, Place};
use super::search::PoseCandidate;
use geometry::optimize::nelder_mead;

/// Silhouettes of one refinement.
const EVALUATIONS: usize = 45;
/// First steps: of the center, shares of the mask's longer side; of the zoom's logarithm.
const PLACE_STEP: f64 = 0.01;
const ZOOM_STEP: f64 = 0.01;

/// The candidate with yaw and place refined; `step_rad` is the first step of the yaw.
pub fn polished(fine: &Comparison, from: PoseCandidate, step_rad: f64) -> PoseCandidate {
    let Some(place) = fine.fitted(from.yaw_rad) else { return from };
    let place_step_px = PLACE_STEP * (fine.crop.high_px - fine.crop.low_px).max_element();
    let start = [from.yaw_rad, place.center_px.x, place.center_px.y, place.log_zoom];
    let spread = [step_rad, place_step_px, place_step_px, ZOOM_STEP];
    let placed = |x: f64, y: f64, log_zoom: f64| Some(Place { center_px: DVec2::new(x, y), log_zoom });
    let ([yaw_rad, x, y, log_zoom], loss) =
        nelder_mead(start, spread, EVALUATIONS, |[yaw_rad, x, y, log_zoom]| {
            fine.standing_at(placed(x, y, log_zoom)).loss(yaw_rad)
        });
    if loss > from.loss {
        return from;
    }
    PoseCandidate { yaw_rad, loss: from.loss, place: placed(x, y, log_zoom) }
}
