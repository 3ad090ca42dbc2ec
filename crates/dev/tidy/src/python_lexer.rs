//! Splits Python text into words, signs, string literals and comment lines, as `lexer` does with Rust.
//!
//! A docstring, that is a statement of one string, is a comment. Adjacent strings are one literal. Expressions in an
//! f-string give tokens of their own, and `{}` stands for each of them in the literal, as in a format string of Rust.
//! The quotation mark of an f-string inside its expressions, which Python allows since 3.12, would end the string.

use crate::lexer::{CommentLine, Lexed, Token};

pub fn lex(text: &str) -> Lexed {
    lex_from(text, 1, 0)
}

/// The content of a text that begins in `line` and within `depth` brackets.
fn lex_from(text: &str, line: usize, depth: usize) -> Lexed {
    let chars = text.chars().collect();
    let mut lexer = Lexer { chars, line, depth, is_at_statement: depth == 0, ..Lexer::default() };
    while lexer.at < lexer.chars.len() {
        lexer.step();
    }
    lexer.lexed
}

#[derive(Default)]
struct Lexer {
    chars: Vec<char>,
    lexed: Lexed,
    at: usize,
    /// Counted from 1.
    line: usize,
    /// Number of open brackets.
    depth: usize,
    /// Only spaces and comments stand between `at` and the begin of a statement.
    is_at_statement: bool,
    /// The token of a literal that the next string would continue, and the spaces after it.
    continued: Option<(usize, String)>,
}

impl Lexer {
    /// Reads a comment, a string, a word, a sign or a space.
    fn step(&mut self) {
        let first = self.chars[self.at];
        let word = self.chars[self.at..].iter().take_while(|c| c.is_alphanumeric() || **c == '_').count();
        if first == '#' {
            let end = self.end_of_line(self.at);
            self.lexed.comments.push(CommentLine { text: self.text(self.at, end), line: self.line });
            self.at = end;
        } else if self.is_string(word) {
            self.string(word);
        } else if word > 0 {
            self.token(self.at + word);
        } else if first.is_whitespace() || first == '\\' {
            self.space(first);
        } else {
            match first {
                '(' | '[' | '{' => self.depth += 1,
                ')' | ']' | '}' => self.depth = self.depth.saturating_sub(1),
                _ => {}
            }
            self.token(self.at + 1);
        }
    }

    fn space(&mut self, space: char) {
        let joins_lines = space == '\\' && self.chars.get(self.at + 1) == Some(&'\n');
        if space == '\n' && self.depth == 0 {
            (self.is_at_statement, self.continued) = (true, None);
        }
        if let Some((_, spaces)) = &mut self.continued {
            spaces.push_str(if joins_lines || space == '\n' { "\n" } else { " " });
        }
        self.line += usize::from(joins_lines || space == '\n');
        self.at += if joins_lines { 2 } else { 1 };
    }

    fn token(&mut self, end: usize) {
        let token = Token { text: self.text(self.at, end), literal: String::new(), line: self.line };
        self.lexed.tokens.push(token);
        (self.at, self.is_at_statement, self.continued) = (end, false, None);
    }

    /// Whether the word of this length is the prefix of a string. No word is one too.
    fn is_string(&self, word: usize) -> bool {
        let mut prefix = self.chars[self.at..self.at + word].iter();
        word <= 2
            && prefix.all(|c| "rRbBuUfF".contains(*c))
            && matches!(self.chars.get(self.at + word), Some('"' | '\''))
    }

    fn string(&mut self, prefix: usize) {
        let (start, first_line) = (self.at, self.line);
        let end = end_of_string(&self.chars, start + prefix);
        let written = self.text(start, end);
        let lines = written.matches('\n').count();
        (self.at, self.line) = (end, first_line + lines);
        if self.is_at_statement && self.depth == 0 && self.ends_statement() {
            let lines = written.split('\n').enumerate();
            let comments = lines.map(|(k, text)| CommentLine { text: text.to_owned(), line: first_line + k });
            self.lexed.comments.extend(comments);
            return;
        }
        let is_formatted = self.chars[start..start + prefix].iter().any(|c| matches!(c, 'f' | 'F'));
        let literal = if is_formatted { self.fields(&written, first_line) } else { written };
        let (token, spaces) = self.continued.take().unwrap_or_else(|| {
            self.lexed.tokens.push(Token { text: "\"".to_owned(), literal: String::new(), line: first_line });
            (self.lexed.tokens.len() - 1, String::new())
        });
        self.lexed.tokens[token].literal.push_str(&(spaces + &literal));
        (self.is_at_statement, self.continued) = (false, Some((token, String::new())));
    }

    /// Adds the tokens of the expressions in an f-string. Returns the literal with `{}` in place of each.
    fn fields(&mut self, written: &str, mut line: usize) -> String {
        let chars: Vec<char> = written.chars().collect();
        let (mut literal, mut i) = (String::new(), 0);
        while i < chars.len() {
            let is_brace = chars[i] == '{' && chars.get(i + 1) == Some(&'{');
            let is_field = chars[i] == '{' && !is_brace;
            let end = if is_field { end_of_field(&chars, i) } else { i + 1 + usize::from(is_brace) };
            let part: String = chars[i..end].iter().collect();
            let lines = part.matches('\n').count();
            if is_field {
                let expression = part[1..].strip_suffix('}').unwrap_or(&part[1..]);
                self.lexed.tokens.extend(lex_from(expression, line, 1).tokens);
                literal.push_str(&format!("{{{}}}", "\n".repeat(lines)));
            } else {
                literal.push_str(&part);
            }
            (line, i) = (line + lines, end);
        }
        literal
    }

    /// Whether nothing but spaces and a comment follows on the line.
    fn ends_statement(&self) -> bool {
        let rest = self.text(self.at, self.end_of_line(self.at));
        rest.trim().is_empty() || rest.trim_start().starts_with('#')
    }

    fn end_of_line(&self, at: usize) -> usize {
        at + self.chars[at.min(self.chars.len())..].iter().take_while(|c| **c != '\n').count()
    }

    fn text(&self, start: usize, end: usize) -> String {
        self.chars[start.min(self.chars.len())..end.min(self.chars.len())].iter().collect()
    }
}

/// Index after the string whose first quotation mark stands at `quote`. A backslash keeps the next mark, even in a raw
/// string.
fn end_of_string(chars: &[char], quote: usize) -> usize {
    let mark = chars[quote];
    let is_mark = |at: usize| chars.get(at) == Some(&mark);
    let marks = if is_mark(quote + 1) && is_mark(quote + 2) { 3 } else { 1 };
    let mut i = quote + marks;
    while i < chars.len() && !(0..marks).all(|k| is_mark(i + k)) {
        i += if chars[i] == '\\' { 2 } else { 1 };
    }
    (i + marks).min(chars.len())
}

/// Index after the expression that begins with the brace at `open`, with its format.
fn end_of_field(chars: &[char], open: usize) -> usize {
    let (mut depth, mut i) = (0usize, open);
    while i < chars.len() {
        match chars[i] {
            '{' => depth += 1,
            '}' => depth -= 1,
            '"' | '\'' => {
                i = end_of_string(chars, i);
                continue;
            }
            _ => {}
        }
        i += 1;
        if depth == 0 {
            break;
        }
    }
    i
}
