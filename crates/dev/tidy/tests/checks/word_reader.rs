//! Examples of words that are banned and that pass.

use tidy::Rule;
use tidy::documents::{self, Document};
use tidy::source::Source;
use tidy::words::{banned_in_identifier, banned_in_text, findings, segments};

#[test]
fn identifiers_are_split_into_segments() {
    let cases: &[(&str, &[&str])] = &[
        ("top_view", &["top", "view"]),
        ("TopView", &["top", "view"]),
        ("TOP_VIEW_2", &["top", "view", "2"]),
        ("GPUTimer", &["gpu", "timer"]),
        ("PoseDRO", &["pose", "dro"]),
        ("view2d", &["view", "2", "d"]),
        ("_unused", &["unused"]),
        ("_", &[]),
        ("x", &["x"]),
    ];
    for (identifier, expected) in cases {
        assert_eq!(segments(identifier), *expected, "{identifier}");
    }
}

#[test]
fn banned_segments_of_identifiers_are_found() {
    let banned = [
        "thing",
        "things_m",
        "PictureReading",
        "LEAST_SHARE",
        "least_visible",
        "most_of_it",
        "in_picture",
        "look_alikes",
        "LookFault",
        "middle_px",
        "told",
        "looks2",
        "herds",
        "faces_look_outward",
    ];
    for identifier in banned {
        assert_eq!(banned_in_identifier(identifier).len(), 1, "{identifier}");
    }
    let fine = [
        "nothing",
        "anything",
        "everything",
        "something",
        "at_least_m",
        "AT_MOST",
        "AtLeast",
        "least_squares",
        "LeastSquares",
        "look_at",
        "look_at_rh",
        "LOOK_AHEAD_S",
        "lookup",
        "look_up",
        "utmost",
        "foremost",
        "almost",
        "pictured",
        "paintbrush",
    ];
    for identifier in fine {
        assert_eq!(banned_in_identifier(identifier), Vec::<String>::new(), "{identifier}");
    }
}

#[test]
fn banned_words_of_comments_are_found() {
    let banned = [
        "// A thing.",
        "/// The picture's width.",
        "//! (things)",
        "// Repainted and painted.",
        "//! Pictures, see `pictures.md` and docs/pictures.",
        "// `look`",
        "// looks at",
        "// middle-aged",
        "// believes",
        "// Nobody.",
        "// Look downward",
    ];
    for comment in banned {
        assert_eq!(banned_in_text(comment).len(), 1, "{comment}");
    }
    let fine = [
        "// Nothing, something, anything, everything.",
        "// look up",
        "// looks up",
        "// a look-up",
        "// lookup",
        "// look-ahead",
        "// a look-at matrix",
        "// `paint_bottle`",
        "// three paintbrushes",
        "// `in_picture`",
        "// at least, at most",
        "// looking",
    ];
    for comment in fine {
        assert_eq!(banned_in_text(comment), Vec::<String>::new(), "{comment}");
    }
}

#[test]
fn bare_participles_name_no_type() {
    let text = "\
struct Seen;
pub enum Found<T> { Told2(T) }
trait Held {}
type Painted2 = u8;
enum Answer { Seen, Drawn }
fn f(x: Sent) {}
";
    let found = findings(&Source::new("src/api.rs", text));
    let names: Vec<_> =
        found.iter().filter(|f| f.rule == Rule::TypeName).map(|f| f.subject.as_str()).collect();
    assert_eq!(names, ["Seen", "Found", "Held"]);
}

#[test]
fn sentences_in_literals_of_shipped_code_are_checked() {
    let words = |path: &str, text: &str| -> Vec<(usize, String)> {
        findings(&Source::new(path, text)).into_iter().map(|f| (f.line, f.subject)).collect()
    };
    let text = "fn f() {\n    g(\"the image shows\\n{} Things, \\\n      one picture\");\n}\n";
    assert_eq!(words("src/api.rs", text), [(2, "things".to_owned()), (3, "picture".to_owned())]);
    assert_eq!(words("src/api.rs", "const A: &str = r#\"a good \"picture\" of it\"#;").len(), 1);
    for free in [
        "const A: &str = \"a thing\";",
        "const A: [&str; 2] = [\"picture\", \"middle\"];",
        "const A: &str = \"it must look up words\";",
        "#[cfg(test)] mod tests { const A: &str = \"put the thing down\"; }",
    ] {
        assert_eq!(words("src/api.rs", free), [], "{free}");
    }
    assert_eq!(words("tests/it/main.rs", "const A: &str = \"put the thing down\";"), []);
}

#[test]
fn documents_are_checked_but_for_code_and_quotations() {
    let lines = |path: &str, text: &str| -> Vec<usize> {
        let document = Document { path: path.to_owned(), text: text.to_owned() };
        documents::findings(&document).into_iter().map(|finding| finding.line).collect()
    };
    let text = "A thing.\n`thing` and \"one thing\", say \"things\n```\nthing\n```\nthe picture\n";
    assert_eq!(lines("docs/limits.md", text), [1, 2, 6]);
    assert_eq!(lines("openapi.yaml", "summary: A picture.\nexample: 'an image'\n"), [1]);
}

#[test]
fn exceptions_hold_in_their_files_alone() {
    let count = |path: &str, text: &str| findings(&Source::new(path, text)).len();
    let golden = "python/tabletopgen_checks/golden/dinov2.py";
    assert_eq!(count("src/api.rs", "fn picture() {} // A picture."), 2);
    assert_eq!(count(golden, "fn picture() {} // A picture."), 0);
    assert_eq!(count(golden, "fn thing() {}"), 1);
    assert_eq!(count("src/api.rs", "#[cfg(test)] mod tests { fn picture() {} }"), 1);
}

#[test]
fn findings_name_path_line_word_and_text() {
    let found = findings(&Source::new("src/api.rs", "//! API.\n\n    let picture = 1; // The picture.\n"));
    let places: Vec<_> = found.iter().map(|f| (f.line, f.subject.as_str(), f.text.as_str())).collect();
    assert_eq!(places, [(3, "picture", "let picture = 1; // The picture."); 2]);
    assert_eq!(
        tidy::listing::places(&found),
        "src/api.rs:3: picture (2 times): let picture = 1; // The picture.\n"
    );
}
