//! The parts of an instruction: objects, sources, destinations and tools.

use std::ops::Range;

use super::{Parser, Referent};
use crate::text_parser::phrase::noun_phrase;
use crate::text_parser::prepositions::{place_at, preposition_at};
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::{Frame, verbs};
use scene::RelationKind;

/// A mention, and how many of its objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub mention: usize,
    pub take: Option<u32>,
}

/// A prepositional phrase of an instruction.
#[derive(Clone, Debug)]
pub(super) struct Path {
    pub kind: PathKind,
    pub targets: Vec<usize>,
    pub second: Option<usize>,
    /// "into", "onto", "to": always a destination.
    pub directed: bool,
    pub inverse: bool,
    pub distance_m: Option<f64>,
    pub tokens: Range<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum PathKind {
    Relation(RelationKind),
    /// "to the plate".
    At,
    Places(Vec<RelationKind>),
    Table,
    /// "to me".
    Person,
    /// "away from".
    Away,
    /// "upright", "upside down".
    State(String),
}

/// An instruction in parts.
#[derive(Clone, Debug)]
pub(super) struct Action {
    pub frame: Frame,
    pub verb: Range<usize>,
    pub objects: Vec<Part>,
    pub seconds: Vec<Part>,
    pub tools: Vec<usize>,
    pub sources: Vec<Path>,
    pub paths: Vec<Path>,
    /// Whether a substance without an object is moved ("pour the water").
    pub substance: bool,
    /// Whether the text names an object that is not known.
    pub unknown: bool,
    /// Whether the next path belongs to a relative clause ("that is next to the kettle").
    pub relative: bool,
    /// Particles after the object.
    pub particles: Vec<Range<usize>>,
}

impl Parser<'_, '_> {
    /// Reads an instruction whose verb is at `at`, and states its goal.
    pub(super) fn act(&mut self, frame: Frame, at: usize, length: usize, subjects: Vec<usize>) {
        let verb = at..at + length;
        self.at = verb.end;
        let mut action = self.new_action(frame, verb.clone());
        if frame == Frame::Use {
            action.tools = subjects;
        } else if !subjects.is_empty() && length <= 2 && !self.object_follows() {
            action.objects = subjects.into_iter().map(|mention| Part { mention, take: None }).collect();
        }
        while self.at < self.tokens.len() {
            let before = self.at;
            if !self.part(&mut action) {
                break;
            }
            self.at = self.at.max(before + 1);
        }
        self.conclude(action);
    }

    pub(super) fn new_action(&self, frame: Frame, verb: Range<usize>) -> Action {
        Action {
            frame,
            verb,
            objects: Vec::new(),
            seconds: Vec::new(),
            tools: Vec::new(),
            sources: Vec::new(),
            paths: Vec::new(),
            substance: false,
            unknown: false,
            relative: false,
            particles: Vec::new(),
        }
    }

    pub(super) fn object_follows(&self) -> bool {
        noun_phrase(self.lexicon, self.tokens, self.at).is_some()
    }

    /// Reads one part of the instruction; `false` at its end.
    pub(super) fn part(&mut self, action: &mut Action) -> bool {
        match &self.tokens[self.at] {
            Token::End => return false,
            Token::Pause => return self.after_pause(action),
            Token::Number(_) | Token::Word(_) => {}
        }
        if matches!(
            self.word(0),
            Some("and" | "then" | "or" | "but" | "while" | "before" | "after" | "so" | "without")
        ) {
            return self.after_conjunction(action);
        }
        if matches!(self.word(0), Some("that" | "which"))
            && matches!(self.word(1), Some("is" | "are" | "lies" | "stands" | "sits" | "was"))
            && !action.objects.is_empty()
        {
            self.parsed.account.used(self.at..self.at + 2);
            self.at += 2;
            action.relative = true;
            return true;
        }
        self.turn(action)
            || self.source(action)
            || self.state_path(action)
            || self.place_path(action)
            || self.tool(action)
            || self.distance_path(action)
            || self.relation_path(action)
            || self.particle(action)
            || self.object(action)
            || self.filler()
    }

    /// After a comma: the list of objects continues, or another prepositional phrase.
    pub(super) fn after_pause(&mut self, action: &mut Action) -> bool {
        let next = self.at + 1;
        if matches!(self.word_at(next), Some("and" | "then")) {
            self.at = next;
            return self.after_conjunction(action);
        }
        let is_verb =
            verbs().at(self.tokens, next).is_some() || verbs().opener_at(self.tokens, next).is_some();
        let list = action.paths.is_empty() && action.sources.is_empty() && !action.objects.is_empty();
        let phrase = noun_phrase(self.lexicon, self.tokens, next);
        let continues =
            (list && phrase.is_some_and(|(phrase, _)| !phrase.negated) && !self.is_statement(next))
                || self.is_source(next)
                || self.is_directed(next);
        if is_verb || !continues {
            return false;
        }
        self.at = next;
        true
    }

    /// Whether a subject with a verb begins ("the mug is red").
    pub(super) fn is_statement(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(_, end)| {
            matches!(self.word_at(end), Some("is" | "are" | "has" | "should" | "must"))
        })
    }

    /// After "and": another object, another action with the same verb ("and the spoon in the mug"), or the end.
    pub(super) fn after_conjunction(&mut self, action: &mut Action) -> bool {
        let next = self.at + 1;
        let conjunction = self.word(0);
        if conjunction != Some("and") && conjunction != Some("or") {
            return false;
        }
        if verbs().at(self.tokens, next).is_some_and(|(_, length)| self.phrase_or_end(next + length))
            || verbs().opener_at(self.tokens, next).is_some()
            || self.is_statement(next)
        {
            return false;
        }
        if action.objects.is_empty() {
            self.at = next;
            return true;
        }
        if self.is_directed(next) || self.is_source(next) {
            self.at = next;
            return true;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, next) else { return false };
        if phrase.negated {
            return false;
        }
        self.parsed.account.used(self.at..next);
        if action.paths.is_empty() && action.sources.is_empty() {
            self.at = next;
            return true;
        }
        // "put the mug on the plate and the spoon in the bowl".
        let own_path = preposition_at(self.tokens, end).is_some()
            || self.is_directed(end)
            || place_at(self.tokens, end, &Self::is_table_word).is_some();
        if action.frame == Frame::Swap {
            self.at = next;
            return true;
        }
        if own_path {
            let (frame, verb) = (action.frame, action.verb.clone());
            let finished = std::mem::replace(action, self.new_action(frame, verb));
            self.conclude(finished);
            self.at = next;
            return true;
        }
        // "between the plate and the mug" is read with its preposition; otherwise another target.
        if let Some(path) = action.paths.last() {
            let path = path.clone();
            self.at = end;
            if let Referent::Mentions(more) = self.refer(phrase, true) {
                action.paths.push(Path { targets: more, ..path });
            }
            return true;
        }
        false
    }

    pub(super) fn phrase_or_end(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some()
            || self.word_at(at).is_none()
            || matches!(
                self.word_at(at),
                Some("it" | "them" | "up" | "down" | "the" | "all" | "back" | "over")
            )
            || preposition_at(self.tokens, at).is_some()
    }

    /// Adverbs and words without an effect stay open; the account reports those that are not ignorable.
    pub(super) fn filler(&mut self) -> bool {
        let Some(word) = self.word(0) else { return false };
        let known = self.lexicon.vocabulary.grammar.ignorable.contains(word) || word.ends_with("ly");
        let ends = matches!(word, "is" | "are" | "has" | "there" | "should" | "must");
        if !known || ends {
            return false;
        }
        self.at += 1;
        true
    }
}
