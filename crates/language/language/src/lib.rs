//! English of instructions: from words to clauses whose parts are typed.
//!
//! [`tokens`] are words. Noun phrases and places are read at every index with the cost of each reading
//! ([`chart`]). Constructions, which are data, say what clauses mean, and the reading of a text is the cheapest
//! sequence of clauses that leaves the fewest words unread. What a phrase means is decided by who knows the scene
//! ([`Referents`]).

mod tokens;
mod lexicon;
mod measures;
pub mod vocabulary;
pub mod nouns;
pub mod words;
pub mod repair;
mod chart;
pub mod outermost;
mod nominal;
mod place;
mod appearance;
mod construction;
mod clause;
mod reading;
pub mod performed;
pub mod edit;
pub mod task;

pub use chart::{EnglishNouns, Referents};
