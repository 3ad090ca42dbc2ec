//! Misspelled words: a word that is not known and differs by one letter, or by two if it is long, from exactly one
//! known word is read as that word. The nearest known words of other unknown words.

use super::lexicon::{Lexicon, edit_distance};
use super::tokens::{Source, Token};
use super::verbs::verbs;

/// Maximum number of words of a text that are compared with the vocabulary.
const MAX_WORDS: usize = 32;
/// Length of the shortest word that is corrected.
const SHORTEST: usize = 4;
/// Length up to which a letter may be missing, superfluous or exchanged, but not another one.
const SHORT: usize = 4;
/// Length from which two letters may differ.
const LONG: usize = 8;
/// Length of the longest word that is compared.
const LONGEST: usize = 24;

/// Prepositions and other words of the grammar that are corrected.
const FUNCTION_WORDS: &[&str] = &[
    "with", "without", "between", "behind", "beside", "around", "inside", "under", "next", "left", "right",
    "front", "center", "corner", "stack", "three", "four", "seven", "eight", "table", "please", "facing",
    "upside",
];

/// Whether any rule of the parser knows the word.
pub(super) fn is_known(lexicon: &Lexicon, word: &str) -> bool {
    let vocabulary = lexicon.vocabulary;
    lexicon.has_word(word)
        || vocabulary.has_word(word)
        || verbs().is_form(word)
        || verbs().asks_for_scene(word)
        || super::phrase::is_boundary(vocabulary, word)
        || lexicon.themes.has_word(word)
}

/// Corrects misspelled words; the corrected tokens with their words.
pub(super) fn correct(lexicon: &Lexicon, source: &mut Source) -> Vec<(usize, String)> {
    let mut corrections = Vec::new();
    let mut compared = 0;
    for token in 0..source.tokens.len() {
        let Token::Word(word) = &source.tokens[token] else { continue };
        let length = word.chars().count();
        let plain = word.chars().all(|c| c.is_ascii_lowercase());
        if !plain
            || !(SHORTEST..=LONGEST).contains(&length)
            || is_known(lexicon, word)
            || lexicon.nouns.is_noun(word)
        {
            continue;
        }
        compared += 1;
        if compared > MAX_WORDS {
            break;
        }
        if let Some(corrected) = corrected(lexicon, word) {
            corrections.push((token, corrected.clone()));
            source.tokens[token] = Token::Word(corrected);
        }
    }
    corrections
}

/// The only known word within the permitted distance.
fn corrected(lexicon: &Lexicon, word: &str) -> Option<String> {
    let limit = if word.len() >= LONG { 2 } else { 1 };
    let colors = lexicon.vocabulary.colors.keys().map(String::as_str);
    let materials = lexicon.vocabulary.materials.keys().map(String::as_str);
    let words = lexicon.words().chain(colors).chain(materials).chain(FUNCTION_WORDS.iter().copied());
    let mut best: Option<(usize, usize, &str)> = None;
    let mut is_tied = false;
    for known in words.filter(|known| known.len() >= 3 && known.len().abs_diff(word.len()) <= limit) {
        // The first letter is seldom wrong, except where two letters are exchanged.
        let same_start = known.as_bytes()[0] == word.as_bytes()[0] || known.get(1..) == Some(word);
        let exchanged = is_exchange(word, known);
        if !same_start && !exchanged {
            continue;
        }
        // Exchanged letters are the likeliest error.
        let distance = if exchanged { 0 } else { edit_distance(word, known) };
        if distance > limit || (word.len() <= SHORT && known.len() == word.len() && !exchanged) {
            continue;
        }
        let rank = (distance, known.len().abs_diff(word.len()));
        match best {
            Some((best_distance, best_length, best_known)) => {
                let best_rank = (best_distance, best_length);
                if rank < best_rank {
                    (best, is_tied) = (Some((rank.0, rank.1, known)), false);
                } else if rank == best_rank && known != best_known {
                    // Singular and plural of one noun: the one that ends as the word does.
                    let (plural, other) = if known.len() > best_known.len() {
                        (known, best_known)
                    } else {
                        (best_known, known)
                    };
                    let same_noun = lexicon.vocabulary.plural_of(other) == plural;
                    if same_noun && word.ends_with('s') == known.ends_with('s') {
                        best = Some((rank.0, rank.1, known));
                    } else if !same_noun {
                        is_tied = true;
                    }
                }
            }
            None => best = Some((rank.0, rank.1, known)),
        }
    }
    best.filter(|_| !is_tied).map(|(_, _, known)| known.to_owned())
}

/// Whether two neighboring letters are exchanged ("palte").
fn is_exchange(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let different: Vec<usize> = (0..a.len()).filter(|&k| a[k] != b[k]).collect();
    matches!(different[..], [i, j] if j == i + 1 && a[i] == b[j] && a[j] == b[i])
}

#[cfg(test)]
mod tests {
    use super::super::LEXICON;
    use super::*;

    #[test]
    fn misspelled_words_are_corrected_if_unambiguous() {
        for (text, expected) in [
            ("a labtop and a keybord", vec!["laptop", "keyboard"]),
            ("two palte", vec!["plate"]),
            ("a screwdrivver", vec!["screwdriver"]),
            ("a scisors", vec!["scissors"]),
            ("a mug and a zorblax", vec![]),
            ("a plate", vec![]),
        ] {
            let mut source = Source::read(text);
            let words: Vec<String> =
                correct(&LEXICON, &mut source).into_iter().map(|(_, word)| word).collect();
            assert_eq!(words, expected, "{text}");
        }
    }
}
