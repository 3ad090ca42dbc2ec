//! Two objects change places.

use super::{Done, all_of, ids};
use crate::pipeline::edit::draft::Draft;
use crate::pipeline::edit::error::EditError;
use editing::PlaceQuery;

/// Distances within which an object stands where the other one stood, meters; what is larger than the other needs the
/// second.
const WITHIN_M: [f64; 2] = [0.03, 0.15];

pub(super) fn swap(draft: &mut Draft, phrases: &[String]) -> Done {
    let [first, second] = all_of(draft, phrases)?[..] else { return Err(EditError::NotTwoToSwap) };
    for (carrier, carried) in [(first, second), (second, first)] {
        if draft.workspace.branch(carrier).contains(&carried) {
            let (object, carried) = (draft.name(carrier).to_owned(), draft.name(carried).to_owned());
            return Err(EditError::RelativeToCarried { object, carried });
        }
    }
    let (of_first, of_second) = (draft.near_by(first, WITHIN_M[0]), draft.near_by(second, WITHIN_M[0]));
    for object in [first, second] {
        draft.is_named(object);
        let branch = draft.workspace.branch(object);
        draft.may_move(&branch, &format!("it moves with {}", draft.name(object)));
        set_placed(draft, object, false);
    }
    for (object, place) in [(first, of_second), (second, of_first)] {
        set_placed(draft, object, true);
        let usual_yaw_rad = draft.pose(object).yaw_rad().unwrap_or(0.0);
        let within = |within_m| PlaceQuery {
            within_m: Some(within_m),
            by_nearness: true,
            usual_yaw_rad,
            ..place.clone()
        };
        let [near, farther] = WITHIN_M.map(within);
        draft.find_and_rest(object, &near).or_else(|_| draft.find_and_rest(object, &farther))?;
    }
    let sentence = format!("{} and {} changed places", draft.name(first), draft.name(second));
    Ok((ids(draft, &[first, second]), sentence))
}

/// Whether an object and what rests on it are in the way of others.
pub(super) fn set_placed(draft: &mut Draft, object: usize, is_placed: bool) {
    for member in draft.workspace.branch(object) {
        draft.workspace.objects[member].is_placed = is_placed;
    }
}
