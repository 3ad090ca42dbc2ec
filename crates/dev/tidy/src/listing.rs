//! Findings as the binary prints them.

use std::collections::BTreeMap;

use crate::{Finding, Rule};

/// `path:line: subject: text`, one line per place; `subject (n times)` where a line repeats a word.
pub fn places(findings: &[Finding]) -> String {
    let mut places: Vec<(&Finding, usize)> = Vec::new();
    for finding in findings {
        let same = |other: &Finding| {
            (&other.path, other.line, &other.subject) == (&finding.path, finding.line, &finding.subject)
        };
        match places.iter_mut().rev().find(|(other, _)| same(other)) {
            Some((_, count)) => *count += 1,
            None => places.push((finding, 1)),
        }
    }
    let mut lines = String::new();
    for (finding, count) in places {
        let times = if count > 1 { format!(" ({count} times)") } else { String::new() };
        let Finding { path, line, subject, text, .. } = finding;
        lines.push_str(&format!("{path}:{line}: {subject}{times}: {text}\n"));
    }
    lines
}

/// The number of findings of each package and rule, as a table.
pub fn totals(findings: &[Finding], rules: &[Rule]) -> String {
    let mut packages: BTreeMap<&str, Vec<&Finding>> = BTreeMap::new();
    for finding in findings {
        packages.entry(group(&finding.path)).or_default().push(finding);
    }
    let row = |name: &str, findings: &[&Finding]| {
        let counts = rules.iter().map(|rule| findings.iter().filter(|f| f.rule == *rule).count());
        let cells: String = counts.map(|count| format!("{count:>17}")).collect();
        format!("{name:<32}{cells}{:>9}\n", findings.len())
    };
    let heads: String = rules.iter().map(|rule| format!("{:>17}", rule.name())).collect();
    let mut table = format!("{:<32}{heads}{:>9}\n", "", "total");
    for (name, findings) in &packages {
        table.push_str(&row(name, findings));
    }
    let all: Vec<&Finding> = findings.iter().collect();
    table.push_str(&row("total", &all));
    table
}

/// `crates/base/scene`, `src/api`, `tests`: what one person works on.
fn group(path: &str) -> &str {
    let parts = match path.split_once('/').map(|(first, _)| first) {
        Some("crates") => 3,
        Some("src") => 2,
        _ => 1,
    };
    let end = path.match_indices('/').nth(parts - 1).map_or(path.len(), |(i, _)| i);
    path[..end].trim_end_matches(".rs")
}
