//! The form of every file.

use tidy::forms::{length_findings, name_findings, opening_findings, shortcut_findings};
use tidy::settings::settings_findings;
use tidy::source::Source;

use crate::{TREE, report, shipped};

fn rust() -> impl Iterator<Item = &'static Source> {
    TREE.iter().filter(|source| source.is_rust())
}

#[test]
fn files_open_with_their_purpose() {
    report("file documentation", rust().filter_map(opening_findings).collect());
}

#[test]
fn file_names_state_the_content() {
    report("file names", TREE.iter().filter_map(name_findings).collect());
}

#[test]
fn files_are_short() {
    report("file lengths", length_findings(&rust().cloned().collect::<Vec<_>>()));
}

#[test]
fn code_that_ships_has_no_shortcuts() {
    report("shortcuts", shipped().flat_map(shortcut_findings).collect());
}

#[test]
fn settings_are_documented_and_have_no_default() {
    report("settings", shipped().flat_map(settings_findings).collect());
}

#[test]
fn violations_of_forms_are_found() {
    let source = |text: &str| Source::new("src/api.rs", text);
    assert!(opening_findings(&source("use a;")).is_some());
    assert!(opening_findings(&source("//! (in progress)")).is_some());
    assert!(opening_findings(&source("//! Routes.")).is_none());
    assert!(name_findings(&Source::new("crates/base/scene/src/utils.rs", "")).is_some());
    assert!(name_findings(&Source::new("crates/base/scene/src/job.rs", "")).is_none());
    assert_eq!(length_findings(&[source(&"a\n".repeat(600))]).len(), 1, "the median alone");
    assert_eq!(length_findings(&[source(&"a\n".repeat(601))]).len(), 2);
    assert_eq!(
        shortcut_findings(&source(concat!("fn f() { a.unwrap(); to", "do!(); println!(); }"))).len(),
        3
    );
    assert_eq!(shortcut_findings(&source("#[test] fn f() { a.unwrap(); }")).len(), 0);
    assert_eq!(shortcut_findings(&Source::new("src/cli.rs", "fn f() { println!(); }")).len(), 0);
    let documented = "/// A.\npub struct ASettings {\n    /// B.\n    pub b: u8,\n    pub c: CSettings,\n}\n";
    assert_eq!(settings_findings(&source(documented)), Vec::<String>::new());
    let bare =
        "#[derive(Default)]\npub struct ASettings {\n    pub b: u8,\n}\nimpl Default for ASettings {}\n";
    assert_eq!(settings_findings(&source(bare)).len(), 4);
}
