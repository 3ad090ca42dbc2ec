//! The phrases of the grammar (`config/catalog/phrases.toml`).

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::tokens::{Token, match_phrase, word};

/// Phrases by their first word.
#[derive(Deserialize)]
#[serde(from = "Vec<String>")]
pub(super) struct PhraseList(BTreeMap<String, Vec<String>>);

impl From<Vec<String>> for PhraseList {
    fn from(phrases: Vec<String>) -> Self {
        let mut by_first: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for phrase in phrases {
            let first = phrase.split(' ').next().unwrap_or_default().to_owned();
            by_first.entry(first).or_default().push(phrase);
        }
        Self(by_first)
    }
}

impl PhraseList {
    /// Number of tokens of the longest phrase at `at`.
    pub fn longest_at(&self, tokens: &[Token], at: usize) -> Option<usize> {
        let phrases = self.0.get(word(tokens, at)?)?;
        phrases.iter().filter_map(|phrase| match_phrase(tokens, at, phrase)).max()
    }

    /// As [`Self::longest_at`]; 0 if there is no phrase.
    pub fn length_at(&self, tokens: &[Token], at: usize) -> usize {
        self.longest_at(tokens, at).unwrap_or(0)
    }

    /// Whether the word is one of the phrases.
    pub fn has(&self, word: &str) -> bool {
        self.0.get(word).is_some_and(|phrases| phrases.iter().any(|phrase| phrase == word))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Phrases {
    pub exclusion: Exclusion,
    pub agent: Agent,
    pub goal_heading: GoalHeading,
    pub end_state: EndStates,
    pub arrangement: Arrangement,
    pub remark: Remark,
    pub answer: Answer,
    pub list: List,
    pub path: Paths,
    pub language: Language,
}

/// Phrases that exclude objects from the table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Exclusion {
    /// Phrases before an excluded object.
    pub before: PhraseList,
    /// Negations of a verb that asks for objects.
    pub negations: PhraseList,
    /// Verbs that ask for objects.
    pub asks: PhraseList,
    /// Words that close a list.
    pub closed: PhraseList,
    /// Phrases after an excluded object.
    pub after: PhraseList,
    /// Phrases after an object that may be there, and need not.
    pub permitted: PhraseList,
    /// With "usual" or "other" before them, they are everything that the text does not name.
    pub anything_else: PhraseList,
}

/// Phrases for the agent: "let the robot arm".
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Agent {
    pub names: PhraseList,
    pub adjectives: PhraseList,
    /// Robots and people by their names and roles.
    pub persons: PhraseList,
    /// Words that stand for an agent before a verb.
    pub pronouns: PhraseList,
    /// People at a table.
    pub people: PhraseList,
    /// Verbs that make an agent act.
    pub causes: PhraseList,
    /// Verbs whose subject may be an object where it is.
    pub stative: PhraseList,
    /// Verbs of seeing ("you can find two apples").
    pub perceives: PhraseList,
    /// Nouns of actions ("placement of the egg in the bowl").
    pub actions: PhraseList,
    /// Before a condition that a scene cannot show.
    pub conditions: PhraseList,
    /// Conjunctions with a noun ("in case").
    pub conjunctions: PhraseList,
    /// Before a clause that says when or why.
    pub times: PhraseList,
    /// Verbs before the gerund of what is to be done ("needs stacking").
    pub needs: PhraseList,
    /// Before the other outcome of a condition.
    pub alternatives: PhraseList,
    /// After "if", what asks for no condition ("if possible").
    pub formulas: PhraseList,
}

/// Headings of the end state: "the goal state has".
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GoalHeading {
    pub names: PhraseList,
    pub states: PhraseList,
    /// After a heading without a state.
    pub reached: PhraseList,
    /// Between the heading and the end state.
    pub links: PhraseList,
}

/// End states: "the mug must end up on the plate".
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EndStates {
    pub modals: PhraseList,
    /// Verbs that link a subject to its end state.
    pub copulas: PhraseList,
    pub adverbs: PhraseList,
    /// Openers of a clause that states the outcome of an action.
    pub results: PhraseList,
    /// Verbs that state that the subject moves or changes, and not where it is.
    pub changes: PhraseList,
}

/// Words before an arrangement: "laid out in a straight line".
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Arrangement {
    pub openers: PhraseList,
    pub adjectives: PhraseList,
    pub verbs: PhraseList,
}

/// Remarks that ask for no object.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Remark {
    /// Phrases after a word of no importance.
    pub indifferent: PhraseList,
    /// Nouns by which a text names itself.
    pub kinds: PhraseList,
}

/// Inventories: "mug: yes, plate: no".
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Answer {
    pub no: PhraseList,
    pub yes: PhraseList,
    /// Headings of a list of all objects.
    pub headings: PhraseList,
    /// Headings of a setting for several people.
    pub settings: PhraseList,
}

/// Lists and counts.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct List {
    /// Before an exception.
    pub exceptions: PhraseList,
    /// Before the members of a set.
    pub examples: PhraseList,
    /// After the count of objects that the text has named.
    pub totals: PhraseList,
    /// Before a count that they leave unchanged.
    pub hedges: PhraseList,
    /// Verbs of events that happened to an object.
    pub falls: PhraseList,
}

/// Destinations.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Paths {
    /// Prepositions of destinations that are not relations of a description.
    pub directed: PhraseList,
}

/// Words that tell languages apart.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Language {
    /// Other languages seldom have them.
    pub english: PhraseList,
    /// Articles, prepositions and conjunctions of other languages that English texts seldom have.
    pub foreign: PhraseList,
    /// Imperatives at the beginning of an instruction in another language.
    pub foreign_verbs: PhraseList,
}

static PHRASES: LazyLock<Phrases> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../../config/catalog/phrases.toml"))
        .expect("the built-in phrases parse (a test loads them)")
});

pub(super) fn phrases() -> &'static Phrases {
    &PHRASES
}

#[cfg(test)]
mod tests {
    use super::super::tokens::tokenize;
    use super::*;

    #[test]
    fn the_longest_phrase_is_found() {
        let list = PhraseList::from(vec!["next".to_owned(), "next to".to_owned(), "on".to_owned()]);
        for (text, length, has) in [("next to it", Some(2), true), ("on", Some(1), true), ("to", None, false)]
        {
            let tokens = tokenize(text);
            assert_eq!(list.longest_at(&tokens, 0), length, "{text}");
            assert_eq!(list.has(text.split(' ').next().unwrap_or_default()), has, "{text}");
        }
        assert_eq!(phrases().exclusion.before.longest_at(&tokenize("instead of a mug"), 0), Some(2));
    }
}
