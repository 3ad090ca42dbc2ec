//! Addresses that vendors sign carry what proves a right to fetch: the values of such parameters are replaced, wherever an
//! address stands in a text.

use std::borrow::Cow;

/// What stands in their place; the same for all, so that an address which was read from a recording finds its own answer.
const REPLACED: &str = "redacted";

/// Parts of the names of parameters whose values prove something.
const TELLING: [&str; 8] = ["sign", "sig", "token", "credential", "key", "secret", "password", "auth"];

/// The text without the values of parameters that prove something (`?X-Amz-Signature=...`).
pub(super) fn without_signatures(text: &str) -> Cow<'_, str> {
    // In JSON an ampersand may be written so.
    if text.contains("\\u0026") {
        let plain = text.replace("\\u0026", "&");
        return match without_signatures(&plain) {
            Cow::Owned(kept) => Cow::Owned(kept),
            Cow::Borrowed(_) => Cow::Borrowed(text),
        };
    }
    let (mut kept, mut done) = (String::new(), 0);
    for (at, _) in text.match_indices(['?', '&']) {
        if let Some((from, to)) = proof(text, at + 1) {
            kept.push_str(&text[done..from]);
            kept.push_str(REPLACED);
            done = to;
        }
    }
    if done == 0 {
        return Cow::Borrowed(text);
    }
    kept.push_str(&text[done..]);
    Cow::Owned(kept)
}

/// Where the value of the parameter that begins at `start` stands, if its name says that it proves something.
fn proof(text: &str, start: usize) -> Option<(usize, usize)> {
    let rest = &text[start..];
    let is_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let name_len = rest.find(|c| !is_name(c)).filter(|&len| len > 0 && rest[len..].starts_with('='))?;
    let name = rest[..name_len].to_ascii_lowercase();
    if !TELLING.iter().any(|telling| name.contains(telling)) {
        return None;
    }
    let from = start + name_len + 1;
    let ends = |c: char| c.is_whitespace() || matches!(c, '&' | '"' | '\'' | '\\' | '<' | '>' | '#');
    let len = text[from..].find(ends).unwrap_or(text.len() - from);
    Some((from, from + len))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signatures_go_and_everything_else_stays() {
        for (text, expected) in [
            ("https://a.example/b?c=1&d=2", "https://a.example/b?c=1&d=2"),
            (
                "https://a.example/b?X-Amz-Credential=AK%2F1&X-Amz-Expires=60&X-Amz-Signature=f00 and",
                "https://a.example/b?X-Amz-Credential=redacted&X-Amz-Expires=60&X-Amz-Signature=redacted and",
            ),
            (
                r#"{"url": "https://a.example/b?q-sign-time=1;2&q-ak=3&token=t", "n": 1}"#,
                r#"{"url": "https://a.example/b?q-sign-time=redacted&q-ak=3&token=redacted", "n": 1}"#,
            ),
            (
                r#"{"url": "https://a.example/b?sig=abc\u0026key=def"}"#,
                r#"{"url": "https://a.example/b?sig=redacted&key=redacted"}"#,
            ),
            ("Is it a key? sign=yes & token= no", "Is it a key? sign=yes & token= no"),
            ("?", "?"),
            ("é?sig=é&", "é?sig=redacted&"),
        ] {
            let kept = without_signatures(text);
            assert_eq!(kept, expected);
            assert_eq!(without_signatures(&kept), expected, "twice is as good as once");
        }
    }
}
