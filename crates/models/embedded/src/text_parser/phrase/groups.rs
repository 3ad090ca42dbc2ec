//! Words for groups in noun phrases: "a row of", "a pair of", "a 2 x 3 grid of".

use super::{Chunk, Group};
use crate::text_parser::quantity::quantity;
use crate::text_parser::tokens::{Token, match_phrase, word};

/// Maximum number of objects of "3 x 3 cubes".
const MAX_BARE_GRID: u32 = 64;

impl Chunk<'_, '_> {
    /// Number of tokens of "of", "made of", "consisting of" after the current word.
    pub(super) fn of_length(&self) -> usize {
        ["of", "made of", "made up of", "made from", "built of", "built from", "consisting of", "composed of"]
            .iter()
            .filter_map(|phrase| match_phrase(self.tokens, self.at + 1, phrase))
            .max()
            .unwrap_or(0)
    }

    /// Whether a plural follows the "of" after the current word: "a pyramid of cubes" is an arrangement, a pyramid is
    /// an object.
    pub(super) fn is_of_many(&self, of_length: usize) -> bool {
        let after = self.at + 1 + of_length;
        let counted = quantity(self.lexicon, self.tokens, after).map_or(after, |(_, length)| after + length);
        (counted..counted + 5)
            .find_map(|at| self.lexicon.longest_at(self.tokens, at))
            .is_some_and(|(entry, _)| entry.plural)
    }

    pub(super) fn pair(&mut self) {
        let (_, two) = self.phrase.count.map_or((1, 1), |[low, high]| (low, high));
        // "a pair of scissors" is one; two of anything else.
        let next = self.lexicon.longest_at(self.tokens, self.at + 2);
        let single = next.is_some_and(|(entry, _)| entry.one_by_default);
        let each = if single { 1 } else { 2 };
        self.phrase.count = Some([two.saturating_mul(each); 2]);
        if !single {
            self.counted(self.at..self.at + 2);
        }
        self.determined = true;
        self.at += 1;
    }

    /// "a 2 x 3 grid of": rows by columns.
    pub(super) fn grid(&mut self) -> bool {
        let numbers = [self.at, self.at + 2].map(|p| match self.tokens.get(p) {
            Some(Token::Number(number)) => Some(number.clamp(0.0, 64.0) as u32),
            _ => word(self.tokens, p).and_then(|w| self.lexicon.vocabulary.numbers.get(w)).copied(),
        });
        let [Some(rows), Some(columns)] = numbers else { return false };
        let joined = matches!(self.word(1), Some("x" | "by"));
        let named =
            matches!(self.word(3), Some("grid" | "array" | "square" | "matrix" | "rectangle" | "block"))
                && self.word(4) == Some("of");
        // "3 x 3 cubes".
        let of_noun = rows.min(columns) > 1
            && rows * columns <= MAX_BARE_GRID
            && self.lexicon.longest_at(self.tokens, self.at + 3).is_some_and(|(entry, _)| entry.plural);
        if !joined || !(named || of_noun) || rows * columns == 0 {
            return false;
        }
        let length = if named { 5 } else { 3 };
        self.phrase.group = Some((Group::Grid, self.at..self.at + length));
        self.phrase.columns = Some(columns as usize);
        self.phrase.count = Some([rows * columns; 2]);
        self.determined = true;
        self.at += length;
        true
    }
}

pub(in crate::text_parser) fn group_of(word: &str) -> Option<Group> {
    Some(match word {
        "row" | "rows" | "line" | "lines" => Group::Row,
        "column" => Group::Column,
        // "two columns of three" are two objects wide.
        "columns" => Group::Row,
        "circle" | "ring" | "semicircle" => Group::Circle,
        "grid" | "array" | "square" => Group::Grid,
        "heap" => Group::Pile,
        "pyramid" => Group::Pyramid,
        _ => return None,
    })
}
