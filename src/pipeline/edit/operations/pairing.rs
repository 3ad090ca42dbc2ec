//! Places relative to several objects: one for each.

use glam::DVec2;

use super::{is_table, several};
use crate::pipeline::edit::draft::Draft;
use crate::pipeline::edit::error::EditError;
use scene::EditPlace;

/// The place of each of several objects. Where the phrase of a place means as many objects as are moved, each object
/// gets one of them, those that are nearest to each other first.
///
/// # Errors
///
/// [`EditError::UnequalNumbers`] where the phrase means several objects, and another number of them.
pub(super) fn places_of_each(
    draft: &Draft,
    objects: &[usize],
    place: &EditPlace,
) -> Result<Vec<EditPlace>, EditError> {
    let landmarks = landmarks(draft, place)?;
    if landmarks.len() < 2 || (objects.len() == 1 && landmarks.len() > 1) {
        return Ok(vec![place.clone(); objects.len()]);
    }
    if landmarks.len() != objects.len() {
        return Err(EditError::UnequalNumbers { objects: objects.len(), landmarks: landmarks.len() });
    }
    let centers =
        |objects: &[usize]| objects.iter().map(|object| draft.center_m(*object)).collect::<Vec<DVec2>>();
    let order = nearest_pairs(&centers(objects), &centers(&landmarks));
    Ok(order.into_iter().map(|landmark| at(draft, place, landmarks[landmark])).collect())
}

/// The places of new objects: `count` for each object that the phrase of the place means.
///
/// # Errors
///
/// A phrase that means no objects.
pub(super) fn places_of_new(draft: &Draft, place: &EditPlace) -> Result<Vec<EditPlace>, EditError> {
    let landmarks = landmarks(draft, place)?;
    Ok(match landmarks.as_slice() {
        [] | [_] => vec![place.clone()],
        several => several.iter().map(|&landmark| at(draft, place, landmark)).collect(),
    })
}

fn landmarks(draft: &Draft, place: &EditPlace) -> Result<Vec<usize>, EditError> {
    match place.target.as_deref() {
        Some(phrase) if !is_table(phrase) => several(draft, phrase),
        _ => Ok(Vec::new()),
    }
}

fn at(draft: &Draft, place: &EditPlace, landmark: usize) -> EditPlace {
    EditPlace { target: Some(draft.name(landmark).to_owned()), ..place.clone() }
}

/// For each object the index of its landmark: of all pairs that are left, the nearest is taken.
fn nearest_pairs(objects: &[DVec2], landmarks: &[DVec2]) -> Vec<usize> {
    let mut pairs: Vec<(usize, usize)> = (0..objects.len())
        .flat_map(|object| (0..landmarks.len()).map(move |landmark| (object, landmark)))
        .collect();
    let distance_m = |&(object, landmark): &(usize, usize)| objects[object].distance(landmarks[landmark]);
    pairs.sort_by(|a, b| distance_m(a).total_cmp(&distance_m(b)));
    let (mut taken, mut free) = (vec![usize::MAX; objects.len()], vec![true; landmarks.len()]);
    for (object, landmark) in pairs {
        if taken[object] == usize::MAX && free[landmark] {
            taken[object] = landmark;
            free[landmark] = false;
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_object_gets_a_landmark_of_its_own() {
        let at = |xs: &[f64]| xs.iter().map(|&x| DVec2::new(x, 0.0)).collect::<Vec<_>>();
        assert_eq!(nearest_pairs(&at(&[0.0, 1.0, 2.0]), &at(&[2.1, 0.1, 1.1])), [1, 2, 0]);
        assert_eq!(nearest_pairs(&at(&[0.0, 0.1]), &at(&[0.0, 5.0])), [0, 1]);
    }
}
