//! Splits Rust or WGSL text into words, signs and comment lines.
//!
//! A lexer of the few rules that matter here (nested comments, raw strings, lifetimes) replaces a parser: it needs no
//! dependency and cannot fail on code that the compiler accepts.

/// A word or a sign and its line.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    /// An identifier, a number, `::`, one other character, or `"` for a whole literal.
    pub text: String,
    /// The literal as written, with its quotes; empty for other tokens.
    pub literal: String,
    /// Counted from 1.
    pub line: usize,
}

impl Token {
    pub fn is_identifier(&self) -> bool {
        self.text.starts_with(|c: char| c.is_alphabetic() || c == '_')
    }
}

/// One line of a comment, with its markers.
#[derive(Clone, Debug, PartialEq)]
pub struct CommentLine {
    pub text: String,
    /// Counted from 1.
    pub line: usize,
}

/// The content of one file.
#[derive(Clone, Debug, Default)]
pub struct Lexed {
    pub tokens: Vec<Token>,
    pub comments: Vec<CommentLine>,
}

pub fn lex(text: &str) -> Lexed {
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut lexed, mut i, mut line) = (Lexed::default(), 0, 1);
    while i < chars.len() {
        let (start, first_line) = (i, line);
        let token = match at(i) {
            '/' if at(i + 1) == '/' => {
                while i < chars.len() && at(i) != '\n' {
                    i += 1;
                }
                lexed.comments.push(CommentLine { text: chars[start..i].iter().collect(), line });
                None
            }
            '/' if at(i + 1) == '*' => {
                i = end_of_comment(&chars, i);
                let comment: String = chars[start..i].iter().collect();
                let lines = comment.split('\n').enumerate();
                lexed.comments.extend(lines.map(|(k, l)| CommentLine { text: l.to_owned(), line: line + k }));
                None
            }
            '"' => {
                i = end_of_string(&chars, i);
                Some("\"".to_owned())
            }
            '\'' if at(i + 1) == '\\' || at(i + 2) == '\'' => {
                i += if at(i + 1) == '\\' { 3 } else { 2 };
                while i < chars.len() && at(i) != '\'' {
                    i += 1;
                }
                i += 1;
                Some("\"".to_owned())
            }
            '\'' => {
                i += 1; // A lifetime: its name follows as a word.
                None
            }
            c if is_word(c) => {
                while is_word(at(i)) {
                    i += 1;
                }
                let word: String = chars[start..i].iter().collect();
                if matches!(word.as_str(), "r" | "br" | "cr") && raw_hashes(&chars, i).is_some() {
                    i = end_of_raw_string(&chars, i);
                    Some("\"".to_owned())
                } else {
                    Some(word)
                }
            }
            ':' if at(i + 1) == ':' => {
                i += 2;
                Some("::".to_owned())
            }
            c => {
                i += 1;
                (!c.is_whitespace()).then(|| c.to_string())
            }
        };
        line += chars[start..i.min(chars.len())].iter().filter(|c| **c == '\n').count();
        lexed.tokens.extend(token.map(|text| {
            let is_literal = text == "\"";
            let literal =
                if is_literal { chars[start..i.min(chars.len())].iter().collect() } else { String::new() };
            Token { text, literal, line: first_line }
        }));
    }
    lexed
}

fn end_of_comment(chars: &[char], mut i: usize) -> usize {
    let mut depth = 0;
    while i < chars.len() {
        match (chars[i], chars.get(i + 1)) {
            ('/', Some('*')) => (depth, i) = (depth + 1, i + 2),
            ('*', Some('/')) => (depth, i) = (depth - 1, i + 2),
            _ => i += 1,
        }
        if depth == 0 {
            break;
        }
    }
    i
}

fn end_of_string(chars: &[char], mut i: usize) -> usize {
    i += 1;
    while i < chars.len() && chars[i] != '"' {
        i += if chars[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

/// Number of `#` of a raw string whose prefix ends before `i`.
fn raw_hashes(chars: &[char], i: usize) -> Option<usize> {
    let hashes = chars[i..].iter().take_while(|c| **c == '#').count();
    (chars.get(i + hashes) == Some(&'"')).then_some(hashes)
}

fn end_of_raw_string(chars: &[char], i: usize) -> usize {
    let hashes = raw_hashes(chars, i).unwrap_or_default();
    let mut end = i + hashes + 1;
    while end < chars.len() {
        let after = &chars[end + 1..];
        if chars[end] == '"' && after.len() >= hashes && after[..hashes].iter().all(|c| *c == '#') {
            return end + hashes + 1;
        }
        end += 1;
    }
    end
}
