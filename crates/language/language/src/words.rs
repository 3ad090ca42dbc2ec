//! English words that are no nouns: adjectives, adverbs and verbs, in any of their regular forms.

use std::collections::HashSet;
use std::sync::LazyLock;

use crate::lexicon::lexicon;
use crate::performed::bases;

static OTHER_WORDS: LazyLock<HashSet<&'static str>> = LazyLock::new(|| {
    let lines = include_str!("../../../../config/language/other_words.txt").lines();
    lines.filter(|line| !line.starts_with('#')).collect()
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
/// assert!(!is_other_word("labtop") && !is_other_word("baterry"));
/// ```
pub fn is_other_word(word: &str) -> bool {
    let comparative = ["er", "est", "r", "st", "ly"].iter().filter_map(|ending| word.strip_suffix(ending));
    let stems = comparative.filter(|stem| stem.len() >= 3).flat_map(|stem| {
        let single = stem.char_indices().next_back().map_or("", |(last, _)| &stem[..last]);
        // "happier", "bigger"
        let doubled = stem.ends_with(single.chars().next_back().unwrap_or(' ')).then(|| single.to_owned());
        let of_y = stem.strip_suffix('i').map(|stem| format!("{stem}y"));
        [Some(stem.to_owned()), of_y, doubled].into_iter().flatten()
    });
    bases(word).into_iter().chain(stems).any(|form| OTHER_WORDS.contains(form.as_str()))
}
