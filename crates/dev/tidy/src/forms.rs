//! The form of a file: its name, its first line, its length, and no shortcuts in code that ships.

use crate::source::Source;

/// Longest a file may be.
pub const MAX_LINES: usize = 600;

/// Half of the files of the product must be shorter.
pub const MEDIAN_LINES: usize = 150;

/// Nine in ten files of the product must be shorter.
pub const NINTH_DECILE_LINES: usize = 400;

/// Names that do not state the content.
const VAGUE_NAMES: &[&str] =
    &["mod", "util", "utils", "common", "helper", "helpers", "types", "misc", "shared", "stuff", "prelude"];

pub fn opening_findings(source: &Source) -> Option<String> {
    if !source.text.starts_with("//! ") {
        return Some(format!("{}:1: the file must open with `//!` and its purpose", source.path));
    }
    let unfinished = source.text.starts_with("//! (in progress)");
    unfinished.then(|| format!("{}:1: the file does not state its purpose yet", source.path))
}

pub fn name_findings(source: &Source) -> Option<String> {
    let name = source.path.rsplit_once('.').map_or(source.path.as_str(), |(name, _)| name);
    let mut parts = name.split('/');
    let vague = parts.any(|part| VAGUE_NAMES.contains(&part));
    vague.then(|| format!("{}: the name does not state the content; name.rs, not mod.rs", source.path))
}

pub fn length_findings(sources: &[Source]) -> Vec<String> {
    let lines = |source: &Source| source.text.lines().count();
    let long = sources.iter().filter(|source| lines(source) > MAX_LINES);
    let mut findings: Vec<String> =
        long.map(|s| format!("{}: {} lines; at most {MAX_LINES}", s.path, lines(s))).collect();
    let product = sources.iter().filter(|s| s.path.starts_with("src/") || s.path.contains("/src/"));
    let mut lengths: Vec<usize> = product.map(lines).collect();
    lengths.sort_unstable();
    if lengths.is_empty() {
        return findings;
    }
    let (median, ninth_decile) = (lengths[lengths.len() / 2], lengths[lengths.len() * 9 / 10]);
    if median >= MEDIAN_LINES || ninth_decile >= NINTH_DECILE_LINES {
        findings.push(format!(
            "half of the files have under {median} lines and nine in ten under {ninth_decile}; at most \
             {MEDIAN_LINES} and {NINTH_DECILE_LINES} are allowed"
        ));
    }
    findings
}

/// `todo!`, `.unwrap()` and prints in code that ships. Only a binary and its command line may print.
pub fn shortcut_findings(source: &Source) -> Vec<String> {
    let prints = matches!(source.top_module(), "cli" | "main");
    let mut findings = Vec::new();
    for window in source.shipped.windows(3) {
        let words = [window[0].text.as_str(), window[1].text.as_str(), window[2].text.as_str()];
        let name = match words {
            ["todo" | "unimplemented" | "dbg", "!", _] => words[0],
            ["println" | "eprintln" | "print" | "eprint", "!", _] if !prints => words[0],
            [".", "unwrap" | "unwrap_err", "("] => words[1],
            _ => continue,
        };
        findings.push(format!("{}:{}: {name} outside tests", source.path, window[0].line));
    }
    findings
}
