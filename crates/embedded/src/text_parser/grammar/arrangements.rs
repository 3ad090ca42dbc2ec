//! Arrangements: "in a row", "in a circle around the vase", "in a 2 x 3 grid", "in a pile", "a pyramid of cups".

use std::ops::Range;

use super::{ArrangementDraft, Link, LinkKind, Parser, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::phrase::{Group, noun_phrase};
use crate::text_parser::tokens::{Token, match_phrase};
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

/// Phrases after the objects.
const PHRASES: &[(&str, Group)] = &[
    ("in a row", Group::Row),
    ("in a line", Group::Row),
    ("in one row", Group::Row),
    ("in a single row", Group::Row),
    ("in a straight line", Group::Row),
    ("in a horizontal row", Group::Row),
    ("in a horizontal line", Group::Row),
    ("into a row", Group::Row),
    ("into a line", Group::Row),
    ("lined up", Group::Row),
    ("lined up in a row", Group::Row),
    ("side by side", Group::Row),
    ("in a column", Group::Column),
    ("in a vertical line", Group::Column),
    ("one behind the other", Group::Column),
    ("one behind another", Group::Column),
    ("in a circle", Group::Circle),
    ("in a ring", Group::Circle),
    ("in circle", Group::Circle),
    ("into a circle", Group::Circle),
    ("in a grid", Group::Grid),
    ("into a grid", Group::Grid),
    ("in a square", Group::Grid),
    ("in a semicircle", Group::Circle),
    ("in a pile", Group::Pile),
    ("in a heap", Group::Pile),
    ("into a pile", Group::Pile),
    ("in a pyramid", Group::Pyramid),
    ("into a pyramid", Group::Pyramid),
    ("as a pyramid", Group::Pyramid),
    ("stacked in a pyramid", Group::Pyramid),
    ("stacked as a pyramid", Group::Pyramid),
];

/// Words before such a phrase.
const VERBS: &[&str] = &[
    "arranged",
    "placed",
    "laid",
    "set",
    "standing",
    "lying",
    "aligned",
    "ordered",
    "stacked",
    "put",
    "organized",
    "lined up",
    "all",
];

impl Parser<'_, '_> {
    /// An arrangement of the current list. Whether the rule applies.
    pub(super) fn arrangement(&mut self) -> bool {
        let start = self.at;
        let mut p = start;
        while let Some(length) = VERBS.iter().filter_map(|verb| match_phrase(self.tokens, p, verb)).max()
            && p < start + 4
            && self.phrase_at(p).is_none()
        {
            p += length;
        }
        if matches!(self.word_at(p), Some("neatly" | "evenly")) {
            p += 1;
        }
        let Some((group, columns, length)) = self.phrase_at(p).or_else(|| self.stack_at(p)) else {
            return false;
        };
        let tokens = start..p + length;
        let Some(group) = group else {
            // "in a stack".
            let members = self.members();
            self.at = tokens.end;
            return self.stack(members, tokens);
        };
        self.at = tokens.end;
        let members = self.members();
        if members.is_empty() {
            self.report(tokens, UnrecognizedReason::NoReferent);
            return true;
        }
        self.arrange(members, group, columns, tokens);
        if matches!(self.word(0), Some("around")) {
            self.circle_around();
        }
        true
    }

    fn phrase_at(&self, at: usize) -> Option<(Option<Group>, Option<usize>, usize)> {
        let fixed = PHRASES
            .iter()
            .filter_map(|(phrase, group)| Some((Some(*group), None, match_phrase(self.tokens, at, phrase)?)))
            .max_by_key(|(_, _, length)| *length);
        fixed.or_else(|| self.counted_grid(at))
    }

    fn stack_at(&self, at: usize) -> Option<(Option<Group>, Option<usize>, usize)> {
        [
            "in a stack",
            "in a tower",
            "into a stack",
            "into a tower",
            "one on top of the other",
            "on top of one another",
            "one on top of another",
            "on top of each other",
            "stacked vertically",
        ]
        .iter()
        .filter_map(|phrase| match_phrase(self.tokens, at, phrase))
        .max()
        .map(|length| (None, None, length))
    }

    /// "in a 2 x 3 grid", "in two rows of three", "in two rows".
    fn counted_grid(&self, at: usize) -> Option<(Option<Group>, Option<usize>, usize)> {
        if !matches!(self.word_at(at), Some("in" | "into" | "as")) {
            return None;
        }
        let p = at + 1 + usize::from(self.word_at(at + 1) == Some("a"));
        let number = |p: usize| match self.tokens.get(p)? {
            Token::Number(number) if (1.0..=64.0).contains(number) => Some(*number as usize),
            Token::Word(word) => self.lexicon.vocabulary.numbers.get(word).map(|number| *number as usize),
            _ => None,
        };
        let first = number(p)?;
        if matches!(self.word_at(p + 1), Some("x" | "by"))
            && let Some(columns) = number(p + 2)
            && matches!(self.word_at(p + 3), Some("grid" | "pattern" | "array"))
        {
            return Some((Some(Group::Grid), Some(columns), p + 4 - at));
        }
        if !matches!(self.word_at(p + 1), Some("rows" | "columns")) || first < 2 {
            return None;
        }
        let in_columns = self.word_at(p + 1) == Some("columns");
        if self.word_at(p + 2) == Some("of")
            && let Some(per_row) = number(p + 3)
        {
            return Some((Some(Group::Grid), Some(if in_columns { first } else { per_row }), p + 4 - at));
        }
        // "in two rows": the number of columns follows from the count.
        let total =
            self.members().iter().map(|&m| self.parsed.mentions[m].count.map_or(1, |c| c[1])).sum::<u32>();
        let columns = if in_columns { first } else { (total as usize).div_ceil(first).max(1) };
        Some((Some(Group::Grid), Some(columns), p + 2 - at))
    }

    pub(super) fn arrange(
        &mut self,
        mentions: Vec<usize>,
        group: Group,
        columns: Option<usize>,
        tokens: Range<usize>,
    ) {
        self.parsed.account.claim(tokens, Claimed::Arrangement(self.parsed.arrangements.len()));
        for &mention in &mentions {
            if group == Group::Pyramid || group == Group::Pile {
                self.parsed.mentions[mention].stacked = false;
            }
        }
        self.parsed.arrangements.push(ArrangementDraft {
            group,
            columns,
            mentions,
            gap_m: None,
            center: None,
        });
    }

    /// "a row of five cups": the group word belongs to the phrase.
    pub(super) fn grouped(
        &mut self,
        mention: usize,
        group: Group,
        columns: Option<usize>,
        tokens: Range<usize>,
    ) {
        if group == Group::Pile {
            if self.is_flat(mention) {
                return;
            }
            self.parsed.mentions[mention].stacked = false;
        }
        if self.parsed.mentions[mention].count.is_none() && group == Group::Pyramid {
            self.parsed.mentions[mention].count = Some([6, 6]);
        }
        if self.parsed.mentions[mention].count.is_none()
            && self.parsed.mentions[mention].plural
            && !matches!(self.tokens.get(self.at), Some(Token::Pause))
        {
            self.parsed.mentions[mention].count = Some([4, 4]);
        }
        self.arrange(vec![mention], group, columns, tokens);
        // "a row of one apple, one orange and one pear".
        if !self.is_several(mention) {
            self.open_group = Some(self.parsed.arrangements.len() - 1);
        }
        if matches!(self.word(0), Some("around")) && group == Group::Circle {
            self.circle_around();
        }
    }

    /// Whether objects of the mention lie flat on each other ("a pile of books").
    fn is_flat(&self, mention: usize) -> bool {
        use crate::text_parser::lexicon::Meaning;
        match self.parsed.mentions[mention].meanings.first() {
            Some(Meaning::Category(index)) => {
                let size = self.lexicon.categories[*index].size.typical_m();
                size.z < 0.5 * size.x.min(size.y)
            }
            _ => false,
        }
    }

    /// "(in a circle) around the vase".
    fn circle_around(&mut self) {
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1) else { return };
        let start = self.at;
        self.at = end;
        if let Referent::Mentions(targets) = self.refer(phrase, true)
            && let Some(&center) = targets.first()
            && let Some(last) = self.parsed.arrangements.last_mut()
        {
            last.center = Some(center);
            let from = last.mentions.clone();
            for &mention in &from {
                self.parsed.links.push(Link::new(mention, LinkKind::Relation(RelationKind::Around), center));
            }
            let claim = Claimed::Relation { kind: RelationKind::Around, from, to: vec![center] };
            self.parsed.account.claim(start..start + 1, claim);
        }
    }

    /// Stacks the objects of mentions: a plural mention on itself, several mentions in order from the bottom up.
    pub(super) fn stack(&mut self, mentions: Vec<usize>, tokens: Range<usize>) -> bool {
        match mentions[..] {
            [] => {
                self.report(tokens, UnrecognizedReason::NoReferent);
                return true;
            }
            [one] => self.parsed.mentions[one].stacked = true,
            _ => {
                for pair in mentions.windows(2) {
                    let kind = LinkKind::Relation(RelationKind::On);
                    self.parsed.links.push(Link::new(pair[1], kind, pair[0]));
                }
            }
        }
        self.claim_property(tokens, "arrangement", mentions);
        true
    }

    /// "next to each other", "facing each other".
    pub(super) fn beside_each_other(&mut self, kind: RelationKind, tokens: Range<usize>) {
        let members = self.members();
        if let [first, second] = members[..] {
            self.parsed.links.push(Link::new(second, LinkKind::Relation(kind), first));
            if kind == RelationKind::Facing {
                self.parsed.links.push(Link::new(first, LinkKind::Relation(kind), second));
            }
            let claim = Claimed::Relation { kind, from: vec![second], to: vec![first] };
            self.parsed.account.claim(tokens, claim);
        } else {
            self.claim_property(tokens, "arrangement", members);
        }
    }
}
