//! Commands that say what objects become: a color, a material, a size, a label.

use super::Reason;
use super::cursor::{Cursor, Outcome};
use super::discourse::Target;
use super::removals::is_table;
use crate::references::{color_of, material_of};
use scene::EditOperation;

/// Wanted size or appearance of an object.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Complement {
    Factor(f64),
    Appearance { color: Option<String>, material: Option<String> },
}

impl Cursor {
    /// The complement from an index on, with its length; a boundary follows.
    pub fn complement_at(&self, index: usize) -> Option<(Complement, usize)> {
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
        let words =
            |length: usize, at: usize| (0..length).map(|k| self.word(at + k)).collect::<Vec<_>>().join(" ");
        let color_length = [2, 1].into_iter().find(|&length| color_of(&words(length, at)).is_some());
        let color = color_length.map(|length| self.text(at, at + length));
        at += color_length.unwrap_or(0);
        let material_length = [2, 1].into_iter().find(|&length| material_of(&words(length, at)).is_some());
        let material = material_length.map(|length| self.text(at, at + length));
        at += material_length.unwrap_or(0);
        let found = color.is_some() || material.is_some();
        (found && self.is_boundary(at)).then_some((Complement::Appearance { color, material }, at - index))
    }

    /// Index of the token at which the complement of the clause begins.
    pub fn complement_index(&self, start: usize) -> Option<usize> {
        let end = self.clause_end(start);
        let is_noun = |index: usize| {
            let word = self.word(index);
            let article = matches!(
                word,
                "the" | "a" | "an" | "my" | "all" | "both" | "these" | "every" | "each" | "to"
            );
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
            Complement::Appearance { color, material } => {
                let first = self.operations.len();
                for target in targets {
                    let operation = if is_table(&target.phrase) {
                        let finish =
                            material.as_deref().and_then(material_of).is_none_or(|word| word.table.is_some());
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
        let end = self.phrase_end(start, &|index| {
            self.length_of_any(index, &["face", "point at", "look at"]).is_some()
        });
        if self.length_of_any(end, &["face", "point at", "look at"]).is_some() {
            let targets = self.targets(&|_, index| index == end)?;
            let _ = self.take_any(&["face", "point at", "look at"]);
            let _ = self.take_any(&["toward", "towards", "to"]);
            return self.faced(&targets, start);
        }
        match self.complement_index(start) {
            Some(index) => self.become_at(index),
            None => {
                self.not_understood(start, "say what it becomes: red, wooden, 20 % larger, twice as large")
            }
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
        let targets =
            self.targets(&|cursor, index| cursor.length_of_any(index, &["to", "into"]).is_some())?;
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
        let targets = self
            .targets(&|cursor, index| cursor.length_of_any(index, &to).is_some() || quoted(cursor, index))?;
        if !self.take_any(&to) && !quoted(self, self.at) {
            return self.not_understood(start, "say the new label: to \"tool box\"");
        }
        self.named(&targets, start)
    }

    pub fn named(&mut self, targets: &[Target], start: usize) -> Outcome<()> {
        let from = self.at;
        let _ = self.take_any(&["the", "a", "an"]);
        let begin = self.at;
        let is_name = |index: usize| {
            let boundary =
                self.is_end(index) || matches!(self.word(index), "," | "then" | "please" | "thanks");
            let next = index + self.connector_at(index);
            let clause = self.word(index) == "and" && (self.is_verb(next) || self.is_beginning(next));
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
