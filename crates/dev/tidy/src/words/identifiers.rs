//! Banned segments of identifiers.

use super::list::is_banned_in_names;

/// Pairs of segments that are standard terms.
const TERMS: &[[&str; 2]] = &[
    ["at", "least"],
    ["at", "most"],
    ["least", "squares"],
    ["look", "ahead"],
    ["look", "at"],
    ["look", "up"],
    ["most", "common"],
];

/// The banned segments of an identifier, in lower case.
pub fn banned_in_identifier(identifier: &str) -> Vec<String> {
    let segments = segments(identifier);
    let is_term = |i: usize| {
        TERMS.iter().any(|[first, second]| {
            let starts = segments[i] == *first && segments.get(i + 1).is_some_and(|s| s == second);
            let ends = i > 0 && segments[i - 1] == *first && segments[i] == *second;
            starts || ends
        })
    };
    let banned = segments.iter().enumerate().filter(|(i, s)| is_banned_in_names(s) && !is_term(*i));
    banned.map(|(_, segment)| segment.clone()).collect()
}

/// `TopView`, `top_view` and `TOP_VIEW` as `["top", "view"]`; `GPUTimer2` as `["gpu", "timer", "2"]`.
pub fn segments(identifier: &str) -> Vec<String> {
    let chars: Vec<char> = identifier.chars().collect();
    let (mut segments, mut segment) = (Vec::new(), String::new());
    for (i, c) in chars.iter().enumerate() {
        let before = if i == 0 { '_' } else { chars[i - 1] };
        let after_is_lower = chars.get(i + 1).is_some_and(|next| next.is_lowercase());
        let starts = *c == '_'
            || (c.is_uppercase() && (!before.is_uppercase() || after_is_lower))
            || (c.is_numeric() != before.is_numeric());
        if starts && !segment.is_empty() {
            segments.push(std::mem::take(&mut segment));
        }
        if *c != '_' {
            segment.extend(c.to_lowercase());
        }
    }
    if !segment.is_empty() {
        segments.push(segment);
    }
    segments
}
