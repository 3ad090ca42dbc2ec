//! Objects and particles of instructions.

use super::action::{Action, Part, PathKind};
use super::{Parser, Referent};
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, color_of, noun_phrase};
use crate::text_parser::property::Property;
use crate::text_parser::tokens::{Token, match_phrase};
use crate::text_parser::verbs::{Frame, verbs};

impl Parser<'_, '_> {
    /// "put the apple where the orange is and the orange where the apple is". Whether the rule applies.
    pub(super) fn exchanged_place(&mut self, action: &mut Action) -> bool {
        if self.word(0) != Some("where") || action.objects.is_empty() {
            return false;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1) else { return false };
        let mut sentence = (end..self.tokens.len()).take_while(|&at| self.tokens[at] != Token::End);
        let is_mutual = action.frame == Frame::Swap || sentence.any(|at| self.word_at(at) == Some("where"));
        if !is_mutual || !matches!(self.word_at(end), Some("is" | "was" | "stands" | "are" | "were")) {
            return false;
        }
        self.parsed.account.used(self.at..end + 1);
        if let Referent::Mentions(list) = self.refer(phrase, true) {
            action.seconds.extend(list.into_iter().map(|mention| Part { mention, take: None }));
        }
        action.frame = Frame::Swap;
        self.at = end + 1;
        true
    }

    /// A particle after the object: "pick the mug up", "turn it over", "turn the lamp on".
    pub(super) fn particle(&mut self, action: &mut Action) -> bool {
        let Some(word) = self.word(0) else { return false };
        if !matches!(
            word,
            "up" | "down"
                | "over"
                | "out"
                | "away"
                | "off"
                | "on"
                | "back"
                | "together"
                | "apart"
                | "around"
                | "open"
                | "closed"
                | "shut"
        ) {
            return false;
        }
        let verb = self.word_at(action.verb.start).unwrap_or_default().to_owned();
        if !action.objects.is_empty()
            && let Some(frame) = verbs().with_particle(&verb, word)
        {
            action.frame = frame;
        } else if matches!(word, "open") && !action.objects.is_empty() {
            action.frame = Frame::Open;
        } else if matches!(word, "closed" | "shut") && !action.objects.is_empty() {
            action.frame = Frame::Close;
        } else if matches!(word, "on") || action.objects.is_empty() && matches!(word, "open" | "closed") {
            return false;
        }
        action.particles.push(self.at..self.at + 1);
        self.parsed.account.used(self.at..self.at + 1);
        self.at += 1;
        true
    }

    /// A noun phrase: an object, or the second object of "swap A and B", "hand me the mug".
    pub(super) fn object(&mut self, action: &mut Action) -> bool {
        if matches!(self.word(0), Some("me" | "us")) {
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
            action.for_person = true;
            return true;
        }
        // "the positions of the apple and the orange", "the contents of the cup".
        let of = [
            "the positions of",
            "the places of",
            "the position of",
            "the contents of",
            "the content of",
            "positions of",
        ]
        .iter()
        .find_map(|phrase| match_phrase(self.tokens, self.at, phrase));
        if let Some(length) = of {
            self.parsed.account.used(self.at..self.at + length);
            self.at += length;
        }
        let verb = self.word_at(action.verb.start).unwrap_or_default();
        let transfers = matches!(verb, "transfer" | "dump" | "tip")
            && (self.at..self.tokens.len())
                .take_while(|&at| self.tokens[at] != Token::End)
                .any(|at| matches!(self.word_at(at), Some("from" | "out")));
        if (transfers || matches!(action.frame, Frame::Pour | Frame::Fill))
            && of.is_none()
            && self.substance(action)
        {
            action.frame = if action.frame == Frame::Fill { Frame::Fill } else { Frame::Pour };
            return true;
        }
        // "dump the contents of the bowl".
        let contents = of.is_some_and(|length| {
            (self.at - length..self.at).any(|at| matches!(self.word_at(at), Some("contents" | "content")))
        });
        if contents && action.frame == Frame::Place {
            action.frame = Frame::Pour;
        }
        if self.dirt(action) || self.own_part(action) || self.partitive(action) || self.own_button(action) {
            return true;
        }
        if self.names_button(action.frame) {
            action.frame = Frame::Press;
        }
        let Some((mut phrase, end)) = self.object_at(self.at, action.frame) else {
            return self.unnamed_object(action) || of.is_some();
        };
        if phrase.negated {
            return false;
        }
        self.bare_is_definite(&mut phrase);
        // "each of them", "each one".
        if phrase.head == Head::It && phrase.determiner == Determiner::Each {
            phrase.head = Head::Them;
        }
        self.at = end;
        action.everything |= phrase.head == Head::All;
        action.by_pronoun = matches!(phrase.head, Head::It | Head::Them);
        // Objects of an earlier sentence are meant by "one of the mugs" and "a mug" after "three mugs".
        let one = (phrase.head == Head::One && phrase.determiner == Determiner::New).then_some(1);
        let take = phrase.count.filter(|count| count[0] == count[1]).map(|count| count[0]).or(one);
        let before = self.parsed.mentions.len();
        let is_each = phrase.determiner == Determiner::Each;
        let is_pronoun = phrase.head == Head::It;
        let is_expected = phrase.determiner != Determiner::New || phrase.count.is_none();
        if self.is_one_of_invariant(&phrase, action) {
            (phrase.count, phrase.plural) = (Some([1, 1]), false);
        }
        let closes = matches!(action.frame, Frame::Open | Frame::Close)
            || matches!(self.word_at(end), Some("open" | "shut" | "closed"));
        let openable = if phrase.head == Head::It && closes { self.openable() } else { None };
        let referent = match (openable, self.part_of_earlier(&phrase), self.members_of_earlier(&phrase)) {
            (Some(mention), _, _) => {
                self.parsed.account.used(phrase.tokens.clone());
                Referent::Mentions(vec![mention])
            }
            (_, Some(mention), _) => {
                self.parsed.account.used(phrase.tokens.clone());
                self.parsed
                    .account
                    .claim(phrase.head_tokens.clone(), crate::text_parser::account::Claimed::Object(mention));
                Referent::Mentions(vec![mention])
            }
            (_, _, members) if !members.is_empty() => {
                self.parsed.account.used(phrase.tokens.clone());
                Referent::Mentions(members)
            }
            _ => self.refer(phrase, false),
        };
        match referent {
            Referent::Mentions(list) => {
                for &mention in list.iter().filter(|mention| **mention >= before && is_expected) {
                    self.expected.push(mention);
                    self.parsed.mentions[mention].plural |= is_each;
                    if is_each {
                        self.each.push(mention);
                    }
                }
                let take = take.filter(|_| list.iter().all(|&mention| mention < before));
                // "take the top book and put it on the tray".
                let before = |mention: usize| {
                    let last = self.parsed.goals.iter().rev().find(|goal| goal.object == mention);
                    last.and_then(|goal| goal.take).filter(|_| is_pronoun)
                };
                let parts = list.iter().map(|&mention| Part { mention, take: take.or(before(mention)) });
                action.objects.extend(parts);
                if let [.., last] = list[..] {
                    self.salient = Some(last);
                    self.salient_list = action.objects.iter().map(|part| part.mention).collect();
                    if self.word(0) == Some("of") {
                        self.contents_of(last);
                    }
                }
            }
            Referent::Table => action.paths.push(self.path(PathKind::Table, end..end)),
            Referent::Nothing => action.unknown = true,
        }
        true
    }

    /// "the dice" is one die, unless the verb is about several.
    fn is_one_of_invariant(&self, phrase: &NounPhrase, action: &Action) -> bool {
        let last = phrase.words.rsplit(' ').next().unwrap_or_default();
        phrase.count.is_none()
            && self.word_at(phrase.tokens.start) == Some("the")
            && self.lexicon.vocabulary.grammar.invariant.contains(last)
            && !matches!(action.frame, Frame::Stack | Frame::Separate | Frame::Other)
            && !matches!(
                self.word_at(action.verb.start),
                Some("collect" | "gather" | "group" | "sort" | "arrange")
            )
    }

    /// "close the door" after something with a door. Whether the rule applies.
    fn own_part(&mut self, action: &mut Action) -> bool {
        let the = usize::from(matches!(self.word(0), Some("the" | "its")));
        let is_part = matches!(self.word(the), Some("door" | "lid" | "drawer" | "cover" | "flap" | "flaps"));
        let alone = matches!(self.word(the + 1), None | Some("and" | "again" | "then" | "afterwards"));
        if !matches!(action.frame, Frame::Open | Frame::Close) || !is_part || !alone {
            return false;
        }
        let Some(whole) = self.openable() else { return false };
        self.parsed.account.used(self.at..self.at + the + 1);
        self.at += the + 1;
        action.objects.push(Part { mention: whole, take: None });
        true
    }

    /// Reads matter that is wiped away and is no object: "the dirt", "the crumbs". Returns whether the rule applies.
    fn dirt(&mut self, action: &mut Action) -> bool {
        let the = usize::from(matches!(self.word(0), Some("the" | "any" | "all" | "some")));
        let is_dirt = matches!(
            self.word(the),
            Some("dirt" | "dust" | "crumbs" | "mess" | "spill" | "stain" | "stains" | "liquid")
        );
        if action.frame != Frame::Use || !is_dirt {
            return false;
        }
        // It is on the table.
        action.paths.push(self.path(PathKind::Table, self.at..self.at + the + 1));
        self.parsed.account.used(self.at..self.at + the + 1);
        self.at += the + 1;
        true
    }

    /// The earlier objects that "all the fruit" means.
    fn members_of_earlier(&self, phrase: &NounPhrase) -> Vec<usize> {
        let Head::Objects(meanings) = &phrase.head else { return Vec::new() };
        let (Some(Meaning::Vague(index)), Determiner::Definite) = (meanings.first(), phrase.determiner)
        else {
            return Vec::new();
        };
        let vague = &self.lexicon.themes.vague[*index];
        let is_member = |m: &usize| match self.parsed.mentions[*m].meanings.first() {
            Some(Meaning::Category(category)) => {
                vague.members.contains(&self.lexicon.categories[*category].name)
            }
            _ => false,
        };
        (0..self.parsed.mentions.len()).filter(is_member).collect()
    }

    /// An earlier plural mention of which the phrase takes some.
    pub(super) fn part_of_earlier(&self, phrase: &NounPhrase) -> Option<usize> {
        let pronoun = phrase.head == Head::One && phrase.properties.is_empty() && phrase.selector.is_none();
        if pronoun && phrase.determiner == Determiner::New {
            let taken = phrase.count.map_or(1, |count| count[1]);
            return self
                .parsed
                .mentions
                .iter()
                .rposition(|mention| mention.count.is_some_and(|count| count[0] > taken));
        }
        let Head::Objects(meanings) = &phrase.head else { return None };
        let [low, high] = phrase.count?;
        if phrase.determiner != Determiner::New || low != high {
            return None;
        }
        let color = &phrase.attributes.color_words;
        self.parsed.mentions.iter().rposition(|mention| {
            mention.meanings.iter().any(|meaning| meanings.contains(meaning))
                && mention.count.is_some_and(|count| count[0] > low)
                && (color.is_empty() || *color == mention.attributes.color_words)
        })
    }

    /// "put apple in bowl": a noun without a determiner means what there is.
    pub(super) fn bare_is_definite(&self, phrase: &mut NounPhrase) {
        if phrase.determiner == Determiner::New
            && phrase.count.is_none()
            && matches!(phrase.head, Head::Objects(_) | Head::Unknown(_))
        {
            phrase.determiner = Determiner::Definite;
        }
    }

    /// "one" before a particle: "take one off".
    pub(super) fn bare_one(&self, at: usize) -> Option<(NounPhrase, usize)> {
        let next = self.word_at(at + 1);
        let ends = matches!(next, Some("off" | "out" | "over" | "up" | "away" | "and")) || next.is_none();
        (self.word_at(at) == Some("one") && ends).then(|| (NounPhrase::part([1, 1], at..at + 1), at + 1))
    }

    /// A color that stands for the object of that color: "stack red on blue".
    pub(super) fn bare_color(&self, at: usize) -> Option<(NounPhrase, usize)> {
        // "the red to the left of the blue".
        let start = at;
        let at = at + usize::from(self.word_at(at) == Some("the"));
        let word = self.word_at(at)?;
        let color = color_of(self.lexicon.vocabulary, word)?;
        let mut phrase = NounPhrase::part([1, 1], start..at + 1);
        phrase.count = None;
        phrase.determiner = Determiner::Definite;
        phrase.attributes.colors = vec![color];
        phrase.attributes.color_words = vec![word.to_owned()];
        phrase.properties.push((Property::Color, at..at + 1));
        Some((phrase, at + 1))
    }

    /// "clockwise", "by 90 degrees", "by a quarter turn" after "rotate".
    pub(super) fn turn(&mut self, action: &Action) -> bool {
        if action.frame != Frame::Rotate || action.objects.is_empty() {
            return false;
        }
        let is_angle = match &self.tokens[self.at] {
            Token::Number(_) => true,
            Token::Word(word) => {
                matches!(
                    word.as_str(),
                    "by" | "clockwise"
                        | "counterclockwise"
                        | "anticlockwise"
                        | "counter"
                        | "degrees"
                        | "degree"
                        | "quarter"
                        | "half"
                        | "full"
                        | "turn"
                        | "turns"
                        | "about"
                        | "through"
                ) || word == "a" && matches!(self.word(1), Some("quarter" | "half" | "full"))
                    || self.lexicon.vocabulary.numbers.contains_key(word)
            }
            _ => false,
        };
        if is_angle {
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
        }
        is_angle
    }
}
