//! The rules in the order in which they are tried at a position.

use super::Parser;
use crate::text_parser::phrase::{Head, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::prepositions::{preposition_at, reciprocal_at};
use crate::text_parser::property::Property;
use crate::text_parser::quantity::quantity;
use crate::text_parser::tokens::Token;
use scene::RelationKind;

impl Parser<'_, '_> {
    /// Applies one rule; the caller skips a token if none applies.
    pub(super) fn step(&mut self) {
        match &self.tokens[self.at] {
            Token::End => {
                self.end_sentence();
                self.at += 1;
                return;
            }
            Token::Pause => {
                if self.listed_contents() {
                    return;
                }
                self.after_and = false;
                self.joined = false;
                self.chain = None;
                // "two mugs, one red and one blue, on a tray".
                let parts = self.split.is_none() && self.parts.len() > 1;
                self.all_members |= parts && self.subject.last() == self.parts.last();
                self.at += 1;
                return;
            }
            _ => {}
        }
        if self.table_size() || self.answer() || self.heading() || self.place_settings() {
            return;
        }
        if self.undecided() || self.before_main_clause() || self.conjunction() {
            return;
        }
        if self.remark() || self.replacement() || self.exception() || self.instruction() {
            return;
        }
        if self.perceived() {
            return;
        }
        let clause_start = std::mem::take(&mut self.clause_start);
        if self.people() || self.per_person() || self.corners() || self.of_each() || self.exclusion() {
            return;
        }
        if self.relative_clause()
            || self.surround()
            || self.examples()
            || self.group_header()
            || self.stated_count()
            || self.counted_part()
        {
            return;
        }
        if matches!(self.word(0), Some("and" | "plus" | "also" | "then" | "while" | "but" | "or")) {
            // "a teapot, and two cups on saucers" are two parts; "a, b, and c in a box" is one list.
            let parts = self.follows_pause() && self.subject.len() < 2;
            self.after_and = self.word(0) == Some("and") && !parts;
            self.chain = None;
            self.at += 1;
            self.clause_start = clause_start;
            return;
        }
        // "there is", "there are", "I want".
        if clause_start && self.introduction() {
            self.clause_start = true;
            return;
        }
        // "all in a basket".
        if matches!(self.word(0), Some("all" | "both"))
            && !self.subject.is_empty()
            && preposition_at(self.tokens, self.at + 1).is_some()
        {
            self.all_members = true;
            self.at += 1;
            return;
        }
        if self.flank() || self.for_each() || self.total() {
            return;
        }
        // "each with a fork", "with a fork each".
        if matches!(self.word(0), Some("each" | "both"))
            && matches!(
                self.word(1),
                Some("with" | "has" | "have" | "holding" | "containing" | "holds" | "contains")
            )
        {
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
            self.with_list(true);
            return;
        }
        if self.arrangement()
            || self.stated_distance()
            || self.distance(clause_start)
            || self.coordinates()
            || self.orientation()
            || self.state()
        {
            return;
        }
        if self.part_state() {
            return;
        }
        if self.with_at().is_some() {
            self.with_list(false);
            return;
        }
        if self.owned_side(clause_start) || self.place(clause_start) || self.bare_place(clause_start) {
            return;
        }
        // "on each other" stacks them; "next to each other" is the default for objects of one category.
        if let Some((kind, length)) = reciprocal_at(self.tokens, self.at) {
            self.reciprocal(kind, length);
            return;
        }
        if self.word(0) == Some("in") && self.attributes() {
            return;
        }
        if let Some((preposition, length)) = preposition_at(self.tokens, self.at) {
            self.prepositional(preposition, length, clause_start, None);
            return;
        }
        let start = self.at;
        if let Some(kind) = self.side_of_it() {
            self.relate_or_wait(kind, clause_start, start..self.at, None);
            return;
        }
        // "three mugs stacked on a tray".
        if matches!(self.word(0), Some("stacked" | "piled"))
            && let Some(&last) = self.subject.last()
        {
            self.parsed.mentions[last].stacked = true;
            self.claim_property(start..start + 1, Property::Arrangement, vec![last]);
            self.at += 1;
            return;
        }
        if self.attributes() || self.unread_verb() {
            return;
        }
        if let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at) {
            self.at = end;
            self.noun(phrase);
            return;
        }
        self.clause_start = clause_start && self.is_transparent();
        self.at += 1;
    }

    /// Whether a clause may still begin after this word.
    fn is_transparent(&self) -> bool {
        self.word(0).is_some_and(|word| {
            self.lexicon.vocabulary.grammar.ignorable.contains(word) && !matches!(word, "of" | "with")
        })
    }

    /// "two objects: a kettle and a jar".
    fn total(&mut self) -> bool {
        let Some((_, length)) = quantity(self.lexicon, self.tokens, self.at) else { return false };
        let noun =
            matches!(self.word(length), Some("objects" | "object" | "items" | "item" | "things" | "pieces"));
        let only = usize::from(self.word(length + 1) == Some("only"));
        let ends =
            matches!(self.tokens.get(self.at + length + 1 + only), None | Some(Token::Pause | Token::End));
        if !noun || !ends {
            return false;
        }
        let end = self.at + length + 1 + only;
        self.claim_property(self.at..end, Property::Count, Vec::new());
        self.at = end;
        true
    }

    fn introduction(&mut self) -> bool {
        let length = match self.word(0) {
            Some("there" | "here")
                if matches!(self.word(1), Some("is" | "are" | "should" | "must" | "will")) =>
            {
                2 + usize::from(self.word(2) == Some("be"))
            }
            Some("theres") => 1,
            _ => return false,
        };
        self.parsed.account.used(self.at..self.at + length);
        self.at += length;
        true
    }

    fn reciprocal(&mut self, kind: RelationKind, length: usize) {
        let tokens = self.at..self.at + length;
        match (kind, self.subject.last()) {
            (RelationKind::On, Some(&last)) => {
                self.parsed.mentions[last].stacked = true;
                self.claim_property(tokens, Property::Arrangement, vec![last]);
            }
            (_, Some(_)) => self.beside_each_other(kind, tokens),
            _ => {}
        }
        self.at += length;
    }

    /// "for four people", "set for two".
    fn people(&mut self) -> bool {
        if self.word(0) != Some("for") {
            return false;
        }
        let Some(([low, _], length)) = quantity(self.lexicon, self.tokens, self.at + 1) else {
            return false;
        };
        let after = self.word(1 + length);
        let people = after.is_some_and(is_people);
        let is_word =
            matches!(self.tokens.get(self.at + 1 + length), Some(Token::Word(_) | Token::Number(_)));
        let ends = !is_word || matches!(after, Some("with" | "and" | "on" | "in" | "at"));
        if !(people || ends) || low == 0 || low > 12 {
            return false;
        }
        self.parsed.people = Some(low);
        let before = self.at.checked_sub(1).and_then(|before| self.word_at(before));
        self.parsed.is_set_for_people |= matches!(before, Some("set" | "laid"));
        let end = self.at + 1 + length + usize::from(people);
        self.claim_property(self.at..end, Property::People, Vec::new());
        self.at = end;
        true
    }

    /// "each person has a plate", "a plate per guest", "for every person".
    fn per_person(&mut self) -> bool {
        let start = usize::from(matches!(self.word(0), Some("for" | "at")));
        let each = matches!(self.word(start), Some("each" | "every" | "per"))
            && self.word(start + 1).is_some_and(|w| is_people(w) || matches!(w, "place" | "seat"));
        if !each {
            return false;
        }
        let mut end = self.at + start + 2;
        if matches!(self.word_at(end), Some("setting")) {
            end += 1;
        }
        let gets = matches!(self.word_at(end), Some("has" | "gets" | "needs" | "have" | "receives" | "with"));
        if self.parsed.people.is_none() && !self.people_ahead(end) {
            self.report(self.at..end, scene::text_account::UnrecognizedReason::NoReferent);
        } else {
            self.claim_property(self.at..end, Property::People, Vec::new());
        }
        if gets || self.subject.is_empty() {
            self.parsed.account.used(end..end + usize::from(gets));
            end += usize::from(gets);
            self.subject.clear();
            self.pending_per_person = true;
        } else {
            for mention in self.subject.clone() {
                self.parsed.mentions[mention].per_person = true;
            }
        }
        self.at = end;
        true
    }

    /// "each corner of the table has a candle", "a candle in each corner".
    fn corners(&mut self) -> bool {
        let start = usize::from(matches!(self.word(0), Some("in" | "at" | "on")));
        // "glasses at the four corners of the table".
        let all = start == 1
            && self.word(1) == Some("the")
            && (self.word(2) == Some("corners")
                || self.word(2) == Some("four") && self.word(3) == Some("corners"));
        if !all && !matches!(self.word(start), Some("each" | "every" | "all")) {
            return false;
        }
        let mut p = self.at + start + 1;
        while matches!(self.word_at(p), Some("the" | "four" | "of")) {
            p += 1;
        }
        if !matches!(self.word_at(p), Some("corner" | "corners")) {
            return false;
        }
        p += 1;
        // "at the corners of the tray" are not those of the table.
        let owner = p + 1 + usize::from(matches!(self.word_at(p + 1), Some("the" | "this" | "a")));
        let of_other = self.word_at(p) == Some("of") && !self.word_at(owner).is_some_and(Self::is_table_word);
        let counted =
            self.attached().iter().any(|&m| self.parsed.mentions[m].count.is_some_and(|c| c != [4, 4]));
        if all && (of_other || counted) {
            return false;
        }
        if self.word_at(p) == Some("of") {
            p += 1;
            while self.word_at(p).is_some_and(|word| word == "the" || Self::is_table_word(word)) {
                p += 1;
            }
        }
        let has = matches!(self.word_at(p), Some("has" | "holds" | "have" | "contains" | "carries"));
        p += usize::from(has);
        self.claim_property(self.at..p, Property::Position, self.attached());
        self.at = p;
        match self.attached()[..] {
            [mention] if !has => {
                self.parsed.mentions[mention].corners = true;
                self.parsed.mentions[mention].count = Some([4, 4]);
            }
            _ => self.pending_corners = true,
        }
        true
    }

    /// "bananas and pears, two of each".
    fn of_each(&mut self) -> bool {
        let Some((range, length)) = quantity(self.lexicon, self.tokens, self.at) else { return false };
        let of = usize::from(self.word(length) == Some("of"));
        let after = self.at + length + of;
        let each = self.word_at(after) == Some("each") || (self.word_at(after - 1) == Some("each"));
        let of_before = self.word_at(after - 1) == Some("of");
        if !each || !of_before || self.subject.is_empty() {
            return false;
        }
        let kind = matches!(self.word_at(after + 1), Some("kind" | "type" | "color" | "sort"));
        let end = after + 1 + usize::from(kind);
        for mention in self.subject.clone() {
            self.parsed.mentions[mention].count = Some(range);
            self.parsed.mentions[mention].plural = true;
        }
        self.claim_property(self.at..end, Property::Count, self.subject.clone());
        self.at = end;
        // "bananas and pears, two of each, in a bowl".
        self.all_members = true;
        true
    }

    /// "a tray with one glass per person": the members of a list, repeated for every person.
    pub(super) fn per_person_after(&mut self, items: &[usize]) {
        let start = usize::from(self.word(0) == Some("for"));
        let each = matches!(self.word(start), Some("per" | "each" | "every"));
        if !each || !self.word(start + 1).is_some_and(is_people) {
            return;
        }
        let end = self.at + start + 2;
        if self.parsed.people.is_none() && !self.people_ahead(end) {
            self.report(self.at..end, scene::text_account::UnrecognizedReason::NoReferent);
        } else {
            self.claim_property(self.at..end, Property::People, items.to_vec());
        }
        for &item in items {
            self.parsed.mentions[item].per_person = true;
        }
        self.at = end;
    }

    /// Whether a later part of the text states the number of people.
    fn people_ahead(&self, from: usize) -> bool {
        (from..self.tokens.len())
            .take(60)
            .any(|p| self.word_at(p) == Some("for") && self.word_at(p + 2).is_some_and(is_people))
    }
}

fn is_people(word: &str) -> bool {
    phrases().agent.people.has(word)
}

/// Whether a head is an object or refers to one.
pub(super) fn is_object(head: &Head) -> bool {
    matches!(head, Head::Objects(_) | Head::Unknown(_))
}
