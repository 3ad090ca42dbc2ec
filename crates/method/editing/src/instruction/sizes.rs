//! Commands that change the size of objects.

use super::Reason;
use super::cursor::{Cursor, Outcome};
use super::discourse::Target;
use super::measures::BIGGER;
use scene::EditOperation;
use scene::edit::MAX_RESIZE;

impl Cursor {
    /// "enlarge X by 20 %", "shrink X to half its size".
    pub fn resize(&mut self, usual: Option<f64>) -> Outcome<()> {
        let start = self.at;
        let _ = self.take_any(&["the size of", "up", "down"]);
        let grows = usual.is_none_or(|factor| factor > 1.0);
        let stops = |cursor: &Self, index: usize| {
            let measured = cursor.number_at(index).is_some_and(|(_, length)| {
                matches!(cursor.word(index + length), "times" | "%" | "percent" | "x")
            });
            let words = ["by", "to", "twice", "up", "down", "a bit", "a little", "slightly", "'s size"];
            measured || cursor.length_of_any(index, &words).is_some()
        };
        let targets = self.targets(&stops)?;
        let from = self.at;
        let factor = self.factor_of(usual, grows);
        let Some(factor) = factor else {
            return self.not_understood(start, "say how much: by 20 %, to half its size, twice as large");
        };
        self.resized(&targets, factor, from)
    }

    pub fn factor_of(&mut self, usual: Option<f64>, grows: bool) -> Option<f64> {
        let directed = |share: f64| if grows { 1.0 + share } else { 1.0 - share };
        if self.take_any(&["a little bit", "a little", "a bit", "slightly"]) {
            return usual.map(|_| if grows { 1.1 } else { 1.0 / 1.1 });
        }
        if self.length_of_any(self.at, &["up", "down"]).is_some() {
            let up = self.is_at(self.at, "up");
            self.at += 1;
            let usual = if up { BIGGER } else { 1.0 / BIGGER };
            return self.factor_of(Some(usual), up);
        }
        if self.take("twice") {
            return grows.then_some(2.0);
        }
        let by = self.take("by");
        if by && self.take("half") {
            return usual.map(|_| directed(0.5));
        }
        let factor_word = by && self.take_any(&["a factor of", "factor"]);
        let to = !by && self.take("to");
        if to && let Some((factor, length)) = self.factor_at(self.at) {
            self.at += length;
            return Some(factor);
        }
        let Some((value, length)) = self.number_at(self.at) else {
            return if by || to { None } else { usual };
        };
        self.at += length;
        if self.take_any(&["%", "percent", "per cent"]) {
            let _ = to && self.take_any(&["of its size", "of its original size", "of its current size"]);
            return match (to, usual) {
                (true, _) => Some(value / 100.0),
                (false, Some(_)) => Some(directed(value / 100.0)),
                (false, None) => None,
            };
        }
        if self.take_any(&["times", "x"]) || factor_word || (by && usual.is_none()) {
            return Some(if grows { value } else { 1.0 / value });
        }
        None
    }

    pub fn resized(&mut self, targets: &[Target], factor: f64, from: usize) -> Outcome<()> {
        if !(1.0 / MAX_RESIZE..=MAX_RESIZE).contains(&factor) {
            return Err(self.error(from, self.at, Reason::Factor(factor)));
        }
        self.turned(targets, from, |target| EditOperation::Resize { target, factor })
    }
}
