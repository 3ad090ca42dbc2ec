//! Contents after "of": "a bowl of apples", "a tray of cups and plates".

use super::{Link, LinkKind, Parser, Referent};
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::property::Property;
use catalog::Affordance;

impl Parser<'_, '_> {
    /// After "of": the contents of a vessel or the load of a board.
    pub(super) fn contents_of(&mut self, vessel: usize) {
        let mut p = self.at + 1;
        loop {
            let substance =
                self.word_at(p).is_some_and(|word| self.lexicon.vocabulary.grammar.substances.contains(word));
            let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else {
                if substance {
                    self.claim_property(self.at..p + 1, Property::Content, vec![vessel]);
                    self.at = p + 1;
                }
                return;
            };
            if substance && phrase.determiner == Determiner::New && phrase.count.is_none() && !phrase.plural {
                // "a cup of tea": a part of the cup's name.
                self.claim_property(self.at..p + 1, Property::Content, vec![vessel]);
                self.at = p + 1;
                return;
            }
            let open = phrase.count.is_none();
            let holds = self.names_vessel(&phrase);
            self.parsed.account.used(self.at..p);
            self.at = end;
            if let Referent::Mentions(list) = self.refer(phrase, false) {
                for content in list {
                    if content != vessel {
                        self.parsed.mentions[content].contents = true;
                        self.parsed.links.push(Link::new(content, LinkKind::With, vessel));
                    }
                }
            }
            // "a bowl of apples and pears": bare plurals are also contents of the vessel, but not the cups of "a plate
            // of sushi and cups".
            let next = self.at + 1;
            if open
                && self.word(0) == Some("and")
                && let Some((second, _)) = noun_phrase(self.lexicon, self.tokens, next)
                && second.count.is_none()
                && second.plural
                && matches!(second.head, Head::Objects(_))
                && (holds || !self.names_vessel(&second))
            {
                p = next;
            } else {
                return;
            }
        }
    }
    /// Whether the phrase names what holds other objects.
    fn names_vessel(&self, phrase: &NounPhrase) -> bool {
        let Head::Objects(meanings) = &phrase.head else { return false };
        self.category_of(meanings).is_some_and(|category| category.affords(Affordance::Container))
    }
}
