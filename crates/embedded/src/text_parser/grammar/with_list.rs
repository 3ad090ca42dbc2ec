//! With-lists: "a plate with a fork on the left and a knife".

use super::steps::{FLANKS, is_object};
use super::{Link, LinkKind, Parser, PendingRelation, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::prepositions::preposition_at;
use crate::text_parser::supports::is_carrier;
use crate::text_parser::tokens::{Token, match_phrase};
use catalog::Affordance;
use scene::RelationKind;

/// Maximum number of members of a list that is read ahead.
const MAX_MEMBERS: usize = 12;

impl Parser<'_, '_> {
    pub(super) fn with_at(&self) -> Option<usize> {
        match self.word(0)? {
            "with" | "containing" | "holding" | "carrying" | "featuring" | "including" => Some(1),
            "filled" | "topped" | "loaded" | "full" if matches!(self.word(1), Some("with" | "of")) => Some(2),
            "surrounded" | "flanked" | "accompanied" if self.word(1) == Some("by") => Some(2),
            "has" | "have" | "holds" | "contains" | "carries" if !self.subject.is_empty() => Some(1),
            "which" | "that"
                if matches!(self.word(1), Some("has" | "holds" | "contains" | "carries"))
                    && !self.subject.is_empty() =>
            {
                Some(2)
            }
            _ => None,
        }
    }

    /// "with a fork and a knife": mentions linked to the last one.
    pub(super) fn with_list(&mut self, each: bool) {
        let last = self.word(self.with_at().unwrap_or(1).saturating_sub(1));
        let kind = match self.word(0) {
            Some("surrounded") => LinkKind::Relation(RelationKind::Around),
            Some("flanked") => LinkKind::Flank,
            Some("topped" | "carrying" | "carries") => LinkKind::Relation(RelationKind::On),
            Some("filled" | "full" | "containing" | "contains") => LinkKind::Relation(RelationKind::In),
            _ if matches!(last, Some("contains")) => LinkKind::Relation(RelationKind::In),
            _ => LinkKind::With,
        };
        let with = self.at..self.at + self.with_at().unwrap_or(1);
        self.at = with.end;
        let mut each = each;
        let hosts: Vec<usize> = if each && self.subject.len() > 1 && self.all_singular() {
            self.subject.clone()
        } else {
            self.subject.last().copied().into_iter().collect()
        };
        // "a desk with ...", or a sentence that begins with "with": an ordinary list.
        let Some(&host) = hosts.last() else { return };
        let whole = self.whole_list(host);
        let mut first = true;
        let mut items: Vec<(usize, LinkKind)> = Vec::new();
        let mut closed = false;
        while let Some((mut phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at) {
            if matches!(phrase.head, Head::It | Head::Them | Head::All) {
                break;
            }
            if phrase.is_table() && first {
                return;
            }
            if phrase.negated {
                self.at = end;
                self.exclude(phrase);
                break;
            }
            if phrase.head == Head::One {
                match self.completed_ahead(&phrase) {
                    Some(copy) => phrase = copy,
                    None => break,
                }
            }
            if phrase.determiner == Determiner::Definite {
                phrase.determiner = Determiner::New;
            }
            let open_plural = phrase.count.is_none() && phrase.plural;
            let of = self.word_at(end) == Some("of");
            self.at = end;
            let list = match self.refer(phrase, false) {
                Referent::Mentions(list) => list,
                _ => Vec::new(),
            };
            if of && let Some(&vessel) = list.last() {
                self.contents_of(vessel);
            }
            let start = self.at;
            let flanks = FLANKS.iter().find_map(|phrase| match_phrase(self.tokens, self.at, phrase));
            let kind = match (flanks, self.side_of_host()) {
                (Some(length), _) if self.word(length) != Some("of") => {
                    let claim =
                        Claimed::Relation { kind: RelationKind::NextTo, from: list.clone(), to: vec![host] };
                    self.parsed.account.claim(start..start + length, claim);
                    self.at = start + length;
                    for &item in &list {
                        self.parsed.mentions[item].count.get_or_insert([2, 2]);
                    }
                    LinkKind::Flank
                }
                (_, Some(side)) if kind == LinkKind::With => {
                    let claim = Claimed::Relation { kind: side, from: list.clone(), to: vec![host] };
                    self.parsed.account.claim(start..self.at, claim);
                    LinkKind::WithAtSide(side)
                }
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
                self.parsed.account.used(self.at..self.at + 1);
                self.at += 1;
                each = true;
            }
            let comma = matches!(self.tokens.get(self.at), Some(Token::Pause));
            let and = self.word(0) == Some("and") || (comma && self.word(1) == Some("and"));
            let ahead = 1 + usize::from(comma && self.word(1) == Some("and"));
            let inside = whole.is_some_and(|end| self.at < end);
            let continues = match noun_phrase(self.lexicon, self.tokens, self.at + ahead) {
                Some((next, _)) if inside && (is_object(&next.head) || next.head == Head::One) => true,
                // "and next to it a lamp" begins another clause.
                Some((next, next_end)) if matches!(next.head, Head::Objects(_) | Head::One) => {
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
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
            each = true;
        }
        if !items.is_empty() {
            self.parsed.account.used(with);
        }
        // "a tray with a cup, a spoon and a plate on it": the relation of the last member is that of all.
        let shared = whole.and_then(|_| self.shared_relation(&items, host));
        for &(item, kind) in &items {
            let tied = self.parsed.links.iter().any(|link| link.from == item && hosts.contains(&link.to));
            let kind = shared.map_or(kind, LinkKind::Relation);
            for (k, &host) in hosts.iter().enumerate() {
                if item == host {
                    continue;
                }
                if each {
                    let each_host = if k == 0 { item } else { self.duplicate(item) };
                    self.parsed.mentions[each_host].each_of = Some(host);
                    if !tied {
                        self.parsed.links.push(Link::new(each_host, kind, host));
                    }
                } else if !tied {
                    self.parsed.links.push(Link::new(item, kind, host));
                }
            }
        }
        self.salient = Some(host);
    }

    /// The support of the last member on the host, if the text states it.
    fn shared_relation(&self, items: &[(usize, LinkKind)], host: usize) -> Option<RelationKind> {
        let (last, _) = items.last()?;
        self.parsed.links.iter().find_map(|link| match link.kind {
            LinkKind::Relation(kind) if link.from == *last && link.to == host => Some(kind),
            _ => None,
        })
    }

    /// The end of the list at the current position if all of it belongs to the host: its last member has a relation to
    /// the host ("on it"), or the list ends the sentence and the host is a vessel or a board.
    fn whole_list(&self, host: usize) -> Option<usize> {
        let mut p = self.at;
        let mut and = false;
        // The end of the last member, if the list was closed with "and" before it.
        let mut closed = None;
        for members in 1..=MAX_MEMBERS {
            let Some((phrase, mut end)) = noun_phrase(self.lexicon, self.tokens, p) else { break };
            if !(is_object(&phrase.head) || phrase.head == Head::One) || phrase.is_table() {
                break;
            }
            if self.word_at(end) == Some("of") {
                end = noun_phrase(self.lexicon, self.tokens, end + 1)?.1;
            }
            let on_it = preposition_at(self.tokens, end).is_some_and(|(preposition, length)| {
                let pronoun = matches!(self.word_at(end + length), Some("it" | "them"));
                let alone = preposition.may_stand_alone
                    && matches!(self.tokens.get(end + length), None | Some(Token::Pause | Token::End));
                pronoun || alone && preposition.kind.is_support()
            });
            if on_it {
                return (members > 1 && and).then_some(end);
            }
            let comma = matches!(self.tokens.get(end), Some(Token::Pause));
            let next = end + usize::from(comma);
            if and && members > 2 {
                closed = Some(end);
            }
            if matches!(self.tokens.get(end), None | Some(Token::End)) {
                break;
            }
            if self.word_at(next) == Some("and") {
                if and {
                    break;
                }
                and = true;
                p = next + 1;
            } else if comma && !and {
                p = next;
            } else if comma {
                break;
            } else {
                return None;
            }
        }
        let only = self.subject.len() == 1 && self.parsed.mentions.len() == 1 + host && self.carries(host);
        closed.filter(|_| only)
    }

    fn carries(&self, host: usize) -> bool {
        match self.parsed.mentions[host].meanings.first() {
            Some(Meaning::Category(index)) => {
                let category = &self.lexicon.categories[*index];
                category.affords(Affordance::Container) || is_carrier(category)
            }
            _ => false,
        }
    }

    fn place_word_at(&self, at: usize) -> bool {
        matches!(
            self.word_at(at),
            Some("in" | "on" | "to" | "at" | "inside" | "atop" | "next" | "beside" | "behind" | "under")
        )
    }

    fn all_singular(&self) -> bool {
        self.subject.iter().all(|&m| !self.parsed.mentions[m].plural)
    }

    pub(super) fn duplicate(&mut self, mention: usize) -> usize {
        let copy = self.parsed.mentions[mention].clone();
        self.parsed.mentions.push(copy);
        self.parsed.mentions.len() - 1
    }

    /// Prepositions inside a with-list relate the listed item to its host: "a spoon in it", "a fork to the left".
    fn details_of_with(&mut self, items: &[usize], host: usize) {
        let start = self.at;
        if let Some(kind) = self.side_of_it() {
            self.relate_items(items, (kind, false), &[host], start..self.at);
            return;
        }
        let Some((preposition, length)) = preposition_at(self.tokens, self.at) else { return };
        let after = self.at + length;
        let tokens = start..after;
        let direction = (preposition.kind, preposition.inverse);
        match noun_phrase(self.lexicon, self.tokens, after) {
            Some((phrase, end)) if matches!(phrase.head, Head::It | Head::Them) => {
                self.parsed.account.used(after..end);
                self.at = end;
                if phrase.determiner == Determiner::Each {
                    for &item in items {
                        self.parsed.mentions[item].each_of = Some(host);
                    }
                }
                self.relate_items(items, direction, &[host], tokens);
            }
            Some((phrase, end))
                if is_object(&phrase.head)
                    && !phrase.is_table()
                    && (!preposition.may_stand_alone || phrase.determiner == Determiner::Definite) =>
            {
                // "with a mug on the coaster".
                self.at = end;
                if let Referent::Mentions(targets) = self.refer(phrase, true) {
                    self.relate_items(items, direction, &targets, tokens);
                }
            }
            None if preposition.may_stand_alone => {
                self.at = after;
                self.relate_items(items, direction, &[host], tokens);
            }
            _ => {}
        }
    }

    fn relate_items(
        &mut self,
        items: &[usize],
        (kind, inverse): (RelationKind, bool),
        targets: &[usize],
        tokens: std::ops::Range<usize>,
    ) {
        for &item in items {
            for &target in targets {
                let (second, distance_m) = (None, None);
                let relation = PendingRelation {
                    kind,
                    inverse,
                    targets: vec![target],
                    second,
                    distance_m,
                    tokens: tokens.clone(),
                };
                self.relate(item, &relation, target);
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
