//! `budget.txt`: how many findings of each rule each file may still have. The numbers may only shrink.
//!
//! A rule that is new or becomes stricter starts from a new list: remove the file, then write it again.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::{fmt, fs, io};

use crate::documents::Document;
use crate::source::{Source, root};
use crate::{Finding, Rule, doc_openings, documents, signatures, width, words};

/// Findings by path and rule.
pub type Counts = BTreeMap<(String, Rule), usize>;

/// All findings of the rules that have a budget.
pub fn findings(sources: &[Source], documents: &[Document]) -> Vec<Finding> {
    let rules = [words::findings, width::findings, doc_openings::findings, signatures::findings];
    let of_sources = sources.iter().flat_map(|source| rules.iter().flat_map(move |rule| rule(source)));
    of_sources.chain(documents.iter().flat_map(documents::findings)).collect()
}

pub fn counts(findings: &[Finding]) -> Counts {
    let mut counts = Counts::new();
    for finding in findings {
        *counts.entry((finding.path.clone(), finding.rule)).or_default() += 1;
    }
    counts
}

pub fn total(counts: &Counts, rule: Rule) -> usize {
    counts.iter().filter(|((_, counted), _)| *counted == rule).map(|(_, count)| count).sum()
}

/// Differences between the counts of the tree and the budget, in either direction.
pub fn differences(actual: &Counts, budget: &Counts) -> Vec<String> {
    let mut keys: Vec<_> = actual.keys().chain(budget.keys()).collect();
    keys.sort();
    keys.dedup();
    let count = |counts: &Counts, key: &(String, Rule)| counts.get(key).copied().unwrap_or_default();
    let differing = keys.into_iter().filter_map(|key| {
        let (found, permitted) = (count(actual, key), count(budget, key));
        let (path, rule) = (&key.0, key.1.name());
        match found.cmp(&permitted) {
            std::cmp::Ordering::Greater => {
                Some(format!("{path}: {rule}: {found} findings, {permitted} allowed"))
            }
            std::cmp::Ordering::Less => {
                Some(format!("{path}: {rule}: {found} findings, but the budget still allows {permitted}"))
            }
            std::cmp::Ordering::Equal => None,
        }
    });
    differing.collect()
}

/// Rules whose total would rise. A file that moves takes its findings along, so only totals count.
pub fn risen(actual: &Counts, budget: &Counts) -> Vec<String> {
    let totals = Rule::ALL.map(|rule| (rule.name(), total(actual, rule), total(budget, rule)));
    let risen = totals.iter().filter(|(_, now, before)| now > before);
    risen.map(|(rule, now, before)| format!("{rule}: {now} findings, {before} before")).collect()
}

pub fn file() -> PathBuf {
    root().join("crates/dev/tidy/budget.txt")
}

/// `None` if there is no budget yet.
pub fn read() -> io::Result<Option<Counts>> {
    match fs::read_to_string(file()) {
        Ok(text) => parse(&text).map(Some).map_err(io::Error::other),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

pub fn write(counts: &Counts) -> io::Result<()> {
    fs::write(file(), format(counts))
}

/// One line per path and rule: `path<TAB>rule<TAB>count`.
pub fn format(counts: &Counts) -> String {
    counts.iter().map(|((path, rule), count)| format!("{path}\t{}\t{count}\n", rule.name())).collect()
}

/// A line of the budget that is not of the form of [`format()`].
#[derive(Debug)]
pub struct MalformedLine {
    /// From 1.
    pub number: usize,
    pub line: String,
}

impl fmt::Display for MalformedLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "budget.txt:{}: `{}`", self.number, self.line)
    }
}

impl Error for MalformedLine {}

pub fn parse(text: &str) -> Result<Counts, MalformedLine> {
    let entry = |(i, line): (usize, &str)| {
        let parts: Vec<&str> = line.split('\t').collect();
        let parsed = match parts.as_slice() {
            [path, rule, count] => {
                Rule::named(rule).zip(count.parse().ok()).map(|(r, n)| ((*path).to_owned(), r, n))
            }
            _ => None,
        };
        let malformed = || MalformedLine { number: i + 1, line: line.to_owned() };
        let (path, rule, count) = parsed.ok_or_else(malformed)?;
        Ok(((path, rule), count))
    };
    text.lines().enumerate().map(entry).collect()
}
