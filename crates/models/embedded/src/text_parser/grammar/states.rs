//! Poses and states: "lying on its side", "upside down", "open", "half full". A state that the category cannot show is
//! reported.

use std::ops::Range;

use super::Parser;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::property::Property;
use crate::text_parser::tokens::word;
use catalog::{Affordance, Category, State};
use scene::description::RequestedPose;
use scene::text_account::UnrecognizedReason;

/// Maximum number of words of a state.
const MAX_WORDS: usize = 5;

impl Parser<'_, '_> {
    /// A state of the current subject. Whether the rule applies.
    pub(super) fn state(&mut self) -> bool {
        let mut p = self.at;
        while matches!(
            self.word_at(p),
            Some(
                "is" | "are"
                    | "that"
                    | "which"
                    | "placed"
                    | "standing"
                    | "lying"
                    | "all"
                    | "both"
                    | "still"
                    | "put"
                    | "turned"
                    | "left"
                    | "kept"
                    | "should"
                    | "be"
                    | "must"
                    | "has"
                    | "have"
                    | "been"
            )
        ) && self.state_at(p).is_none()
            && p < self.at + 4
        {
            p += 1;
        }
        let Some((state, length)) = self.state_at(p) else { return false };
        let tokens = self.at..p + length;
        // "full of pencils", "filled with water", "open to the left", "an open book".
        let next = self.word_at(tokens.end);
        if matches!(state.as_str(), "full") && matches!(next, Some("of" | "with")) {
            return false;
        }
        let subjects =
            if self.subject.is_empty() && p > self.at { self.salient_list.clone() } else { self.attached() };
        // "a glass upside down and a jar lying on its side".
        let subjects = match subjects.last() {
            Some(&last) if subjects.iter().any(|&m| self.contradicts_state(m, &state)) => vec![last],
            Some(_) => subjects,
            None => return false,
        };
        if matches!(state.as_str(), "open" | "empty" | "full" | "closed" | "folded" | "broken")
            && self.noun_follows(tokens.end)
        {
            return false;
        }
        self.at = tokens.end;
        if state == "half_full"
            && next == Some("of")
            && self.word(1).is_some_and(|word| self.lexicon.vocabulary.grammar.substances.contains(word))
        {
            self.parsed.account.used(self.at..self.at + 2);
            self.at += 2;
        }
        self.set_states(&subjects, &state, tokens);
        true
    }

    fn noun_follows(&self, at: usize) -> bool {
        self.lexicon.longest_at(self.tokens, at).is_some()
    }

    /// The state of the longest phrase at a position, and its number of tokens.
    pub(super) fn state_at(&self, at: usize) -> Option<(String, usize)> {
        let mut phrase = String::new();
        let mut best = None;
        for k in 0..MAX_WORDS {
            let Some(next) = word(self.tokens, at + k) else { break };
            if k > 0 {
                phrase.push(' ');
            }
            phrase.push_str(next);
            if let Some(state) = self.lexicon.vocabulary.states.get(&phrase) {
                best = Some((state.clone(), k + 1));
            }
        }
        best
    }

    /// Sets a pose or a state of mentions.
    pub(super) fn set_states(&mut self, mentions: &[usize], state: &str, tokens: Range<usize>) {
        let pose = pose_of(state);
        if mentions.iter().any(|&m| self.contradicts_state(m, state)) {
            self.report(tokens, UnrecognizedReason::Contradiction);
            return;
        }
        for &m in mentions {
            self.stated.push((m, state.to_owned()));
        }
        let supported: Vec<usize> =
            mentions.iter().copied().filter(|&m| pose.is_some() || self.can_show(m, state)).collect();
        if supported.is_empty() {
            self.report(tokens, UnrecognizedReason::NotSupported);
            return;
        }
        for &m in &supported {
            let mention = &mut self.parsed.mentions[m];
            match pose {
                Some(pose) => mention.pose = pose,
                None => {
                    mention.state =
                        Some(state.to_owned()).filter(|state| state != "empty").or(mention.state.take())
                }
            }
        }
        self.claim_property(tokens, Property::State, supported);
    }

    /// Whether the mention has a state that excludes this one.
    fn contradicts_state(&self, mention: usize, state: &str) -> bool {
        const EXCLUSIVE: &[&[&str]] = &[
            &["upright", "lying_on_side", "upside_down"],
            &["open", "closed"],
            &["empty", "full", "half_full"],
            &["on", "off"],
        ];
        let known = self.stated.iter().filter(|(m, _)| *m == mention).map(|(_, known)| known.as_str());
        known.into_iter().any(|known| {
            known != state && EXCLUSIVE.iter().any(|group| group.contains(&known) && group.contains(&state))
        })
    }

    /// Whether objects of the mention can show a state. Containers are empty unless the text says what they contain.
    pub(super) fn can_show(&self, mention: usize, state: &str) -> bool {
        match self.parsed.mentions[mention].meanings.first() {
            Some(Meaning::Category(index)) => {
                let category = &self.lexicon.categories[*index];
                (state == "empty" && category.affords(Affordance::Container))
                    || category_shows(category, state)
            }
            _ => false,
        }
    }
}

/// The pose that a word of `[states]` names.
pub(super) fn pose_of(state: &str) -> Option<RequestedPose> {
    Some(match state {
        "upright" => RequestedPose::Upright,
        "lying_on_side" => RequestedPose::LyingOnSide,
        "upside_down" => RequestedPose::UpsideDown,
        _ => return None,
    })
}

/// Whether the meshes of a category show a state.
pub(in crate::text_parser) fn category_shows(category: &Category, state: &str) -> bool {
    match state {
        "open" => category.can_be(State::Open),
        "closed" => category.can_be(State::Closed),
        "folded" => category.can_be(State::Folded),
        _ => false,
    }
}
