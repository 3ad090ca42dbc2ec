//! English words that are no nouns: adjectives, adverbs and verbs, in any of their regular forms.

use std::collections::HashMap;
use std::sync::LazyLock;

use crate::lexicon::lexicon;
use crate::performed::bases;

/// Whether each word is an adjective, which has a comparative.
static OTHER_WORDS: LazyLock<HashMap<&'static str, bool>> = LazyLock::new(|| {
    let lines = include_str!("../../../../config/language/other_words.txt").lines();
    let word = |line: &'static str| match line.strip_suffix('+') {
        Some(adjective) => (adjective, true),
        None => (line, false),
    };
    lines.filter(|line| !line.starts_with('#')).map(word).collect()
});

/// Whether a word in lower case only joins others ("the", "then", "of").
pub fn is_function_word(word: &str) -> bool {
    lexicon().is_function_word(word)
}

/// Whether a word in lower case is an adjective, an adverb or a verb.
///
/// ```
/// use language::words::is_other_word;
///
/// assert!(is_other_word("outer") && is_other_word("taller") && is_other_word("scattered"));
/// assert!(!is_other_word("labtop") && !is_other_word("hamer"));
/// ```
pub fn is_other_word(word: &str) -> bool {
    let comparative = ["er", "est", "r", "st", "ly"].iter().filter_map(|ending| word.strip_suffix(ending));
    let mut stems = comparative.filter(|stem| stem.len() >= 3).flat_map(|stem| {
        let single = stem.char_indices().next_back().map_or("", |(last, _)| &stem[..last]);
        // "happier", "bigger"
        let doubled = stem.ends_with(single.chars().next_back().unwrap_or(' ')).then(|| single.to_owned());
        let of_y = stem.strip_suffix('i').map(|stem| format!("{stem}y"));
        [Some(stem.to_owned()), of_y, doubled].into_iter().flatten()
    });
    stems.any(|stem| OTHER_WORDS.get(stem.as_str()) == Some(&true))
        || bases(word).iter().any(|base| OTHER_WORDS.contains_key(base.as_str()))
}
