//! With-lists: "a plate with a fork on the left and a knife".

use super::{Link, LinkKind, Parser, Referent};
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::prepositions::preposition_at;
use crate::text_parser::tokens::Token;
use scene::RelationKind;

impl Parser<'_, '_> {
    /// "with a fork and a knife": mentions linked to the last one.
    pub(super) fn with_list(&mut self, each: bool) {
        let kind = match self.word(0) {
            Some("surrounded") => LinkKind::Relation(RelationKind::Around),
            Some("flanked") => LinkKind::Flank,
            Some("topped" | "carrying" | "carries") => LinkKind::Relation(RelationKind::On),
            Some("filled" | "full" | "containing" | "contains") => LinkKind::Relation(RelationKind::In),
            _ => LinkKind::With,
        };
        self.at += self.with_at().unwrap_or(1);
        let mut each = each;
        let hosts: Vec<usize> = if each && self.subject.len() > 1 && self.all_singular() {
            self.subject.clone()
        } else {
            self.subject.last().copied().into_iter().collect()
        };
        // "a desk with ...", or a sentence that begins with "with": an ordinary list.
        let Some(&host) = hosts.last() else { return };
        let mut first = true;
        let mut items: Vec<(usize, LinkKind)> = Vec::new();
        let mut closed = false;
        while let Some((mut phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at) {
            if matches!(phrase.head, Head::It | Head::Them) {
                break;
            }
            if matches!(&phrase.head, Head::Objects(meanings) if matches!(meanings[0], Meaning::Table(_)))
                && first
            {
                return;
            }
            if phrase.determiner == Determiner::Definite {
                phrase.determiner = Determiner::New;
            }
            let open_plural = phrase.count.is_none() && phrase.plural;
            let of = self.tokens.get(end).and_then(Token::word) == Some("of");
            self.at = end;
            let list = match self.refer(phrase, false) {
                Referent::Mentions(list) => list,
                _ => Vec::new(),
            };
            if of && let Some(&vessel) = list.last() {
                self.contents_of(vessel);
            }
            let start = self.at;
            let kind = match self.side_of_host() {
                Some(side) if kind == LinkKind::With => LinkKind::WithAtSide(side),
                _ => kind,
            };
            for &item in &list {
                self.parsed.mentions[item].contents = open_plural;
                items.push((item, kind));
            }
            self.details_of_with(&list, host);
            let has_place = self.at > start;
            first = false;
            // "a fork each".
            if self.word(0) == Some("each") {
                self.at += 1;
                each = true;
            }
            let comma = matches!(self.tokens.get(self.at), Some(Token::Pause));
            let and = self.word(0) == Some("and") || (comma && self.word(1) == Some("and"));
            let ahead = 1 + usize::from(comma && self.word(1) == Some("and"));
            let continues = match noun_phrase(self.lexicon, self.tokens, self.at + ahead) {
                // "and next to it a lamp" begins another clause.
                Some((next, next_end)) if matches!(next.head, Head::Objects(_)) => {
                    // "a mug with a spoon in it and two eggs": a member without a relation of its own ends the list.
                    if has_place && !each && !self.place_word_at(next_end) {
                        break;
                    }
                    let bare = next.count.is_none() && next.plural;
                    // "each with a fork and a knife, four glasses": "and" closed the list.
                    (and && !comma) || (comma && bare && open_plural) || (comma && each && !closed)
                }
                _ => false,
            };
            if !continues {
                break;
            }
            closed |= and;
            self.at += ahead;
        }
        if self.word(0) == Some("each") {
            self.at += 1;
            each = true;
        }
        for &(item, kind) in &items {
            let tied = self.parsed.links.iter().any(|link| link.from == item && hosts.contains(&link.to));
            for (k, &host) in hosts.iter().enumerate() {
                if each {
                    let each_host = if k == 0 { item } else { self.duplicate(item) };
                    self.parsed.mentions[each_host].each_of = Some(host);
                    if !tied {
                        self.parsed.links.push(Link { from: each_host, kind, to: host });
                    }
                } else if !tied {
                    self.parsed.links.push(Link { from: item, kind, to: host });
                }
            }
        }
        self.salient = Some(host);
    }

    fn place_word_at(&self, at: usize) -> bool {
        let word = self.tokens.get(at).and_then(Token::word);
        matches!(
            word,
            Some("in" | "on" | "to" | "at" | "inside" | "atop" | "next" | "beside" | "behind" | "under")
        )
    }

    fn all_singular(&self) -> bool {
        self.subject.iter().all(|&m| !self.parsed.mentions[m].plural)
    }

    fn duplicate(&mut self, mention: usize) -> usize {
        let copy = self.parsed.mentions[mention].clone();
        self.parsed.mentions.push(copy);
        self.parsed.mentions.len() - 1
    }

    /// Prepositions inside a with-list relate the listed item to its host: "a spoon in it", "a fork to the left".
    fn details_of_with(&mut self, items: &[usize], host: usize) {
        if let Some(kind) = self.side_of_it() {
            for &item in items {
                self.link(item, kind, false, host);
            }
            return;
        }
        if let Some((preposition, length)) = preposition_at(self.tokens, self.at) {
            let after = self.at + length;
            match noun_phrase(self.lexicon, self.tokens, after) {
                Some((phrase, end)) if matches!(phrase.head, Head::It | Head::Them) => {
                    self.at = end;
                    for &item in items {
                        if phrase.determiner == Determiner::Each {
                            self.parsed.mentions[item].each_of = Some(host);
                        }
                        self.link(item, preposition.kind, preposition.inverse, host);
                    }
                }
                Some((phrase, end))
                    if matches!(phrase.head, Head::Objects(_))
                        && phrase.determiner != Determiner::New
                        && !(preposition.may_stand_alone && phrase.determiner == Determiner::Each) =>
                {
                    // "with a mug on the coaster".
                    self.at = end;
                    if let Referent::Mentions(targets) = self.refer(phrase, true) {
                        for &item in items {
                            for &target in &targets {
                                self.link(item, preposition.kind, preposition.inverse, target);
                            }
                        }
                    }
                }
                None if preposition.may_stand_alone => {
                    self.at = after;
                    for &item in items {
                        self.link(item, preposition.kind, preposition.inverse, host);
                    }
                }
                Some((phrase, end))
                    if matches!(phrase.head, Head::Objects(_)) && !preposition.may_stand_alone =>
                {
                    self.at = end;
                    if let Referent::Mentions(targets) = self.refer(phrase, true) {
                        for &item in items {
                            for &target in &targets {
                                self.link(item, preposition.kind, preposition.inverse, target);
                            }
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// "on the left" in "a plate with a fork on the left": relative to the plate, not to the table.
    fn side_of_host(&mut self) -> Option<RelationKind> {
        let of_host = matches!(self.word(0), Some("to" | "on" | "at")) && self.word(1) == Some("the");
        let kind = match self.word(2).filter(|_| of_host)? {
            "left" => RelationKind::LeftOf,
            "right" => RelationKind::RightOf,
            _ => return None,
        };
        let length = 3 + usize::from(matches!(self.word(3), Some("side" | "hand")));
        if self.word(length) == Some("of") {
            return None;
        }
        self.at += length;
        Some(kind)
    }
}
