//! The paths a file names, `use` trees unfolded: `use crate::{a::{b, c}, d}` names three.

use super::source::{Source, Token};

/// A path as written, from its first segment on, with `crate`, `self` and `super` resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// `["crate", "geometry", "Pose"]` or `["std", "fs", "read"]`.
    pub segments: Vec<String>,
    pub line: usize,
}

/// Every path of the file that has at least two segments, or stands in a `use`.
pub fn paths(source: &Source) -> Vec<Named> {
    let module = source.module();
    let mut found = Vec::new();
    let mut i = 0;
    while i < source.tokens.len() {
        let continues = i > 0 && source.tokens[i - 1].text == "::";
        if continues || !is_name(&source.tokens[i].text) {
            i += 1;
            continue;
        }
        let in_use = i > 0 && source.tokens[i - 1].text == "use";
        let mut unfolded = Vec::new();
        let end = unfold(&source.tokens, i, &[], &mut unfolded);
        found.extend(unfolded.into_iter().filter(|p| in_use || p.segments.len() > 1));
        i = end.max(i + 1);
    }
    found.into_iter().map(|named| resolve(named, &module)).collect()
}

/// Reads one tree at `i`; gives the index after it.
fn unfold(tokens: &[Token], mut i: usize, prefix: &[String], found: &mut Vec<Named>) -> usize {
    let mut segments = prefix.to_vec();
    let line = tokens.get(i).map_or(0, |t| t.line);
    while let Some(token) = tokens.get(i) {
        if token.text == "{" {
            i += 1;
            while tokens.get(i).is_some_and(|t| t.text != "}") {
                let next = unfold(tokens, i, &segments, found);
                i = if tokens.get(next).is_some_and(|t| t.text == ",") { next + 1 } else { next.max(i + 1) };
            }
            return i + 1;
        }
        if token.text != "*" && !is_name(&token.text) {
            break;
        }
        segments.push(token.text.clone());
        i += 1;
        if tokens.get(i).is_some_and(|t| t.text == "as") {
            i += 2; // the new name is the file's own affair
        }
        if tokens.get(i).is_none_or(|t| t.text != "::") {
            break;
        }
        i += 1;
    }
    found.push(Named { segments, line });
    i
}

fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Turns `self::x` and `super::x` into `crate::...`.
fn resolve(named: Named, module: &[&str]) -> Named {
    let mut base: Vec<String> = module.iter().map(|s| (*s).to_owned()).collect();
    let mut rest = named.segments.as_slice();
    if !matches!(rest.first().map(String::as_str), Some("self" | "super")) {
        return named;
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
    Named { segments, line: named.line }
}
