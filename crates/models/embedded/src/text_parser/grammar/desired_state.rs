//! Goals that a text states as an end state: "the goal is to have the lemon in the jar", "make sure that the spoon ends
//! up in the bowl", "I want the apple in the bowl", "the mug must end up on the plate", "so that it stands".

use std::ops::Range;

use super::action::Action;
use super::{Parser, Referent};
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::tokens::{Token, match_phrase};
use crate::text_parser::verbs::{Frame, verbs};

/// An end state: the words between it and its subject, and where it begins.
#[derive(Clone, Debug)]
pub(super) struct EndState {
    pub frame: Frame,
    pub link: Range<usize>,
    pub at: usize,
}

impl Parser<'_, '_> {
    pub(super) fn longest(&self, phrases: &[&str], at: usize) -> usize {
        phrases.iter().filter_map(|phrase| match_phrase(self.tokens, at, phrase)).max().unwrap_or(0)
    }

    /// Number of words of "should", "has to" at `at`.
    pub(super) fn modal_length(&self, at: usize) -> usize {
        phrases().end_state.modals.length_at(self.tokens, at)
    }

    /// Number of words that link a subject and its end state: "has to be", "goes".
    pub(super) fn link_length(&self, at: usize) -> usize {
        let modal = phrases().end_state.modals.length_at(self.tokens, at);
        let copula = phrases().end_state.copulas.length_at(self.tokens, at + modal);
        // "to the left": no modal.
        if copula == 0 {
            return 0;
        }
        modal + copula + phrases().end_state.adverbs.length_at(self.tokens, at + modal + copula)
    }

    /// The end state of a subject before `at`.
    fn end_state(&self, at: usize) -> Option<EndState> {
        if let Some(state) = self.needed(at) {
            return Some(state);
        }
        let p = at + self.link_length(at);
        let link = at..p;
        let linked = p > at;
        let stands = (at..p).any(|p| matches!(self.word_at(p), Some("stand" | "stands")));
        let ends = self.word_at(p).is_none() || matches!(self.word_at(p), Some("up" | "and" | "again"));
        if stands && ends {
            let up = usize::from(self.word_at(p) == Some("up"));
            return Some(EndState { frame: Frame::Upright, link, at: p + up });
        }
        let poses = |state: &str| super::states::pose_of(state).is_some();
        if self.state_at(p).is_some_and(|(state, _)| poses(&state)) {
            return Some(EndState { frame: Frame::Place, link, at: p });
        }
        let participle = self
            .word_at(p)
            .filter(|word| *word != "left" || !self.path_follows(p))
            .and_then(|word| verbs().participle(word));
        if let Some(frame) = participle {
            let particle = usize::from(
                matches!(self.word_at(p), Some("picked" | "lifted" | "turned" | "left"))
                    && matches!(self.word_at(p + 1), Some("up" | "on" | "off" | "over")),
            );
            let turns_on = particle == 1 && matches!(self.word_at(p + 1), Some("on" | "off"));
            let turns_over = particle == 1 && self.word_at(p + 1) == Some("over");
            let frame = match frame {
                Frame::Rotate if turns_on => Frame::Press,
                Frame::Rotate if turns_over => Frame::Flip,
                frame => frame,
            };
            let is_adjective = matches!(frame, Frame::Open | Frame::Close);
            let begins = linked || is_adjective || frame == Frame::Place;
            let leads = frame != Frame::Place || self.path_follows(p + 1 + particle);
            return (begins && leads).then_some(EndState { frame, link: at..p + 1, at: p + 1 + particle });
        }
        let reaches = self.contact_at(p) || self.path_follows(p) || self.is_measured(p);
        reaches.then_some(EndState { frame: Frame::Place, link, at: p })
    }

    /// "needs stacking on the plate" at `at`.
    fn needed(&self, at: usize) -> Option<EndState> {
        let needs = self.word_at(at).is_some_and(|word| phrases().agent.needs.has(word));
        let gerund = self.word_at(at + 1).is_some_and(|word| word.ends_with("ing"));
        let (frame, length) = verbs().at(self.tokens, at + 1).filter(|_| needs && gerund)?;
        let end = at + 1 + length;
        let leads = !matches!(frame, Frame::Place | Frame::Stack | Frame::Push) || self.path_follows(end);
        (leads && frame != Frame::Other).then_some(EndState { frame, link: at..end, at: end })
    }

    /// An end state at `at` that is to come: "is to be placed", "goes", "needs stacking".
    pub(super) fn obliged_state(&self, at: usize) -> Option<EndState> {
        let begins = phrases().end_state.modals.length_at(self.tokens, at) > 0
            || self.word_at(at).is_some_and(is_change)
            || self.needed(at).is_some();
        self.end_state(at).filter(|_| begins && self.word_at(at) != Some("to"))
    }

    fn is_measured(&self, at: usize) -> bool {
        read_length(self.lexicon.vocabulary, self.tokens, at)
            .is_some_and(|(_, length)| self.path_follows(at + length))
    }

    /// "touches" as a relation.
    pub(super) fn contact_at(&self, at: usize) -> bool {
        matches!(self.word_at(at), Some("touches" | "touch" | "reaches" | "meets" | "contacts"))
    }

    /// The subjects of a statement at `at`, and the position after them.
    fn subjects_at(&self, at: usize, only_definite: bool) -> Option<(Vec<NounPhrase>, usize)> {
        let mut phrases = Vec::new();
        let mut p = at;
        loop {
            let (phrase, end) = noun_phrase(self.lexicon, self.tokens, p)?;
            let is_definite = phrase.determiner != Determiner::New
                || matches!(phrase.head, Head::Them | Head::All | Head::It);
            if phrase.negated || phrase.is_table() || (only_definite && !is_definite) || phrases.len() > 8 {
                return None;
            }
            phrases.push(phrase);
            let joint = usize::from(matches!(self.tokens.get(end), Some(Token::Pause)));
            let and = usize::from(self.word_at(end + joint) == Some("and"));
            if and == 0 && joint == 0 || self.end_state(end).is_some() {
                return Some((phrases, end));
            }
            p = end + joint + and;
        }
    }

    fn refer_subjects(&mut self, phrases: Vec<NounPhrase>) -> Vec<usize> {
        let mut subjects = Vec::new();
        for mut phrase in phrases {
            self.bare_is_definite(&mut phrase);
            let at = phrase.tokens.end;
            if let Referent::Mentions(list) = self.refer(phrase, false) {
                subjects.extend(list);
            }
            self.at = at;
        }
        subjects.dedup();
        self.salient = subjects.last().copied().or(self.salient);
        self.salient_list.clone_from(&subjects);
        subjects
    }

    /// States an end state as the goal; the words from `start` on ask for it.
    fn conclude_state(&mut self, start: usize, state: EndState, subjects: Vec<usize>) {
        self.parsed.account.used(start..state.at);
        self.instructed = true;
        self.clause_start = false;
        let verb = if state.link.is_empty() { start..state.at } else { state.link };
        self.act_on(state.frame, verb, state.at, subjects.clone());
        while let Some(state) = self.next_participle() {
            self.parsed.account.used(self.at..state.at);
            // "carried over and laid in the bowl".
            if state.frame == Frame::Place && !self.path_follows(state.at) {
                self.at = state.at;
                continue;
            }
            self.act_on(state.frame, state.link, state.at, subjects.clone());
        }
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
    }

    /// "and placed" after "should be picked up": another step of the same subjects.
    fn next_participle(&self) -> Option<EndState> {
        let mut p = self.at;
        p += usize::from(matches!(self.tokens.get(p), Some(Token::Pause)));
        p += usize::from(self.word_at(p) == Some("and"));
        p += usize::from(matches!(self.word_at(p), Some("then" | "afterwards" | "finally" | "subsequently")));
        p += usize::from(p > self.at && matches!(self.word_at(p), Some("be" | "is" | "are")));
        let frame = self.word_at(p).filter(|_| p > self.at).and_then(|word| verbs().participle(word))?;
        let particle = matches!(self.word_at(p + 1), Some("up" | "over" | "down" | "out" | "away" | "back"));
        let next = p + 2;
        let ends = self.word_at(next).is_none_or(|word| word == "and") || self.path_follows(next);
        let at = p + 1 + usize::from(particle && ends);
        Some(EndState { frame, link: p..at, at })
    }

    /// "is grasped and then placed on the plate": what happens, not a state.
    fn is_taken_elsewhere(&self, at: usize) -> bool {
        let is = matches!(self.word_at(at), Some("is" | "are" | "gets" | "get"));
        let taken = self.word_at(at + 1).and_then(|word| verbs().participle(word));
        let mut rest = (at + 2..at + 7).map_while(|p| self.word_at(p)).skip_while(|word| *word != "and");
        is && matches!(taken, Some(Frame::Lift | Frame::Take))
            && rest.any(|word| verbs().participle(word) == Some(Frame::Place))
    }

    /// A statement of the end state at `p`, after words from `start` on that ask for an action.
    pub(super) fn states_goal(&mut self, start: usize, p: usize) -> bool {
        let names_goal = (start..p)
            .any(|token| matches!(self.word_at(token), Some("goal" | "task" | "objective" | "aim")))
            || self.goal_heading(start).is_some_and(|length| start + length <= p);
        let has = names_goal && matches!(self.word_at(p), Some("have" | "get")) && self.noun_at(p + 1);
        let described = !names_goal && !self.instructed && !self.parsed.mentions.is_empty();
        let Some((phrases, end)) = self.subjects_at(p + usize::from(has), !names_goal) else { return false };
        let Some(state) = self.end_state(end) else { return false };
        let says_so = !state.link.is_empty() || has || names_goal;
        let changes = state.link.clone().any(|at| self.word_at(at).is_some_and(is_change))
            || state.link.clone().any(|at| self.word_at(at).is_some_and(|w| verbs().participle(w).is_some()));
        // "A desk with a lamp. Make sure that the lamp is at the back" describes the scene.
        if !says_so || described && !changes && !self.goal_words() {
            return false;
        }
        let subjects = self.refer_subjects(phrases);
        if subjects.is_empty() {
            return false;
        }
        self.conclude_state(start, state, subjects);
        while names_goal && self.another_state() {}
        true
    }

    /// The next of several end states: "Goal: the apple is on the plate and the pear is in the bowl".
    fn another_state(&mut self) -> bool {
        let joint = usize::from(matches!(self.tokens.get(self.at), Some(Token::Pause)));
        let next = self.at + joint + usize::from(self.word(joint) == Some("and"));
        if next == self.at || verbs().at(self.tokens, next).is_some() {
            return false;
        }
        let Some((phrases, end)) = self.subjects_at(next, false) else { return false };
        let Some(state) = self.end_state(end) else { return false };
        let subjects = self.refer_subjects(phrases);
        if subjects.is_empty() {
            return false;
        }
        self.conclude_state(next, state, subjects);
        true
    }

    /// The subjects between `at` and `end`.
    fn subjects_until(&self, at: usize, end: usize) -> Option<Vec<NounPhrase>> {
        let (mut phrases, mut p) = (Vec::new(), at);
        while phrases.len() < 4 {
            let (phrase, after) = noun_phrase(self.lexicon, &self.tokens[..end], p)?;
            let is_definite = phrase.determiner != Determiner::New || phrase.head == Head::It;
            if phrase.negated || phrase.is_table() || !is_definite {
                return None;
            }
            phrases.push(phrase);
            if after == end {
                return Some(phrases);
            }
            p = after + 1;
            if self.word_at(after) != Some("and") {
                return None;
            }
        }
        None
    }

    /// "make the bottle lie on its side", "have the cup and the bowl switch places": the subjects, and the position of
    /// the verb, which may also be a noun.
    fn caused(&self, at: usize) -> Option<(Vec<NounPhrase>, usize)> {
        let is_verb = |word: &str| {
            verbs().is_base(word)
                || matches!(word, "be" | "lie" | "sit" | "stand" | "rest" | "end" | "land" | "face")
        };
        (at + 1..at + 10)
            .take_while(|&v| matches!(self.tokens.get(v), Some(Token::Word(_))))
            .filter(|&v| self.word_at(v).is_some_and(is_verb))
            .filter(|&v| !matches!(self.tokens.get(v + 1), None | Some(Token::Pause | Token::End)))
            .find_map(|v| Some((self.subjects_until(at, v)?, v)))
    }

    fn noun_at(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(phrase, _)| !phrase.negated)
    }

    /// "I want the apple in the bowl", "we need the ketchup to be in the basket". Whether the rule applies.
    pub(super) fn desire(&mut self, start: usize, p: usize) -> bool {
        // "I want to see the pear in the bowl": its beginning is also that of other requests.
        let longer =
            verbs().desire_at(self.tokens, start).map(|length| start + length).filter(|end| *end > p);
        let desire = verbs().desire_at(self.tokens, p).map(|length| p + length);
        let Some(object) = desire.or(longer) else { return false };
        let Some((phrases, end)) = self.subjects_at(object, true) else { return false };
        let Some(state) = self.end_state(end) else { return false };
        let described = !self.instructed && !self.parsed.mentions.is_empty();
        let is_support =
            matches!(self.word_at(state.at), Some("in" | "on" | "inside" | "into" | "onto" | "atop"))
                && noun_phrase(self.lexicon, self.tokens, state.at + 1)
                    .is_some_and(|(phrase, _)| !phrase.is_table());
        if described && !is_support && !self.goal_words() {
            return false;
        }
        let subjects = self.refer_subjects(phrases);
        if subjects.is_empty() {
            return false;
        }
        self.conclude_state(start, state, subjects);
        true
    }

    /// "make the fork and the knife trade places", "have the mug stand upright". Whether the rule applies.
    pub(super) fn causative(&mut self, start: usize, p: usize) -> bool {
        if !matches!(self.word_at(p), Some("make" | "have" | "let" | "get")) {
            return false;
        }
        if let Some((phrases, v)) = self.caused(p + 1)
            && matches!(self.word_at(v), Some("be" | "lie" | "sit" | "stand" | "rest" | "end" | "land"))
            && let Some(state) = self.end_state(v)
        {
            let subjects = self.refer_subjects(phrases);
            if !subjects.is_empty() {
                self.conclude_state(start, state, subjects);
                return true;
            }
        }
        let Some((phrases, end)) = self.caused(p + 1).or_else(|| self.subjects_at(p + 1, true)) else {
            return false;
        };
        let at = end + usize::from(self.word_at(end) == Some("to"));
        let base = self.word_at(at).is_some_and(|word| verbs().is_base(word));
        let Some((frame, length)) = verbs().at(self.tokens, at).filter(|_| base) else { return false };
        if frame == Frame::Other {
            return false;
        }
        let subjects = self.refer_subjects(phrases);
        if subjects.is_empty() {
            return false;
        }
        self.parsed.account.used(start..at);
        self.instructed = true;
        self.clause_start = false;
        self.act_on(frame, at..at + length, at + length, subjects);
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// "the apple should be in the bowl at the end", "the mug must end up on the plate": a goal about the last subject.
    pub(super) fn required_state(&mut self) -> bool {
        let start = self.at;
        let begins = phrases().end_state.modals.length_at(self.tokens, start) > 0
            || matches!(self.word(0), Some("gets" | "goes" | "go" | "belongs" | "belong" | "ends"))
            || matches!(self.word(0), Some("is" | "are")) && self.word(1) == Some("being")
            || self.is_taken_elsewhere(start)
            || self.needed(start).is_some();
        if self.subject.is_empty() || !begins || self.word(0) == Some("to") {
            return false;
        }
        let Some(state) = self.end_state(start) else { return false };
        let mut words = state.link.clone().filter_map(|at| self.word_at(at));
        let changes = words.clone().any(is_change);
        let passive = words.clone().next_back().is_some_and(|word| verbs().participle(word).is_some());
        // "The mug has to be on the plate" as the whole text.
        let obliges = words.any(|word| matches!(word, "must" | "has" | "have" | "needs" | "need" | "ought"))
            && self.parsed.mentions.len() == self.subject.len()
            && self.word_at(0) == Some("the");
        let needed = self.needed(start).is_some();
        if !(changes || passive || obliges || needed || self.instructed || self.goal_words()) {
            return false;
        }
        let subjects = self.subject.clone();
        self.salient = subjects.last().copied();
        self.conclude_state(start, state, subjects);
        true
    }

    /// "so that it stands", "until it touches the plate" at the current position: the position of its subject, and its
    /// end state.
    pub(super) fn result_opener(&self) -> Option<(usize, EndState)> {
        let at = self.at + phrases().end_state.results.longest_at(self.tokens, self.at)?;
        let end = match self.word_at(at) {
            Some("it" | "they" | "them" | "both") => at + 1,
            _ => noun_phrase(self.lexicon, self.tokens, at)
                .filter(|(phrase, _)| phrase.determiner == Determiner::Definite && !phrase.negated)
                .map(|(_, end)| end)?,
        };
        let state = self.end_state(end)?;
        let linked = !state.link.is_empty() || self.contact_at(state.at);
        linked.then_some((at, state))
    }

    /// The subjects and the end state of a clause after an instruction.
    pub(super) fn result_ahead(&mut self, action: &Action) -> Option<(Vec<usize>, EndState)> {
        let (at, state) = self.result_opener()?;
        let subjects = match self.word_at(at) {
            Some("it" | "they" | "them" | "both") => {
                let objects = Self::mentions(&action.objects);
                if objects.is_empty() { self.salient.into_iter().collect() } else { objects }
            }
            _ => {
                let (phrase, _) = noun_phrase(self.lexicon, self.tokens, at)?;
                let here = self.at;
                let subjects = self.refer_subjects(vec![phrase]);
                self.at = here;
                subjects
            }
        };
        (!subjects.is_empty()).then_some((subjects, state))
    }

    /// Whether the text speaks of a goal or of a robot.
    fn goal_words(&self) -> bool {
        self.tokens.iter().take(400).filter_map(Token::word).any(|word| {
            matches!(
                word,
                "goal"
                    | "task"
                    | "robot"
                    | "finally"
                    | "afterwards"
                    | "end"
                    | "finished"
                    | "done"
                    | "gripper"
            )
        })
    }
}

/// Whether the word names a state of an object ("closed").
pub(super) fn is_state_word(word: &str) -> bool {
    verbs().participle(word).is_some()
}

/// Whether the verb states that its subject moves or changes.
fn is_change(word: &str) -> bool {
    phrases().end_state.changes.has(word)
}
