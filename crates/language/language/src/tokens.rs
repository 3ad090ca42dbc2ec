//! Words of a text in lower case, with their bytes.
//!
//! Contractions are two words ("don't" is "do not"), hyphens divide words, a number is divided from its unit, and a
//! quoted part is one token. Punctuation that divides clauses is a word of its own; marks at the end of a sentence are
//! all ".".

use std::ops::Range;

/// One word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Token {
    /// In lower case; as written where it is quoted.
    pub word: String,
    /// Bytes of the text, without quotation marks.
    pub span: Range<usize>,
    pub is_quoted: bool,
    /// Whether the sentence that it ends is a question.
    pub asks: bool,
}

/// Contractions that no ending tells.
const WHOLE: &[(&str, &[&str])] = &[
    ("can't", &["can", "not"]),
    ("cannot", &["can", "not"]),
    ("won't", &["will", "not"]),
    ("shan't", &["shall", "not"]),
    ("let's", &["let", "us"]),
    ("dont", &["do", "not"]),
    ("lets", &["let", "us"]),
    ("gonna", &["going", "to"]),
    ("wanna", &["want", "to"]),
];

/// Endings of contractions, with the word that each stands for.
const ENDINGS: &[(&str, &str)] =
    &[("n't", "not"), ("'d", "would"), ("'ll", "will"), ("'re", "are"), ("'ve", "have"), ("'m", "am")];

/// Words after which 's is "is".
const SUBJECTS: &[&str] = &["it", "that", "there", "he", "she", "what", "where", "here", "everything"];

/// The words of a text.
pub fn tokens(text: &str) -> Vec<Token> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let end = at + c.len_utf8();
        if let Some(close) = closing(c, text, at) {
            let length = text[end..].find(close).unwrap_or(0);
            let span = end..end + length;
            found.push(Token { word: text[span.clone()].to_owned(), span, is_quoted: true, asks: false });
            at = end + length + close.len_utf8();
        } else if c.is_ascii_digit() {
            let length = number_length(&text[at..]);
            push(&mut found, text, at..at + length);
            at += length;
        } else if is_letter(c) {
            let length = text[at..].find(|c: char| !is_letter(c)).unwrap_or(text.len() - at);
            push_word(&mut found, text, at..at + length);
            at += length;
        } else {
            let mark = match c {
                '.' | '!' | '?' | ';' | '\n' => Some("."),
                ',' => Some(","),
                ':' => Some(":"),
                '%' => Some("%"),
                '°' => Some("degrees"),
                _ => None,
            };
            if let Some(word) = mark {
                let span = at..end;
                found.push(Token { word: word.to_owned(), span, is_quoted: false, asks: c == '?' });
            }
            at = end;
        }
    }
    // "the mug's too close"
    for index in 1..found.len() {
        let follows = matches!(found[index].word.as_str(), "too" | "not" | "so" | "already" | "way" | "far");
        if follows && found[index - 1].word == "'s" {
            found[index - 1].word = "is".to_owned();
        }
    }
    found
}

fn is_letter(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '\'' | '’' | '_')
}

/// The mark that ends what a mark begins to quote.
fn closing(c: char, text: &str, at: usize) -> Option<char> {
    let close = match c {
        '"' => '"',
        '“' => '”',
        '\'' | '‘' => '\'',
        _ => return None,
    };
    let rest = &text[at + c.len_utf8()..];
    let begins = text[..at].chars().next_back().is_none_or(char::is_whitespace);
    (begins && rest.contains(close)).then_some(close)
}

/// "10", "2.5", "1st"; a unit that follows is another word.
fn number_length(text: &str) -> usize {
    let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let whole = digits(text);
    if let Some(fraction) = text[whole..].strip_prefix(['.', ',']).map(digits).filter(|&length| length > 0) {
        return whole + 1 + fraction;
    }
    let ordinal = ["st", "nd", "rd", "th"].iter().any(|ending| text[whole..].starts_with(ending));
    if ordinal { whole + 2 } else { whole }
}

fn push(found: &mut Vec<Token>, text: &str, span: Range<usize>) {
    let word = text[span.clone()].to_lowercase();
    found.push(Token { word, span, is_quoted: false, asks: false });
}

fn push_word(found: &mut Vec<Token>, text: &str, span: Range<usize>) {
    let written = text[span.clone()].to_lowercase().replace('’', "'");
    let mut parts = |words: &[&str], divide_at: usize| {
        let divide = span.start + divide_at.min(span.len());
        for (index, word) in words.iter().enumerate() {
            let span = if index == 0 { span.start..divide } else { divide..span.end };
            found.push(Token { word: (*word).to_owned(), span, is_quoted: false, asks: false });
        }
    };
    if let Some((_, words)) = WHOLE.iter().find(|(whole, _)| *whole == written) {
        return parts(words, words[0].len());
    }
    if let Some(stem) = written.strip_suffix("'s") {
        let word = if SUBJECTS.contains(&stem) { "is" } else { "'s" };
        return parts(&[stem, word], stem.len());
    }
    for (ending, word) in ENDINGS {
        if let Some(stem) = written.strip_suffix(ending).filter(|stem| !stem.is_empty()) {
            return parts(&[stem, word], stem.len());
        }
    }
    let word = written.trim_matches('\'').to_owned();
    if !word.is_empty() {
        parts(&[&word], span.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        tokens(text).into_iter().map(|token| token.word).collect()
    }

    #[test]
    fn contractions_units_and_quotes_are_divided() {
        assert_eq!(words("Don't move it 10cm!"), ["do", "not", "move", "it", "10", "cm", "."]);
        assert_eq!(words("I'd like the mug's lid"), ["i", "would", "like", "the", "mug", "'s", "lid"]);
        assert_eq!(words("it's 2.5 m, the 2nd"), ["it", "is", "2.5", "m", ",", "the", "2nd"]);
        assert_eq!(words("label it 'Spare Parts'."), ["label", "it", "Spare Parts", "."]);
        assert_eq!(words("turn it 45° at mug_1"), ["turn", "it", "45", "degrees", "at", "mug_1"]);
        assert_eq!(words("front-left"), ["front", "left"]);
        assert_eq!(words("the boys' toy"), ["the", "boys", "toy"]);
    }

    #[test]
    fn spans_are_those_of_the_words() {
        let text = "Can’t you put “Tea 1” there?";
        for token in tokens(text) {
            assert!(text.is_char_boundary(token.span.start) && text.is_char_boundary(token.span.end));
        }
        assert!(tokens(text).last().expect("a mark").asks);
    }
}
