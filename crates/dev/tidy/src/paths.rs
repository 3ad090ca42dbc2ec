//! The paths that a file names, with `use` trees unfolded: `use crate::{a::{b, c}, d}` names three.

use crate::lexer::Token;
use crate::source::Source;

/// A path as written, from its first segment on, with `self` and `super` resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPath {
    /// `["crate", "geometry", "Pose"]` or `["std", "fs", "read"]`.
    pub segments: Vec<String>,
    pub line: usize,
}

impl NamedPath {
    pub fn spelled(&self) -> String {
        self.segments.join("::")
    }
}

/// Every path of the shipped code that has at least two segments or stands in a `use`.
pub fn paths(source: &Source) -> Vec<NamedPath> {
    let module = source.module();
    let (tokens, mut named, mut i) = (&source.shipped, Vec::new(), 0);
    while i < tokens.len() {
        if !starts_a_path(&tokens[i]) || continues_a_path(&tokens[..i]) {
            i += 1;
            continue;
        }
        let before = tokens[..i].iter().rev().find(|t| t.text != "::");
        let in_use = before.is_some_and(|t| t.text == "use");
        let mut unfolded = Vec::new();
        let end = unfold(tokens, i, &[], &mut unfolded);
        named.extend(unfolded.into_iter().filter(|p| in_use || p.segments.len() > 1));
        i = end.max(i + 1);
    }
    named.into_iter().map(|path| resolve(path, &module)).collect()
}

fn starts_a_path(token: &Token) -> bool {
    token.is_identifier() && !matches!(token.text.as_str(), "use" | "return" | "as")
}

/// `a::` or `<T>::` stands before; a leading `::` starts a path.
fn continues_a_path(before: &[Token]) -> bool {
    match before {
        [.., name, sign] if sign.text == "::" => name.text == ">" || starts_a_path(name),
        _ => false,
    }
}

/// Reads one tree at `i`; gives the index after it.
fn unfold(tokens: &[Token], mut i: usize, prefix: &[String], named: &mut Vec<NamedPath>) -> usize {
    let mut segments = prefix.to_vec();
    let line = tokens.get(i).map_or(0, |t| t.line);
    while let Some(token) = tokens.get(i) {
        if token.text == "{" {
            i += 1;
            while tokens.get(i).is_some_and(|t| t.text != "}") {
                let next = unfold(tokens, i, &segments, named);
                i = if tokens.get(next).is_some_and(|t| t.text == ",") { next + 1 } else { next.max(i + 1) };
            }
            return i + 1;
        }
        if token.text != "*" && !token.is_identifier() {
            break;
        }
        segments.push(token.text.clone());
        i += 1;
        if tokens.get(i).is_some_and(|t| t.text == "as") {
            i += 2; // The new name matters to this file only.
        }
        if tokens.get(i).is_none_or(|t| t.text != "::") {
            break;
        }
        i += 1;
    }
    named.push(NamedPath { segments, line });
    i
}

/// Turns `self::x` and `super::x` into `crate::...`.
fn resolve(path: NamedPath, module: &[&str]) -> NamedPath {
    let mut base: Vec<String> = module.iter().map(|s| (*s).to_owned()).collect();
    let mut rest = path.segments.as_slice();
    if !matches!(rest.first().map(String::as_str), Some("self" | "super")) {
        return path;
    }
    while let Some(first) = rest.first() {
        match first.as_str() {
            "self" => {}
            "super" => drop(base.pop()),
            _ => break,
        }
        rest = &rest[1..];
    }
    let segments = std::iter::once("crate".to_owned()).chain(base).chain(rest.iter().cloned()).collect();
    NamedPath { segments, line: path.line }
}
