//! The parts of an instruction: objects, sources, destinations and tools.

use std::ops::Range;

use super::{Parser, Referent};
use crate::text_parser::phrase::{Determiner, noun_phrase};
use crate::text_parser::phrases::phrases;
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

/// Arrangement of the objects at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Formation {
    Stack,
    Together,
    /// Each object in this relation to the next.
    Ordered(RelationKind),
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
    /// A substance without an object that is moved ("pour the water").
    pub substance: Option<Range<usize>>,
    /// Whether the text names an object that is not known.
    pub unknown: bool,
    /// Whether the next path belongs to a relative clause ("that is next to the kettle").
    pub relative: bool,
    /// Particles after the object.
    pub particles: Vec<Range<usize>>,
    /// "on top of each other", "from left to right".
    pub formation: Option<Formation>,
    /// Whether the objects are for a person ("bring me the mug").
    pub for_person: bool,
    /// Whether a clause or a list after the instruction states its outcome.
    pub is_continued: bool,
    /// Whether the object is "everything".
    pub everything: bool,
    /// Whether the object is a pronoun, which no path describes.
    pub by_pronoun: bool,
}

impl Parser<'_, '_> {
    /// Reads an instruction whose verb is at `at`, and states its goal.
    pub(super) fn act(&mut self, frame: Frame, at: usize, length: usize, subjects: Vec<usize>) {
        let subjects = if length <= 2 || frame == Frame::Use { subjects } else { Vec::new() };
        self.act_on(frame, at..at + length, at + length, subjects);
    }

    /// Reads the parts of an instruction from `at` on, and states its goal.
    pub(super) fn act_on(&mut self, frame: Frame, verb: Range<usize>, at: usize, subjects: Vec<usize>) {
        self.at = at;
        self.before_action = self.salient;
        let mut action = self.new_action(frame, verb);
        if matches!(frame, Frame::Use | Frame::Pour) {
            action.tools = subjects;
        } else if !subjects.is_empty() && !self.object_follows() {
            action.objects = subjects.into_iter().map(|mention| Part { mention, take: None }).collect();
        }
        self.parts(&mut action);
        if self.listed(&mut action) {
            return;
        }
        let result = self.result_ahead(&action);
        action.is_continued = result.is_some();
        self.conclude(action);
        if let Some((subjects, state)) = result {
            self.parsed.account.used(self.at..state.at);
            self.act_on(state.frame, state.link, state.at, subjects);
        }
    }

    /// Reads parts until the instruction ends.
    pub(super) fn parts(&mut self, action: &mut Action) {
        while self.at < self.tokens.len() {
            let before = self.at;
            if !self.part(action) {
                break;
            }
            self.at = self.at.max(before + 1);
        }
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
            substance: None,
            unknown: false,
            relative: false,
            particles: Vec::new(),
            formation: None,
            for_person: false,
            is_continued: false,
            everything: false,
            by_pronoun: false,
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
            _ if self.step_number(self.at).is_some() => return false,
            Token::Number(_) | Token::Word(_) => {}
        }
        if matches!(
            self.word(0),
            Some("and" | "then" | "or" | "but" | "while" | "before" | "after" | "so" | "without")
        ) {
            return self.after_conjunction(action);
        }
        // "put the carrot in the bowl" with a knife beside it.
        if self.word(0) == Some("with") && !action.paths.is_empty() {
            return self.tool(action);
        }
        if self.result_opener().is_some() || self.purpose_begins() || self.conjunction_at(self.at).is_some() {
            return false;
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
        self.aimless_end()
            || self.other_arm(action)
            || self.turn(action)
            || self.formation(action)
            || self.exchanged_place(action)
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

    /// "use the sponge to wipe the plate", "pull the handle to open the drawer".
    fn purpose_begins(&self) -> bool {
        let verb = verbs().at(self.tokens, self.at + 1).map_or(0, |(_, length)| length);
        let builds = matches!(self.word(1), Some("build" | "make" | "form" | "construct" | "create"));
        self.word(0) == Some("to") && (verb > 0 && self.phrase_follows(self.at + 1 + verb) || builds)
    }

    /// After a comma: the list of objects continues, or another prepositional phrase.
    pub(super) fn after_pause(&mut self, action: &mut Action) -> bool {
        let next = self.at + 1;
        if matches!(self.word_at(next), Some("and" | "then")) {
            self.at = next;
            return self.after_conjunction(action);
        }
        if self.is_colon(self.at) {
            return self.colon_target(action);
        }
        if self.stated_number(action) {
            return true;
        }
        if self.is_arrow(self.at) {
            return self.verb_begins(next).is_none() && self.pointed_target(action);
        }
        // "put the can, which is in the bowl, on the plate".
        let relates = matches!(self.word_at(next), Some("which" | "that"))
            && matches!(self.word_at(next + 1), Some("is" | "are" | "lies" | "stands"))
            && !action.objects.is_empty();
        let resumes = action.frame == Frame::Place
            && action.paths.is_empty()
            && !action.objects.is_empty()
            && self.path_follows(next);
        if relates || resumes {
            self.at = next;
            return true;
        }
        let is_verb = self.verb_begins(next).is_some() || verbs().opener_at(self.tokens, next).is_some();
        let list = action.paths.is_empty() && action.sources.is_empty() && !action.objects.is_empty();
        let phrase = noun_phrase(self.lexicon, self.tokens, next);
        // "put the apple in the bowl, the plate on the tray".
        if let Some((phrase, end)) = &phrase
            && !is_verb
            && !action.objects.is_empty()
            && !action.paths.is_empty()
            && (phrase.determiner == Determiner::Definite || phrase.count.is_none())
            && !phrase.negated
            && self.path_follows(*end)
        {
            self.finish(action);
            self.at = next;
            return true;
        }
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

    /// Concludes an action; the next one has the same verb.
    fn finish(&mut self, action: &mut Action) {
        let (frame, verb) = (action.frame, action.verb.clone());
        let finished = std::mem::replace(action, self.new_action(frame, verb));
        self.before_action = finished.objects.last().map(|part| part.mention).or(self.before_action);
        self.conclude(finished);
    }

    /// Whether a destination begins at `at`.
    pub(super) fn path_follows(&self, at: usize) -> bool {
        preposition_at(self.tokens, at).is_some()
            || self.is_directed(at)
            || place_at(self.tokens, at, &Self::is_table_word).is_some()
    }

    /// Whether a subject with a verb begins ("the mug is red").
    pub(super) fn is_statement(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(_, end)| {
            let falls = self.word_at(end).is_some_and(|word| phrases().list.falls.has(word));
            falls && self.is_directed(end + 1)
                || matches!(
                    self.word_at(end),
                    Some(
                        "is" | "are"
                            | "has"
                            | "should"
                            | "must"
                            | "goes"
                            | "go"
                            | "belongs"
                            | "belong"
                            | "needs"
                            | "need"
                            | "stays"
                            | "stay"
                            | "remains"
                            | "remain"
                    )
                )
        })
    }

    /// After "and": another object, another action with the same verb ("and the spoon in the mug"), or the end.
    pub(super) fn after_conjunction(&mut self, action: &mut Action) -> bool {
        if let Some(next) = self.next_step_of_same_verb(action) {
            self.parsed.account.used(self.at..next);
            self.finish(action);
            self.at = next;
            return true;
        }
        let next = self.at + 1;
        let conjunction = self.word(0);
        if conjunction != Some("and") && conjunction != Some("or") {
            return false;
        }
        let tells = self.is_narrated && self.past_at(next).is_some();
        if tells
            || self.verb_begins(next).is_some_and(|length| self.phrase_or_end(next + length))
            || verbs().opener_at(self.tokens, next).is_some()
            || self.agent_opener(next).is_some()
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
        if action.frame == Frame::Swap {
            self.at = next;
            return true;
        }
        if self.path_follows(end) {
            self.finish(action);
            self.at = next;
            return true;
        }
        // "in the pot or pan": one of them is enough.
        if conjunction == Some("or") {
            self.parsed.account.used(phrase.tokens);
            self.at = end;
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

    /// Position at which a further step begins that leaves out its verb: "put the apple in the bowl, then the spoon
    /// next to it".
    fn next_step_of_same_verb(&self, action: &Action) -> Option<usize> {
        const THEN: [&str; 5] = ["then", "afterwards", "next", "finally", "lastly"];
        let then = self.at + usize::from(self.word(0) == Some("and"));
        let next = then + 1;
        let continues = self.word_at(then).is_some_and(|word| THEN.contains(&word))
            && !action.objects.is_empty()
            && !(action.paths.is_empty() && action.sources.is_empty())
            && verbs().opener_at(self.tokens, next).is_none()
            && self.verb_begins(next).is_none()
            && !self.is_statement(next);
        let (phrase, end) = noun_phrase(self.lexicon, self.tokens, next).filter(|_| continues)?;
        (!phrase.negated && self.path_follows(end)).then_some(next)
    }

    /// The number of words of a verb at `at` that is no noun ("and water bottle", "and brush in the jar").
    fn verb_begins(&self, at: usize) -> Option<usize> {
        let (_, length) = verbs().at(self.tokens, at)?;
        let noun = self.lexicon.longest_at(self.tokens, at).map_or(0, |(_, noun)| noun);
        let has_object = matches!(
            self.word_at(at + length),
            Some("the" | "a" | "an" | "it" | "them" | "this" | "that" | "both" | "all" | "each" | "one")
        );
        (noun < length || noun == length && has_object).then_some(length)
    }

    pub(super) fn phrase_or_end(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some()
            || self.word_at(at).is_none()
            || matches!(
                self.word_at(at),
                Some("it" | "them" | "up" | "down" | "the" | "all" | "back" | "over")
            )
            || verbs().is_base(self.word_at(at.saturating_sub(1)).unwrap_or_default())
                && matches!(self.word_at(at), Some("again" | "afterwards"))
            || preposition_at(self.tokens, at).is_some()
    }
}
