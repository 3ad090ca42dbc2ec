//! The width of comment lines. rustfmt and ruff keep the width of code and leave comments as they are.

use crate::source::Source;
use crate::{Finding, Rule};

/// Widest a line with a comment may be, in columns.
pub const MAX_COLUMNS: usize = 120;

/// Lines with a comment that are wider than [`MAX_COLUMNS`]. A link that alone fills a line cannot be broken.
pub fn findings(source: &Source) -> Vec<Finding> {
    let lines: Vec<&str> = source.text.lines().collect();
    let mut findings = Vec::new();
    let mut comments = source.comments.clone();
    comments.dedup_by_key(|comment| comment.line);
    for comment in &comments {
        let Some(line) = lines.get(comment.line - 1) else { continue };
        let columns = line.chars().count();
        let words = comment.text.split_whitespace().count();
        let is_link = comment.text.contains("://") && words <= 2;
        if columns > MAX_COLUMNS && !is_link {
            findings.push(Finding {
                rule: Rule::CommentWidth,
                path: source.path.clone(),
                line: comment.line,
                subject: format!("{columns} columns"),
                text: line.trim().to_owned(),
            });
        }
    }
    findings
}
