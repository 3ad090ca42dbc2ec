//! Nouns outside the catalog: stand-ins, meanings, and nouns for what does not stand on a table.

use catalog::stand_in::{self, Placeability};
use catalog::{Category, SizeRange, category};

/// A plain form in place of an object that the catalog does not have.
#[derive(Clone, Debug)]
pub(super) struct StandIn<'c> {
    /// The category that builds the shape.
    pub category: &'c Category,
    pub size: SizeRange,
    /// A name of `config/materials.toml`.
    pub substance: String,
}

/// A lexicon of nouns.
pub(super) trait Nouns: Sync {
    /// The stand-in for objects with this name, singular.
    fn stand_in(&self, noun: &str) -> Option<StandIn<'static>>;
    /// The label of the category that is nearest in meaning.
    fn nearest_by_meaning(&self, noun: &str) -> Option<&'static str>;
    /// Whether the noun denotes a person, a place, a substance or the like.
    fn is_not_placeable(&self, noun: &str) -> bool;
    /// Whether the word is an English noun, so that it is not a misspelled word of the catalog.
    fn is_noun(&self, word: &str) -> bool;
}

/// The nouns of WordNet, with the stand-ins of the catalog.
pub(super) struct WordNetNouns;

impl Nouns for WordNetNouns {
    fn stand_in(&self, noun: &str) -> Option<StandIn<'static>> {
        let found = stand_in::stand_in(noun)?;
        let category = category(&found.category_name())?;
        Some(StandIn { category, size: found.size, substance: found.substance.to_owned() })
    }

    fn nearest_by_meaning(&self, noun: &str) -> Option<&'static str> {
        stand_in::nearest_by_meaning(noun)
    }

    fn is_not_placeable(&self, noun: &str) -> bool {
        matches!(stand_in::placeability(noun), Some(Placeability::NotPlaceable(_)))
    }

    fn is_noun(&self, word: &str) -> bool {
        stand_in::placeability(word).is_some()
    }
}
