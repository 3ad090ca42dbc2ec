//! Lists after the colon of an instruction: the members of what it names ("all the fruit: two apples and a pear"),
//! their order ("from left to right: red, green, blue") or a place for each ("set the table: plate in the center,
//! ...").

use super::action::{Action, Part};
use super::{Parser, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, color_of, noun_phrase};
use crate::text_parser::property::Property;
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::{Frame, verbs};

/// Maximum number of members of a list.
const MAX_MEMBERS: usize = 16;

/// Phrases for the place of the lowest object of a stack.
const LOWEST: &[&str] = &["at the bottom", "on the bottom", "at the base", "lowest", "at the very bottom"];

impl Parser<'_, '_> {
    pub(super) fn is_colon(&self, at: usize) -> bool {
        matches!(self.tokens.get(at), Some(Token::Pause))
            && self.source.spans.get(at).is_some_and(|span| &self.source.text[span.clone()] == ":")
    }

    /// Reads a list after the colon at the end of an instruction. Whether it replaces the instruction.
    pub(super) fn listed(&mut self, action: &mut Action) -> bool {
        let lists = matches!(
            action.frame,
            Frame::Place | Frame::Stack | Frame::Push | Frame::Separate | Frame::Other | Frame::Take
        );
        let leaves = action.everything && !action.sources.is_empty();
        let empties = matches!(self.word_at(action.verb.start), Some("unload" | "unpack")) || leaves;
        if !lists || empties || !self.is_colon(self.at) {
            return false;
        }
        let at = self.at + 1;
        let is_instruction =
            verbs().at(self.tokens, at).is_some_and(|(frame, length)| self.governs(at, length, frame, false));
        let Some((phrase, end)) = self.item_at(at) else { return false };
        if is_instruction || phrase.negated || phrase.is_table() {
            return false;
        }
        if self.item_has_place(end) {
            self.listed_places(action, at);
            return true;
        }
        self.listed_members(action, at);
        false
    }

    fn item_has_place(&self, end: usize) -> bool {
        let at = end + self.link_length(end);
        let side = matches!(self.word_at(at), Some("left" | "right"))
            && self.word_at(at + 1).is_none_or(|word| word == "and");
        side || self.path_follows(at) || self.longest(LOWEST, at) > 0
    }

    /// An item of a list: a noun phrase, or a color or size without a noun.
    fn item_at(&self, at: usize) -> Option<(NounPhrase, usize)> {
        let vocabulary = self.lexicon.vocabulary;
        let start = at + usize::from(matches!(self.word_at(at), Some("the" | "a")));
        let end = start + 1;
        let alone = matches!(self.word_at(end), None | Some("and")) || self.item_has_place(end);
        if let Some(word) = self.word_at(start).filter(|_| alone) {
            let mut phrase = NounPhrase::part([1, 1], at..end);
            if let Some(color) = color_of(vocabulary, word) {
                phrase.attributes.colors = vec![color];
                phrase.attributes.color_words = vec![word.to_owned()];
                phrase.properties.push((Property::Color, start..end));
                return Some((phrase, end));
            }
            if let Some(scale) = vocabulary.sizes.get(word) {
                phrase.attributes.scale = *scale;
                phrase.properties.push((Property::Size, start..end));
                return Some((phrase, end));
            }
        }
        noun_phrase(self.lexicon, self.tokens, at)
    }

    /// "red ones in the bowl, blue ones in the basket".
    fn listed_places(&mut self, action: &mut Action, at: usize) {
        let whole = match action.objects[..] {
            [one] if action.sources.is_empty() => Some(one.mention),
            _ => None,
        };
        let verb = action.verb.clone();
        if action.frame == Frame::Separate || !action.sources.is_empty() {
            let finished = std::mem::replace(action, self.new_action(Frame::Place, verb.clone()));
            self.conclude(finished);
        }
        self.parsed.account.used(verb.start..at);
        let mentions = self.parsed.mentions.len();
        let mut at = Some(at);
        while let Some((phrase, end)) = at.and_then(|at| self.item_at(at)) {
            let mut next = self.new_action(Frame::Place, verb.clone());
            self.before_action = self.salient;
            self.at = end;
            let mut phrase = phrase;
            self.bare_is_definite(&mut phrase);
            // "blue on green, green on red": the second green is the first.
            let color = &phrase.attributes.color_words;
            let listed = self.parsed.mentions[mentions..].iter().any(|m| m.attributes.color_words == *color);
            if phrase.head == Head::One && !color.is_empty() && listed {
                (phrase.determiner, phrase.count) = (Determiner::Definite, None);
            }
            let before = self.parsed.mentions.len();
            let is_open = phrase.count.is_none();
            if let Referent::Mentions(list) = self.refer(phrase, false) {
                self.expected.extend(list.iter().filter(|mention| is_open && **mention >= before));
                self.salient = list.last().copied().or(self.salient);
                next.objects = list.into_iter().map(|mention| Part { mention, take: None }).collect();
            }
            let link = self.link_length(end);
            self.parsed.account.used(end..end + link);
            self.at = end + link;
            // "stack these: the plate at the bottom, ...": the lowest stays where it is.
            let level = if self.verb_stacks(&verb) { self.longest(LOWEST, self.at) } else { 0 };
            self.parsed.account.used(self.at..self.at + level);
            self.at += level;
            if level == 0 {
                self.parts(&mut next);
                self.conclude(next);
            }
            let joint = usize::from(matches!(self.tokens.get(self.at), Some(Token::Pause)));
            let and = usize::from(self.word_at(self.at + joint) == Some("and"));
            at = Some(self.at + joint + and)
                .filter(|at| *at > self.at)
                .filter(|at| self.item_at(*at).is_some_and(|(_, end)| self.item_has_place(end)));
        }
        // The parts of the list are all that there is.
        let is_vague = |m: usize| matches!(self.parsed.mentions[m].meanings.first(), Some(Meaning::Vague(_)));
        if let Some(whole) = whole
            && self.parsed.mentions.len() > mentions
            && (is_vague(whole)
                || self.parsed.mentions[mentions..]
                    .iter()
                    .any(|part| part.meanings == self.parsed.mentions[whole].meanings))
            && self.parsed.goals.iter().all(|goal| goal.object != whole && goal.target != Some(whole))
        {
            self.drop_mention(whole);
        }
    }

    fn verb_stacks(&self, verb: &std::ops::Range<usize>) -> bool {
        matches!(self.word_at(verb.start), Some("stack" | "pile" | "build"))
    }

    /// "two apples, a pear and a banana", "red, green, blue": the objects of the instruction.
    fn listed_members(&mut self, action: &mut Action, at: usize) {
        let whole = match action.objects[..] {
            [] => None,
            [one] => Some(one.mention),
            _ => return,
        };
        let mut phrases: Vec<NounPhrase> = Vec::new();
        let mut p = at;
        while let Some((phrase, end)) = self.item_at(p) {
            if phrase.negated || phrases.len() == MAX_MEMBERS {
                return;
            }
            phrases.push(phrase);
            p = end;
            if matches!(self.tokens.get(p), Some(Token::Pause)) {
                p += 1;
            }
            p += usize::from(self.word_at(p) == Some("and"));
            if p == end {
                break;
            }
        }
        let is_vague = |m: usize| matches!(self.parsed.mentions[m].meanings.first(), Some(Meaning::Vague(_)));
        let attributes = phrases.iter().all(|phrase| phrase.head == Head::One);
        let names_members = match whole {
            Some(whole) => is_vague(whole) || attributes && self.is_several(whole),
            None => !attributes && (action.formation.is_some() || !action.paths.is_empty()),
        };
        if !names_members || phrases.is_empty() {
            return;
        }
        self.salient = whole.or(self.salient);
        self.parsed.account.used(self.at..at);
        action.objects.clear();
        for phrase in phrases {
            self.at = phrase.tokens.end;
            if let Referent::Mentions(list) = self.refer(phrase, false) {
                action.objects.extend(list.into_iter().map(|mention| Part { mention, take: None }));
            }
        }
        if let Some(whole) = whole {
            self.drop_mention(whole);
        }
        self.salient = action.objects.last().map(|part| part.mention);
        self.salient_list = Self::mentions(&action.objects);
    }

    /// "sort: forks to the left, spoons to the right" at `p`. Whether the rule applies.
    pub(super) fn terse_list(&mut self, start: usize, p: usize) -> bool {
        let Some((frame, length)) = verbs().at(self.tokens, p) else { return false };
        let mut end = p + length;
        let all =
            ["everything", "these", "them", "all", "all of them", "the following", "these things", "it all"];
        end += self.longest(&all, end);
        if !matches!(frame, Frame::Place | Frame::Stack | Frame::Other) || !self.is_colon(end) {
            return false;
        }
        let listed = self.item_at(end + 1).is_some_and(|(_, end)| self.item_has_place(end));
        if !listed {
            return false;
        }
        self.parsed.account.used(start..end);
        self.instructed = true;
        self.clause_start = false;
        let mut action = self.new_action(Frame::Place, p..end);
        self.listed_places(&mut action, end + 1);
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// Removes the objects of a mention that others replace.
    fn drop_mention(&mut self, mention: usize) {
        self.parsed.mentions[mention].count = Some([0, 0]);
        self.parsed.account.claims.retain(|claim| claim.meaning != Claimed::Object(mention));
    }
}
