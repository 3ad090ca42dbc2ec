//! Kinds of objects by the nouns that a model answers with.

use catalog::stand_in::stand_in;
use catalog::{Category, category, category_called};
use scene::StandIn;

/// A kind of objects: the category that builds them.
pub(super) struct ObjectKind {
    pub category: &'static Category,
    /// For nouns that the catalog lacks: the mark of their objects, and the substance of their shape.
    pub stand_in: Option<(StandIn, &'static str)>,
}

impl ObjectKind {
    /// First part of the ids of its objects.
    pub fn stem(&self) -> &str {
        self.stand_in.as_ref().map_or(&self.category.name, |(mark, _)| &mark.stands_for)
    }
}

/// The category with this name or synonym, else a stand-in from the lexicon; `None` for words that name no object for a
/// table.
pub(super) fn object_kind(noun: &str) -> Option<ObjectKind> {
    if let Some(category) = category_called(noun) {
        return Some(ObjectKind { category, stand_in: None });
    }
    let noun = noun.trim().to_lowercase().replace(['_', '-'], " ");
    let last_word = noun.rsplit(' ').next().unwrap_or(&noun);
    let found = stand_in(&noun).or_else(|| stand_in(last_word))?;
    let category = category(&found.category_name())?;
    let mark = StandIn { stands_for: noun, shown_as: category.label.clone() };
    Some(ObjectKind { category, stand_in: Some((mark, found.substance)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nouns_are_categories_or_stand_ins_or_nothing() {
        for (noun, name) in [("mug", "mug"), ("Coffee Mug", "mug"), ("safety-pin", "safety_pin")] {
            let kind = object_kind(noun).expect(noun);
            assert_eq!((kind.category.name.as_str(), kind.stem()), (name, name), "{noun}");
            assert!(kind.stand_in.is_none(), "{noun}");
        }
        let accordion = object_kind("piano_accordion").expect("a noun of the lexicon");
        assert_eq!(accordion.stem(), "piano accordion");
        assert!(catalog::stand_in::is_stand_in(&accordion.category.name));
        for noun in ["happiness", "sofa", ""] {
            assert!(object_kind(noun).is_none(), "{noun}");
        }
    }
}
