//! The length of sentences in the documents that teach.
//!
//! Prose is what stands outside of fences and headings: paragraphs, items of lists and cells of tables. A sentence
//! ends at a period, an exclamation mark or a question mark before white space, so that a colon or a semicolon makes
//! it no shorter. A code span is one word; of a link its text counts.

use crate::documents::Document;

/// Most words of a sentence.
pub const MAX_WORDS: usize = 25;

/// Documents whose sentences are measured.
pub const MEASURED: &[&str] = &["README.md", "docs/concepts.md", "docs/tutorial.md", "docs/user_guide.md"];

/// One sentence with more than [`MAX_WORDS`] words.
#[derive(Clone, Debug, PartialEq)]
pub struct LongSentence {
    /// Line on which its paragraph, item or row begins, from 1.
    pub line: usize,
    pub words: usize,
    /// The sentence with each code span as `` ` ``.
    pub text: String,
}

/// Sentences of the document that are too long, in their order.
pub fn long_sentences(document: &Document) -> Vec<LongSentence> {
    let mut found = Vec::new();
    for (line, prose) in passages(&document.text) {
        for text in sentences(&without_links(&without_code(&prose))) {
            let words = text.split_whitespace().filter(|word| is_word(word)).count();
            if words > MAX_WORDS {
                found.push(LongSentence { line, words, text });
            }
        }
    }
    found
}

fn is_word(word: &str) -> bool {
    word.contains(|c: char| c.is_alphanumeric() || c == '`')
}

/// Paragraphs, items and cells with the line on which each begins.
fn passages(text: &str) -> Vec<(usize, String)> {
    let (mut passages, mut is_open, mut in_fence) = (Vec::<(usize, String)>::new(), false, false);
    for (k, line) in text.lines().enumerate() {
        let line = line.trim();
        let is_fence = line.starts_with("```");
        in_fence ^= is_fence;
        if in_fence || is_fence || line.is_empty() || line.starts_with('#') {
            is_open = false;
        } else if line.starts_with('|') {
            let cells = line.replace("\\|", " ");
            passages.extend(cells.split('|').map(|cell| (k + 1, cell.trim().to_owned())));
            is_open = false;
        } else if let (Some((_, passage)), true, None) = (passages.last_mut(), is_open, item(line)) {
            passage.push(' ');
            passage.push_str(line);
        } else {
            passages.push((k + 1, item(line).unwrap_or(line).to_owned()));
            is_open = true;
        }
    }
    passages
}

/// The text of an item of a list.
fn item(line: &str) -> Option<&str> {
    let digits = line.trim_start_matches(|c: char| c.is_ascii_digit());
    let is_numbered = digits.len() < line.len();
    line.strip_prefix("- ").or_else(|| digits.strip_prefix(". ").filter(|_| is_numbered))
}

/// The text with one backtick for each code span.
fn without_code(text: &str) -> String {
    text.split('`').step_by(2).collect::<Vec<_>>().join("`")
}

/// The text with the words of links and images in place of them.
fn without_links(text: &str) -> String {
    let mut parts = text.split("](");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        kept.push_str(part.split_once(')').map_or(part, |(_, after)| after));
    }
    kept.replace("![", "").replace('[', "")
}

fn sentences(text: &str) -> Vec<String> {
    let (mut sentences, mut current) = (Vec::new(), Vec::new());
    for word in text.split_whitespace() {
        current.push(word);
        let bare = word.trim_end_matches(['"', '\'', ')', '*']);
        if bare.ends_with(['.', '!', '?']) && !bare.ends_with("...") {
            sentences.push(current.join(" "));
            current.clear();
        }
    }
    sentences.push(current.join(" "));
    sentences
}
