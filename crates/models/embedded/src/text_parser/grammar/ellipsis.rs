//! Heads that the text leaves out: "a red and a blue mug", "the blue one".

use super::{Parser, Referent};
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, Selector, noun_phrase};
use crate::text_parser::tokens::Token;
use scene::text_account::UnrecognizedReason;

impl Parser<'_, '_> {
    /// A phrase without a head in subject position. Whether the rule applies.
    pub(super) fn elliptic(&mut self, phrase: &NounPhrase) -> bool {
        // "two plates, a red and a blue mug": the noun follows.
        let completes = !phrase.properties.is_empty() && self.completed_ahead(phrase).is_some();
        if phrase.determiner == Determiner::New && !completes && self.split_off(phrase) {
            return true;
        }
        // "two of them" are no further objects.
        if self.is_part_of_them(phrase) {
            self.report(phrase.tokens.clone(), UnrecognizedReason::NoReferent);
            self.salient_list.clear();
            return true;
        }
        let explicit = matches!(self.word_at(phrase.tokens.end.saturating_sub(1)), Some("one" | "ones"));
        if explicit || phrase.selector.is_some_and(|selector| selector == Selector::Other) {
            return false;
        }
        let Some(copy) = self.completed_ahead(phrase) else { return false };
        let Referent::Mentions(list) = self.refer(copy, false) else { return true };
        for mention in list {
            self.apply_pending(mention);
            self.subject.push(mention);
            self.salient = Some(mention);
        }
        self.salient_list = self.subject.clone();
        self.joined = std::mem::take(&mut self.after_and);
        true
    }

    /// The phrase with the head of the next phrase of the list.
    pub(super) fn completed_ahead(&self, phrase: &NounPhrase) -> Option<NounPhrase> {
        let headed = self.headed_ahead(phrase)?;
        let mut copy = phrase.clone();
        copy.head = headed.head;
        copy.head_tokens = headed.head_tokens.clone();
        copy.plural = phrase.count.map_or(headed.plural, |count| count[1] > 1);
        let noun = self.source.tokens[headed.head_tokens]
            .iter()
            .filter_map(Token::word)
            .collect::<Vec<_>>()
            .join(" ");
        copy.words = self.described(phrase, &noun);
        Some(copy)
    }

    /// The words of the modifiers of a phrase, then the noun.
    fn described(&self, phrase: &NounPhrase, noun: &str) -> String {
        let mut words: Vec<&str> = phrase
            .properties
            .iter()
            // "another with 6 cm sides": a measure is no part of the name.
            .filter(|(_, range)| self.tokens[range.clone()].iter().all(|token| token.word().is_some()))
            .flat_map(|(_, range)| self.tokens[range.clone()].iter().filter_map(Token::word))
            .collect();
        words.push(noun);
        words.join(" ")
    }

    /// The next phrase of the list that has a head and the same kind of property.
    fn headed_ahead(&self, phrase: &NounPhrase) -> Option<NounPhrase> {
        let mut at = phrase.tokens.end;
        // At most this many heads are left out.
        for _ in 0..6 {
            while matches!(self.word_at(at), Some("and" | "or"))
                || matches!(self.tokens.get(at), Some(Token::Pause))
            {
                at += 1;
            }
            let (next, end) = noun_phrase(self.lexicon, self.tokens, at)?;
            let alike =
                next.properties.iter().any(|(kind, _)| phrase.properties.iter().any(|(k, _)| k == kind));
            match next.head {
                Head::Objects(_) | Head::Unknown(_) if alike => return Some(next),
                Head::One => at = end,
                _ => return None,
            }
        }
        None
    }

    /// A phrase with the head of an earlier mention.
    pub(super) fn completed(&self, mut phrase: NounPhrase, of: usize) -> NounPhrase {
        let known = &self.parsed.mentions[of].words;
        let noun = self.lexicon.vocabulary.singular_of(known);
        let noun = noun.rsplit(' ').next().unwrap_or_default().to_owned();
        phrase.words = self.described(&phrase, &noun);
        phrase.stand_in = self.parsed.mentions[of].stand_in.clone();
        phrase.plural = phrase.count.is_some_and(|count| count[1] > 1);
        phrase
    }
}
