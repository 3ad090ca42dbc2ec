//! Words, numbers, quotations and marks of an instruction.

use std::ops::Range;

/// A word or a mark.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    /// In lower case, without apostrophes; "," and "." for marks.
    pub word: String,
    /// As written.
    pub text: String,
    /// Bytes of the instruction.
    pub span: Range<usize>,
    pub quoted: bool,
    /// A question mark.
    pub asks: bool,
}

const CONTRACTIONS: &[&str] = &["let's", "that's", "there's", "it's", "what's", "where's", "here's"];

/// The tokens of a text. Sentence marks and semicolons become ".", a possessive "'s" is a token of its own.
pub(super) fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut characters = text.char_indices().peekable();
    while let Some((start, c)) = characters.next() {
        if c.is_whitespace() {
            continue;
        }
        if let Some(close) = closing_quote(c)
            && let Some(length) = text[start + c.len_utf8()..].find(close)
            && length > 0
        {
            let inside = start + c.len_utf8();
            let end = inside + length;
            tokens.push(token(&text[inside..end], start..end + close.len_utf8(), true));
            while characters.next_if(|(at, _)| *at < end + close.len_utf8()).is_some() {}
            continue;
        }
        let mut end = start + c.len_utf8();
        if is_part(c) {
            while let Some((at, next)) = characters.next_if(|&(at, next)| continues(text, at, next)) {
                end = at + next.len_utf8();
            }
            push_word(&mut tokens, text, start..end);
        } else {
            let mark = if matches!(c, '.' | '!' | '?' | ';' | ':' | '\n') { "." } else { &text[start..end] };
            let mut mark = token(mark, start..end, false);
            mark.asks = c == '?';
            tokens.push(mark);
        }
    }
    tokens
}

fn token(text: &str, span: Range<usize>, quoted: bool) -> Token {
    let word = text.to_lowercase().replace(['\'', '’'], "");
    Token { word, text: text.to_owned(), span, quoted, asks: false }
}

fn closing_quote(c: char) -> Option<char> {
    match c {
        '"' => Some('"'),
        '\'' => Some('\''),
        '“' => Some('”'),
        '‘' => Some('’'),
        _ => None,
    }
}

fn is_part(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '\'' | '’')
}

/// A point or a hyphen continues a word between letters or digits.
fn continues(text: &str, at: usize, c: char) -> bool {
    let next = text[at + c.len_utf8()..].chars().next();
    let before = text[..at].chars().next_back();
    match c {
        '.' => before.is_some_and(|c| c.is_ascii_digit()) && next.is_some_and(|c| c.is_ascii_digit()),
        '-' => next.is_some_and(char::is_alphanumeric),
        c => is_part(c),
    }
}

/// "10cm" is a number and a unit, "laptop's" a noun and a possessive.
fn push_word(tokens: &mut Vec<Token>, text: &str, span: Range<usize>) {
    let word = &text[span.clone()];
    let lower = word.to_lowercase().replace('’', "'");
    let digits = word.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(word.len());
    let unit = &lower[digits..];
    let is_unit = matches!(unit, "cm" | "mm" | "m" | "in" | "deg" | "degrees" | "x" | "rad" | "inches");
    if digits > 0 && is_unit {
        let split = span.start + digits;
        tokens.push(token(&word[..digits], span.start..split, false));
        tokens.push(token(&word[digits..], split..span.end, false));
        return;
    }
    if let Some(owner) = lower.strip_suffix("'s")
        && !CONTRACTIONS.contains(&lower.as_str())
    {
        let end = span.start + owner.len();
        tokens.push(token(&text[span.start..end], span.start..end, false));
        tokens.push(Token { word: "'s".to_owned(), ..token("'s", end..span.end, false) });
        return;
    }
    tokens.push(token(word, span, false));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_units_and_quotations_are_tokens() {
        let words = |text: &str| tokens(text).into_iter().map(|token| token.word).collect::<Vec<_>>();
        assert_eq!(words("Move it 10cm, please."), ["move", "it", "10", "cm", ",", "please", "."]);
        assert_eq!(words("1.5 times; 45°"), ["1.5", "times", ".", "45", "°"]);
        assert_eq!(words("the laptop's color"), ["the", "laptop", "'s", "color"]);
        assert_eq!(words("don't call it 'Tool Box'"), ["dont", "call", "it", "tool box"]);
        assert_eq!(words("mug_1 and tea-light"), ["mug_1", "and", "tea-light"]);
    }
}
