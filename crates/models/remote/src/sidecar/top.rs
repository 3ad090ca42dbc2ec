//! Assignment of boxes on a top view to recognized objects.
//!
//! Method: the ray of the reference camera through an object meets the plane at half its height above its support;
//! this gives its position on the table. The box of the table maps the position onto the top view. Boxes with the
//! object's label are assigned by distance, the nearest pair first, each box once. Input: boxes in pixels, y down; up
//! in the view = world +y. Guarantee: equal input gives an equal assignment.

use glam::DVec2;

use super::wire::{Detection, normalized};
use ports::TopBoxes;
use scene::{InstanceId, Recognition, SupportTree, TopBox};

/// The box of every recognized object, or the first object without one.
pub fn matched(
    recognition: &Recognition,
    supports: &SupportTree,
    found: &[Detection],
    table_px: [f64; 4],
) -> Result<TopBoxes, InstanceId> {
    let objects = &recognition.objects;
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        let label = normalized(&object.label);
        let expected = expected_px(recognition, supports, index, table_px);
        for (other, candidate) in found.iter().enumerate() {
            if candidate.label.as_deref() == Some(label.as_str()) {
                // Objects without an expected position come last, the highest scores first.
                let apart = match expected {
                    Some(place) => (center(candidate.box_px) - place).length(),
                    None => 1e9 - candidate.score,
                };
                pairs.push((apart, index, other));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut taken: Vec<Option<usize>> = vec![None; objects.len()];
    for (_, index, other) in pairs {
        if taken[index].is_none() && !taken.contains(&Some(other)) {
            taken[index] = Some(other);
        }
    }
    let boxes = objects.iter().zip(taken).map(|(object, at)| {
        let box_px = at.and_then(|at| found[at].mask.bbox_px()).ok_or_else(|| object.id.clone())?;
        Ok(TopBox { id: object.id.clone(), box_px: box_px.map(f64::from) })
    });
    Ok(TopBoxes { table_px, objects: boxes.collect::<Result<_, InstanceId>>()? })
}

/// The expected center of an object on the view; `None` where recognition states no box.
fn expected_px(
    recognition: &Recognition,
    supports: &SupportTree,
    index: usize,
    [x0, y0, x1, y1]: [f64; 4],
) -> Option<DVec2> {
    let object = &recognition.objects[index];
    let height_m = recognition.support_height_m(supports, index) + 0.5 * object.size_m.z;
    let met = recognition.camera.meet_plane(center(object.seen_px?), height_m)?.truncate();
    let share = met / recognition.table.size_m.truncate();
    Some(DVec2::new(x0 + (0.5 + share.x) * (x1 - x0), y0 + (0.5 - share.y) * (y1 - y0)))
}

fn center([x0, y0, x1, y1]: [f64; 4]) -> DVec2 {
    DVec2::new(0.5 * (x0 + x1), 0.5 * (y0 + y1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Camera;
    use glam::DVec3;
    use imaging::Mask;
    use scene::{CameraKnowledge, RecognizedObject, RecognizedTable, StandsOn, TableShape};

    /// Two mugs left and right on a table of 1.2 m, seen by a camera at 45 degrees of elevation.
    fn recognition() -> Recognition {
        let camera = Camera::orbit(640, 480, 0.7, DVec3::ZERO, 0.0, 0.8, 2.5);
        let object = |id: &str, x: f64| {
            let (pixel, _) = camera.project(DVec3::new(x, 0.1, 0.05)).expect("is seen");
            RecognizedObject {
                id: InstanceId::new(id).expect("a name"),
                label: "Mug".into(),
                category: "mug".into(),
                size_m: DVec3::splat(0.1),
                tipped: None,
                color: None,
                material: None,
                seed: 1,
                stands_on: StandsOn::Table,
                seen_px: Some([pixel.x - 9.0, pixel.y - 9.0, pixel.x + 9.0, pixel.y + 9.0]),
                seen_as: None,
                seen_like: None,
                mass_kg: None,
                stand_in: None,
            }
        };
        Recognition {
            camera,
            camera_is: CameraKnowledge::Judged,
            table: RecognizedTable {
                label: "table".into(),
                shape: TableShape::Rectangular,
                model: "dining_table".into(),
                outline_m: None,
                size_m: DVec3::new(1.2, 0.8, 0.74),
                color: None,
                material: None,
                seed: 1,
            },
            objects: vec![object("mug_1", 0.3), object("mug_2", -0.3)],
            left_out_px: Vec::new(),
            depth: None,
        }
    }

    fn found(label: &str, x0: u32, y0: u32) -> Detection {
        let inside = |x: u32, y: u32| (x0..x0 + 20).contains(&x) && (y0..y0 + 20).contains(&y);
        let box_px = [x0, y0, x0 + 20, y0 + 20].map(f64::from);
        Detection { label: Some(label.into()), score: 0.5, box_px, mask: Mask::from_fn(300, 220, inside) }
    }

    const TABLE_PX: [f64; 4] = [30.0, 30.0, 270.0, 190.0];

    #[test]
    fn equal_labels_are_matched_by_the_position_in_the_reference_image() {
        // A tenth of a meter is 20 pixels; up is away from the camera.
        let (left, right) = (found("mug", 80, 80), found("mug", 200, 80));
        let recognition = recognition();
        let supports = recognition.support_tree().expect("a tree");
        let boxes = matched(&recognition, &supports, &[left, right], TABLE_PX).expect("both are there");
        let places: Vec<f64> = boxes.objects.iter().map(|found| found.box_px[0]).collect();
        assert_eq!(places, [200.0, 80.0]);
        let expected = expected_px(&recognition, &supports, 0, TABLE_PX).expect("was seen");
        assert!((expected - DVec2::new(210.0, 90.0)).length() < 1.0, "{expected}");
    }

    #[test]
    fn missing_object_is_named() {
        let one = [found("mug", 80, 80), found("bowl", 200, 80)];
        let recognition = recognition();
        let supports = recognition.support_tree().expect("a tree");
        let missing = matched(&recognition, &supports, &one, TABLE_PX).expect_err("one is missing");
        assert_eq!(missing.as_str(), "mug_1");
    }
}
