//! Nouns outside the catalog: stand-ins, meanings, and nouns for what does not stand on a table.

use catalog::{Category, SizeRange};

/// A plain shape in place of an object that the catalog does not have.
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

/// No nouns beside those of the catalog.
pub(super) struct CatalogOnly;

impl Nouns for CatalogOnly {
    fn stand_in(&self, _: &str) -> Option<StandIn<'static>> {
        None
    }

    fn nearest_by_meaning(&self, _: &str) -> Option<&'static str> {
        None
    }

    fn is_not_placeable(&self, _: &str) -> bool {
        false
    }

    fn is_noun(&self, _: &str) -> bool {
        false
    }
}
