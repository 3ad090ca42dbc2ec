//! Supports that arrangements imply: layers of pyramids, and the upper objects of piles.

use catalog::{Affordance, category};
use scene::predicates::pyramid_layers;
use scene::{Arrangement, ArrangementKind, InstanceId, ObjectSpec, Relation, RelationKind, SceneDescription};

/// Share of the objects of a pile that lie on other ones, where those can carry them.
const UPPER_SHARE: f64 = 0.4;

/// The description with the support relations that its arrangements imply. Without pyramids and piles it is the same.
/// An upper object loses its former support.
pub(super) fn with_supports(description: &SceneDescription) -> SceneDescription {
    let mut extended = description.clone();
    for arrangement in &description.arrangements {
        let pairs = match arrangement.kind {
            ArrangementKind::Pyramid => pyramid_pairs(arrangement),
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

    fn id(number: usize) -> InstanceId {
        InstanceId::numbered("block", number)
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
