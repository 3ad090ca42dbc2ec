//! The support tree of the objects.

use super::LayoutObject;

/// The supporter of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Supporter {
    /// Index of the supporting object.
    pub parent: usize,
    /// Whether the object is inside the supporter rather than on top.
    pub inside: bool,
}

/// The supporter of each object by its first support relation; `None` = the table. Relations that would close a
/// cycle are ignored.
pub(super) fn supporters(objects: &[LayoutObject]) -> Vec<Option<Supporter>> {
    let mut supporters: Vec<Option<Supporter>> = vec![None; objects.len()];
    for (index, object) in objects.iter().enumerate() {
        let support = object.relations.iter().find_map(|&(kind, target)| match target {
            Some(parent) if kind.is_support() && parent < objects.len() => {
                Some(Supporter { parent, inside: kind == scene::RelationKind::In })
            }
            _ => None,
        });
        if support.is_some_and(|supporter| !rests_on(&supporters, supporter.parent, index)) {
            supporters[index] = support;
        }
    }
    supporters
}

/// Whether `object` is `base` or rests on it, directly or indirectly.
pub(super) fn rests_on(supporters: &[Option<Supporter>], object: usize, base: usize) -> bool {
    let mut at = Some(object);
    while let Some(here) = at {
        if here == base {
            return true;
        }
        at = supporters[here].map(|supporter| supporter.parent);
    }
    false
}
