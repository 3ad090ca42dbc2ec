//! Readers of signatures.

use tidy::lexer::lex;
use tidy::signatures::{long_functions, text_errors};

#[test]
fn errors_that_are_texts_are_found() {
    for (code, lines) in [
        ("fn a() -> Result<(), String> {}", vec![1]),
        ("fn a() -> Result<Vec<u8>, String> {}\nfn b(x: Result<u8, Error>) {}", vec![1]),
        ("fn a() -> Result<String, Error> {}", vec![]),
        ("type F = Arc<dyn Fn(&str) -> Result<BTreeMap<u8, String>, Error>>;", vec![]),
        ("type F = Result<Box<dyn Fn(u8) -> u8>, String>;", vec![1]),
        ("fn a() -> Result<(u8, [u8; 2]), String> {}", vec![1]),
        ("fn a() -> Result<u8> {}", vec![]),
    ] {
        assert_eq!(text_errors(&lex(code).tokens), lines, "{code}");
    }
}

#[test]
fn long_functions_are_measured_from_their_name_to_their_end() {
    let body = "    x();\n".repeat(79);
    let code = format!("trait T {{ fn declared(&self); }}\nfn long() {{\n{body}}}\nfn short() {{}}\n");
    assert_eq!(long_functions(&lex(&code).tokens), [(2, 81)]);
}
