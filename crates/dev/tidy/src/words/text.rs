//! Banned whole words of comments, messages and documents.

use super::list::is_banned_in_text;

/// The banned words of a line, in lower case. Names of files ("pictures.md", "docs/pictures") are no words.
pub fn banned_in_text(text: &str) -> Vec<String> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut banned = Vec::new();
    let mut at = 0;
    while let Some(start) = text[at..].find(is_part).map(|offset| at + offset) {
        let end = text[start..].find(|c| !is_part(c)).map_or(text.len(), |length| start + length);
        let (word, after) = (text[start..end].to_lowercase(), &text[end..]);
        let is_path = text[..start].ends_with('/') || after.starts_with(".md") || after.starts_with(".json");
        if is_banned_in_text(&word) && !is_path && !is_phrase(&word, after) {
            banned.push(word);
        }
        at = end;
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
