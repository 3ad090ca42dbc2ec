//! A cursor over the tokens of an instruction, with what has been read so far.

use super::discourse::Discourse;
use super::tokens::Token;
use super::{InstructionError, Reason};
use scene::EditOperation;

pub(super) type Outcome<T> = Result<T, InstructionError>;

pub(super) struct Cursor {
    pub tokens: Vec<Token>,
    pub at: usize,
    pub operations: Vec<EditOperation>,
    pub discourse: Discourse,
}

impl Cursor {
    /// The word at an index; empty beyond the end.
    pub fn word(&self, index: usize) -> &str {
        self.tokens.get(index).filter(|token| !token.quoted).map_or("", |token| token.word.as_str())
    }

    /// Whether these words, separated by spaces, stand at an index.
    pub fn is_at(&self, index: usize, pattern: &str) -> bool {
        pattern.split(' ').enumerate().all(|(k, word)| self.word(index + k) == word)
    }

    /// The number of words of the first pattern that stands at an index.
    pub fn length_of_any(&self, index: usize, patterns: &[&str]) -> Option<usize> {
        let found = patterns.iter().find(|pattern| self.is_at(index, pattern))?;
        Some(found.split(' ').count())
    }

    /// Consumes these words if they follow.
    pub fn take(&mut self, pattern: &str) -> bool {
        let follows = self.is_at(self.at, pattern);
        self.at += if follows { pattern.split(' ').count() } else { 0 };
        follows
    }

    /// Consumes the first of these patterns that follows.
    pub fn take_any(&mut self, patterns: &[&str]) -> bool {
        patterns.iter().any(|pattern| self.take(pattern))
    }

    pub fn is_end(&self, index: usize) -> bool {
        index >= self.tokens.len() || self.word(index) == "."
    }

    /// The tokens as written, separated by spaces.
    pub fn text(&self, from: usize, to: usize) -> String {
        let mut text = String::new();
        let to = to.min(self.tokens.len());
        for token in &self.tokens[from.min(to)..to] {
            if !text.is_empty() && !matches!(token.word.as_str(), "'s" | ",") {
                text.push(' ');
            }
            // A phrase may begin the sentence.
            let is_article =
                matches!(token.word.as_str(), "the" | "a" | "an" | "all" | "both" | "every" | "each");
            text.push_str(if is_article { &token.word } else { &token.text });
        }
        text
    }

    /// An error about the tokens of a range.
    pub fn error(&self, from: usize, to: usize, reason: Reason) -> InstructionError {
        let to = to.clamp(from + 1, self.tokens.len().max(from + 1));
        let end = self.tokens.last().map_or(0, |token| token.span.end);
        let span = match (self.tokens.get(from), self.tokens.get(to - 1)) {
            (Some(first), Some(last)) => first.span.start..last.span.end,
            (Some(first), None) => first.span.start..end,
            _ => end..end,
        };
        InstructionError { words: self.text(from.min(self.tokens.len()), to), span, reason }
    }

    /// An error about what follows in the clause.
    pub fn not_understood<T>(&self, from: usize, advice: &'static str) -> Outcome<T> {
        let end = (from..self.tokens.len()).find(|&index| self.is_end(index)).unwrap_or(self.tokens.len());
        Err(self.error(from, end, Reason::NotUnderstood(advice)))
    }
}
