//! Objects that were named before, for pronouns, "the others" and "a blue one".

use scene::{EditPlace, RelationKind};

use crate::vocabulary::{color_of, material_of};

/// Objects that a pronoun may stand for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Topic {
    /// Phrases that mean them at the beginning of the next operation.
    pub phrases: Vec<String>,
    pub is_plural: bool,
    /// Whether a change made the phrases unfit, so that only "it" right after it still means them.
    pub is_stale: bool,
    pub is_removed: bool,
    /// Indices of the operations that made them, where they are new and have no place yet.
    pub made_at: Vec<usize>,
}

/// Content of earlier clauses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Discourse {
    pub topic: Option<Topic>,
    /// Relation and object of the last place.
    pub landmark: Option<(RelationKind, String)>,
    pub place: Option<EditPlace>,
    /// Nouns with the phrase that named their object, and whether it was removed.
    pub mentions: Vec<(String, String, bool)>,
    /// Noun of the main objects of the clause, for "the red mug next to the blue one".
    pub clause_noun: Option<String>,
    /// Noun of the main objects of the last clause that named them.
    pub main_noun: Option<String>,
    /// Phrase of the main object of the clause, for "the cup nearest to it".
    pub clause_phrase: Option<String>,
    /// Objects that stay as they are.
    pub kept: Vec<String>,
    /// The operation that took objects from where they were, until a clause says where they go.
    pub taken_at: Option<usize>,
}

/// Property of its objects that an operation changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Changes {
    Place,
    Appearance,
    Size,
    Label,
    Nothing,
}

impl Discourse {
    pub fn mention(&mut self, noun: &str, phrase: &str, is_removed: bool) {
        let noun = noun.split(" of ").next().unwrap_or_default().to_owned();
        self.mentions.retain(|(_, known, _)| known != phrase);
        self.mentions.push((noun, phrase.to_owned(), is_removed));
    }

    /// The noun of "a blue one".
    pub fn last_noun(&self) -> Option<&str> {
        let mentioned = self.mentions.iter().rev().map(|(noun, ..)| noun.as_str());
        self.clause_noun
            .as_deref()
            .into_iter()
            .chain(mentioned)
            .find(|noun| !matches!(*noun, "it" | "them" | "" | "one" | "ones"))
    }

    /// "the other mug" as "the mug other than the red mug".
    pub fn other(&self, noun: &str) -> Option<String> {
        let (_, phrase, is_removed) = self.mentions.iter().rev().find(|(known, ..)| known == noun)?;
        let only = phrase == &format!("the {noun}");
        match (is_removed, only) {
            (true, _) => Some(format!("the {noun}")),
            (false, true) => None,
            (false, false) => Some(format!("the {noun} other than {phrase}")),
        }
    }

    /// Phrases of what is not "everything else".
    pub fn not_rest(&self) -> Vec<String> {
        let mut named = self.kept.clone();
        for (_, phrase, is_removed) in &self.mentions {
            if !is_removed && !named.contains(phrase) {
                named.push(phrase.clone());
            }
        }
        named
    }
}

/// Whether a phrase may cease to mean the same objects by a change of them.
pub(super) fn goes_stale(phrase: &str, changes: Changes) -> bool {
    const PLACES: &[&str] = &[
        "left",
        "right",
        "front",
        "back",
        "rear",
        "middle",
        "center",
        "centre",
        "leftmost",
        "rightmost",
        "frontmost",
        "backmost",
        "first",
        "second",
        "third",
        "fourth",
        "fifth",
        "sixth",
        "last",
        "nearest",
        "closest",
        "farthest",
        "furthest",
        "next",
        "beside",
        "behind",
        "near",
        "on",
        "in",
        "inside",
        "under",
        "between",
        "top",
        "topmost",
        "bottom",
        "lowest",
        "corner",
        "edge",
        "by",
        "with",
    ];
    const SIZES: &[&str] = &[
        "small", "smaller", "smallest", "big", "bigger", "biggest", "large", "larger", "largest", "tall",
        "taller", "tallest", "short", "shorter", "shortest", "little", "tiny", "long", "longest",
    ];
    let lower = phrase.to_lowercase();
    let mut words = lower.split(' ');
    match changes {
        Changes::Place => words.any(|word| PLACES.contains(&word)),
        Changes::Appearance => words.any(|word| color_of(word).is_some() || material_of(word).is_some()),
        Changes::Size => words.any(|word| SIZES.contains(&word)),
        Changes::Label => true,
        Changes::Nothing => false,
    }
}
