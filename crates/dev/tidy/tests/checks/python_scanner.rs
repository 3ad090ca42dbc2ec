//! Examples of Python text that the lexer keeps and drops, and of words in it.

use tidy::python_lexer::lex;
use tidy::source::Source;
use tidy::{Rule, width, words};

fn tokens(text: &str) -> Vec<String> {
    lex(text).tokens.into_iter().map(|token| token.text).collect()
}

fn literals(text: &str) -> Vec<(String, usize)> {
    let literals = lex(text).tokens.into_iter().filter(|token| !token.literal.is_empty());
    literals.map(|token| (token.literal, token.line)).collect()
}

fn comments(text: &str) -> Vec<(String, usize)> {
    lex(text).comments.into_iter().map(|comment| (comment.text, comment.line)).collect()
}

#[test]
fn strings_of_every_form_become_one_sign_each() {
    let cases: &[(&str, &[&str])] = &[
        ("a('b # c')", &["a", "(", "\"", ")"]),
        ("a = \"b \\\" c\" + d", &["a", "=", "\"", "+", "d"]),
        ("a = r'b\\' + c", &["a", "=", "\""]),
        ("a = r'b\\\\' + c", &["a", "=", "\"", "+", "c"]),
        ("a = Rb'b' + c", &["a", "=", "\"", "+", "c"]),
        ("a = \"\"\"b \" c \"\" d\"\"\" + e", &["a", "=", "\"", "+", "e"]),
        ("a = '''b\n' c''' + d", &["a", "=", "\"", "+", "d"]),
        ("a = '' + b", &["a", "=", "\"", "+", "b"]),
        ("bar('a')", &["bar", "(", "\"", ")"]),
        ("a.b_1 @ 2", &["a", ".", "b_1", "@", "2"]),
    ];
    for (text, expected) in cases {
        assert_eq!(tokens(text), *expected, "{text}");
    }
}

#[test]
fn expressions_in_strings_are_tokens_and_not_part_of_the_literal() {
    assert_eq!(tokens("a(f'b {c.d:.2f} {e[\"f\"]!r}')").concat(), "a(c.d:.2fe[\"]!r\")");
    assert_eq!(literals("a(f'b {c:>{d}} {{e}} f')"), [("f'b {} {{e}} f'".to_owned(), 1)]);
    assert_eq!(literals("a(f'''b\n{c(\n)}\nd''')"), [("f'''b\n{\n}\nd'''".to_owned(), 1)]);
    assert_eq!(tokens("a('b {c}')"), ["a", "(", "\"", ")"]);
}

#[test]
fn adjacent_strings_are_one_literal() {
    assert_eq!(
        literals("a(\n'b ' # c\n  f'd {e}', 'f')"),
        [("'b ' \n  f'd {}'".to_owned(), 2), ("'f'".to_owned(), 3)]
    );
    assert_eq!(literals("a = 'b' \\\n'c'\nd = 'e'").len(), 2);
}

#[test]
fn comments_and_docstrings_are_kept_with_their_lines() {
    let text = "\"\"\"a\n\nb\"\"\"\ndef f(): # c\n    'd'\n    return 'e'\n";
    let expected = [("\"\"\"a", 1), ("", 2), ("b\"\"\"", 3), ("# c", 4), ("'d'", 5)];
    assert_eq!(comments(text), expected.map(|(text, line)| (text.to_owned(), line)));
    assert_eq!(tokens(text).concat(), "deff():return\"");
    for code in ["'a'.join(b)", "a(\n'b'\n)", "[\n'a',\n]", "a = \\\n'b'", "'# a' + b"] {
        assert_eq!(comments(code), [], "{code}");
    }
}

#[test]
fn lines_are_counted_through_strings_and_comments() {
    let text = "a # b\n'''c\n''' + d \\\n+ f'''\n{e}''' + g";
    let lines: Vec<usize> =
        lex(text).tokens.iter().filter(|t| t.is_identifier()).map(|token| token.line).collect();
    assert_eq!(lines, [1, 3, 5, 5]);
}

#[test]
fn unfinished_text_ends_the_file() {
    for text in ["'a", "'''a''", "f'{", "f'{a", "f'{a['", "'\\", "(", ")", "\\", "#", "f'{'", "f\"{'é"] {
        Source::new("python/a.py", text);
    }
}

#[test]
fn words_of_comments_names_and_sentences_are_found() {
    let found = |path: &str, text: &str| -> Vec<(Rule, usize)> {
        words::findings(&Source::new(path, text)).into_iter().map(|f| (f.rule, f.line)).collect()
    };
    let text =
        "\"\"\"A scene.\n\nIts picture.\"\"\"\n# A thing.\nclass Seen:\n    most = f'{middle_px} px'\n";
    assert_eq!(
        found("python/a.py", text),
        [
            (Rule::CommentWord, 3),
            (Rule::CommentWord, 4),
            (Rule::TypeName, 5),
            (Rule::IdentifierWord, 6),
            (Rule::IdentifierWord, 6)
        ]
    );
    let sentence = "a('put the ' \\\n  'thing there')";
    assert_eq!(found("python/a.py", sentence), [(Rule::LiteralWord, 2)]);
    assert_eq!(found("tests/judges/a.py", sentence).len(), 1);
    for test in ["python/tabletopgen_checks/tests/machine.py", "training/test_training.py"] {
        assert_eq!(found(test, sentence), []);
    }
    for free in ["a('picture')", "a['one picture']", "Counter(a).most_common(2)", "a['at_most']"] {
        assert_eq!(found("python/a.py", free), [], "{free}");
    }
}

#[test]
fn comments_and_docstrings_are_measured() {
    let wide = "x".repeat(120);
    let count = |text: &str| width::findings(&Source::new("python/a.py", text)).len();
    assert_eq!(count(&format!("# {wide}")), 1);
    assert_eq!(count(&format!("'''a\n{wide}y'''")), 1);
    assert_eq!(count(&format!("a = '{wide}'")), 0);
}
