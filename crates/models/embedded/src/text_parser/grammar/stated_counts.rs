//! Counts that follow their objects: "a heap of bolts, about ten", "there are four of them", "three plates in total".

use super::Parser;
use crate::text_parser::account::Claimed;
use crate::text_parser::phrases::phrases;
use crate::text_parser::property::Property;
use crate::text_parser::quantity::quantity;
use crate::text_parser::tokens::{Token, match_phrase};

impl Parser<'_, '_> {
    /// "fork (x3)", "plate: 0", and the line "count: 2" after the line of its object. Whether the rule applies.
    fn noted_count(&mut self) -> bool {
        let key = matches!(self.word(0), Some("count" | "quantity" | "qty" | "number" | "amount"));
        let pause = usize::from(matches!(self.tokens.get(self.at + 1), Some(Token::Pause)));
        let number_at = match self.word(0) {
            Some("x") if self.follows_pause() => self.at + 1,
            _ if key => self.at + 1 + pause,
            None if self.follows_pause() => self.at,
            _ => return false,
        };
        let Some(Token::Number(number)) = self.tokens.get(number_at) else { return false };
        let ends = matches!(self.tokens.get(number_at + 1), None | Some(Token::Pause | Token::End));
        let last = if key { self.salient } else { self.subject.last().copied() };
        let Some(mention) = last.filter(|_| ends && number.fract() == 0.0 && (0.0..=64.0).contains(number))
        else {
            return false;
        };
        let count = *number as u32;
        let open = matches!(self.parsed.mentions[mention].count, None | Some([1, 1]));
        // Without "x" and without a key only a zero says how many: other numbers follow their noun directly.
        if !open || self.word(0).is_none() && count > 0 {
            return false;
        }
        let target = &mut self.parsed.mentions[mention];
        (target.count, target.plural) = (Some([count; 2]), count > 1);
        if count == 0 {
            let meanings = target.meanings.clone();
            self.parsed.account.claim(self.at..number_at + 1, Claimed::Exclusion(meanings.clone()));
            self.parsed.excluded.extend(meanings);
        } else {
            self.claim_property(self.at..number_at + 1, Property::Count, vec![mention]);
        }
        self.at = number_at + 1;
        true
    }

    /// The lines "color: red" and "material: wood" after the line of their object. Whether the rule applies.
    fn noted_property(&mut self) -> bool {
        let key = matches!(self.word(0), Some("color" | "colour" | "material" | "size" | "state" | "pose"));
        let pause = matches!(self.tokens.get(self.at + 1), Some(Token::Pause));
        let Some(mention) = self.salient.filter(|_| key && pause) else { return false };
        self.parsed.account.used(self.at..self.at + 1);
        self.at += 2;
        self.subject = vec![mention];
        self.predicate_at = Some(self.at);
        true
    }

    /// A count of the last plural. Whether the rule applies.
    pub(super) fn stated_count(&mut self) -> bool {
        if self.noted_count() || self.noted_property() {
            return true;
        }
        let tokens = self.tokens;
        let total = |at: usize| phrases().list.totals.longest_at(tokens, at);
        let own = ["in total", "in all", "altogether", "all told", "overall"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, self.at, phrase));
        if let Some(length) = own.filter(|_| !self.subject.is_empty()) {
            self.parsed.account.used(self.at..self.at + length);
            self.at += length;
            return true;
        }
        // "a heap of potatoes, say seven".
        let hedged = self.follows_pause()
            && matches!(self.word(0), Some("say" | "maybe" | "perhaps" | "namely" | "like" | "possibly"));
        let number = self.at + usize::from(hedged);
        let Some((range, length)) = quantity(self.lexicon, self.tokens, number) else { return false };
        let before = self.at.checked_sub(1);
        let there = before.is_some_and(|before| {
            matches!(self.word_at(before), Some("are" | "theres"))
                && (self.word_at(before) == Some("theres")
                    || before > 0 && matches!(self.word_at(before - 1), Some("there" | "they")))
        });
        let after_number = number + length;
        // "four of" is one quantity.
        let tail = match total(after_number) {
            Some(words)
                if self.word_at(after_number) == Some("them")
                    || self.word_at(after_number) == Some("these") =>
            {
                Some(words).filter(|_| self.word_at(after_number - 1) == Some("of"))
            }
            tail => tail,
        };
        let end = after_number + tail.unwrap_or(0);
        let ends = matches!(self.tokens.get(end), None | Some(Token::Pause | Token::End));
        let Some(mention) = self.subject.last().copied().or_else(|| self.salient_list.last().copied()) else {
            return false;
        };
        let open = self.parsed.mentions[mention].plural && self.parsed.mentions[mention].count.is_none();
        if !open || !ends || range[0] != range[1] || !(there || self.follows_pause()) {
            return false;
        }
        self.parsed.mentions[mention].count = Some(range);
        self.claim_property(self.at..end, Property::Count, vec![mention]);
        self.at = end;
        true
    }
}
