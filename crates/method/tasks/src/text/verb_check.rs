//! Check that a robot performs every verb of an instruction, and that the goal states all that the verbs do.
//!
//! The analyst finds a goal in many sentences that ask for more than it: "crack the egg into the pan" ends with the egg
//! in the pan. Therefore the verbs decide, and they are listed ([`super::performed`]). Words are examined in the places
//! of a sentence where a verb may be: where a clause begins, before a noun phrase, after "to", "should" and the like,
//! and where the analyst found a goal. A word in such a place that is no performed verb, no noun of the analyst and no
//! function word is a verb that is not performed, whether it is known or not.
//!
//! Goals state no recipients, amounts, directions of turns, conditions and negations. Instructions with these are
//! refused, too.

use std::ops::Range;

use scene::text_account::{GoalPredicate, PredicateKind, TextMeaning, Understood};

use super::function_words::{FUNCTION_WORDS, PHRASE_OPENERS, REQUEST_WORDS, VERB_OPENERS};
use super::unstated::unstated;
use super::words::{Word, words};
use crate::refusal::Refusal;
use language::performed::{PERFORMED, States, states};

/// An instruction with what the analyst made of it.
pub(super) struct Sentence<'a> {
    pub text: &'a str,
    /// In lower case without apostrophes.
    pub words: Vec<Word>,
    /// As the analyst read misspelled words; empty for the others.
    corrected: Vec<String>,
    /// Whether the analyst took the word for a part of an object, a property or a place.
    pub is_noun: Vec<bool>,
    /// Whether it took it for a property or a place.
    pub is_property: Vec<bool>,
    /// The predicates for which the word stands.
    goals: Vec<Vec<usize>>,
    /// Whether it is the first word that stands for one of them; others are its place ("10 cm to the left").
    opens_goal: Vec<bool>,
}

/// Checks the verbs of an instruction, and that its goal leaves nothing out.
///
/// # Errors
///
/// [`Refusal::VerbNotPerformed`] with the first verb that is not performed, and
/// [`Refusal::InstructionNotUnderstood`] with what the goal does not state.
pub(super) fn require_performed(
    text: &str,
    understood: &[Understood],
    predicates: &[GoalPredicate],
) -> Result<(), Refusal> {
    let sentence = Sentence::new(text, understood);
    let other = (0..sentence.words.len()).find(|&at| sentence.is_other_verb(at));
    if let Some(at) = other.or_else(|| sentence.unfit_verb(predicates)) {
        return Err(not_performed(sentence.verb_phrase(at)));
    }
    unstated(&sentence, predicates)
}

/// The refusal of a verb.
pub(super) fn not_performed(verb: &str) -> Refusal {
    Refusal::VerbNotPerformed { verb: verb.to_owned(), performed: PERFORMED.to_owned() }
}

impl<'a> Sentence<'a> {
    fn new(text: &'a str, understood: &[Understood]) -> Self {
        let covers = |part: &Understood, bytes: &Range<usize>| {
            part.span.start < bytes.end && bytes.start < part.span.end
        };
        let mut words = words(text);
        let (mut is_noun, mut is_property, mut goals) = (Vec::new(), Vec::new(), Vec::new());
        let (mut corrected, mut opens_goal) = (Vec::new(), Vec::new());
        for word in &mut words {
            word.text.retain(|c| !matches!(c, '\'' | '’'));
            let (mut noun, mut property, mut indices, mut read) = (false, false, Vec::new(), String::new());
            let mut opens = false;
            for part in understood.iter().filter(|part| covers(part, &word.bytes)) {
                match &part.meaning {
                    TextMeaning::Goal { index } => {
                        opens |= part.span.start >= word.bytes.start;
                        indices.push(*index);
                    }
                    TextMeaning::Correction { corrected } => read = corrected.to_lowercase(),
                    TextMeaning::Completion { .. } => {}
                    TextMeaning::Property { .. } | TextMeaning::Relation { .. } => property = true,
                    _ => noun = true,
                }
            }
            is_noun.push((noun || property) && indices.is_empty());
            is_property.push(property);
            goals.push(indices);
            corrected.push(read);
            opens_goal.push(opens);
        }
        Self { text, words, corrected, is_noun, is_property, goals, opens_goal }
    }

    /// The word at an index; empty beyond the ends.
    pub fn word(&self, at: Option<usize>) -> &str {
        at.and_then(|at| self.words.get(at)).map_or("", |word| &word.text)
    }

    /// Whether punctuation is between a word and the one before it.
    pub fn is_after_pause(&self, at: usize) -> bool {
        let Some(before) = at.checked_sub(1) else { return true };
        let between = &self.text[self.words[before].bytes.end..self.words[at].bytes.start];
        between.chars().any(|c| !c.is_whitespace() && !matches!(c, '-' | '"' | '\'' | '“' | '”'))
    }

    /// Index of the word at which the first sentence with a part of the goal begins; 0 without a goal.
    pub fn first_instruction(&self) -> usize {
        let Some(goal) = self.goals.iter().position(|goals| !goals.is_empty()) else { return 0 };
        let begins = |at: &usize| {
            let Some(before) = at.checked_sub(1) else { return true };
            let between = &self.text[self.words[before].bytes.end..self.words[*at].bytes.start];
            let mut chars = between.chars();
            // "0.5" is no end.
            chars.find(|c| matches!(c, '.' | '!' | '?' | ';')).is_some() && chars.any(char::is_whitespace)
        };
        (0..=goal).rev().find(begins).unwrap_or(0)
    }

    /// The words of a range as the text has them.
    pub fn words_of(&self, range: Range<usize>) -> &'a str {
        let start = self.words.get(range.start).map_or(self.text.len(), |word| word.bytes.start);
        let end = self.words.get(range.end.wrapping_sub(1)).map_or(start, |word| word.bytes.end);
        self.text.get(start..end).unwrap_or_default()
    }

    fn begins_clause(&self, at: usize) -> bool {
        let before = at.checked_sub(1);
        self.is_after_pause(at)
            || matches!(
                self.word(before),
                "and" | "then" | "but" | "or" | "so" | "before" | "after" | "while"
            )
    }

    /// Whether a noun phrase with a determiner, or a pronoun, follows.
    fn is_before_phrase(&self, at: usize) -> bool {
        at + 1 < self.words.len()
            && !self.is_after_pause(at + 1)
            && PHRASE_OPENERS.contains(&self.word(Some(at + 1)))
    }

    /// Whether the word is in a place of a verb and is none that is performed.
    fn is_other_verb(&self, at: usize) -> bool {
        let before = self.word(at.checked_sub(1));
        let word = self.word(Some(at));
        // "the spoon": a noun, whatever it could be elsewhere; "without touching the glass" is no motion.
        if PHRASE_OPENERS.contains(&before) && !matches!(before, "it" | "them" | "me" | "us" | "him")
            || before == "without"
        {
            return false;
        }
        // "the red plate": the noun of a phrase; "the left hand".
        let is_noun = self.is_noun[at] && at > 0 && self.is_noun[at - 1] && !self.is_after_pause(at);
        let is_hand = matches!(word, "hand" | "hands")
            && matches!(before, "left" | "right" | "robot" | "robots" | "robotic" | "other" | "both");
        if is_noun || is_hand {
            return false;
        }
        let is_passive = matches!(before, "be" | "been" | "being" | "get" | "gets")
            && ["ed", "en", "wn"].iter().any(|ending| word.ends_with(ending));
        let is_place = self.is_before_phrase(at)
            || is_passive && !self.is_property[at]
            || !self.is_noun[at]
                && (self.begins_clause(at) || VERB_OPENERS.contains(&before) || self.opens_goal[at]);
        let is_performed = [word, &self.corrected[at]].into_iter().any(|word| states(word).is_some());
        is_place && !self.is_no_verb(at) && !is_performed
    }

    fn is_no_verb(&self, at: usize) -> bool {
        let word = self.word(Some(at));
        FUNCTION_WORDS.contains(&word)
            || REQUEST_WORDS.contains(&word)
            || word.ends_with("ly")
            || word.chars().all(|c| c.is_ascii_digit())
            || word == "use" && self.uses_arm(at)
    }

    /// "use the left arm to": the arm is no tool.
    fn uses_arm(&self, at: usize) -> bool {
        (at + 1..at + 5).any(|at| matches!(self.word(Some(at)), "arm" | "gripper" | "hand" | "robot"))
    }

    /// A verb that is performed, but does not state the predicate for which it stands: "turn on the lamp".
    fn unfit_verb(&self, predicates: &[GoalPredicate]) -> Option<usize> {
        predicates.iter().enumerate().find_map(|(index, predicate)| {
            // "make sure that": verbs that state nothing are neither fit nor unfit.
            let verbs: Vec<(usize, States)> = (0..self.words.len())
                .filter(|at| self.goals[*at].contains(&index))
                .filter_map(|at| Some((at, states(self.word(Some(at)))?)))
                .filter(|(_, states)| *states != States::Nothing)
                .collect();
            let fits = |states: States| {
                states.includes(predicate.predicate)
                    // "pick up and put down": the place replaces the lift.
                    || predicate.predicate == PredicateKind::Lifted && states == States::Places && verbs.len() > 1
            };
            let (first, _) = verbs.first()?;
            (!verbs.iter().any(|(_, states)| fits(*states))).then_some(*first)
        })
    }

    /// A verb with its particle: "turn on", "hand".
    fn verb_phrase(&self, at: usize) -> &'a str {
        let has_particle = matches!(self.word(Some(at + 1)), "on" | "off" | "away" | "out" | "over")
            && !self.is_after_pause(at + 1);
        self.words_of(at..at + 1 + usize::from(has_particle))
    }
}

#[cfg(test)]
mod tests {
    use embedded::text_parser::{DescribeOptions, TextParserSettings, describe};
    use serde_json::Value;

    use super::*;

    /// Instructions of `tests/words/tasks.jsonl` that are refused although their predicates are performed: what they
    /// ask for is more than these.
    const REFUSED: &[&str] = &[
        "push_pull_10",
        "rotate_flip_01",
        "rotate_flip_02",
        "rotate_flip_05",
        "rotate_flip_06",
        "rotate_flip_10",
        "sort_07",
        "request_02",
        "multi_step_12",
    ];

    /// A table of 200 instructions: those whose predicates an execution performs are not refused.
    #[test]
    fn instructions_with_performed_predicates_are_not_refused() {
        const NOT_PERFORMED: [&str; 5] = ["poured_into", "used_on", "pressed", "opened", "closed"];
        let settings: TextParserSettings = test_settings::section("analyst");
        let options = DescribeOptions { max_objects: 64, table: None, on_unknown: Default::default() };
        let mut wrong = Vec::new();
        for line in include_str!("../../../../../tests/words/tasks.jsonl").lines() {
            let entry: Value = serde_json::from_str(line).expect("a line of the table");
            let (id, text) = (entry["id"].as_str().expect("an id"), entry["text"].as_str().expect("a text"));
            let kinds =
                entry["goal"].as_array().into_iter().flatten().map(|one| one["predicate"].to_string());
            let is_performed =
                !kinds.flat_map(|kind| NOT_PERFORMED.map(|not| kind.contains(not))).any(|not| not);
            let Ok(described) = describe(text, 1, &options, &settings) else { continue };
            let predicates = described.goal.as_ref().map_or(&[][..], |goal| &goal.predicates);
            let found = require_performed(text, &described.understood, predicates);
            if is_performed && found.is_ok() == REFUSED.contains(&id) {
                wrong.push(format!("{id} {text:?}: {found:?}"));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}
