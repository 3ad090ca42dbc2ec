//! Examples of text that the lexer keeps and drops.

use tidy::Rule;
use tidy::lexer::lex;
use tidy::source::Source;
use tidy::width;

fn tokens(text: &str) -> Vec<String> {
    lex(text).tokens.into_iter().map(|token| token.text).collect()
}

fn comments(text: &str) -> Vec<(String, usize)> {
    lex(text).comments.into_iter().map(|comment| (comment.text, comment.line)).collect()
}

#[test]
fn literals_become_one_sign_each() {
    let cases: &[(&str, &[&str])] = &[
        ("a(\"b // c\")", &["a", "(", "\"", ")"]),
        ("\"a \\\" b\" c", &["\"", "c"]),
        ("\"a \\\\\" b", &["\"", "b"]),
        ("r\"a\\\" b", &["\"", "b"]),
        ("r#\"a \" b\"# c", &["\"", "c"]),
        ("br##\"a \"# b\"## c", &["\"", "c"]),
        ("b\"a\" c", &["b", "\"", "c"]),
        ("'a' b", &["\"", "b"]),
        ("'\\'' b", &["\"", "b"]),
        ("'\\\\' b", &["\"", "b"]),
        ("'\\u{1F600}' b", &["\"", "b"]),
        ("'\"' b", &["\"", "b"]),
        ("r#type b", &["r", "#", "type", "b"]),
    ];
    for (text, expected) in cases {
        assert_eq!(tokens(text), *expected, "{text}");
    }
}

#[test]
fn lifetimes_are_no_literals() {
    assert_eq!(
        tokens("fn f<'a, 'b>(x: &'a str) -> char { '\"' }"),
        [
            "fn", "f", "<", "a", ",", "b", ">", "(", "x", ":", "&", "a", "str", ")", "-", ">", "char", "{",
            "\"", "}"
        ]
    );
    assert_eq!(
        tokens("'outer: loop { break 'outer; }"),
        ["outer", ":", "loop", "{", "break", "outer", ";", "}"]
    );
}

#[test]
fn comments_are_kept_with_their_lines_and_not_as_tokens() {
    assert_eq!(tokens("a // b\nc /* d */ e"), ["a", "c", "e"]);
    assert_eq!(
        comments("//! a\n/// b\nc // d"),
        [("//! a".to_owned(), 1), ("/// b".to_owned(), 2), ("// d".to_owned(), 3),]
    );
    assert_eq!(tokens("/* a /* b */ c */ d"), ["d"]);
    assert_eq!(
        comments("x\n/* a\n /* b */\n c */ d"),
        [("/* a".to_owned(), 2), (" /* b */".to_owned(), 3), (" c */".to_owned(), 4),]
    );
    assert_eq!(comments("\"// a\" 'b' r#\"/* c */\"#"), []);
}

#[test]
fn lines_are_counted_through_literals_and_comments() {
    let lines: Vec<usize> = lex("a\n\"b\nc\" d /*\n*/ e\nr\"\n\" f").tokens.iter().map(|t| t.line).collect();
    assert_eq!(lines, [1, 2, 3, 4, 5, 6]);
}

#[test]
fn unfinished_text_ends_the_file() {
    for text in ["\"a", "r#\"a\"", "'\\", "/* a", "r#\"", "#[cfg(test)]", "#[cfg(test)] mod", "}", "'"] {
        Source::new("src/api.rs", text);
    }
}

#[test]
fn items_under_test_attributes_do_not_ship() {
    let shipped = |text: &str| {
        let source = Source::new("src/api.rs", text);
        source.shipped.into_iter().map(|token| token.text).collect::<Vec<_>>().concat()
    };
    assert_eq!(shipped("a; #[cfg(test)] mod tests { b } c;"), "a;c;");
    assert_eq!(shipped("#[cfg(test)]\n#[allow(dead_code)]\nfn check(x: [u8; 3]) { b } c;"), "c;");
    assert_eq!(shipped("#[test] fn f() { { } } c;"), "c;");
    assert_eq!(shipped("#[cfg(test)] use a::{b, c}; d;"), "d;");
    assert_eq!(shipped("#[cfg(all(test, feature = \"a\"))] mod b; d;"), "d;");
    assert_eq!(shipped("#[cfg(not(test))] a;"), "#[cfg(not(test))]a;");
    assert_eq!(shipped("#[cfg(any(test, feature = \"a\"))] b;"), "#[cfg(any(test,feature=\"))]b;");
}

#[test]
fn sources_name_their_package_and_module() {
    let cases = [
        ("crates/base/scene/src/job/state.rs", "scene", vec!["job", "state"], "job", false),
        ("crates/base/scene/src/lib.rs", "scene", vec![], "lib", false),
        (
            "crates/base/scene/tests/all.rs",
            "scene",
            vec!["crates", "base", "scene", "tests", "all"],
            "crates",
            true,
        ),
        ("src/api/jobs.rs", "tabletopgen", vec!["api", "jobs"], "api", false),
        ("src/main.rs", "tabletopgen", vec![], "main", false),
        ("benches/soft.rs", "tabletopgen", vec!["benches", "soft"], "benches", true),
    ];
    for (path, package, module, top, is_test) in cases {
        let source = Source::new(path, "");
        assert_eq!(
            (source.package(), source.module(), source.top_module(), source.is_test),
            (package, module, top, is_test)
        );
    }
}

#[test]
fn only_lines_with_comments_are_measured() {
    let wide = "x".repeat(120);
    let count = |text: &str| {
        let findings = width::findings(&Source::new("src/api.rs", text));
        assert!(findings.iter().all(|finding| finding.rule == Rule::CommentWidth));
        findings.len()
    };
    assert_eq!(count(&format!("// {wide}")), 1);
    assert_eq!(count(&format!("a {wide} // b")), 1);
    assert_eq!(count(&format!("/* a\n{wide}y */")), 1);
    assert_eq!(count(&format!("// {}", "é".repeat(117))), 0);
    assert_eq!(count(&format!("\"// {wide}\"")), 0);
    assert_eq!(count(&format!("// https://{wide}")), 0);
    assert_eq!(count(&format!("// at https://{wide}")), 1);
}
