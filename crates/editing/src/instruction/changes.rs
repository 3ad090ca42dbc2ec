//! Commands about what objects are like: turn, resize, recolor, relabel.

use std::f64::consts::PI;

use super::commands::is_table;
use super::cursor::{Cursor, Outcome};
use super::discourse::Target;
use super::measures::BIGGER;
use super::Reason;
use crate::references::{color_of, material_of};
use scene::EditOperation;
use scene::edit::MAX_RESIZE;

/// What a verb asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Frame {
    /// New objects; existing ones are moved.
    Add,
    Move,
    Remove,
    /// Removal, or a move out of something.
    Take,
    Clear,
    Empty,
    Replace,
    Swap,
    Rotate,
    Face,
    /// The factor without a measure.
    Resize(Option<f64>),
    Make,
    Change,
    ColorOf,
    Relabel,
    Stack,
    Tidy,
    Clutter,
}

/// What an object becomes.
#[derive(Clone, Debug, PartialEq)]
enum Complement {
    Factor(f64),
    Look { color: Option<String>, material: Option<String> },
}

impl Cursor {
    /// "by 90 degrees clockwise", "around", "toward the plate" after what is turned.
    pub fn rotate(&mut self) -> Outcome<()> {
        let start = self.at;
        if let Some(at) = self.complement_index(start) {
            return self.become_at(at);
        }
        let facing = ["toward", "towards", "to face", "so that it faces", "so it faces", "to point at", "to"];
        let stops = |cursor: &Self, index: usize| {
            cursor.angle_at(index).is_some()
                || (cursor.turn_direction_at(index).is_some() && !cursor.is_at(index + 3, "of"))
                || cursor.length_of_any(index, &["by", "around", "over", "upside down", "on its side", "into"]).is_some()
                || cursor.length_of_any(index, &facing).is_some()
        };
        let targets = self.targets(&stops)?;
        if self.length_of_any(self.at, &["over", "upside down", "on its side"]).is_some() {
            return self.not_understood(start, "objects turn about the vertical axis only");
        }
        if self.is_at(self.at, "into") {
            return self.not_understood(start, "say: replace it with ...");
        }
        let (mut angle_rad, mut sign, mut around) = (None, None, false);
        loop {
            if self.is_at(self.at, "by") && self.number_at(self.at + 1).is_some() && self.angle_at(self.at + 1).is_none() {
                let (degrees, length) = self.number_at(self.at + 1).unwrap_or_default();
                self.at += 1 + length;
                angle_rad = Some(degrees.to_radians());
            } else if let Some((direction, length)) = self.turn_direction_at(self.at) {
                self.at += length;
                sign = Some(direction);
            } else if let Some(angle) = self.angle_at(self.at) {
                self.at += angle.length;
                angle_rad = Some(angle.rad);
            } else if self.take("around") {
                around = true;
            } else if !(self.is_at(self.at, "by") && self.angle_at(self.at + 1).is_some() && self.take("by")) {
                break;
            }
        }
        if let Some(angle) = self.is_at(self.at, "to").then(|| self.angle_at(self.at + 1)).flatten() {
            self.at += 1 + angle.length;
            let to_rad = Some(angle.rad);
            return self.turned(&targets, start, |target| EditOperation::Rotate { target, by_rad: None, to_rad, facing: None });
        }
        if angle_rad.is_none() && sign.is_none() && !around {
            if self.take_any(&facing[..6]) {
                return self.faced(&targets, start);
            }
            return Err(self.error(start, self.at, Reason::HowFarTurned));
        }
        let angle_rad = angle_rad.or((around && sign.is_none()).then_some(PI));
        let Some(angle_rad) = angle_rad else {
            return Err(self.error(start, self.at, Reason::HowFarTurned));
        };
        let by_rad = Some(sign.unwrap_or(1.0) * angle_rad);
        self.turned(&targets, start, |target| EditOperation::Rotate { target, by_rad, to_rad: None, facing: None })
    }

    /// "face X to Y", "make X face Y".
    pub fn face(&mut self) -> Outcome<()> {
        let start = self.at;
        let toward = ["toward", "towards", "to face", "to", "at"];
        let stops = |cursor: &Self, index: usize| {
            cursor.length_of_any(index, &toward).is_some()
                || cursor.heading_at(index).is_some_and(|(_, length)| cursor.is_boundary(index + length))
        };
        let targets = self.targets(&stops)?;
        let _ = self.take_any(&toward);
        self.faced(&targets, start)
    }

    /// What the targets face follows.
    pub fn faced(&mut self, targets: &[Target], start: usize) -> Outcome<()> {
        if let Some((yaw_rad, length)) = self.heading_at(self.at)
            && self.is_boundary(self.at + length)
        {
            self.at += length;
            let to_rad = Some(yaw_rad);
            return self.turned(targets, start, |target| EditOperation::Rotate { target, by_rad: None, to_rad, facing: None });
        }
        let from = self.at;
        if self.is_at(from, "each other") {
            let [first, second] = targets else {
                return Err(self.error(start, from + 2, Reason::SeveralLandmarks));
            };
            self.at += 2;
            for (target, other) in [(first, second), (second, first)] {
                let facing = Some(other.phrase.clone());
                let target = target.phrase.clone();
                self.operations.push(EditOperation::Rotate { target, by_rad: None, to_rad: None, facing });
            }
            return Ok(());
        }
        let end = self.phrase_end(from, &|_| false);
        if end == from {
            return self.not_understood(start, "say what it faces: the plate, the front, the left");
        }
        if matches!(self.word(from), "it" | "them" | "each" | "every" | "all" | "a" | "an") {
            return Err(self.error(from, end, Reason::SeveralLandmarks));
        }
        self.at = end;
        let facing = self.target_text(from, end);
        self.turned(targets, start, |target| {
            EditOperation::Rotate { target, by_rad: None, to_rad: None, facing: Some(facing.clone()) }
        })
    }

    fn turned(
        &mut self,
        targets: &[Target],
        start: usize,
        operation: impl Fn(String) -> EditOperation,
    ) -> Outcome<()> {
        let first = self.operations.len();
        for target in targets {
            if is_table(&target.phrase) {
                return Err(self.error(start, self.at, Reason::Table));
            }
            self.change(target, operation(target.phrase.clone()), start)?;
        }
        self.now_about(targets, first);
        Ok(())
    }

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

    fn factor_of(&mut self, usual: Option<f64>, grows: bool) -> Option<f64> {
        let directed = |share: f64| if grows { 1.0 + share } else { 1.0 - share };
        if self.take_any(&["a little bit", "a little", "a bit", "slightly"]) {
            return usual.map(|_| if grows { 1.1 } else { 1.0 / 1.1 });
        }
        if self.take("up") {
            return Some(usual.unwrap_or(BIGGER));
        }
        if self.take("down") {
            return Some(1.0 / BIGGER);
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

    fn resized(&mut self, targets: &[Target], factor: f64, from: usize) -> Outcome<()> {
        if !(1.0 / MAX_RESIZE..=MAX_RESIZE).contains(&factor) {
            return Err(self.error(from, self.at, Reason::Factor(factor)));
        }
        self.turned(targets, from, |target| EditOperation::Resize { target, factor })
    }

    /// The complement from an index on, with its length; a boundary follows.
    fn complement_at(&self, index: usize) -> Option<(Complement, usize)> {
        if let Some((mut factor, mut length)) = self.factor_at(index) {
            let at = index + length;
            if self.is_at(at, "by")
                && let Some((percent, number)) = self.number_at(at + 1)
                && matches!(self.word(at + 1 + number), "%" | "percent")
            {
                factor = if factor > 1.0 { 1.0 + percent / 100.0 } else { 1.0 - percent / 100.0 };
                length += number + 2;
            }
            return self.is_boundary(index + length).then_some((Complement::Factor(factor), length));
        }
        let opening = self.length_of_any(index, &["out of", "of", "in", "from"]).unwrap_or(0);
        let mut at = index + opening;
        let words = |length: usize, at: usize| (0..length).map(|k| self.word(at + k)).collect::<Vec<_>>().join(" ");
        let color_length = [2, 1].into_iter().find(|&length| color_of(&words(length, at)).is_some());
        let color = color_length.map(|length| self.text(at, at + length));
        at += color_length.unwrap_or(0);
        let material_length = [2, 1].into_iter().find(|&length| material_of(&words(length, at)).is_some());
        let material = material_length.map(|length| self.text(at, at + length));
        at += material_length.unwrap_or(0);
        let found = color.is_some() || material.is_some();
        (found && self.is_boundary(at)).then_some((Complement::Look { color, material }, at - index))
    }

    /// Where the complement of the clause begins.
    pub fn complement_index(&self, start: usize) -> Option<usize> {
        let end = (start..self.tokens.len()).find(|&index| self.is_end(index)).unwrap_or(self.tokens.len());
        let is_noun = |index: usize| {
            let word = self.word(index);
            let article = matches!(word, "the" | "a" | "an" | "my" | "all" | "both" | "these" | "every" | "each" | "to");
            !article && !self.is_boundary(index)
        };
        (start + 1..end).find(|&index| self.complement_at(index).is_some() && is_noun(index - 1))
    }

    /// "make X red", with the complement at an index.
    pub fn become_at(&mut self, index: usize) -> Outcome<()> {
        let start = self.at;
        let be = index.checked_sub(2).filter(|&at| self.is_at(at, "to be"));
        let targets = self.targets(&|_, at| at == be.unwrap_or(index))?;
        let _ = self.take("to be");
        if self.at != index {
            return self.not_understood(self.at, "say what it becomes: red, wooden, 20 % larger");
        }
        self.becomes(&targets, start)
    }

    /// The complement of the targets at the cursor.
    pub fn becomes(&mut self, targets: &[Target], start: usize) -> Outcome<()> {
        let index = self.at;
        let Some((complement, length)) = self.complement_at(index) else {
            return self.not_understood(index, "say what it becomes: red, wooden, 20 % larger");
        };
        self.at += length;
        match complement {
            Complement::Factor(factor) => self.resized(targets, factor, index),
            Complement::Look { color, material } => {
                let first = self.operations.len();
                for target in targets {
                    let operation = if is_table(&target.phrase) {
                        let finish = material.as_deref().and_then(material_of).is_none_or(|word| word.table.is_some());
                        if !finish {
                            return Err(self.error(index, self.at, Reason::TableMaterial));
                        }
                        EditOperation::RestyleTable { material: material.clone(), color: color.clone() }
                    } else {
                        let target = target.phrase.clone();
                        EditOperation::Recolor { target, color: color.clone(), material: material.clone() }
                    };
                    self.change(target, operation, start)?;
                }
                self.now_about(targets, first);
                Ok(())
            }
        }
    }

    /// "make X red", "make X bigger", "make X face Y".
    pub fn make(&mut self) -> Outcome<()> {
        let start = self.at;
        if self.take_any(&["a stack of", "a pile of", "a stack out of", "a pile out of"]) {
            return self.stack();
        }
        let end = self.phrase_end(start, &|index| self.length_of_any(index, &["face", "point at", "look at"]).is_some());
        if self.length_of_any(end, &["face", "point at", "look at"]).is_some() {
            let targets = self.targets(&|_, index| index == end)?;
            let _ = self.take_any(&["face", "point at", "look at"]);
            let _ = self.take_any(&["toward", "towards", "to"]);
            return self.faced(&targets, start);
        }
        match self.complement_index(start) {
            Some(index) => self.become_at(index),
            None => self.not_understood(start, "say what it becomes: red, wooden, 20 % larger, twice as large"),
        }
    }

    /// "change X to red", "change X's color to red", "change X to a glass".
    pub fn change_to(&mut self) -> Outcome<()> {
        let start = self.at;
        let to = ["to", "into", "for", "'s", "with"];
        if self.take_any(&["its color", "its colour", "its material", "their color", "their colour"]) {
            // The possessive stands for the object itself.
            self.at -= 1;
            let word = if self.word(self.at - 1) == "its" { "it" } else { "them" };
            self.tokens[self.at].word = word.to_owned();
            return self.color_of();
        }
        let targets = self.targets(&|cursor, index| cursor.length_of_any(index, &to).is_some())?;
        if self.take_any(&["'s color to", "'s colour to", "'s material to"]) {
            return self.becomes(&targets, start);
        }
        if self.take_any(&["'s label to", "'s name to"]) {
            return self.named(&targets, start);
        }
        if !self.take_any(&["to", "into", "for", "with"]) {
            return self.not_understood(start, "say what it becomes: change the mug to a glass");
        }
        if self.complement_at(self.at).is_some() {
            return self.becomes(&targets, start);
        }
        self.at = start;
        self.replace(start.saturating_sub(1), &["to", "into", "for", "with"])
    }

    /// "the color of X to red".
    pub fn color_of(&mut self) -> Outcome<()> {
        let start = self.at;
        let targets = self.targets(&|cursor, index| cursor.length_of_any(index, &["to", "into"]).is_some())?;
        if !self.take_any(&["to", "into"]) {
            return self.not_understood(start, "say which color: to red");
        }
        self.becomes(&targets, start)
    }

    /// "rename X to Y".
    pub fn relabel(&mut self) -> Outcome<()> {
        let start = self.at;
        let to = ["to", "as", "into"];
        let quoted = |cursor: &Self, index: usize| cursor.tokens.get(index).is_some_and(|token| token.quoted);
        let targets = self.targets(&|cursor, index| {
            cursor.length_of_any(index, &to).is_some() || quoted(cursor, index)
        })?;
        if !self.take_any(&to) && !quoted(self, self.at) {
            return self.not_understood(start, "say the new label: to \"tool box\"");
        }
        self.named(&targets, start)
    }

    fn named(&mut self, targets: &[Target], start: usize) -> Outcome<()> {
        let from = self.at;
        let _ = self.take_any(&["the", "a", "an"]);
        let begin = self.at;
        let is_name = |index: usize| {
            let boundary = self.is_end(index) || matches!(self.word(index), "," | "then" | "please" | "thanks");
            let clause = self.word(index) == "and" && self.is_verb(index + self.connector_at(index));
            index < self.tokens.len() && (self.tokens[index].quoted || (!boundary && !clause))
        };
        let end = (begin..=self.tokens.len()).find(|&index| !is_name(index)).unwrap_or(begin);
        self.at = end;
        let label = self.text(begin, self.at);
        if label.is_empty() {
            return self.not_understood(from, "say the new label: to \"tool box\"");
        }
        if targets.iter().any(|target| is_table(&target.phrase)) {
            return Err(self.error(start, self.at, Reason::Table));
        }
        let first = self.operations.len();
        for target in targets {
            let operation = EditOperation::Relabel { target: target.phrase.clone(), label: label.clone() };
            self.change(target, operation, start)?;
        }
        self.now_about(targets, first);
        Ok(())
    }
}
