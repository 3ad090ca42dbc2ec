//! The first words of doc comments. They state what the item is or computes: a noun phrase, or a verb in the third
//! person. A relative clause or a pronoun leaves that to the reader.

use crate::source::Source;
use crate::{Finding, Rule};

/// Words that no doc comment begins with. "Whether" is the usual form for truth values.
const BANNED: &[&str] = &[
    "How", "It", "Its", "That", "Their", "These", "They", "This", "Those", "What", "When", "Where", "Which",
    "Who", "Whose", "Why",
];

/// Doc comments of the file that begin with one of these words.
pub fn findings(source: &Source) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut previous = (0, "");
    for comment in &source.comments {
        let marker = ["///", "//!"].into_iter().find(|marker| comment.text.starts_with(marker));
        let Some(marker) = marker.filter(|_| !comment.text.starts_with("////")) else { continue };
        let continues = previous == (comment.line - 1, marker);
        previous = (comment.line, marker);
        let text = comment.text[marker.len()..].trim_start();
        let end = text.find(|c: char| !c.is_alphabetic()).unwrap_or(text.len());
        if !continues && BANNED.contains(&&text[..end]) {
            findings.push(Finding {
                rule: Rule::DocOpening,
                path: source.path.clone(),
                line: comment.line,
                subject: text[..end].to_owned(),
                text: comment.text.clone(),
            });
        }
    }
    findings
}
