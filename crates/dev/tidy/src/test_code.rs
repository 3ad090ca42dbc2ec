//! Separates the code that ships from the code that only tests compile.

use crate::lexer::Token;

/// Drops every item under `#[cfg(test)]` or `#[test]`; also gives the names of modules declared so.
pub fn without_tests(tokens: &[Token]) -> (Vec<Token>, Vec<String>) {
    let (mut kept, mut modules, mut i) = (Vec::new(), Vec::new(), 0);
    while i < tokens.len() {
        if !is_test_attribute(&tokens[i..]) {
            kept.push(tokens[i].clone());
            i += 1;
            continue;
        }
        i = end_of_group(tokens, i + 1);
        while tokens.get(i).is_some_and(|t| t.text == "#") {
            i = end_of_group(tokens, i + 1); // Further attributes of the same item.
        }
        let start = i;
        while i < tokens.len() && tokens[i].text != ";" && tokens[i].text != "{" {
            i = if matches!(tokens[i].text.as_str(), "(" | "[") { end_of_group(tokens, i) } else { i + 1 };
        }
        let words = &tokens[start..i.min(tokens.len())];
        if let Some(at) = words.iter().position(|t| t.text == "mod")
            && tokens.get(i).is_some_and(|t| t.text == ";")
        {
            modules.extend(words.get(at + 1).map(|t| t.text.clone()));
        }
        let is_use = words.iter().any(|t| t.text == "use");
        i = if tokens.get(i).is_some_and(|t| t.text == "{") { end_of_group(tokens, i) } else { i + 1 };
        if is_use && tokens.get(i).is_some_and(|t| t.text == ";") {
            i += 1;
        }
    }
    (kept, modules)
}

/// `#[cfg(test)]`, `#[cfg(all(test, ...))]`, `#[test]`; neither `#[cfg(not(test))]` nor `#[cfg(any(test, ...))]`.
fn is_test_attribute(tokens: &[Token]) -> bool {
    if tokens.first().is_none_or(|t| t.text != "#") || tokens.get(1).is_none_or(|t| t.text != "[") {
        return false;
    }
    let words: Vec<&str> = tokens[1..end_of_group(tokens, 1)].iter().map(|t| t.text.as_str()).collect();
    match words.get(1) {
        Some(&"test") => words.len() == 3,
        Some(&"cfg") => words.contains(&"test") && !words.contains(&"not") && !words.contains(&"any"),
        _ => false,
    }
}

/// Index after the bracket that closes the one at `open`.
fn end_of_group(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0usize;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    tokens.len()
}
