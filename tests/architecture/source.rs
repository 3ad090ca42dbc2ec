//! One source file as the architecture tests see it: its words, without comments, strings and test code.
//!
//! A lexer of the few rules that matter here (nested comments, raw strings, lifetimes) instead of a
//! parser: it needs no dependency and cannot fail on code that the compiler accepts.

use std::fs;
use std::path::{Path, PathBuf};

/// A word or a sign, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    /// An identifier, `::`, or one character.
    pub text: String,
    /// Counted from 1.
    pub line: usize,
}

/// One file of `src/`, `tests/` or `benches/`.
pub struct Source {
    /// Relative to the repository, with `/`.
    pub path: String,
    pub text: String,
    /// Everything but comments, literals and what stands under `cfg(test)`.
    pub tokens: Vec<Token>,
    /// Declared under `cfg(test)` by its parent, so that only tests see it.
    pub is_test: bool,
}

impl Source {
    /// `["align", "dro", "crop"]` of `src/align/dro/crop.rs`; empty for `lib.rs` and `main.rs`.
    pub fn module(&self) -> Vec<&str> {
        let inner = self.path.trim_start_matches("src/").trim_end_matches(".rs");
        if matches!(inner, "lib" | "main") { Vec::new() } else { inner.split('/').collect() }
    }

    /// First segment of [`Self::module`]: a row of the import table.
    pub fn row(&self) -> &str {
        self.path.trim_start_matches("src/").trim_end_matches(".rs").split('/').next().unwrap_or_default()
    }
}

/// Every Rust file below `folder` of the repository, by path.
pub fn sources(folder: &str) -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    collect(&root.join(folder), &mut paths);
    paths.sort();
    let mut found = Vec::new();
    let mut under_test = Vec::new();
    for path in paths {
        let text =
            fs::read_to_string(&path).unwrap_or_else(|e| panic!("cannot read {}: {e}", path.display()));
        let relative = path.strip_prefix(root).expect("files are found below the root");
        let relative = relative.to_string_lossy().replace('\\', "/");
        let (tokens, test_modules) = without_tests(&tokens(&text));
        let folder = match relative.strip_suffix("/lib.rs").or(relative.strip_suffix("/main.rs")) {
            Some(folder) => folder.to_owned(),
            None => relative.trim_end_matches(".rs").to_owned(),
        };
        under_test.extend(test_modules.into_iter().map(|name| format!("{folder}/{name}")));
        found.push(Source { path: relative, text, tokens, is_test: false });
    }
    for source in &mut found {
        let name = source.path.trim_end_matches(".rs");
        source.is_test = under_test.iter().any(|test| name == test || name.starts_with(&format!("{test}/")));
    }
    found
}

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, paths);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            paths.push(path);
        }
    }
}

/// The words and signs of a file; comments are dropped, each literal becomes one `"`.
pub fn tokens(text: &str) -> Vec<Token> {
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let (mut tokens, mut i, mut line) = (Vec::new(), 0, 1);
    while i < chars.len() {
        let (start, first_line) = (i, line);
        let token = match at(i) {
            '/' if at(i + 1) == '/' => {
                while i < chars.len() && at(i) != '\n' {
                    i += 1;
                }
                None
            }
            '/' if at(i + 1) == '*' => {
                i = end_of_comment(&chars, i);
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
                i += 1; // a lifetime: its name follows as a word
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
        tokens.extend(token.map(|text| Token { text, line: first_line }));
    }
    tokens
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
        let closed = chars[end] == '"' && chars[end + 1..].iter().take(hashes).all(|c| *c == '#');
        if closed && chars.len() > end + hashes {
            return end + hashes + 1;
        }
        end += 1;
    }
    end
}

/// Drops every item under `#[cfg(test)]` or `#[test]`; also gives the names of modules declared so.
pub fn without_tests(tokens: &[Token]) -> (Vec<Token>, Vec<String>) {
    let (mut kept, mut modules, mut i) = (Vec::new(), Vec::new(), 0);
    while i < tokens.len() {
        if !is_test_attribute(&tokens[i..]) {
            kept.push(tokens[i].clone());
            i += 1;
            continue;
        }
        i = end_of_group(tokens, i + 1);
        while tokens.get(i).is_some_and(|t| t.text == "#") {
            i = end_of_group(tokens, i + 1); // further attributes of the same item
        }
        let start = i;
        while i < tokens.len() && tokens[i].text != ";" && tokens[i].text != "{" {
            i = if matches!(tokens[i].text.as_str(), "(" | "[") { end_of_group(tokens, i) } else { i + 1 };
        }
        let words = &tokens[start..i.min(tokens.len())];
        if let Some(at) = words.iter().position(|t| t.text == "mod")
            && tokens.get(i).is_some_and(|t| t.text == ";")
        {
            modules.extend(words.get(at + 1).map(|t| t.text.clone()));
        }
        let is_use = words.iter().any(|t| t.text == "use");
        i = if tokens.get(i).is_some_and(|t| t.text == "{") { end_of_group(tokens, i) } else { i + 1 };
        if is_use && tokens.get(i).is_some_and(|t| t.text == ";") {
            i += 1;
        }
    }
    (kept, modules)
}

/// `#[cfg(test)]`, `#[cfg(all(test, ...))]`, `#[test]`; not `#[cfg(not(test))]`.
fn is_test_attribute(tokens: &[Token]) -> bool {
    if tokens.first().is_none_or(|t| t.text != "#") || tokens.get(1).is_none_or(|t| t.text != "[") {
        return false;
    }
    let words: Vec<&str> = tokens[1..end_of_group(tokens, 1)].iter().map(|t| t.text.as_str()).collect();
    match words.get(1) {
        Some(&"test") => words.len() == 3,
        Some(&"cfg") => words.contains(&"test") && !words.contains(&"not") && !words.contains(&"any"),
        _ => false,
    }
}

/// Index after the bracket that closes the one at `open`.
fn end_of_group(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0usize;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    tokens.len()
}
