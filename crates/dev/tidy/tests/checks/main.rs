//! The rules of `ARCHITECTURE.md` that Cargo cannot express, applied to every source file of the tree.
//!
//! A finding names file, line and rule.

use std::sync::LazyLock;

use tidy::documents::{Document, documents};
use tidy::source::{Source, tree};

mod import_table;
mod file_forms;
mod budgets;
mod scanner;
mod python_scanner;
mod import_reader;
mod word_reader;
mod doc_openings;
mod document_paths;
mod sentences;
mod signatures;
mod single_places;

/// Every source file, read once.
static TREE: LazyLock<Vec<Source>> = LazyLock::new(tree);

/// Every document, read once.
static DOCUMENTS: LazyLock<Vec<Document>> = LazyLock::new(documents);

/// The Rust files that ship.
fn shipped() -> impl Iterator<Item = &'static Source> {
    TREE.iter().filter(|source| source.is_rust() && !source.is_test)
}

/// Fails with one line per finding.
fn report(subject: &str, findings: Vec<String>) {
    assert!(
        findings.is_empty(),
        "{} findings about {subject}:\n  {}\n",
        findings.len(),
        findings.join("\n  ")
    );
}
