//! Destinations on the table: "to the left side of the table", "in the corner at the back left", "forward".

use super::Parser;
use super::action::{Action, Path, PathKind};
use crate::text_parser::phrase::{Head, noun_phrase};
use crate::text_parser::prepositions::{place_at, preposition_at};
use crate::text_parser::tokens::match_phrase;
use scene::RelationKind;

const DIRECTIONS: &[&str] = &[
    "to the left",
    "to the right",
    "to the front",
    "to the back",
    "leftward",
    "rightward",
    "leftwards",
    "rightwards",
    "forward",
    "forwards",
    "backward",
    "backwards",
    "left",
    "right",
    "towards left",
    "towards right",
    "toward left",
    "toward right",
    "slightly to the left",
    "slightly to the right",
    "slightly left",
    "slightly right",
    "a bit to the left",
    "a bit to the right",
    "a bit left",
    "a bit right",
    "further left",
    "further right",
    "a little left",
    "a little right",
    "a little to the left",
    "a little to the right",
];

impl Parser<'_, '_> {
    /// "to the left side of the table", "in the center", "to the left".
    pub(super) fn place_path(&mut self, action: &mut Action) -> bool {
        let start = self.at;
        let (places, length) = match self.table_place_at(start) {
            Some(place) => place,
            None => {
                let direction =
                    DIRECTIONS.iter().filter_map(|phrase| match_phrase(self.tokens, start, phrase)).max();
                let Some(length) = direction else { return false };
                if matches!(
                    self.word(length),
                    Some("of" | "side" | "edge" | "corner" | "half" | "end" | "from")
                ) || self.distinguishes_noun(start + length)
                {
                    return false;
                }
                let kind = match self.word(length - 1) {
                    Some("left" | "leftward" | "leftwards") => RelationKind::AtLeft,
                    Some("right" | "rightward" | "rightwards") => RelationKind::AtRight,
                    Some("back" | "forward" | "forwards") => RelationKind::AtBack,
                    _ => RelationKind::AtFront,
                };
                if self.shared_side(kind, start, length, action) {
                    return true;
                }
                (vec![kind], length)
            }
        };
        self.at = start + length;
        let directed = matches!(self.word_at(start), Some("to" | "toward" | "towards" | "into" | "onto"));
        action.paths.push(Path { directed, ..self.path(PathKind::Places(places), start..start + length) });
        true
    }

    /// A named part of the table at `at`; the next words may say which corner it is.
    fn table_place_at(&self, at: usize) -> Option<(Vec<RelationKind>, usize)> {
        // In an instruction, "the board" without an earlier board is where everything stands.
        let has_board = self.parsed.mentions.iter().any(|mention| mention.words.ends_with("board"));
        let is_table = |word: &str| Self::is_table_word(word) || (word == "board" && !has_board);
        let (places, length) =
            place_at(self.tokens, at, &is_table).or_else(|| self.side_of_table(at, &is_table))?;
        if self.distinguishes_noun(at + length) {
            return None;
        }
        let is_corner = self.word_at(at + length - 1) == Some("corner");
        if is_corner && let Some((which, more)) = place_at(self.tokens, at + length, &is_table) {
            return Some((which, length + more));
        }
        Some((places, length))
    }

    /// "to the back of the table", "to the front left of the table": its sides, and the number of words.
    fn side_of_table(
        &self,
        at: usize,
        is_table: &dyn Fn(&str) -> bool,
    ) -> Option<(Vec<RelationKind>, usize)> {
        let opens =
            matches!(self.word_at(at), Some("to" | "toward" | "towards" | "on" | "at" | "in" | "into"));
        let mut p = at + 1 + usize::from(self.word_at(at + 1) == Some("the"));
        let (mut left, mut right, mut back, mut front) = (false, false, false, false);
        while let Some(word) = self.word_at(p) {
            match word {
                "left" => left = true,
                "right" => right = true,
                "back" | "rear" | "top" | "upper" => back = true,
                "front" | "bottom" | "lower" => front = true,
                _ => break,
            }
            p += 1;
        }
        let of = match_phrase(self.tokens, p, "of the")?;
        if !opens || !self.word_at(p + of).is_some_and(is_table) || self.word_at(p + of) == Some("it") {
            return None;
        }
        let kind = match (left, right, back, front) {
            (true, _, true, _) => RelationKind::AtBackLeft,
            (true, _, _, true) => RelationKind::AtFrontLeft,
            (_, true, true, _) => RelationKind::AtBackRight,
            (_, true, _, true) => RelationKind::AtFrontRight,
            (true, ..) => RelationKind::AtLeft,
            (_, true, ..) => RelationKind::AtRight,
            (_, _, true, _) => RelationKind::AtBack,
            (_, _, _, true) => RelationKind::AtFront,
            _ => return None,
        };
        Some((vec![kind], p + of + 1 - at))
    }

    /// Whether the word before `at` tells a noun from others: "the left plate", "the back compartment".
    fn distinguishes_noun(&self, at: usize) -> bool {
        let selects = matches!(
            self.word_at(at - 1),
            Some("left" | "right" | "front" | "back" | "rear" | "middle" | "center" | "top" | "bottom")
        );
        let is_noun = matches!(
            self.word_at(at),
            Some(
                "one"
                    | "ones"
                    | "compartment"
                    | "section"
                    | "slot"
                    | "drawer"
                    | "shelf"
                    | "burner"
                    | "pocket"
            )
        ) || self.lexicon.longest_at(self.tokens, at).is_some()
            || noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(phrase, _)| {
                matches!(phrase.head, Head::Objects(_)) && !phrase.words.is_empty()
            }) && !matches!(self.word_at(at), Some("the" | "a" | "an" | "it"));
        selects && is_noun
    }

    /// "to the left and the knife to the right of the plate": both sides are of the plate.
    fn shared_side(&mut self, kind: RelationKind, start: usize, length: usize, action: &mut Action) -> bool {
        let side = match kind {
            RelationKind::AtLeft => RelationKind::LeftOf,
            RelationKind::AtRight => RelationKind::RightOf,
            _ => return false,
        };
        if self.word(length) != Some("and") {
            return false;
        }
        let Some((_, end)) = noun_phrase(self.lexicon, self.tokens, start + length + 1) else { return false };
        let Some((preposition, words)) = preposition_at(self.tokens, end) else { return false };
        if !matches!(preposition.kind, RelationKind::LeftOf | RelationKind::RightOf)
            || preposition.may_stand_alone
        {
            return false;
        }
        let Some((phrase, _)) = noun_phrase(self.lexicon, self.tokens, end + words) else { return false };
        let super::Referent::Mentions(targets) = self.refer(phrase, true) else { return false };
        self.at = start + length;
        let path = self.path(PathKind::Relation(side), start..start + length);
        action.paths.push(Path { targets, directed: true, ..path });
        true
    }
}
