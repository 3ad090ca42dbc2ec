//! Arrangements: "in a row", "in a circle around the vase", "in a 2 x 3 grid", "in a pile", "a pyramid of cups".

use std::ops::Range;

use super::{ArrangementDraft, Link, LinkKind, Parser, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::phrase::{Group, group_of, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::property::Property;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

/// Phrases after the objects.
const PHRASES: &[(&str, Group)] = &[
    ("lined up", Group::Row),
    ("lined up in a row", Group::Row),
    ("lined up in a line", Group::Row),
    ("side by side", Group::Row),
    ("one beside the other", Group::Row),
    ("one behind the other", Group::Column),
    ("one behind another", Group::Column),
    ("in circle", Group::Circle),
    ("stacked in a pyramid", Group::Pyramid),
    ("stacked as a pyramid", Group::Pyramid),
];

/// The direction of a row.
const DIRECTIONS: &[(&str, Group)] = &[
    ("from left to right", Group::Row),
    ("from right to left", Group::Row),
    ("from front to back", Group::Column),
    ("from back to front", Group::Column),
    ("going away from the viewer", Group::Column),
    ("leading away from the viewer", Group::Column),
    ("away from the viewer", Group::Column),
    ("away from me", Group::Column),
    ("toward the back", Group::Column),
    ("towards the back", Group::Column),
];

impl Parser<'_, '_> {
    /// An arrangement of the current list. Whether the rule applies.
    pub(super) fn arrangement(&mut self) -> bool {
        if self.row_direction() {
            return true;
        }
        let start = self.at;
        let mut p = start;
        while let Some(length) = phrases().arrangement.verbs.longest_at(self.tokens, p)
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
        // Objects that no part has yet belong to the arrangement too.
        self.end_split();
        let mut tokens = start..p + length;
        let direction = DIRECTIONS
            .iter()
            .find_map(|(phrase, group)| Some((*group, match_phrase(self.tokens, tokens.end, phrase)?)));
        let group = match (group, direction) {
            (Some(Group::Row | Group::Column), Some((directed, more))) => {
                tokens.end += more;
                Some(directed)
            }
            (group, _) => group,
        };
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

    pub(super) fn phrase_at(&self, at: usize) -> Option<(Option<Group>, Option<usize>, usize)> {
        let fixed = PHRASES
            .iter()
            .filter_map(|(phrase, group)| Some((Some(*group), None, match_phrase(self.tokens, at, phrase)?)))
            .max_by_key(|(_, _, length)| *length);
        fixed.or_else(|| self.shaped(at)).or_else(|| self.counted_grid(at))
    }

    /// "a column of cans going away from the viewer", "a plate, a bowl and a cup, from left to right". Whether it
    /// applies.
    fn row_direction(&mut self) -> bool {
        let found = DIRECTIONS
            .iter()
            .filter_map(|(phrase, group)| Some((*group, match_phrase(self.tokens, self.at, phrase)?)))
            .max_by_key(|(_, length)| *length);
        let members = self.members();
        let several = members.len() > 1 || members.iter().any(|&m| self.is_several(m));
        let Some((group, length)) = found.filter(|_| several && !self.subject.is_empty()) else {
            return false;
        };
        let tokens = self.at..self.at + length;
        self.at = tokens.end;
        match self.parsed.arrangements.last_mut() {
            Some(last) if members.iter().any(|m| last.mentions.contains(m)) => {
                if matches!(last.group, Group::Row | Group::Column) {
                    last.group = group;
                }
                self.claim_property(tokens, Property::Arrangement, members);
            }
            _ => self.arrange(members, group, None, tokens),
        }
        true
    }

    /// "in a straight line", "to form a circle", "as a tower".
    fn shaped(&self, at: usize) -> Option<(Option<Group>, Option<usize>, usize)> {
        let opener = phrases().arrangement.openers.longest_at(self.tokens, at)?;
        let mut p = at + opener;
        p += usize::from(matches!(self.word_at(p), Some("a" | "an" | "one" | "the")));
        // "form a circle" needs a subject.
        let verb = matches!(self.word_at(at), Some("form" | "forms" | "make"));
        if p == at + opener || verb && self.subject.is_empty() {
            return None;
        }
        let adjectives = p;
        while self.word_at(p).is_some_and(|word| phrases().arrangement.adjectives.has(word)) {
            p += 1;
        }
        let vertical = (adjectives..p).any(|p| self.word_at(p) == Some("vertical"));
        let noun = self.word_at(p)?;
        // "in a ring box" and "in a pile of books" name objects.
        let named = self.lexicon.longest_at(self.tokens, p).is_some_and(|(_, length)| length > 1);
        if named || self.word_at(p + 1) == Some("of") {
            return None;
        }
        let group = match noun {
            "stack" | "tower" => None,
            "pile" => Some(Group::Pile),
            "triangle" => Some(Group::Circle),
            "row" | "line" if vertical => Some(Group::Column),
            _ => Some(group_of(noun).filter(|_| !noun.ends_with('s'))?),
        };
        Some((group, None, p + 1 - at))
    }

    pub(super) fn stack_at(&self, at: usize) -> Option<(Option<Group>, Option<usize>, usize)> {
        [
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
        let opener = phrases().arrangement.openers.length_at(self.tokens, at);
        // "six mugs, two rows of three".
        if opener == 0 && !(at == self.at && self.follows_pause() && !self.subject.is_empty()) {
            return None;
        }
        let p = at + opener + usize::from(opener > 0 && self.word_at(at + opener) == Some("a"));
        let number = |p: usize| match self.tokens.get(p)? {
            Token::Number(number) if (1.0..=64.0).contains(number) => Some(*number as usize),
            Token::Word(word) => self.lexicon.vocabulary.numbers.get(word).map(|number| *number as usize),
            _ => None,
        };
        let first = number(p)?;
        if matches!(self.word_at(p + 1), Some("x" | "by"))
            && let Some(columns) = number(p + 2)
            && opener > 0
        {
            let noun = matches!(
                self.word_at(p + 3),
                Some(
                    "grid"
                        | "pattern"
                        | "array"
                        | "square"
                        | "matrix"
                        | "rectangle"
                        | "layout"
                        | "formation"
                        | "arrangement"
                )
            );
            let ends = matches!(self.tokens.get(p + 3), None | Some(Token::Pause | Token::End));
            if noun || ends {
                return Some((Some(Group::Grid), Some(columns), p + 3 + usize::from(noun) - at));
            }
        }
        if !matches!(self.word_at(p + 1), Some("rows" | "columns")) || first < 2 {
            return None;
        }
        let in_columns = self.word_at(p + 1) == Some("columns");
        if self.word_at(p + 2) == Some("of")
            && let Some(per_row) = number(p + 3)
            && (opener > 0 || matches!(self.tokens.get(p + 4), None | Some(Token::Pause | Token::End)))
        {
            return Some((Some(Group::Grid), Some(if in_columns { first } else { per_row }), p + 4 - at));
        }
        // "in two rows": the number of columns follows from the count.
        if opener == 0 {
            return None;
        }
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
        // "3 x 3 cubes in a grid" is one arrangement.
        if let Some((known, last)) = self.parsed.arrangements.iter_mut().enumerate().next_back()
            && (last.group, &last.mentions) == (group, &mentions)
        {
            last.columns = last.columns.or(columns);
            self.parsed.account.claim(tokens, Claimed::Arrangement(known));
            return;
        }
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
        self.claim_property(tokens, Property::Arrangement, mentions);
        true
    }

    /// "next to each other", "facing each other".
    pub(super) fn beside_each_other(&mut self, kind: RelationKind, tokens: Range<usize>) {
        let mut members = self.members();
        // "two cups facing each other".
        if let [both] = members[..]
            && matches!(kind, RelationKind::Facing | RelationKind::ParallelTo)
            && self.parsed.mentions[both].count == Some([2, 2])
        {
            members.push(self.one_of(both));
        }
        if let [first, second] = members[..] {
            self.parsed.links.push(Link::new(second, LinkKind::Relation(kind), first));
            if kind == RelationKind::Facing {
                self.parsed.links.push(Link::new(first, LinkKind::Relation(kind), second));
            }
            let claim = Claimed::Relation { kind, from: vec![second], to: vec![first] };
            self.parsed.account.claim(tokens, claim);
        } else {
            self.claim_property(tokens, Property::Arrangement, members);
        }
    }
}
