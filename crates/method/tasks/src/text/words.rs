//! Words of a text with their bytes.

use std::ops::Range;

/// A word in lower case.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Word {
    pub text: String,
    pub bytes: Range<usize>,
}

/// The words of a text: letters, digits and underscores; hyphens and punctuation separate them.
pub(super) fn words(text: &str) -> Vec<Word> {
    let mut words: Vec<Word> = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices().chain([(text.len(), ' ')]) {
        let is_part = c.is_alphanumeric() || matches!(c, '_' | '\'' | '’');
        match (is_part, start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                words.push(Word { text: text[from..at].to_lowercase(), bytes: from..at });
                start = None;
            }
            _ => {}
        }
    }
    words
}
