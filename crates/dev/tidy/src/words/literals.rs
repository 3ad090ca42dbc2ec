//! Banned words of string literals that people read: messages, reports, texts of the command line.

use super::text::banned_in_text;
use crate::lexer::Token;

/// Literals of fewer words are names, keys and vocabulary.
const SENTENCE_WORDS: usize = 3;

/// The banned words of a literal of several words, each with its line.
pub fn banned_in_literal(token: &Token) -> Vec<(String, usize)> {
    // Escapes are no parts of words: `\nA`.
    let text = token.literal.replace("\\n", "  ").replace("\\t", "  ");
    if text.split_whitespace().count() < SENTENCE_WORDS {
        return Vec::new();
    }
    let lines = text.split('\n').enumerate();
    lines
        .flat_map(|(k, line)| banned_in_text(line).into_iter().map(move |word| (word, token.line + k)))
        .collect()
}
