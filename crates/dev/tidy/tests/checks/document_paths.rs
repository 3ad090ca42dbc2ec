//! Paths in documents, and examples of names that are paths.

use tidy::document_paths::findings;
use tidy::documents::Document;

use crate::{DOCUMENTS, report};

#[test]
fn paths_in_documents_exist() {
    report("paths in documents", DOCUMENTS.iter().flat_map(findings).collect());
}

#[test]
fn dead_paths_and_links_are_found() {
    let count =
        |path: &str, text: &str| findings(&Document { path: path.to_owned(), text: text.to_owned() }).len();
    assert_eq!(count("docs/limits.md", "`crates/dev/tidy/src/nothing.rs`, `docs/limits.md`"), 1);
    assert_eq!(count("docs/limits.md", "[a](nothing.md) [b](limits.md#poses) [c](../crates/dev/tidy/)"), 1);
    assert_eq!(
        count("docs/results/kill.md", "[a](../limits.md) [b](../nothing.md) [c](https://a.b/c.md)"),
        1
    );
    assert_eq!(count("README.md", "`out/scene.json`, `crates/*/src`, `a/b`, `/scenes/{id}`, [a](#b)"), 0);
    assert_eq!(count("crates/data/export/src/readme_template.md", "[a](nothing.md)"), 0);
}
