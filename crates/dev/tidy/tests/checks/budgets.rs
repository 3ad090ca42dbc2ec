//! Comment widths and words against `budget.txt`.

use tidy::allowed::{ALLOWED, ALLOWED_IN_TEXTS};
use tidy::budget::{counts, differences, findings, parse, read, risen};
use tidy::{Finding, Rule, documents, listing, words};

use crate::{DOCUMENTS, TREE, report};

#[test]
fn findings_of_every_file_equal_its_budget() {
    let findings = findings(&TREE, &DOCUMENTS);
    eprintln!("{}", listing::totals(&findings, &Rule::ALL));
    let budget = read().expect("budget.txt is readable").expect("budget.txt exists");
    report(
        "the budget (after findings are fixed: cargo run -p tabletopgen-tidy -- budget)",
        differences(&counts(&findings), &budget),
    );
}

#[test]
fn every_allowed_word_occurs() {
    let of_documents = DOCUMENTS.iter().flat_map(documents::all_findings);
    let all: Vec<Finding> = TREE.iter().flat_map(words::all_findings).chain(of_documents).collect();
    let (in_texts, in_code): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|finding| finding.rule.is_of_texts());
    let mut unused = Vec::new();
    for (entries, findings) in [(ALLOWED, in_code), (ALLOWED_IN_TEXTS, in_texts)] {
        let words =
            entries.iter().flat_map(|allowed| allowed.words.iter().map(move |word| (allowed.path, *word)));
        let absent = words.filter(|(path, word)| {
            !findings.iter().any(|finding| finding.path.starts_with(path) && finding.subject == *word)
        });
        unused.extend(absent.map(|(path, word)| format!("{path}: no {word}")));
    }
    report("allowed.rs", unused);
}

#[test]
fn budgets_differ_in_both_directions_and_totals_may_only_fall() {
    let budget = parse("a.rs\tcomment-word\t2\nb.rs\tcomment-word\t1\n").expect("two entries");
    let moved = parse("c.rs\tcomment-word\t2\nb.rs\tcomment-word\t1\n").expect("two entries");
    let more =
        parse("a.rs\tcomment-word\t2\nb.rs\tcomment-word\t1\nb.rs\ttype-name\t1\n").expect("three entries");
    assert_eq!(differences(&budget, &budget), Vec::<String>::new());
    assert_eq!(differences(&moved, &budget).len(), 2);
    assert_eq!(risen(&moved, &budget), Vec::<String>::new());
    assert_eq!(risen(&more, &budget), ["type-name: 1 findings, 0 before"]);
    assert!(parse("a.rs\tno-rule\t2").is_err());
    assert!(parse("a.rs comment-word 2").is_err());
}
