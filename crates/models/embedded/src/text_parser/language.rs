//! Texts in other languages are refused: most of their words are not known, or their articles and prepositions are of
//! another language.

use super::correction::is_known;
use super::lexicon::Lexicon;
use super::phrases::phrases;
use super::tokens::{Source, Token};

/// The words that are not known, if the text does not seem to be English.
pub(super) fn foreign_words(lexicon: &Lexicon, source: &Source) -> Option<Vec<String>> {
    let list = &phrases().language;
    let words: Vec<&str> = source.tokens.iter().filter_map(Token::word).collect();
    let known = |word: &str| is_known(lexicon, word) || lexicon.nouns.is_noun(word);
    let foreign = words.iter().filter(|word| list.foreign.has(word)).count();
    let unknown = words.iter().filter(|word| !known(word)).count();
    let english = words.iter().filter(|word| list.english.has(word)).count();
    let letters: usize = source.text.chars().filter(|c| c.is_alphabetic()).count();
    let latin = source.text.chars().filter(|c| c.is_ascii_alphabetic()).count();
    let other_script = letters >= 2 && 2 * latin < letters;
    let mostly_unknown = words.len() >= 3 && 2 * unknown >= words.len() && english <= words.len() / 8;
    let hardly_known = words.len() >= 6 && 3 * unknown >= 2 * words.len();
    // Portuguese and Spanish have an "a" as well.
    let has_article = words.iter().any(|word| matches!(*word, "a" | "an"));
    // "coloque a maçã na tigela".
    let commands =
        english == 0 && words.first().is_some_and(|word| list.foreign_verbs.has(word) && unknown > 0);
    let is_foreign =
        commands || foreign >= 2 && foreign > english || foreign == 1 && english == 0 && !has_article;
    let strange = words.iter().filter(|word| !known(word) || list.foreign.has(word));
    (other_script || mostly_unknown || hardly_known || is_foreign)
        .then(|| strange.map(|word| (*word).to_owned()).collect())
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
            ("una taza", true),
            ("Eine Banane", true),
            ("Un plato y una manzana", true),
            ("Leg den roten Würfel in die Schüssel", true),
            ("Pon la manzana en el plato", true),
            ("een kopje en een bord", true),
            ("leg de appel in de mand", true),
            ("Et bord med en kop og to skeer", true),
            ("Coloque a maçã na tigela", true),
            ("two cups, pain au chocolat", false),
            ("a le creuset pot", false),
            ("a desk with a zorblax", false),
            ("two mugs and a plate", false),
            ("a zorblax and a frobnicator", false),
            ("laptop keyboard", false),
        ] {
            assert_eq!(foreign_words(&LEXICON, &Source::read(text)).is_some(), refused, "{text}");
        }
    }
}
