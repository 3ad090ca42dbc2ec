//! Supports that arrangements imply: layers of pyramids, and the upper objects of piles. Objects of a pyramid are equal
//! in size, as its layers would tilt otherwise.

use crate::requested_pose::posed;
use catalog::{Affordance, Recipe, build_cached, category};
use geometry::DVec3;
use scene::predicates::pyramid_layers;
use scene::{Arrangement, ArrangementKind, InstanceId, ObjectSpec, Relation, RelationKind, SceneDescription};

/// Share of the objects of a pile that lie on other ones, where those can carry them.
const UPPER_SHARE: f64 = 0.4;

/// The description with the support relations that its arrangements imply. Without pyramids and piles it is the same.
/// An upper object loses its former support.
pub(super) fn with_supports(description: &SceneDescription) -> SceneDescription {
    let mut extended = description.clone();
    for arrangement in &description.arrangements {
        if arrangement.kind == ArrangementKind::Pyramid {
            make_equal(arrangement, &mut extended.objects);
        }
        let pairs = match arrangement.kind {
            // What nothing can stand on stays on the table, and the pyramid is reported as unmet.
            ArrangementKind::Pyramid if has_flat_tops(arrangement, &extended.objects) => {
                pyramid_pairs(arrangement)
            }
            ArrangementKind::Pile => pile_pairs(arrangement, &description.objects),
            _ => Vec::new(),
        };
        for (upper, lower) in pairs {
            if let Some(object) = extended.objects.iter_mut().find(|object| object.id == upper) {
                object.relations.retain(|relation| !relation.kind.is_support());
                object.relations.push(Relation::new(RelationKind::On, Some(lower)));
            }
        }
    }
    extended
}

/// Gives the upright objects of a pyramid the size of the first one of their category.
fn make_equal(pyramid: &Arrangement, objects: &mut [ObjectSpec]) {
    let mut first: Vec<(String, DVec3)> = Vec::new();
    for id in &pyramid.objects {
        let Some(object) = objects.iter_mut().find(|object| object.id == *id) else { continue };
        if !object.pose.is_upright() {
            continue;
        }
        match first.iter().find(|(category, _)| *category == object.category) {
            Some((_, size_m)) => object.size_m = *size_m,
            None => first.push((object.category.clone(), object.size_m)),
        }
    }
}

/// The description without the supports within pyramids: there an object stands on two, between their centers, which
/// the pyramid itself demands.
pub(super) fn without_layers(description: &SceneDescription) -> SceneDescription {
    let mut stated = description.clone();
    for pyramid in description.arrangements.iter().filter(|a| a.kind == ArrangementKind::Pyramid) {
        let is_member = |id: &InstanceId| pyramid.objects.contains(id);
        for object in stated.objects.iter_mut().filter(|object| is_member(&object.id)) {
            object.relations.retain(|relation| {
                !(relation.kind == RelationKind::On && relation.target.as_ref().is_some_and(is_member))
            });
        }
    }
    stated
}

/// Points this close to the highest one belong to the top that carries, meters.
const TOP_M: f64 = 0.001;
/// Least extent of a top that carries, as a share of the object's.
const MIN_TOP_SHARE: f64 = 0.4;

/// Whether other objects can stand on each object of the arrangement: its top is flat and wide, or a rim.
fn has_flat_tops(arrangement: &Arrangement, objects: &[ObjectSpec]) -> bool {
    let is_flat = |object: &ObjectSpec| {
        let mesh = build_cached(&Recipe {
            category: object.category.clone(),
            size_m: object.size_m,
            color: object.color,
            material: object.material.clone(),
            seed: object.seed,
        });
        let Some(mesh) = mesh.and_then(|mesh| posed(&mesh, object.pose)) else { return false };
        let (low, high) = mesh.bounds();
        let top = mesh.positions.iter().filter(|p| p.z >= high.z - TOP_M);
        let (from, to) =
            top.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(from, to), &p| (from.min(p), to.max(p)));
        let share = (to - from) / (high - low);
        share.x.min(share.y) >= MIN_TOP_SHARE
    };
    let find = |id: &InstanceId| objects.iter().find(|object| object.id == *id);
    arrangement.objects.iter().filter_map(find).all(is_flat)
}

/// Each object of a higher layer with the left one of the two below it.
fn pyramid_pairs(pyramid: &Arrangement) -> Vec<(InstanceId, InstanceId)> {
    let mut pairs = Vec::new();
    let (mut below, mut start) = (0, 0);
    for (layer, size) in pyramid_layers(pyramid.objects.len()).into_iter().enumerate() {
        if layer > 0 {
            let upper = &pyramid.objects[start..start + size];
            pairs.extend(upper.iter().cloned().zip(pyramid.objects[below..start].iter().cloned()));
        }
        (below, start) = (start, start + size);
    }
    pairs
}

/// The last objects of a pile, each with one of the first that can carry it.
fn pile_pairs(pile: &Arrangement, objects: &[ObjectSpec]) -> Vec<(InstanceId, InstanceId)> {
    let spec = |id: &InstanceId| objects.iter().find(|object| object.id == *id);
    let can_carry = |id: &&InstanceId| {
        spec(id).is_some_and(|object| {
            let kind = category(&object.category);
            object.pose.is_upright()
                && kind.is_some_and(|kind| kind.affordances.contains(&Affordance::Support))
        })
    };
    let upper_count = (UPPER_SHARE * pile.objects.len() as f64).floor() as usize;
    let (lower, upper) = pile.objects.split_at(pile.objects.len() - upper_count);
    upper.iter().cloned().zip(lower.iter().filter(can_carry).cloned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::RequestedPose;

    fn id(number: usize) -> InstanceId {
        InstanceId::numbered("block", number)
    }

    #[test]
    fn tops_are_flat_of_what_others_can_stand_on() {
        for (category_name, expected) in
            [("cube", true), ("soda_can", true), ("mug", true), ("tennis_ball", false), ("tissue_box", false)]
        {
            let size_m = Recipe::typical(category_name, None, None).expect("a category").size_m;
            let object = ObjectSpec {
                id: id(1),
                label: category_name.to_owned(),
                category: category_name.to_owned(),
                size_m,
                color: None,
                material: None,
                seed: 1,
                requested: true,
                stand_in: None,
                pose: RequestedPose::Upright,
                yaw_rad: None,
                position_m: None,
                state: None,
                mass_kg: None,
                relations: Vec::new(),
            };
            let alone = Arrangement {
                kind: ArrangementKind::Pyramid,
                objects: vec![id(1)],
                gap_m: None,
                center: None,
            };
            assert_eq!(has_flat_tops(&alone, &[object]), expected, "{category_name}");
        }
    }

    #[test]
    fn pyramid_of_six_stands_on_its_lower_layers() {
        let pyramid = Arrangement {
            kind: ArrangementKind::Pyramid,
            objects: (1..=6).map(id).collect(),
            gap_m: None,
            center: None,
        };
        let expected = [(4, 1), (5, 2), (6, 4)].map(|(upper, lower)| (id(upper), id(lower)));
        assert_eq!(pyramid_pairs(&pyramid), expected);
    }
}
