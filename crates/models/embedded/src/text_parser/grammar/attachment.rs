//! Referents of relations: the object of the same preposition before it ("a fork behind a spoon behind a cup"), the
//! vessel of its content ("three lemons in a bowl, a knife to its right"), a support with its load ("in a bowl at the
//! back"), and an arrangement ("in front of the pile").

use super::{Link, LinkKind, Parser};
use crate::text_parser::phrase::{Attributes, Head, NounPhrase, group_of};
use scene::RelationKind;

impl Parser<'_, '_> {
    /// The object of the same preposition that ends at `start`.
    pub(super) fn repeated(&self, kind: RelationKind, start: usize) -> Option<usize> {
        let (target, _) = self.last_target.filter(|(_, end)| *end == start)?;
        let last = self.parsed.links.last()?;
        (last.kind == LinkKind::Relation(kind) && last.to == target && !kind.is_support()).then_some(target)
    }

    fn is_supported_by(&self, mention: usize, target: usize) -> bool {
        self.parsed.links.iter().any(|link| is_support(link) && (link.from, link.to) == (mention, target))
    }

    /// Referent of a singular pronoun beside an object: the vessel that the object is in, or the support of several.
    pub(super) fn beside(&self, mention: usize) -> usize {
        let several = self.is_several(mention);
        let holds = |link: &&Link| {
            link.from == mention
                && (link.kind == LinkKind::Relation(RelationKind::In) || several && is_support(link))
        };
        self.parsed.links.iter().find(holds).map_or(mention, |link| link.to)
    }

    /// The support of the last subject that ends at `start`: a place after it is also the place of the support.
    pub(super) fn carrier_before(&self, start: usize) -> Option<usize> {
        let (target, _) = self.last_target.filter(|(_, end)| *end == start)?;
        let subject = *self.subject.last()?;
        self.is_supported_by(subject, target).then_some(target)
    }

    /// The referent of "it" in "a cookie on a saucer to the right of it": not the support of the cookie.
    pub(super) fn other_than_support(&self, target: usize) -> usize {
        let Some(&last) = self.subject.last() else { return target };
        if !self.is_supported_by(last, target) {
            return target;
        }
        let is_other =
            |m: &usize| *m != last && *m != target && self.parsed.mentions[*m].count != Some([0, 0]);
        self.subject
            .iter()
            .rev()
            .copied()
            .find(is_other)
            .or_else(|| (0..last).rev().find(is_other))
            .unwrap_or(target)
    }

    /// The referents of "them" after a subject: the objects before it, also the support of one of them.
    pub(super) fn others(&self, targets: Vec<usize>) -> Vec<usize> {
        let last = self.subject.last();
        let mut others: Vec<usize> = targets.iter().copied().filter(|target| Some(target) != last).collect();
        if let [one] = others[..]
            && !self.is_several(one)
        {
            let partner =
                self.parsed.links.iter().rev().find(|link| link.from == one && Some(&link.to) != last);
            others.extend(partner.map(|link| link.to));
        }
        if others.is_empty() { targets } else { others }
    }

    /// "the pile", "this row" at `at`: an object of the last such arrangement, and the position after the noun.
    pub(super) fn arrangement_named_at(&self, at: usize) -> Option<(usize, usize)> {
        let is_definite = matches!(self.word_at(at), Some("the" | "this" | "that"));
        let noun = self.word_at(at + 1).filter(|_| is_definite)?;
        let is_stack = matches!(noun, "stack" | "tower" | "pile" | "heap");
        if !(is_stack || group_of(noun).is_some())
            || self.word_at(at + 2) == Some("of")
            || self.lexicon.longest_at(self.tokens, at + 1).is_some_and(|(_, length)| length > 1)
        {
            return None;
        }
        let stacked = |m: &usize| self.parsed.mentions[*m].stacked;
        let last = self.parsed.arrangements.last();
        let of_stack = (0..self.parsed.mentions.len()).rev().find(stacked).filter(|_| is_stack);
        let member = of_stack.or_else(|| last?.mentions.first().copied())?;
        Some((member, at + 2))
    }

    /// "a yellow cup and saucer": the adjectives of the first noun are those of both.
    pub(super) fn shares_adjectives(&self, phrase: &NounPhrase) -> Option<usize> {
        let bare = phrase.count.is_none() && !phrase.plural && phrase.properties.is_empty();
        let before = *self.subject.last()?;
        let first = &self.parsed.mentions[before];
        let described = !first.attributes.color_words.is_empty() || first.attributes.substance.is_some();
        let is_next =
            first.tokens.end + 1 == phrase.tokens.start && phrase.tokens.start == phrase.head_tokens.start;
        let start = first.tokens.start;
        let article = (start.saturating_sub(4)..start).rev().map_while(|at| self.word_at(at));
        let has_article =
            article.take_while(|word| *word != "and").any(|word| matches!(word, "a" | "an" | "one"));
        let named = matches!(phrase.head, Head::Objects(_)) && !phrase.is_table();
        let and = phrase.tokens.start.checked_sub(1).and_then(|at| self.word_at(at)) == Some("and");
        (self.after_and && and && bare && described && is_next && has_article && named && !first.plural)
            .then_some(before)
    }

    pub(super) fn share_adjectives(&mut self, first: usize, second: usize) {
        let known = self.parsed.mentions[first].attributes.clone();
        let mention = &mut self.parsed.mentions[second];
        let color = known.color_words.first().cloned();
        mention.words = color.into_iter().chain([mention.words.clone()]).collect::<Vec<_>>().join(" ");
        let shared = Attributes { measures: Vec::new(), volume_m3: None, mass_kg: None, ..known };
        super::references::merge(&mut mention.attributes, shared);
    }

    /// "a stack made of two plates and a bowl": what the phrase lies on.
    pub(super) fn continues_stack(&self, phrase: &NounPhrase) -> Option<usize> {
        let below = *self.subject.last()?;
        let mention = &self.parsed.mentions[below];
        let of = mention.tokens.start.saturating_sub(6)..mention.tokens.start;
        let is_made = of.clone().any(|at| {
            matches!(self.word_at(at), Some("made" | "consisting" | "composed" | "built"))
                && at > 0
                && matches!(self.word_at(at - 1), Some("stack" | "pile" | "tower"))
        });
        let joins = self.after_and && mention.tokens.end + 3 >= phrase.tokens.start;
        (mention.stacked && is_made && joins && matches!(phrase.head, Head::Objects(_))).then_some(below)
    }
}

fn is_support(link: &Link) -> bool {
    matches!(link.kind, LinkKind::Relation(kind) if kind.is_support())
}
