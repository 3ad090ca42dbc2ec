//! With-lists: "a plate with a fork on the left and a knife".

use std::ops::Range;

use super::flanks::FLANKS;
use super::steps::is_object;
use super::{Link, LinkKind, Parser, PendingRelation, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::prepositions::preposition_at;
use crate::text_parser::supports::is_carrier;
use crate::text_parser::tokens::{Token, match_phrase};
use catalog::Affordance;
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

/// Maximum number of members of a list that is read ahead.
const MAX_MEMBERS: usize = 12;

impl Parser<'_, '_> {
    pub(super) fn with_at(&self) -> Option<usize> {
        match self.word(0)? {
            "with" | "containing" | "holding" | "carrying" | "featuring" | "including" => Some(1),
            "filled" | "topped" | "loaded" | "full" if matches!(self.word(1), Some("with" | "of")) => Some(2),
            "surrounded" | "flanked" | "accompanied" if self.word(1) == Some("by") => Some(2),
            "has" | "have" | "holds" | "contains" | "carries" | "gets" | "receives"
                if !self.subject.is_empty() =>
            {
                Some(1)
            }
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
            Some("holding" | "holds") => LinkKind::At,
            _ if matches!(last, Some("contains")) => LinkKind::Relation(RelationKind::In),
            _ => LinkKind::With,
        };
        let with = self.at..self.at + self.with_at().unwrap_or(1);
        self.keep_gap(last, kind);
        self.at = with.end;
        let Some(&host) = self.subject.last() else { return };
        // "a bowl next to a plate with two cookies": the plate has them.
        let nearer = self.last_target.filter(|(target, end)| {
            *end == with.start && kind == LinkKind::With && self.carries(*target) && !each
        });
        let host = nearer.filter(|_| !self.has_support(host)).map_or(host, |(target, _)| target);
        self.list_of(host, kind, with, each);
    }

    /// The list at the current position, whose members have a relation to the host.
    pub(super) fn list_of(&mut self, host: usize, kind: LinkKind, with: Range<usize>, each: bool) {
        let mut each = each || self.each_subject == Some(host);
        let hosts: Vec<usize> = if each && self.subject.len() > 1 && self.all_singular() {
            self.subject.clone()
        } else {
            vec![host]
        };
        let whole = self.whole_list(host);
        let mut first = true;
        let mut items: Vec<(usize, LinkKind)> = Vec::new();
        let mut closed = false;
        // Objects that the text has as many of as of the host.
        let mut given: Vec<usize> = Vec::new();
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
            if !items.is_empty() && self.begins_clause(&phrase, end) {
                break;
            }
            if phrase.determiner == Determiner::Definite && phrase.selector.is_none() {
                phrase.determiner = Determiner::New;
            }
            let open_plural = phrase.count.is_none() && phrase.plural;
            let of = self.word_at(end) == Some("of");
            self.at = end;
            let list = match self.distributed(&phrase, host).filter(|_| each) {
                Some(known) => {
                    given.push(known);
                    vec![known]
                }
                None => match self.refer(phrase, false) {
                    Referent::Mentions(list) => list,
                    _ => Vec::new(),
                },
            };
            if of && let Some(&vessel) = list.last() {
                self.contents_of(vessel);
            }
            let start = self.at;
            let flanks = FLANKS.iter().filter_map(|phrase| match_phrase(self.tokens, self.at, phrase)).max();
            let kind = match (flanks, self.side_of_host()) {
                (Some(length), _) if self.word(length) != Some("of") => {
                    let claim =
                        Claimed::Relation { kind: RelationKind::NextTo, from: list.clone(), to: vec![host] };
                    self.parsed.account.claim(start..start + length, claim);
                    self.at = start + length;
                    for &item in &list {
                        self.parsed.mentions[item].doubled();
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
            // "a tray with two glasses upside down".
            if let Some((state, length)) = self.state_at(self.at)
                && !list.is_empty()
                && self.lexicon.longest_at(self.tokens, self.at + length).is_none()
                && self.word(length) != Some("of")
            {
                let tokens = self.at..self.at + length;
                self.at = tokens.end;
                self.set_states(&list, &state, tokens);
            }
            self.details_of_with(&list, host);
            let has_place = self.at > start;
            first = false;
            self.per_person_after(&list);
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
                Some((next, next_end)) if self.begins_clause(&next, next_end) => false,
                Some((_, next_end)) if !each && self.stands_by_itself(next_end) => false,
                // "and next to it a lamp" begins another clause.
                Some((next, next_end)) if matches!(next.head, Head::Objects(_) | Head::One) => {
                    // "a mug with a spoon in it and two eggs": a member without a relation to the host ends the list.
                    let at_host = self.place_word_at(next_end) && !self.is_beside_another(next_end, host);
                    if has_place && !each && !at_host {
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
        // "a bowl that is empty and full of apples".
        let is_empty = self.stated.iter().any(|(m, state)| *m == host && state == "empty");
        if !items.is_empty() && is_empty && kind == LinkKind::Relation(RelationKind::In) {
            self.report(with, UnrecognizedReason::Contradiction);
        } else if !items.is_empty() {
            let ignorable = &self.lexicon.vocabulary.grammar.ignorable;
            let is_silent =
                with.clone().all(|at| self.word_at(at).is_some_and(|word| ignorable.contains(word)));
            if is_silent {
                self.parsed.account.used(with);
            } else {
                let from = items.iter().map(|(item, _)| *item).collect();
                self.parsed.account.claim(with, Claimed::Linked { from, to: hosts.clone() });
            }
        }
        // "a tea set with a teapot and four cups": the set is its parts.
        if items.len() > 1 && kind == LinkKind::With && self.parsed.mentions[host].words.ends_with(" set") {
            self.parsed.mentions[host].count = Some([0, 0]);
            self.parsed.account.claims.retain(|claim| claim.meaning != Claimed::Object(host));
            self.subject.retain(|member| *member != host);
            self.subject.extend(items.iter().map(|(item, _)| *item));
            self.salient = items.last().map(|(item, _)| *item);
            return;
        }
        // "a tray with a cup, a spoon and a plate on it": the relation of the last member is that of all.
        let shared = whole.and_then(|_| self.shared_relation(&items, host));
        for (number, &(item, kind)) in items.iter().enumerate() {
            // "flanked by a fork and a knife": one on each side.
            let kind = match kind {
                LinkKind::Flank if items.len() == 2 && !self.is_several(item) => {
                    LinkKind::Relation([RelationKind::LeftOf, RelationKind::RightOf][number])
                }
                kind => kind,
            };
            let tied = self.parsed.links.iter().any(|link| link.from == item && hosts.contains(&link.to));
            let kind = shared.map_or(kind, LinkKind::Relation);
            for (k, &host) in hosts.iter().enumerate() {
                if item == host {
                    continue;
                }
                if each && !given.contains(&item) {
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

    /// "three plates and three forks, each plate with a fork": one of the objects that the text has as many of.
    fn distributed(&mut self, phrase: &NounPhrase, host: usize) -> Option<usize> {
        let Head::Objects(meanings) = &phrase.head else { return None };
        let count = self.parsed.mentions[host].count.filter(|count| count[0] == count[1] && count[0] > 1)?;
        let known = (0..self.parsed.mentions.len()).rev().find(|&m| {
            let mention = &self.parsed.mentions[m];
            m != host
                && phrase.count == Some([1, 1])
                && mention.count == Some(count)
                && mention.meanings.iter().any(|meaning| meanings.contains(meaning))
        })?;
        self.parsed.account.claim(phrase.tokens.clone(), Claimed::Object(known));
        Some(known)
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

    /// Whether the mention is on or in another one.
    fn has_support(&self, mention: usize) -> bool {
        let supports = |kind: LinkKind| matches!(kind, LinkKind::Relation(kind) if kind.is_support());
        self.parsed.links.iter().any(|link| link.from == mention && supports(link.kind))
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

    /// Whether a list after a colon names the contents of the host.
    pub(super) fn holds_others(&self, host: usize) -> bool {
        match self.parsed.mentions[host].meanings.first() {
            Some(Meaning::Category(index)) => {
                let category = &self.lexicon.categories[*index];
                category.affords(Affordance::Container) && category.group != "vessel" && !is_carrier(category)
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

    /// "behind a plate", "to the left of a knife" at `at`: a place beside an object other than the host.
    fn is_beside_another(&self, at: usize, host: usize) -> bool {
        let Some((_, length)) = preposition_at(self.tokens, at) else { return false };
        let Some((phrase, _)) = noun_phrase(self.lexicon, self.tokens, at + length) else { return false };
        match &phrase.head {
            Head::Objects(meanings) => {
                let known = &self.parsed.mentions[host].meanings;
                !phrase.is_table() && !meanings.iter().any(|meaning| known.contains(meaning))
            }
            _ => false,
        }
    }

    fn all_singular(&self) -> bool {
        self.subject.iter().all(|&m| !self.parsed.mentions[m].plural)
    }

    pub(super) fn duplicate(&mut self, mention: usize) -> usize {
        let copy = self.parsed.mentions[mention].clone();
        self.add_part(mention, copy, usize::MAX)
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
        // "a kettle opposite a teapot with a tray in between", "with a spoon between them".
        if preposition.two_targets {
            let pronoun = noun_phrase(self.lexicon, self.tokens, after)
                .filter(|(phrase, _)| matches!(phrase.head, Head::Them))
                .map(|(_, end)| end);
            let alone = preposition.may_stand_alone && self.word_at(after).is_none_or(|word| word == "and");
            if let (true, Some((first, second))) = (pronoun.is_some() || alone, self.pair_before(items)) {
                self.at = pronoun.unwrap_or(after);
                self.parsed.account.used(start..self.at);
                self.relate_between(items, first, second, tokens);
                return;
            }
        }
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
            // "a pot with a lid on".
            None if preposition.may_stand_alone
                || preposition.kind.is_support() && self.word_at(after).is_none_or(|word| word == "and") =>
            {
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
        tokens: Range<usize>,
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
