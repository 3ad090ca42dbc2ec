//! "put the apple in the bowl, then the spoon next to it": a verb that is left out after "then".
//!
//! The text parser repeats the verb after "and", so that "then" becomes "and" where a noun phrase follows. The text
//! keeps its length, and every other word its place.

use super::words::{is_determiner, words};

/// The text with "and" for "then" before noun phrases.
pub(super) fn completed(text: &str) -> String {
    let words = words(text);
    let mut bytes = text.as_bytes().to_vec();
    for pair in words.windows(2) {
        let [then, next] = pair else { continue };
        if then.text != "then" || !is_determiner(&next.text) || then.bytes.start == 0 {
            continue;
        }
        bytes[then.bytes.clone()].copy_from_slice(b"and ");
        // "; then", ". then": one sentence.
        let before = text[..then.bytes.start].trim_end();
        if before.ends_with([';', '.']) {
            bytes[before.len() - 1] = b',';
        }
        // "and then" is "and" once.
        if let Some(stem) = before.strip_suffix("and").filter(|stem| stem.ends_with([' ', ','])) {
            bytes[stem.len()..stem.len() + 3].copy_from_slice(b"   ");
        }
    }
    // Replaced bytes are ASCII in both texts.
    String::from_utf8(bytes).unwrap_or_else(|_| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn then_becomes_and_before_noun_phrases() {
        for (text, expected) in [
            ("put it in the bowl, then the spoon on it", "put it in the bowl, and  the spoon on it"),
            ("put it down; then the spoon on it", "put it down, and  the spoon on it"),
            ("put it down and then the spoon on it", "put it down     and  the spoon on it"),
            ("put it down, then put the spoon on it", "put it down, then put the spoon on it"),
            ("then the spoon", "then the spoon"),
        ] {
            assert_eq!(completed(text), expected);
        }
    }
}
