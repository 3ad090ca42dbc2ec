//! Parts of objects in instructions: the lid, door or button of an object stands for the object, and "it" in "close
//! it" for what has a lid or door.

use super::Parser;
use super::action::Action;
use super::goals::{GoalDraft, GoalKind};
use super::states::category_shows;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Head, NounPhrase, noun_phrase};
use crate::text_parser::prepositions::preposition_at;
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::Frame;
use scene::text_account::PredicateKind;

/// Whether the noun is a part that moves with its object or that is pressed.
fn is_part(word: &str) -> bool {
    matches!(
        word,
        "door"
            | "lid"
            | "drawer"
            | "button"
            | "handle"
            | "cap"
            | "switch"
            | "lever"
            | "cover"
            | "doors"
            | "drawers"
            | "knobs"
            | "knob"
            | "burner"
            | "burners"
            | "dispenser"
            | "spout"
    )
}

impl Parser<'_, '_> {
    pub(super) fn can_open(&self, mention: usize) -> bool {
        match self.parsed.mentions[mention].meanings.first() {
            Some(Meaning::Category(index)) => {
                let category = &self.lexicon.categories[*index];
                category_shows(category, "open") || category_shows(category, "closed")
            }
            _ => false,
        }
    }

    /// The object of "open it" and "close it": the one that has been opened, that something was put into, or the last
    /// one that can be open.
    pub(super) fn openable(&self) -> Option<usize> {
        let is_opened = |goal: &&GoalDraft| {
            matches!(goal.kind, GoalKind::Predicate(PredicateKind::Opened | PredicateKind::Closed))
        };
        let goals = self.parsed.goals.iter().rev();
        let opened = goals.clone().find(is_opened).map(|goal| goal.object);
        let filled = goals.filter_map(|goal| goal.target).find(|target| self.can_open(*target));
        let last = (0..self.parsed.mentions.len()).rev().find(|m| self.can_open(*m));
        opened.or(filled).or(self.salient.filter(|it| self.can_open(*it))).or(last)
    }

    /// The object of a phrase: a part stands for its whole, and the words that tell drawers apart for nothing.
    pub(super) fn object_at(&self, at: usize, frame: Frame) -> Option<(NounPhrase, usize)> {
        let at = at + usize::from(self.word_at(at) == Some("either"));
        let (mut phrase, end) = self
            .whole_of_part(at, frame)
            .or_else(|| noun_phrase(self.lexicon, self.tokens, at))
            .or_else(|| self.bare_color(at))
            .or_else(|| self.bare_one(at))?;
        let is_drawer = self.tokens[phrase.head_tokens.clone()]
            .iter()
            .filter_map(Token::word)
            .any(|word| matches!(word, "drawer" | "drawers" | "shelf" | "door"));
        if is_drawer {
            let is_level = |token: usize| {
                matches!(self.word_at(token), Some("top" | "bottom" | "middle" | "upper" | "lower"))
            };
            phrase.reports.retain(|(tokens, _)| !tokens.clone().all(is_level));
        }
        Some((phrase, end))
    }

    /// Whether the object is a button of an appliance: "the power button of the blender", "the toaster switch".
    pub(super) fn names_button(&self, frame: Frame) -> bool {
        let presses = matches!(
            frame,
            Frame::Push
                | Frame::Use
                | Frame::Flip
                | Frame::Other
                | Frame::Lift
                | Frame::Place
                | Frame::Topple
        );
        let mut words = self.at..self.at + 6;
        let button = words.find(|&at| matches!(self.word_at(at), Some("button" | "switch")));
        let Some(button) = button.filter(|_| presses) else { return false };
        if (self.at..button).any(|at| self.word_at(at).is_none() || preposition_at(self.tokens, at).is_some())
        {
            return false;
        }
        let of = matches!(self.word_at(button + 1), Some("on" | "of" | "at"))
            && noun_phrase(self.lexicon, self.tokens, button + 2)
                .is_some_and(|(phrase, _)| matches!(phrase.head, Head::Objects(_)) && !phrase.is_table());
        let compound = (self.at..button).any(|first| self.noun_ends_at(first, button).is_some());
        of || compound
    }

    /// "push its start button", "press the power button": that of the last object. Whether the rule applies.
    pub(super) fn own_button(&mut self, action: &mut Action) -> bool {
        let presses =
            matches!(action.frame, Frame::Push | Frame::Use | Frame::Flip | Frame::Press | Frame::Other);
        let its = self.word(0) == Some("its");
        let kind = 1 + usize::from(matches!(
            self.word(1),
            Some("power" | "start" | "stop" | "on" | "off" | "reset" | "main" | "brew")
        ));
        let button = matches!(self.word(kind), Some("button" | "switch"));
        let owned = its || kind == 2 && self.word(0) == Some("the");
        if !presses || !button || !owned || preposition_at(self.tokens, self.at + kind + 1).is_some() {
            return false;
        }
        let is_switched = |m: &usize| super::openings::is_switched(&self.parsed.mentions[*m].words);
        let known = (0..self.parsed.mentions.len()).rev().find(is_switched);
        let Some(whole) = self.salient.filter(is_switched).or(known).or(self.salient) else { return false };
        self.parsed.account.used(self.at..self.at + kind + 1);
        self.at += kind + 1;
        action.frame = Frame::Press;
        action.objects.push(super::action::Part { mention: whole, take: None });
        true
    }

    /// "the lid of the toolbox", "the microwave door": the object with that part, and the position after it.
    fn whole_of_part(&self, at: usize, frame: Frame) -> Option<(NounPhrase, usize)> {
        let mut p = at;
        while matches!(
            self.word_at(p),
            Some(
                "the"
                    | "its"
                    | "top"
                    | "bottom"
                    | "upper"
                    | "lower"
                    | "middle"
                    | "left"
                    | "right"
                    | "front"
                    | "back"
                    | "rear"
                    | "center"
            )
        ) {
            p += 1;
        }
        if self.word_at(p).is_some_and(is_part) && self.word_at(p + 1) == Some("of") {
            let (mut phrase, end) = noun_phrase(self.lexicon, self.tokens, p + 2)?;
            phrase.tokens.start = at;
            return matches!(phrase.head, Head::Objects(_)).then_some((phrase, end));
        }
        // "the red button on the coffee machine".
        if matches!(frame, Frame::Press | Frame::Push) {
            let part = (p..p + 4).find(|&p| {
                matches!(self.word_at(p), Some("button" | "switch" | "knob" | "lever" | "key"))
                    && matches!(self.word_at(p + 1), Some("on" | "of" | "at"))
            });
            // "the button on the left side of the blender".
            let whole = |part: usize| {
                let sides = ["left", "right", "front", "back", "top", "bottom", "rear", "other"];
                let the = part + 2 + usize::from(self.word_at(part + 2) == Some("the"));
                let side = the + usize::from(self.word_at(the).is_some_and(|word| sides.contains(&word)));
                let end = side + usize::from(matches!(self.word_at(side), Some("side" | "panel" | "end")));
                let of = end > the && self.word_at(end) == Some("of");
                if of { end + 1 } else { part + 2 }
            };
            if let Some((mut phrase, end)) =
                part.and_then(|part| noun_phrase(self.lexicon, self.tokens, whole(part)))
                && matches!(phrase.head, Head::Objects(_))
                && !phrase.is_table()
            {
                phrase.tokens.start = at;
                return Some((phrase, end));
            }
        }
        let (mut phrase, end) = noun_phrase(self.lexicon, self.tokens, at)?;
        let moves_part = matches!(frame, Frame::Open | Frame::Close | Frame::Press);
        let last = phrase.head_tokens.end.checked_sub(1)?;
        if !self.word_at(last).is_some_and(is_part) {
            return None;
        }
        let first = match &phrase.head {
            Head::Unknown(_) => phrase.head_tokens.start,
            // "the laptop lid" is a lid, but what is closed is the laptop.
            Head::Objects(_) if moves_part => (at..last).find(|p| self.noun_ends_at(*p, last).is_some())?,
            _ => return None,
        };
        let meanings = self.noun_ends_at(first, last)?;
        phrase.head = Head::Objects(meanings);
        phrase.stand_in = None;
        phrase.words = self.tokens[first..last].iter().filter_map(Token::word).collect::<Vec<_>>().join(" ");
        phrase.head_tokens = first..last + 1;
        Some((phrase, end))
    }

    /// The meanings of the tokens from `first` to `end` as a noun.
    fn noun_ends_at(&self, first: usize, end: usize) -> Option<Vec<Meaning>> {
        let words: Vec<&str> = self.tokens[first..end].iter().filter_map(Token::word).collect();
        let entry = self.lexicon.get(&words.join(" "))?;
        matches!(entry.meanings.first(), Some(Meaning::Category(_))).then(|| entry.meanings.clone())
    }
}
