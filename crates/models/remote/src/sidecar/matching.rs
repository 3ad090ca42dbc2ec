//! Assignment of detections to recognized objects.
//!
//! Method: every pair of an object and a detection is scored by the overlap of their boxes (intersection over union,
//! where recognition states a box), by equal labels and by the detector's score. Pairs are accepted greedily by
//! score, each object once. A detection is rejected where its mask mostly coincides with an accepted one. A pair
//! needs an equal label or overlapping boxes. Guarantee: equal input gives an equal assignment; ties follow the order
//! of recognition.

use super::wire::{Detection, normalized};
use imaging::Mask;
use scene::{InstanceId, RecognizedObject};

/// Minimum overlap of boxes at which objects with different labels match.
const SAME_BOX: f64 = 0.5;

/// Overlap of masks above which two detections are the same object.
const SAME_MASK: f64 = 0.8;

/// The mask of every recognized object in order, or the first object without one.
pub fn matched(objects: &[RecognizedObject], found: &[Detection]) -> Result<Vec<Mask>, InstanceId> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        let label = normalized(&object.label);
        for (other, candidate) in found.iter().enumerate() {
            if let Some(score) = score(object, &label, candidate) {
                pairs.push((score, index, other));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut taken: Vec<Option<usize>> = vec![None; objects.len()];
    for (_, index, other) in pairs {
        let again = |known: &usize| *known == other || found[*known].mask.iou(&found[other].mask) > SAME_MASK;
        if taken[index].is_none() && !taken.iter().flatten().any(again) {
            taken[index] = Some(other);
        }
    }
    let masks = objects.iter().zip(taken);
    masks
        .map(|(object, found_at)| found_at.map(|at| found[at].mask.clone()).ok_or(object.id.clone()))
        .collect()
}

/// The score of a pair; `None` where neither label nor box supports it.
fn score(object: &RecognizedObject, label: &str, candidate: &Detection) -> Option<f64> {
    let named = candidate.label.as_deref() == Some(label);
    match object.seen_px {
        Some(seen) => {
            let overlap = overlap(seen, candidate.box_px);
            let same = if named { overlap > 0.0 } else { overlap >= SAME_BOX };
            same.then_some(overlap + 0.3 * f64::from(u8::from(named)) + 0.1 * candidate.score)
        }
        None => named.then_some(candidate.score),
    }
}

/// Intersection over union of two boxes.
fn overlap(a: [f64; 4], b: [f64; 4]) -> f64 {
    let area = |[x0, y0, x1, y1]: [f64; 4]| (x1 - x0).max(0.0) * (y1 - y0).max(0.0);
    let common = area([a[0].max(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].min(b[3])]);
    common / (area(a) + area(b) - common).max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use scene::StandsOn;

    fn object(id: &str, label: &str, seen_px: Option<[f64; 4]>) -> RecognizedObject {
        RecognizedObject {
            id: InstanceId::new(id).expect("a name"),
            label: label.into(),
            category: "mug".into(),
            size_m: DVec3::splat(0.1),
            tipped: None,
            color: None,
            material: None,
            seed: 1,
            stands_on: StandsOn::Table,
            seen_px,
            seen_as: None,
            seen_like: None,
            mass_kg: None,
            stand_in: None,
        }
    }

    fn found(label: Option<&str>, score: f64, box_px: [f64; 4]) -> Detection {
        let inside = |x: u32, y: u32| {
            let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            box_px[0] < x && x < box_px[2] && box_px[1] < y && y < box_px[3]
        };
        Detection { label: label.map(str::to_owned), score, box_px, mask: Mask::from_fn(100, 60, inside) }
    }

    const LEFT: [f64; 4] = [10.0, 10.0, 30.0, 40.0];
    const RIGHT: [f64; 4] = [60.0, 12.0, 80.0, 42.0];

    fn places(objects: &[RecognizedObject], found: &[Detection]) -> Result<Vec<u32>, String> {
        let masks = matched(objects, found).map_err(|id| id.to_string())?;
        Ok(masks.iter().map(|mask| mask.bbox_px().expect("shows")[0]).collect())
    }

    #[test]
    fn equal_labels_are_matched_by_their_boxes() {
        let near = |[x0, y0, x1, y1]: [f64; 4]| Some([x0 + 2.0, y0 - 3.0, x1 + 4.0, y1]);
        let objects = [object("mug_1", "Mug", near(RIGHT)), object("mug_2", "mug", near(LEFT))];
        let all = [found(Some("mug"), 0.9, LEFT), found(Some("mug"), 0.5, RIGHT)];
        assert_eq!(places(&objects, &all), Ok(vec![60, 10]));
    }

    #[test]
    fn objects_without_boxes_take_the_highest_scores() {
        let objects = [object("mug_1", "mug", None), object("mug_2", "mug", None)];
        let all = [found(Some("mug"), 0.5, LEFT), found(Some("mug"), 0.9, RIGHT)];
        assert_eq!(places(&objects, &all), Ok(vec![60, 10]));
    }

    #[test]
    fn duplicate_detections_match_once() {
        let objects = [object("mug_1", "mug", None), object("cup_1", "cup", None)];
        let again = [LEFT[0], LEFT[1], LEFT[2] + 1.0, LEFT[3]];
        let all =
            [found(Some("mug"), 0.9, LEFT), found(Some("cup"), 0.8, again), found(Some("cup"), 0.4, RIGHT)];
        assert_eq!(places(&objects, &all), Ok(vec![10, 60]));
        assert_eq!(places(&objects, &all[..2]), Err("cup_1".into()));
    }

    #[test]
    fn overlapping_box_matches_a_detection_without_label() {
        let objects = [object("mug_1", "mug", Some(LEFT))];
        assert_eq!(places(&objects, &[found(None, 0.4, LEFT)]), Ok(vec![10]));
        assert_eq!(places(&objects, &[found(None, 0.9, RIGHT)]), Err("mug_1".into()));
        assert_eq!(places(&objects, &[found(Some("mug"), 0.9, RIGHT)]), Err("mug_1".into()));
        assert_eq!(places(&objects, &[]), Err("mug_1".into()));
        assert_eq!(places(&[object("mug_1", "mug", None)], &[found(None, 0.9, LEFT)]), Err("mug_1".into()));
    }
}
