//! Some of several objects as the object of an instruction: "one of the two balls", "either mug", "the red one of the
//! two cubes", "the top book of the stack".

use super::action::{Action, Part};
use super::{Parser, Referent};
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::property::Property;
use crate::text_parser::quantity::quantity;
use crate::text_parser::tokens::{Token, match_phrase};

/// Number of objects of a stack of which the text does not say the number.
const STACK: u32 = 3;

impl Parser<'_, '_> {
    /// Whether one of the rules applies at the current position.
    pub(super) fn partitive(&mut self, action: &mut Action) -> bool {
        self.either(action)
            || self.one_of_named(action)
            || self.described_one_of(action)
            || self.top_of_stack(action)
    }

    /// "of the two" at `at`: the number, and the position of the noun.
    fn of_several(&self, at: usize) -> Option<(u32, usize)> {
        let the = at + usize::from(self.word_at(at) == Some("of"));
        if the == at || !matches!(self.word_at(the), Some("the" | "these" | "those")) {
            return None;
        }
        let ([low, high], length) = quantity(self.lexicon, self.tokens, the + 1)?;
        (low == high && low > 1 && low < 20).then_some((low, the + 1 + length))
    }

    /// Takes some of the objects of a noun phrase at `noun`.
    fn take(&mut self, action: &mut Action, number: u32, noun: usize, take: u32) -> bool {
        let Some((mut phrase, end)) = noun_phrase(self.lexicon, self.tokens, noun) else { return false };
        if phrase.negated || phrase.is_table() || !super::steps::is_object(&phrase.head) {
            return false;
        }
        phrase.count = Some([number; 2]);
        phrase.plural = true;
        phrase.determiner = Determiner::Definite;
        self.parsed.account.used(self.at..noun);
        self.at = end;
        let before = self.parsed.mentions.len();
        match self.refer(phrase, false) {
            Referent::Mentions(list) => {
                let Some(&mention) = list.last() else { return true };
                let take = (self.is_several(mention)).then_some(take);
                if mention >= before {
                    self.expected.push(mention);
                }
                action.objects.push(Part { mention, take });
                self.salient = Some(mention);
                self.salient_list = vec![mention];
            }
            _ => action.unknown = true,
        }
        true
    }

    /// "either mug", "either of the two mugs".
    fn either(&mut self, action: &mut Action) -> bool {
        if self.word(0) != Some("either") {
            return false;
        }
        let (number, noun) = match self.of_several(self.at + 1) {
            Some(several) => several,
            None if self.word(1) == Some("of") => (2, self.at + 2),
            None => (2, self.at + 1),
        };
        self.take(action, number, noun, 1)
    }

    /// "one of the two balls", when no balls have been named.
    fn one_of_named(&mut self, action: &mut Action) -> bool {
        let any = usize::from(self.word(0) == Some("any"));
        let start = self.at + any;
        let number = self.tokens.get(..=start).and_then(|tokens| quantity(self.lexicon, tokens, start));
        let (take, length) = match number {
            Some(([low, high], length)) if low == high => (low, length),
            _ if any == 1 => (1, 0),
            _ => return false,
        };
        let Some((number, noun)) = self.of_several(start + length) else { return false };
        take < number && self.take(action, number, noun, take)
    }

    /// "the red one of the two cubes".
    fn described_one_of(&mut self, action: &mut Action) -> bool {
        let Some((one, end)) = noun_phrase(self.lexicon, self.tokens, self.at) else { return false };
        let Some(several) = self.of_several(end).filter(|_| one.head == Head::One) else { return false };
        let (number, noun) = several;
        let Some((whole, after)) = noun_phrase(self.lexicon, self.tokens, noun) else { return false };
        let Head::Objects(meanings) = whole.head.clone() else { return false };
        if one.properties.is_empty() || whole.negated || whole.is_table() {
            return false;
        }
        self.parsed.account.used(self.at..noun);
        let known = self.parsed.mentions.iter().any(|mention| mention.meanings == meanings);
        let described = NounPhrase {
            determiner: Determiner::Definite,
            count: Some([1, 1]),
            plural: false,
            attributes: one.attributes,
            properties: one.properties,
            ..whole.clone()
        };
        self.at = after;
        if let Referent::Mentions(list) = self.refer(described, false) {
            action.objects.extend(list.iter().map(|&mention| Part { mention, take: None }));
            self.salient = list.last().copied().or(self.salient);
        }
        if !known {
            let rest = number - 1;
            let others =
                NounPhrase { count: Some([rest; 2]), plural: rest > 1, determiner: Determiner::New, ..whole };
            self.refer(others, false);
        }
        true
    }

    /// "the top book of the stack", "the topmost plate from the pile of four plates".
    fn top_of_stack(&mut self, action: &mut Action) -> bool {
        let the = usize::from(self.word(0) == Some("the"));
        let is_top = matches!(self.word(the), Some("top" | "topmost" | "upper" | "uppermost" | "highest"));
        let noun = self.at + the + 1;
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, noun).filter(|_| is_top) else {
            return false;
        };
        let Head::Objects(meanings) = phrase.head.clone() else { return false };
        if phrase.count.is_some_and(|count| count != [1, 1]) || phrase.plural || phrase.is_table() {
            return false;
        }
        let of = end + usize::from(matches!(self.word_at(end), Some("from" | "of" | "off" | "on" | "in")));
        let of = of + usize::from(matches!(self.word_at(of), Some("of")));
        let noun = of + usize::from(matches!(self.word_at(of), Some("the" | "a")));
        let is_stack = noun > end && matches!(self.word_at(noun), Some("stack" | "pile" | "tower"));
        let stacked =
            self.parsed.mentions.iter().rposition(|mention| mention.stacked && mention.meanings == meanings);
        let mention = match stacked {
            Some(stacked) => {
                self.parsed.account.used(self.at..end);
                stacked
            }
            None if is_stack => {
                let number = (self.word_at(noun + 1) == Some("of"))
                    .then(|| quantity(self.lexicon, self.tokens, noun + 2))
                    .flatten()
                    .map_or(STACK, |([low, _], _)| low.clamp(2, 12));
                let words = self.lexicon.vocabulary.singular_of(&phrase.words);
                let whole = NounPhrase {
                    count: Some([number; 2]),
                    plural: true,
                    stacked: true,
                    determiner: Determiner::New,
                    words,
                    ..phrase
                };
                self.parsed.account.used(self.at..end);
                let Referent::Mentions(list) = self.refer(whole, false) else { return false };
                let Some(&mention) = list.last() else { return false };
                mention
            }
            None => return false,
        };
        self.at = end;
        if is_stack {
            self.at = noun + 1;
            // "of three books".
            if self.word_at(self.at) == Some("of")
                && let Some((_, after)) = noun_phrase(self.lexicon, self.tokens, self.at + 1)
            {
                self.at = after;
            }
            self.parsed.account.used(end..self.at);
        }
        action.objects.push(Part { mention, take: Some(1) });
        self.salient = Some(mention);
        self.salient_list = vec![mention];
        true
    }

    /// ", of which there are three," after an object. Whether the rule applies.
    pub(super) fn stated_number(&mut self, action: &Action) -> bool {
        let at = self.at + 1;
        let length = ["of which there are", "of which you see", "there are"]
            .iter()
            .find_map(|words| match_phrase(self.tokens, at, words));
        let (Some(length), Some(part)) = (length, action.objects.last()) else { return false };
        let Some((range, number)) = quantity(self.lexicon, self.tokens, at + length) else { return false };
        let end = at + length + number;
        if !matches!(self.tokens.get(end), Some(Token::Pause)) {
            return false;
        }
        let mention = &mut self.parsed.mentions[part.mention];
        (mention.count, mention.plural) = (Some(range), range[1] > 1);
        self.claim_property(at..end, Property::Count, vec![part.mention]);
        self.at = end + 1;
        true
    }
}
