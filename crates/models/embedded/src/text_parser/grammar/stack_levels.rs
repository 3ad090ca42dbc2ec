//! Levels of stacks: "the second book of the stack is red", "three books in a stack; the second is red".

use super::{Link, LinkKind, Parser};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Attributes, Head, NounPhrase, Selector};
use scene::RelationKind;

/// Number of objects of a stack of which the text does not say the number.
const STACK: u32 = 3;

impl Parser<'_, '_> {
    /// Number of tokens of "of the stack" at `at`.
    fn of_stack(&self, at: usize) -> usize {
        let of = usize::from(matches!(self.word_at(at), Some("of" | "in" | "from")));
        let the = usize::from(matches!(self.word_at(at + of), Some("the" | "a" | "that")));
        let is_stack = matches!(self.word_at(at + of + the), Some("stack" | "tower" | "pile"));
        if of + the == 2 && is_stack && self.word_at(at + 3) != Some("of") { 3 } else { 0 }
    }

    /// "the second book of the stack": the mention of that level. Without such a stack, the text is about one of three
    /// objects.
    pub(super) fn stack_level(&mut self, phrase: &NounPhrase) -> Option<usize> {
        let length = self.of_stack(self.at);
        let Some(selector @ (Selector::Ordinal(_) | Selector::Top | Selector::Bottom)) = phrase.selector
        else {
            return None;
        };
        let Head::Objects(meanings) = &phrase.head else { return None };
        if length == 0 || !matches!(meanings.first(), Some(Meaning::Category(_))) {
            return None;
        }
        let like = |m: &usize| {
            let mention = &self.parsed.mentions[*m];
            mention.stacked && mention.meanings.iter().any(|meaning| meanings.contains(meaning))
        };
        let known = (0..self.parsed.mentions.len()).rev().find(like);
        let whole = known.unwrap_or_else(|| {
            let low = match selector {
                Selector::Ordinal(k) => k as u32 + 1,
                _ => 1,
            };
            let count = Some([STACK.max(low); 2]);
            let whole = NounPhrase {
                count,
                plural: true,
                stacked: true,
                selector: None,
                attributes: Attributes::plain(),
                properties: Vec::new(),
                ..phrase.clone()
            };
            self.add_mention(meanings.clone(), whole, false)
        });
        let level = match selector {
            Selector::Ordinal(k) => k,
            Selector::Bottom => 0,
            _ => self.parsed.mentions[whole].count.map_or(0, |count| count[0] as usize).checked_sub(1)?,
        };
        let found = self.level_of(&[whole], level)?;
        super::references::merge(&mut self.parsed.mentions[found].attributes, phrase.attributes.clone());
        for (property, range) in phrase.properties.clone() {
            self.claim_property(range, property, vec![found]);
        }
        self.parsed.account.claim(phrase.head_tokens.clone(), Claimed::Object(found));
        self.parsed.account.used(phrase.tokens.start..self.at + length);
        self.at += length;
        Some(found)
    }

    /// The object at a level of a stack, counted from the bottom; the objects below and above it remain mentions of
    /// their own.
    pub(super) fn level_of(&mut self, candidates: &[usize], level: usize) -> Option<usize> {
        let below = candidates.iter().copied().rfind(|&m| self.parsed.mentions[m].stacked)?;
        let count = self.parsed.mentions[below].count.filter(|count| count[0] == count[1])?[0] as usize;
        if level >= count || count < 2 {
            return None;
        }
        let on = LinkKind::Relation(RelationKind::On);
        let found = self.one_of(below);
        self.parsed.mentions[found].stacked = false;
        if level == 0 {
            // The others stand on it; it stands where they stood.
            self.parsed.links.retain(|link| link.from != below);
            self.parsed.links.push(Link::new(below, on, found));
            return Some(found);
        }
        self.parsed.links.retain(|link| link.from != found);
        let above = count - level - 1;
        if above > 0 {
            let upper = self.one_of(below);
            self.set_count(upper, above as u32);
            self.set_count(below, level as u32);
            self.parsed.links.retain(|link| link.from != upper);
            self.parsed.links.push(Link::new(upper, on, found));
        }
        self.parsed.links.push(Link::new(found, on, below));
        Some(found)
    }
}
