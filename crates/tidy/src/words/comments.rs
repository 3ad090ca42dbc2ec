//! Banned whole words of comments.

const BANNED: &[&str] = &[
    "belief", "beliefs", "bite", "bites", "knob", "knobs", "look", "looked", "looks", "middle", "nobody",
    "picture", "pictures", "somebody", "thing", "things", "told", "whoever", "wish", "wishes",
];

/// Beginnings of banned words.
const BANNED_STEMS: &[&str] = &["believe", "paint"];

/// The banned words of one comment line, in lower case.
pub fn banned_in_comment(comment: &str) -> Vec<String> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut banned = Vec::new();
    let mut rest = comment;
    while let Some(start) = rest.find(is_part) {
        let word = &rest[start..];
        let end = word.find(|c| !is_part(c)).unwrap_or(word.len());
        let (word, after) = word.split_at(end);
        let lower = word.to_lowercase();
        let is_stem = BANNED_STEMS.iter().any(|stem| lower.starts_with(stem)) && !lower.contains('_');
        if (is_stem || BANNED.contains(&lower.as_str())) && !is_phrase(&lower, after) {
            banned.push(lower);
        }
        rest = after;
    }
    banned
}

/// The standard terms "look up", "look-ahead" and "look-at", also inflected.
fn is_phrase(word: &str, after: &str) -> bool {
    if !word.starts_with("look") {
        return false;
    }
    let next: String = after.chars().skip(1).take_while(|c| c.is_alphanumeric()).collect();
    match after.chars().next() {
        Some(' ') => next == "up",
        Some('-') => matches!(next.as_str(), "up" | "ahead" | "at"),
        _ => false,
    }
}
