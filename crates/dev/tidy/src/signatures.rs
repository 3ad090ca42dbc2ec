//! Functions that are hard to read or whose errors callers cannot tell apart.

use crate::lexer::Token;
use crate::source::Source;
use crate::{Finding, Rule};

/// Most lines of a function, from its name to its end.
pub const MAX_FUNCTION_LINES: usize = 80;

/// Errors that are texts, and functions that are too long, in shipped code.
pub fn findings(source: &Source) -> Vec<Finding> {
    if source.is_test || !source.is_rust() {
        return Vec::new();
    }
    let finding = |rule, line: usize, subject| Finding {
        rule,
        path: source.path.clone(),
        line,
        subject,
        text: source.line(line).to_owned(),
    };
    let texts = text_errors(&source.shipped).into_iter();
    let texts = texts.map(|line| finding(Rule::TextError, line, "Result<_, String>".to_owned()));
    let long = long_functions(&source.shipped).into_iter();
    texts
        .chain(long.map(|(line, lines)| finding(Rule::LongFunction, line, format!("{lines} lines"))))
        .collect()
}

/// Lines of `Result<_, String>`: callers can print such an error, and do nothing else with it.
pub fn text_errors(tokens: &[Token]) -> Vec<usize> {
    let is = |index: usize, text: &str| tokens.get(index).is_some_and(|token| token.text == text);
    let ends_with_string = |start: usize| {
        let mut depth = 0_usize;
        for (index, token) in tokens.iter().enumerate().skip(start) {
            match token.text.as_str() {
                "<" | "(" | "[" => depth += 1,
                // The sign of a return type within.
                ">" if is(index - 1, "-") => {}
                ">" | ")" | "]" => depth = depth.saturating_sub(1),
                "," if depth == 1 => return is(index + 1, "String") && is(index + 2, ">"),
                ";" | "{" if depth <= 1 => return false,
                _ => {}
            }
            if depth == 0 {
                return false;
            }
        }
        false
    };
    let results = (0..tokens.len()).filter(|&index| is(index, "Result") && is(index + 1, "<"));
    results.filter(|index| ends_with_string(index + 1)).map(|index| tokens[index].line).collect()
}

/// Line and length of each function that is longer than [`MAX_FUNCTION_LINES`].
pub fn long_functions(tokens: &[Token]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    for (index, token) in tokens.iter().enumerate().filter(|(_, token)| token.text == "fn") {
        let after = &tokens[index..];
        let Some(start) = after.iter().position(|token| matches!(token.text.as_str(), "{" | ";")) else {
            continue;
        };
        let mut depth = 0_usize;
        for inner in &after[start..] {
            match inner.text.as_str() {
                "{" => depth += 1,
                "}" => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                let lines = inner.line + 1 - token.line;
                if lines > MAX_FUNCTION_LINES {
                    found.push((token.line, lines));
                }
                break;
            }
        }
    }
    found
}
