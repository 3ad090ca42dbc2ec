//! Examples of doc comments that the check of openings finds and that it lets pass.

use tidy::doc_openings::findings;
use tidy::source::Source;

fn subjects(text: &str) -> Vec<(usize, String)> {
    findings(&Source::new("src/api.rs", text)).into_iter().map(|f| (f.line, f.subject)).collect()
}

#[test]
fn clauses_and_pronouns_at_the_begin_of_a_doc_comment_are_found() {
    let text = "//! What the API tells.\n\n/// How far it is.\n/// Where it is.\nfn f() {}\n\n/// Its width.\nfn g() {}\n";
    assert_eq!(subjects(text), [(1, "What".to_owned()), (3, "How".to_owned()), (7, "Its".to_owned())]);
    assert_eq!(subjects("    /// They're equal.\n"), [(1, "They".to_owned())]);
}

#[test]
fn noun_phrases_statements_and_other_comments_pass() {
    for text in [
        "//! Routes of the API.\n//! What they answer.\n",
        "/// Whether it holds.\n",
        "/// However it comes.\n",
        "/// Itself.\n",
        "// What follows is no doc comment.\n",
        "//// What this is, only lint knows.\n",
        "fn f() { g(\"/// What\") }\n",
    ] {
        assert_eq!(subjects(text), [], "{text}");
    }
}
