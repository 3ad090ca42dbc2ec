//! Who carries whom.

use super::Thing;

/// What carries a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Carrier {
    /// Index of the supporting thing.
    pub parent: usize,
    /// In it rather than on it.
    pub inside: bool,
}

/// The carrier of each thing by its first supporting relation; `None` = the table. A relation that would
/// close a circle is left out.
pub(super) fn carriers(things: &[Thing]) -> Vec<Option<Carrier>> {
    let mut carriers: Vec<Option<Carrier>> = vec![None; things.len()];
    for (index, thing) in things.iter().enumerate() {
        let support = thing.relations.iter().find_map(|&(kind, target)| match target {
            Some(parent) if kind.is_support() && parent < things.len() => {
                Some(Carrier { parent, inside: kind == scene::RelationKind::In })
            }
            _ => None,
        });
        if support.is_some_and(|carrier| !rests_on(&carriers, carrier.parent, index)) {
            carriers[index] = support;
        }
    }
    carriers
}

/// Whether `thing` is `base` or rests on it, directly or not.
pub(super) fn rests_on(carriers: &[Option<Carrier>], thing: usize, base: usize) -> bool {
    let mut at = Some(thing);
    while let Some(here) = at {
        if here == base {
            return true;
        }
        at = carriers[here].map(|carrier| carrier.parent);
    }
    false
}
