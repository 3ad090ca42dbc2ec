//! Words that the tree avoids, because a standard term is more exact.
//!
//! Identifiers are split into segments (`snake_case`, `CamelCase`); comments, docstrings of Python, documents and
//! string literals outside tests into whole words. Literals of one or two words are free: they are names and the
//! vocabulary of texts. `allowed.rs` lists where a word is the standard term or part of an input.

mod list;
mod text;
mod identifiers;
mod literals;
mod type_names;

pub use identifiers::{banned_in_identifier, segments};
pub use text::banned_in_text;

use crate::allowed::is_allowed;
use crate::source::Source;
use crate::{Finding, Rule};

/// Every banned word of the file that the table of exceptions does not allow, by line.
pub fn findings(source: &Source) -> Vec<Finding> {
    let mut findings = all_findings(source);
    findings.retain(|finding| !is_allowed(finding));
    findings
}

/// Findings before exceptions.
pub fn all_findings(source: &Source) -> Vec<Finding> {
    let lines: Vec<&str> = source.text.lines().collect();
    let mut findings = Vec::new();
    let mut add = |rule, line: usize, subject: &str| {
        findings.push(Finding {
            rule,
            path: source.path.clone(),
            line,
            subject: subject.to_owned(),
            text: lines.get(line - 1).map_or("", |l| l.trim()).to_owned(),
        });
    };
    for comment in &source.comments {
        for word in banned_in_text(&comment.text) {
            add(Rule::CommentWord, comment.line, &word);
        }
    }
    for token in source.tokens.iter().filter(|token| token.is_identifier()) {
        for word in banned_in_identifier(&token.text) {
            add(Rule::IdentifierWord, token.line, &word);
        }
    }
    for token in source.shipped.iter().filter(|_| !source.is_test) {
        for (word, line) in literals::banned_in_literal(token) {
            add(Rule::LiteralWord, line, &word);
        }
    }
    for (name, line) in type_names::declared_participles(&source.tokens) {
        add(Rule::TypeName, line, name);
    }
    findings.sort_by_key(|finding| finding.line);
    findings
}
