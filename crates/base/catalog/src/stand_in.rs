//! Stand-ins: forms of their kind for physical objects that the catalog lacks.
//!
//! A lexicon of about 19,000 nouns maps each to a rule with family (camera, bag, animal), size range and substance, and
//! to the nearest category of the catalog. The Python module `tabletopgen_checks.language.stand_ins` derives it from
//! the hypernyms of WordNet 3.0 and from `config/catalog/stand_in_rules.toml`; it is compiled in as
//! `config/catalog/stand_ins.tsv`. 23,000 more nouns are known as no object for a table, with the reason. Others are
//! unknown.
//!
//! A stand-in is built like any object of the catalog: its [`Recipe`](crate::Recipe) names a hidden category per family
//! (`stand_in_box`), which [`category`](crate::category) finds and [`categories`](crate::categories) does not list. The
//! object keeps the requested label. The lexicon is read at the first call, in a few milliseconds.
//!
//! ```
//! use catalog::stand_in::stand_in;
//! use catalog::build;
//!
//! let peach = stand_in("peach").expect("a fruit of WordNet");
//! assert_eq!(peach.family, "fruit");
//! let mesh = build(&peach.recipe(None, None, None, 7)).expect("every family has a shape");
//! assert!((mesh.size_m() - peach.typical_size_m()).length() < 0.01);
//! ```

mod lexicon;
mod rules;
mod shapes;
#[cfg(test)]
mod tests;

pub use lexicon::{Obstacle, Placeability, StandIn};
pub use shapes::is_stand_in;

pub(crate) use shapes::hidden_categories;
#[cfg(test)]
pub(crate) use tests::rule_samples;

/// The stand-in for a noun: singular, lower case, words separated by spaces. `None` if the noun is unknown or cannot
/// stand on a table; [`placeability`] distinguishes the two.
///
/// Names of species and breeds whose last word means the same shape are not listed ("brook trout"); ask for the head
/// noun when the whole is unknown.
pub fn stand_in(noun: &str) -> Option<&'static StandIn> {
    match placeability(noun)? {
        Placeability::Placeable(stand_in) => Some(stand_in),
        Placeability::NotPlaceable(_) => None,
    }
}

/// Ability of an object of that name to stand on a table; `None` for words that the lexicon does not have. The noun is
/// as for [`stand_in`]. "toy", "model" or "miniature" before a noun makes a toy of what is too large or a person.
pub fn placeability(noun: &str) -> Option<Placeability> {
    lexicon::lexicon().placeability(noun)
}

/// The label of the catalog's category whose meaning is nearest to a noun's: the fewest steps over a common hypernym.
/// `None` for nouns without a stand-in and for those that share no specific meaning with a category.
pub fn nearest_by_meaning(noun: &str) -> Option<&'static str> {
    let nearest = stand_in(noun)?.nearest?;
    crate::category(nearest).map(|category| category.label.as_str())
}
