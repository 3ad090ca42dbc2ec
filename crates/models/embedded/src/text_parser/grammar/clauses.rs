//! Clauses after the first of a sentence: new clauses, verbs that are left out, and members of announced groups.

use super::{LinkKind, Parser, Referent};
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::{Determiner, Group, Head, NounPhrase, group_of, noun_phrase};
use crate::text_parser::prepositions::place_at;
use crate::text_parser::property::Property;
use crate::text_parser::quantity::quantity;
use crate::text_parser::tokens::Token;
use scene::RelationKind;

/// Verbs of which a phrase before them is the subject.
const FINITE: &[&str] = &[
    "is", "are", "was", "were", "has", "have", "holds", "hold", "contains", "contain", "carries", "carry",
    "stands", "stand", "lies", "lie", "sits", "sit", "rests", "rest", "must", "should",
];

impl Parser<'_, '_> {
    /// Whether a verb at `at` has the phrase before it as its subject.
    pub(super) fn finite_verb_at(&self, at: usize) -> bool {
        self.word_at(at).is_some_and(|word| FINITE.contains(&word))
    }

    /// Before a phrase whose end has been reached: "in the corner there is a plant, and a phone lies close to the edge"
    /// begins another clause, to which the place before the plant does not apply.
    pub(super) fn begin_clause(&mut self) {
        let placed = place_at(self.tokens, self.at, &Self::is_table_word).is_some();
        let own = self.finite_verb_at(self.at) || placed && !self.pending_places.is_empty();
        if self.subject.is_empty() || !own || (self.pending.is_empty() && self.pending_places.is_empty()) {
            return;
        }
        self.pending.clear();
        self.pending_places.clear();
        self.pending_each = None;
        self.pending_pronoun = false;
    }

    /// "the left one carries a croissant, the right one an egg": the verb is left out. Adjectives may follow likewise
    /// ("the cup is white, the saucer blue").
    pub(super) fn gapped(&mut self, host: usize) {
        if self.predicated > 0 {
            self.predicate_at = Some(self.at);
        }
        let Some(kind) = self.gap else { return };
        if self.subject.len() < 2 || !self.object_begins(self.at) {
            return;
        }
        self.list_of(host, kind, self.at..self.at, false);
    }

    /// "on a book that lies on a tray", "left of the banana, which is left of the orange": the object of the
    /// preposition is the subject of the clause. Whether the rule applies.
    pub(super) fn relative_clause(&mut self) -> bool {
        let Some((target, end)) = self.last_target else { return false };
        let relative = matches!(self.word(0), Some("that" | "which")) && self.finite_verb_at(self.at + 1);
        let follows = end == self.at || end + 1 == self.at && self.follows_pause();
        if !relative || !follows || self.subject.last() == Some(&target) {
            return false;
        }
        self.parsed.account.used(self.at..self.at + 1);
        self.at += 1;
        self.subject = vec![target];
        self.chain = None;
        self.salient = Some(target);
        true
    }

    /// "surround the cake with five candles". Whether the rule applies.
    pub(super) fn surround(&mut self) -> bool {
        let kind = match self.word(0) {
            Some("surround" | "encircle" | "ring") => LinkKind::Relation(RelationKind::Around),
            Some("flank") => LinkKind::Flank,
            _ => return false,
        };
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1) else { return false };
        if !matches!(self.word_at(end), Some("with" | "by"))
            || phrase.determiner == Determiner::New && phrase.count.is_none()
        {
            return false;
        }
        let start = self.at;
        self.at = end;
        if let Referent::Mentions(hosts) = self.refer(phrase, false)
            && let Some(&host) = hosts.last()
        {
            self.subject = vec![host];
            self.at = end + 1;
            self.parsed.account.used(end..end + 1);
            self.list_of(host, kind, start..start + 1, false);
        }
        true
    }

    /// Whether an indefinite phrase begins: the object of a verb that is left out.
    pub(super) fn object_begins(&self, at: usize) -> bool {
        let article = matches!(self.word_at(at), Some("a" | "an" | "another"))
            || quantity(self.lexicon, self.tokens, at).is_some();
        article
            && noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(phrase, _)| {
                phrase.determiner == Determiner::New && matches!(phrase.head, Head::Objects(_))
            })
    }

    /// Whether the phrase with this end is the subject of a clause of its own: "... and the right bowl holds a lemon".
    pub(super) fn begins_clause(&self, phrase: &NounPhrase, end: usize) -> bool {
        self.finite_verb_at(end) || phrase.determiner == Determiner::Definite && self.object_begins(end)
    }

    /// Whether what follows a member of a list says that it is not with the host: "a bin containing a nut and a
    /// wrench in the back left corner", "... and three carrots in a row", "... and a mat with a knife on it".
    pub(super) fn stands_by_itself(&self, end: usize) -> bool {
        let at_table = place_at(self.tokens, end, &Self::is_table_word).is_some_and(|(places, length)| {
            !matches!(places[..], [RelationKind::AtLeft | RelationKind::AtRight])
                || (end..end + length)
                    .any(|p| matches!(self.word_at(p), Some("corner" | "edge" | "table" | "desk")))
        });
        let from_edge = read_length(self.lexicon.vocabulary, self.tokens, end)
            .is_some_and(|(_, length)| self.edge_at(end + length).is_some());
        at_table
            || from_edge
            || self.phrase_at(end).is_some()
            || matches!(self.word_at(end), Some("with" | "containing" | "holding" | "stacked"))
    }

    /// "two towers: one of three red cubes, one of two blue cubes". Whether the rule applies.
    pub(super) fn group_header(&mut self) -> bool {
        let count = quantity(self.lexicon, self.tokens, self.at).map_or(0, |(_, length)| length);
        let article = usize::from(count == 0 && matches!(self.word(0), Some("a" | "the" | "these")));
        let p = self.at + count + article;
        let Some(word) = self.word_at(p).filter(|_| count + article > 0) else { return false };
        let singular = self.lexicon.vocabulary.singular_of(word);
        let is_stack = matches!(singular.as_str(), "stack" | "tower");
        let group = match singular.as_str() {
            "pile" => Some(Group::Pile),
            _ => group_of(&singular),
        };
        let is_colon = self.is_colon(p + 1);
        if !(is_stack || group.is_some()) || !is_colon {
            return false;
        }
        self.claim_property(self.at..p + 1, Property::Arrangement, Vec::new());
        self.each_member = Some(group.filter(|_| !is_stack));
        self.at = p + 1;
        true
    }

    /// Whether a phrase is "one of three plates" after "a tower of two books".
    pub(super) fn is_like_before(&self, phrase: &NounPhrase) -> bool {
        let start = phrase.tokens.start;
        matches!(self.word_at(start), Some("one" | "another"))
            && self.word_at(start + 1) == Some("of")
            && phrase.count.is_some_and(|count| count[1] > 1)
            && self.subject.last().is_some_and(|&last| self.parsed.mentions[last].stacked)
    }

    /// Arranges a member of an announced list.
    pub(super) fn arrange_member(&mut self, mention: usize, like_before: bool) {
        if !self.is_several(mention) {
            return;
        }
        let tokens = self.parsed.mentions[mention].tokens.clone();
        match self.each_member {
            Some(Some(group)) => self.arrange(vec![mention], group, None, tokens),
            Some(None) => self.parsed.mentions[mention].stacked = true,
            None if like_before => self.parsed.mentions[mention].stacked = true,
            None => {}
        }
    }

    /// Keeps the relation of a verb for clauses without one.
    pub(super) fn keep_gap(&mut self, verb: Option<&str>, kind: LinkKind) {
        if matches!(verb, Some("has" | "have" | "holds" | "contains" | "carries")) {
            self.gap = Some(kind);
        }
    }

    /// Whether the token before is a pause.
    pub(super) fn follows_pause(&self) -> bool {
        self.at.checked_sub(1).is_some_and(|before| matches!(self.tokens[before], Token::Pause))
    }
}
