//! Lists findings file by file, and rewrites the budget.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use tidy::source::{folders, root, sources_below};
use tidy::{Finding, Rule, budget, doc_openings, documents, listing, signatures, width, words};

const USAGE: &str = "\
usage: cargo run -p tabletopgen-tidy -- COMMAND

  words [PATH...]    banned words of code and documents as `path:line: word: text`; without a path, totals per crate
  widths [PATH...]   comment lines that are too wide; without a path, totals per crate
  openings [PATH...] doc comments that do not begin with what the item is; without a path, totals per crate
  signatures [PATH...] long functions, and errors that are texts; without a path, totals per crate
  budget             rewrites crates/dev/tidy/budget.txt; refuses if a total has risen
";

/// Reason why a command does nothing.
enum Failure {
    Usage,
    /// A path that does not exist, or lies outside the repository.
    Outside {
        path: String,
    },
    /// The budget cannot be read or written.
    Budget(io::Error),
    /// Findings of more places than the budget has; the lines state where and which rules.
    Risen {
        differences: Vec<String>,
        rules: Vec<String>,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage => f.write_str(USAGE),
            Self::Outside { path } => write!(f, "{path} is no path of {}", root().display()),
            Self::Budget(error) => write!(f, "{}: {error}", budget::file().display()),
            Self::Risen { differences, rules } => {
                let (differences, rules) = (differences.join("\n"), rules.join("\n"));
                write!(f, "{differences}\nthe budget may only shrink:\n{rules}")
            }
        }
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.split_first() {
        Some((command, paths)) if command == "words" => list_words(paths),
        Some((command, paths)) if command == "widths" => list(paths, width::findings, &[Rule::CommentWidth]),
        Some((command, paths)) if command == "openings" => {
            list(paths, doc_openings::findings, &[Rule::DocOpening])
        }
        Some((command, paths)) if command == "signatures" => {
            list(paths, signatures::findings, &[Rule::LongFunction, Rule::TextError])
        }
        Some((command, [])) if command == "budget" => rewrite_budget(),
        _ => Err(Failure::Usage),
    };
    match result {
        Ok(text) => {
            // A reader such as `head` may close the pipe early.
            let _ = io::stdout().lock().write_all(text.as_bytes());
            ExitCode::SUCCESS
        }
        Err(failure) => {
            let _ = writeln!(io::stderr().lock(), "{}", failure.to_string().trim_end());
            ExitCode::FAILURE
        }
    }
}

fn list_words(paths: &[String]) -> Result<String, Failure> {
    let within = within_all(paths)?;
    let (sources, documents) = match paths.is_empty() {
        true => (sources_below(&folders()), documents::documents()),
        false => (sources_below(&within), documents::documents_below(&within)),
    };
    let of_sources = sources.iter().flat_map(words::findings);
    let findings: Vec<Finding> = of_sources.chain(documents.iter().flat_map(documents::findings)).collect();
    let rules =
        [Rule::CommentWord, Rule::DocumentWord, Rule::IdentifierWord, Rule::LiteralWord, Rule::TypeName];
    Ok(listed(paths, &findings, &rules, sources.len() + documents.len()))
}

fn list(
    paths: &[String],
    findings: fn(&tidy::source::Source) -> Vec<Finding>,
    rules: &[Rule],
) -> Result<String, Failure> {
    let within = if paths.is_empty() { folders() } else { within_all(paths)? };
    let sources = sources_below(&within);
    let findings: Vec<Finding> = sources.iter().flat_map(findings).collect();
    Ok(listed(paths, &findings, rules, sources.len()))
}

/// Totals per package; with paths, every place.
fn listed(paths: &[String], findings: &[Finding], rules: &[Rule], files: usize) -> String {
    match paths.is_empty() {
        true => listing::totals(findings, rules),
        false => format!("{}{} findings in {files} files\n", listing::places(findings), findings.len()),
    }
}

fn within_all(paths: &[String]) -> Result<Vec<PathBuf>, Failure> {
    paths.iter().map(|path| within_repository(path)).collect()
}

/// A path given relative to the current folder or to the repository, relative to the repository.
fn within_repository(path: &str) -> Result<PathBuf, Failure> {
    let root = root();
    let candidates = [PathBuf::from(path), root.join(path)];
    let existing = candidates.iter().find_map(|candidate| candidate.canonicalize().ok());
    let inside = existing.as_deref().and_then(|p: &Path| p.strip_prefix(&root).ok());
    inside.map(Path::to_owned).ok_or_else(|| Failure::Outside { path: path.to_owned() })
}

fn rewrite_budget() -> Result<String, Failure> {
    let findings = budget::findings(&tidy::source::tree(), &documents::documents());
    let actual = budget::counts(&findings);
    if let Some(before) = budget::read().map_err(Failure::Budget)? {
        let rules = budget::risen(&actual, &before);
        if !rules.is_empty() {
            return Err(Failure::Risen { differences: budget::differences(&actual, &before), rules });
        }
    }
    budget::write(&actual).map_err(Failure::Budget)?;
    Ok(listing::totals(&findings, &Rule::ALL))
}
