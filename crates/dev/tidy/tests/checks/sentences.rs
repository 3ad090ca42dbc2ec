//! Lengths of sentences in documents.

use tidy::documents::Document;
use tidy::sentences::{LongSentence, MAX_WORDS, MEASURED, long_sentences};

use crate::{DOCUMENTS, report};

fn found(text: &str) -> Vec<(usize, usize)> {
    let document = Document { path: "README.md".to_owned(), text: text.to_owned() };
    long_sentences(&document).iter().map(|LongSentence { line, words, .. }| (*line, *words)).collect()
}

fn words(count: usize) -> String {
    vec!["word"; count].join(" ")
}

#[test]
fn sentences_of_measured_documents_are_short() {
    let mut findings = Vec::new();
    for path in MEASURED {
        let document = DOCUMENTS.iter().find(|document| document.path == *path);
        let long = long_sentences(document.unwrap_or_else(|| panic!("{path} exists")));
        findings
            .extend(long.iter().map(|one| format!("{path}:{}: {} words: {}", one.line, one.words, one.text)));
    }
    report("sentences; divide them", findings);
}

#[test]
fn a_sentence_is_measured_over_lines_and_ends_at_a_mark() {
    let (full, more) = (words(MAX_WORDS), words(MAX_WORDS + 1));
    assert_eq!(found(&format!("# {more}\n\n{full}.\n{full}? (And more.) {full}\n")), []);
    assert_eq!(found(&format!("Short.\n\nIt has\n{more}.\n")), [(3, MAX_WORDS + 3)]);
    assert_eq!(found(&format!("{}; {}", words(13), words(13))), [(1, 26)]);
    assert_eq!(found(&format!("{} 0.5 ... {}", words(13), words(13))), [(1, 27)]);
}

#[test]
fn items_and_cells_are_apart_and_fences_are_free() {
    let (half, more) = (words(13), words(MAX_WORDS + 1));
    assert_eq!(found(&format!("{half}\n- {half}\n2. {half}\n| {half} | {half} |\n{half}\n")), []);
    assert_eq!(found(&format!("- {half}\n  {half}\n")), [(1, 26)]);
    assert_eq!(found(&format!("| name | {more} |\n```sh\n{more}\n```\n")), [(1, 26)]);
}

#[test]
fn code_spans_are_one_word_and_links_their_text() {
    let half = words(12);
    assert_eq!(found(&format!("{half} `tabletopgen serve. now` {half}.")), []);
    assert_eq!(found(&format!("{half} [two words](a.md) ![](b.png) {half}.")), [(1, 26)]);
}
