//! Inventories with answers ("mug: yes, plate: no"), what is no longer there, headings of what there is, and places of
//! a setting ("place settings for two: plate, fork left, knife right").

use super::{Link, LinkKind, Parser, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::phrases::{PhraseList, phrases};
use crate::text_parser::property::Property;
use crate::text_parser::quantity::quantity;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::RelationKind;

impl Parser<'_, '_> {
    fn ends_at(&self, at: usize) -> bool {
        matches!(self.tokens.get(at), None | Some(Token::Pause | Token::End))
    }

    /// "(mug) yes", "(plate): no" after an object. Whether the rule applies.
    pub(super) fn answer(&mut self) -> bool {
        let Some(&last) = self.subject.last() else { return false };
        let noun_end = self.parsed.mentions[last].tokens.end;
        let pause = usize::from(self.follows_pause());
        if noun_end + pause != self.at || pause == 1 && !self.is_colon(self.at - 1) {
            return false;
        }
        let longest = |list: &PhraseList| {
            list.longest_at(self.tokens, self.at).filter(|length| self.ends_at(self.at + length))
        };
        let (no, yes) = (longest(&phrases().answer.no), longest(&phrases().answer.yes));
        let Some(length) = no.or(yes) else { return false };
        let tokens = self.at..self.at + length;
        if no.is_some() {
            let mention = &mut self.parsed.mentions[last];
            mention.count = Some([0, 0]);
            let meanings = mention.meanings.clone();
            self.parsed.account.claim(tokens.clone(), Claimed::Exclusion(meanings.clone()));
            self.parsed.excluded.extend(meanings);
            self.subject.pop();
        } else {
            self.parsed.account.claim(tokens.clone(), Claimed::Object(last));
        }
        self.at = tokens.end;
        true
    }

    /// "what remains: ..." Whether the rule applies.
    pub(super) fn heading(&mut self) -> bool {
        let Some(length) = phrases().answer.headings.longest_at(self.tokens, self.at) else { return false };
        let is = usize::from(matches!(self.word(length), Some("is" | "are")));
        if !self.is_colon(self.at + length) && is == 0 {
            return false;
        }
        self.parsed.account.used(self.at..self.at + length + is);
        self.at += length + is;
        true
    }

    /// "place settings for two: plate, fork left, knife right": every person has each object, and a side is that of
    /// the first object. Whether the rule applies.
    pub(super) fn place_settings(&mut self) -> bool {
        let opener = phrases().answer.settings.longest_at(self.tokens, self.at);
        let Some(length) = opener else { return false };
        let Some(([people, _], more)) = quantity(self.lexicon, self.tokens, self.at + length) else {
            return false;
        };
        let mut colon = self.at + length + more;
        colon += usize::from(matches!(self.word_at(colon), Some("people" | "persons" | "guests")));
        let listed = noun_phrase(self.lexicon, self.tokens, colon + 1);
        if !self.is_colon(colon) || !(1..=12).contains(&people) || listed.is_none() {
            return false;
        }
        self.parsed.people = Some(people);
        self.claim_property(self.at..colon, Property::People, Vec::new());
        self.at = colon + 1;
        let mut host: Option<usize> = None;
        while let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at) {
            if phrase.negated || phrase.is_table() {
                break;
            }
            let own = phrase.count.unwrap_or([1, 1]);
            self.at = end;
            let Referent::Mentions(list) = self.refer(phrase, false) else { break };
            for &item in &list {
                self.subject.push(item);
                match host {
                    None => {
                        self.parsed.mentions[item].count = Some(own.map(|count| count * people));
                        host = Some(item);
                    }
                    Some(host) => {
                        self.parsed.mentions[item].count = Some(own);
                        self.parsed.mentions[item].each_of = Some(host);
                        let kind = self.side_in_setting(&list, host).unwrap_or(RelationKind::NextTo);
                        self.parsed.links.push(Link::new(item, LinkKind::Relation(kind), host));
                    }
                }
            }
            let pause = usize::from(matches!(self.tokens.get(self.at), Some(Token::Pause)));
            let and = usize::from(self.word(pause) == Some("and"));
            if pause + and == 0 {
                break;
            }
            self.at += pause + and;
        }
        self.salient_list = self.subject.clone();
        self.salient = host;
        true
    }

    /// "a cup for each of the four saucers". Whether the rule applies.
    pub(super) fn for_each(&mut self) -> bool {
        if self.word(0) != Some("for") || self.subject.is_empty() {
            return false;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1) else { return false };
        if phrase.determiner != Determiner::Each
            || !matches!(phrase.head, Head::Objects(_))
            || phrase.is_table()
        {
            return false;
        }
        let subjects = self.attached();
        self.parsed.account.used(self.at..self.at + 1);
        self.at = end;
        if let Referent::Mentions(targets) = self.refer(phrase, true)
            && let Some(&target) = targets.first()
        {
            for subject in subjects.into_iter().filter(|subject| *subject != target) {
                self.parsed.mentions[subject].each_of = Some(target);
                self.parsed.links.push(Link::new(subject, LinkKind::With, target));
            }
        }
        true
    }

    /// "left", "on the right", "behind (it)" after an object of a setting.
    fn side_in_setting(&mut self, items: &[usize], host: usize) -> Option<RelationKind> {
        let opener = ["on the", "to the", "at the", "in"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, self.at, phrase));
        let side = self.at + opener.unwrap_or(0);
        let kind = match self.word_at(side)? {
            "left" => RelationKind::LeftOf,
            "right" => RelationKind::RightOf,
            "behind" | "above" | "back" | "top" => RelationKind::Behind,
            "front" | "below" | "bottom" => RelationKind::InFrontOf,
            "on" | "inside" => RelationKind::On,
            _ => return None,
        };
        let it = usize::from(matches!(self.word_at(side + 1), Some("it" | "side")));
        if !self.ends_at(side + 1 + it) && self.word_at(side + 1 + it) != Some("and") {
            return None;
        }
        let claim = Claimed::Relation { kind, from: items.to_vec(), to: vec![host] };
        self.parsed.account.claim(self.at..side + 1 + it, claim);
        self.at = side + 1 + it;
        Some(kind)
    }

    /// "a toolbox: a hammer and two nails": what a vessel holds. Whether the rule applies.
    pub(super) fn listed_contents(&mut self) -> bool {
        let [host] = self.subject[..] else { return false };
        let others = self.parsed.mentions.iter().filter(|mention| mention.count != Some([0, 0])).count();
        let is_vessel = self.holds_others(host) && !self.is_several(host);
        if !self.is_colon(self.at) || others != 1 || !is_vessel || !self.object_begins(self.at + 1) {
            return false;
        }
        // "a bowl: two apples and a pear in it" says where they are.
        let end = (self.at + 1..self.tokens.len()).find(|at| matches!(self.tokens[*at], Token::End));
        let states_place = (self.at + 1..end.unwrap_or(self.tokens.len())).any(|at| {
            matches!(
                self.word_at(at),
                Some("it" | "beside" | "next" | "behind" | "front" | "left" | "right" | "on")
            )
        });
        if states_place {
            return false;
        }
        let colon = self.at..self.at + 1;
        self.at += 1;
        self.list_of(host, LinkKind::At, colon, false);
        true
    }
}
