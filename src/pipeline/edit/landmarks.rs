//! Objects of a parent whose meshes are not loaded, for phrases that say how many new objects are made.

use geometry::DVec3;

use crate::pipeline::composition::Composition;
use editing::EditableObject;
use editing::references::resolve;
use scene::predicates::PosedFootprint;

/// The number of objects that a phrase means; 1 where it means none, which the operation reports when it is carried
/// out.
pub(super) fn count(parent: &Composition, phrase: &str) -> usize {
    resolve(&objects(parent), phrase).map_or(1, |found| found.len())
}

/// The objects with their boxes as footprints.
fn objects(parent: &Composition) -> Vec<EditableObject> {
    let recognized = parent.recognition.objects.iter().zip(parent.bodies.iter().skip(1));
    recognized
        .enumerate()
        .map(|(index, (object, body))| {
            let pose = body.resolved.settled;
            let half_m = 0.5 * object.size_m;
            let corners = [-1.0, 1.0].into_iter().flat_map(|x| [-1.0, 1.0].map(|y| DVec3::new(x, y, 0.0)));
            let corners = corners.flat_map(|side| {
                let at = half_m * side;
                [at, at + DVec3::Z * object.size_m.z].map(|point| pose.transform_point(point))
            });
            EditableObject {
                name: object.id.clone(),
                label: object.label.clone(),
                category: object.category.clone(),
                stand_in: object.stand_in.is_some(),
                color: object.color,
                material: object.material.clone(),
                size_m: object.size_m,
                footprint: PosedFootprint::of_points(corners, &pose),
                supporter: parent.supports.supporter(index),
            }
        })
        .collect()
}
