//! Texts in other languages are refused: most of their words are not known.

use super::correction::is_known;
use super::lexicon::Lexicon;
use super::tokens::{Source, Token};

/// Words that other languages seldom have.
const ENGLISH: &[&str] = &[
    "the", "and", "with", "of", "two", "three", "four", "on", "is", "are", "there", "next", "left", "right",
    "put", "to", "that", "this", "it", "without", "please", "pick", "place", "move",
];

/// The words that are not known, if the text does not seem to be English.
pub(super) fn foreign_words(lexicon: &Lexicon, source: &Source) -> Option<Vec<String>> {
    let words: Vec<&str> = source.tokens.iter().filter_map(Token::word).collect();
    let known = |word: &str| is_known(lexicon, word) || lexicon.nouns.is_noun(word);
    let unknown: Vec<String> =
        words.iter().filter(|word| !known(word)).map(|word| (*word).to_owned()).collect();
    let english = words.iter().filter(|word| ENGLISH.contains(word)).count();
    let letters: usize = source.text.chars().filter(|c| c.is_alphabetic()).count();
    let latin = source.text.chars().filter(|c| c.is_ascii_alphabetic()).count();
    let other_script = letters >= 2 && 2 * latin < letters;
    let mostly_unknown = words.len() >= 3 && 2 * unknown.len() >= words.len() && english <= words.len() / 8;
    let hardly_known = words.len() >= 6 && 3 * unknown.len() >= 2 * words.len();
    (other_script || mostly_unknown || hardly_known).then_some(unknown)
}

#[cfg(test)]
mod tests {
    use super::super::LEXICON;
    use super::*;

    #[test]
    fn other_languages_are_refused() {
        for (text, refused) in [
            ("ein Tisch mit zwei Tassen und einem Teller", true),
            ("une table avec deux tasses et une assiette", true),
            ("una mesa con dos tazas y un plato", true),
            ("机の上にマグカップ", true),
            ("стол с двумя чашками", true),
            ("un escritorio con una lámpara y tres libros", true),
            ("a desk with a zorblax", false),
            ("two mugs and a plate", false),
            ("a zorblax and a frobnicator", false),
            ("laptop keyboard", false),
        ] {
            assert_eq!(foreign_words(&LEXICON, &Source::read(text)).is_some(), refused, "{text}");
        }
    }
}
