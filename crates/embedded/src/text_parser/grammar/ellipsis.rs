//! Heads that the text leaves out: "a red and a blue mug", "two mugs, one red and one blue", "the blue one".

use super::{Parser, Referent};
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::tokens::Token;

impl Parser<'_, '_> {
    /// A phrase without a head in subject position. Whether the rule applies.
    pub(super) fn elliptic(&mut self, phrase: &NounPhrase) -> bool {
        if phrase.determiner == Determiner::New && self.split_off(phrase) {
            return true;
        }
        let explicit = matches!(self.word_at(phrase.tokens.end.saturating_sub(1)), Some("one" | "ones"));
        if explicit {
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

    /// "two mugs, one red and one blue": each phrase takes its share of the plural mention before it.
    fn split_off(&mut self, phrase: &NounPhrase) -> bool {
        let count = phrase.count.map_or(1, |count| count[0]);
        let (mention, left) = match self.split {
            Some(split) => split,
            None => {
                let Some(last) = self.subject.last().copied().or(self.salient) else { return false };
                // "the plates ...; there are three of them".
                if let (None, Some(count), true) =
                    (self.parsed.mentions[last].count, phrase.count, self.parsed.mentions[last].plural)
                    && phrase.properties.is_empty()
                    && matches!(self.word_at(phrase.tokens.end.saturating_sub(1)), Some("them" | "these"))
                {
                    self.parsed.mentions[last].count = Some(count);
                    self.claim_property(phrase.tokens.clone(), "count", vec![last]);
                    return true;
                }
                match self.parsed.mentions[last].count {
                    Some([low, high]) if low == high && low > 1 && low <= 64 => (last, low),
                    _ => return false,
                }
            }
        };
        if count == 0 || count > left {
            return false;
        }
        self.parsed.account.used(phrase.tokens.clone());
        let part = if self.split.is_none() { mention } else { self.duplicate(mention) };
        let target = &mut self.parsed.mentions[part];
        if self.split.is_some() {
            target.attributes.colors.clear();
            target.attributes.color_words.clear();
        }
        target.count = Some([count; 2]);
        target.plural = count > 1;
        super::references::merge(&mut target.attributes, phrase.attributes.clone());
        for (property, range) in phrase.properties.clone() {
            self.claim_property(range, property, vec![part]);
        }
        self.split = (left > count).then_some((mention, left - count));
        if !self.subject.contains(&part) {
            self.subject.push(part);
        }
        self.salient = Some(part);
        self.salient_list = self.subject.clone();
        true
    }

    /// What is left of a split mention is a mention without the attributes of the others.
    pub(super) fn end_split(&mut self) {
        let Some((mention, left)) = self.split.take() else { return };
        let rest = self.duplicate(mention);
        let target = &mut self.parsed.mentions[rest];
        target.attributes.colors.clear();
        target.attributes.color_words.clear();
        target.attributes.scale = 1.0;
        target.count = Some([left; 2]);
        target.plural = left > 1;
    }

    /// A phrase with the head of an earlier mention.
    pub(super) fn completed(&self, mut phrase: NounPhrase, of: usize) -> NounPhrase {
        let known = &self.parsed.mentions[of].words;
        let noun = self.lexicon.vocabulary.singular_of(known);
        let noun = noun.rsplit(' ').next().unwrap_or_default().to_owned();
        phrase.words = self.described(&phrase, &noun);
        phrase.plural = phrase.count.is_some_and(|count| count[1] > 1);
        phrase
    }
}
