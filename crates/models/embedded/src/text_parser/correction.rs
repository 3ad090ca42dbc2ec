//! Misspelled words: a word that is not known and differs by one letter, or by two if it is long, from exactly one
//! nearest known word is read as that word. An English noun outside the catalog stays as it is, except a rare one
//! (`grammar.rare_nouns`).

use super::lexicon::Lexicon;
use super::phrases::phrases;
use super::tokens::{Source, Token};
use super::verbs::verbs;
use language::words::is_other_word;
use runtime::edit_distance;

/// Maximum number of words of a text that are compared with the vocabulary.
const MAX_WORDS: usize = 32;
/// Length of the shortest word that is corrected; of such a word only exchanged letters are.
const SHORTEST: usize = 3;
/// Length up to which a letter may be missing, superfluous or exchanged, but not another one.
const SHORT: usize = 4;
/// Length from which two letters may differ.
const LONG: usize = 8;
/// Length of the shortest word that may be a participle.
const PARTICIPLE: usize = 6;
/// Length of the longest word that is compared.
const LONGEST: usize = 24;

/// Prepositions and other words of the grammar that are corrected.
const FUNCTION_WORDS: &[&str] = &[
    "with", "without", "between", "behind", "beside", "around", "inside", "under", "next", "left", "right",
    "front", "center", "corner", "stack", "three", "four", "seven", "eight", "table", "please", "facing",
    "upside", "the", "and",
];

/// A word, one that is often written after it, and what is meant.
const CONFUSED: &[(&str, &str, &str)] = &[
    ("next", "too", "to"),
    ("close", "too", "to"),
    ("top", "off", "of"),
    ("front", "off", "of"),
    ("left", "off", "of"),
    ("right", "off", "of"),
    ("side", "off", "of"),
];

/// Two words that are often written as one, and the second of them.
const JOINED: &[(&str, &str)] =
    &[("infront", "front"), ("nextto", "to"), ("ontop", "top"), ("leftof", "of"), ("rightof", "of")];

/// Whether any rule of the parser knows the word.
pub(super) fn is_known(lexicon: &Lexicon, word: &str) -> bool {
    let vocabulary = lexicon.vocabulary;
    lexicon.has_word(word)
        || vocabulary.has_word(word)
        || verbs().is_form(word)
        || verbs().asks_for_scene(word)
        || super::phrase::is_boundary(vocabulary, word)
        || lexicon.themes.has_word(word)
        || phrases().agent.persons.has(word)
        || verbs().participle(word).is_some()
}

/// Corrects misspelled words; the corrected tokens with their words.
pub(super) fn correct(lexicon: &Lexicon, source: &mut Source) -> Vec<(usize, String)> {
    let mut corrections = Vec::new();
    let mut compared = 0;
    let mut token = 0;
    while token < source.tokens.len() {
        let Token::Word(word) = source.tokens[token].clone() else {
            token += 1;
            continue;
        };
        let before = token.checked_sub(1).and_then(|before| source.tokens[before].word());
        if let Some((_, second)) = JOINED.iter().find(|(joined, _)| *joined == word) {
            let first = word.strip_suffix(second).unwrap_or_default().to_owned();
            corrections.push((token, format!("{first} {second}")));
            let span = source.spans[token].clone();
            source.tokens[token] = Token::Word(first);
            source.tokens.insert(token + 1, Token::Word((*second).to_owned()));
            source.spans.insert(token, span);
            token += 2;
            continue;
        }
        let confused = CONFUSED.iter().find(|(first, written, _)| before == Some(*first) && *written == word);
        let meant = match confused {
            Some((_, _, meant)) => Some((*meant).to_owned()),
            None if is_right(lexicon, &word) || acts(lexicon, source, token) => None,
            None => {
                compared += 1;
                if compared > MAX_WORDS {
                    break;
                }
                plural_of_misspelled(lexicon, &word).or_else(|| corrected(lexicon, &word))
            }
        };
        if let Some(meant) = meant {
            source.tokens[token] = Token::Word(meant.clone());
            corrections.push((token, meant));
        }
        token += 1;
    }
    corrections
}

/// Whether a word is the name of who acts: "Nina carefully lowers the egg", "Tolm put it".
fn acts(lexicon: &Lexicon, source: &Source, token: usize) -> bool {
    let word = |at: usize| source.tokens.get(at).and_then(Token::word);
    let mut verb = token + 1;
    while word(verb).is_some_and(|adverb| adverb.ends_with("ly")) {
        verb += 1;
    }
    let is_verb = word(verb).is_some_and(|form| {
        let is_third = form.len() > 3 && form.ends_with('s') && !lexicon.has_word(form);
        is_third || verbs().participle(form).is_some()
    });
    let has_object = matches!(
        word(verb + 1),
        Some("the" | "a" | "an" | "it" | "them" | "his" | "her" | "their" | "up" | "down")
    );
    source.is_capitalized(token) && is_verb && has_object
}

/// Whether a word stays as it is: it is known, an English noun that is not rare, or too short or too long to compare.
fn is_right(lexicon: &Lexicon, word: &str) -> bool {
    let vocabulary = lexicon.vocabulary;
    let plain = word.chars().all(|c| c.is_ascii_lowercase());
    if !plain || !(SHORTEST..=LONGEST).contains(&word.len()) || is_known(lexicon, word) {
        return true;
    }
    let singular = vocabulary.singular_of(word);
    let forms = [word, singular.as_str()];
    // "rusty" and "dusty" are adjectives of nouns.
    if let Some(stem) = word.strip_suffix('y').filter(|stem| stem.len() >= SHORT)
        && (is_known(lexicon, stem) || lexicon.nouns.is_noun(stem))
    {
        return true;
    }
    if forms.iter().any(|form| vocabulary.grammar.rare_nouns.contains(*form)) {
        return false;
    }
    // "taller" is no "tiller", "outer" no "router".
    (is_other_word(word) || forms.iter().any(|form| lexicon.nouns.is_noun(form)))
        && !is_wrong_plural(lexicon, word)
}

/// "boxs", "knifes": a known noun with an ending that its plural does not have.
fn is_wrong_plural(lexicon: &Lexicon, word: &str) -> bool {
    let singular = lexicon.vocabulary.singular_of(word);
    singular != word
        && singular.len() >= SHORTEST
        && lexicon.vocabulary.plural_of(&singular) != word
        && (lexicon.has_word(&singular) || lexicon.nouns.is_noun(&singular))
}

fn plural_of_misspelled(lexicon: &Lexicon, word: &str) -> Option<String> {
    let singular = lexicon.vocabulary.singular_of(word);
    is_wrong_plural(lexicon, word).then(|| lexicon.vocabulary.plural_of(&singular))
}

/// Distance of a word from a known one, the likeliest error first: letters that differ, whether the word alone names no
/// object, the kind of error, and the difference in length.
type Rank = (usize, bool, Slip, usize);

/// The kinds of errors, the likeliest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Slip {
    /// Two letters are exchanged.
    Exchange,
    /// A letter is doubled, or a double letter is single.
    Doubling,
    /// A vowel is missing, superfluous or another one, or a letter that sounds alike ("vaze").
    Sound,
    Other,
}

/// The only known word that is nearest within the permitted distance.
fn corrected(lexicon: &Lexicon, word: &str) -> Option<String> {
    let limit = if word.len() >= LONG { 2 } else { 1 };
    let colors = lexicon.vocabulary.colors.keys().map(String::as_str);
    let materials = lexicon.vocabulary.materials.keys().map(String::as_str);
    let words = lexicon.words().chain(colors).chain(materials).chain(FUNCTION_WORDS.iter().copied());
    // Participles stay participles: "fluted" is not "flutes".
    let ending = ["ing", "ed"].into_iter().find(|ending| word.len() >= PARTICIPLE && word.ends_with(ending));
    let is_rare = lexicon.nouns.is_noun(word);
    let mut best: Option<(Rank, &str)> = None;
    let mut is_tied = false;
    for known in words.filter(|known| known.len() >= 3 && known.len().abs_diff(word.len()) <= limit) {
        // The first letter is seldom wrong, except where two letters are exchanged.
        let same_start = known.as_bytes()[0] == word.as_bytes()[0] || known.get(1..) == Some(word);
        let slip = slip(word, known);
        if !same_start && slip != Slip::Exchange || ending.is_some_and(|ending| !known.ends_with(ending)) {
            continue;
        }
        // Exchanged letters are the likeliest error.
        let distance = match slip {
            Slip::Exchange => 0,
            // "baterry".
            Slip::Doubling => 1,
            _ => edit_distance(word, known),
        };
        // Short words: exchanged letters, and from four letters on another one only if it sounds alike.
        let is_likely = match word.len() {
            ..SHORT => {
                let may_sound =
                    FUNCTION_WORDS.contains(&known) || lexicon.vocabulary.colors.contains_key(known);
                slip == Slip::Exchange || slip == Slip::Sound && may_sound
            }
            SHORT => known.len() != word.len() || matches!(slip, Slip::Exchange | Slip::Sound),
            _ => true,
        };
        if distance > limit || !is_likely {
            continue;
        }
        // Exchanged letters make "blue" of the rare noun "bleu".
        let is_part = !FUNCTION_WORDS.contains(&known) && !lexicon.names_object(known);
        if is_rare && (is_part && slip != Slip::Exchange || distance > 1) {
            continue;
        }
        let rank = (distance, is_part, slip, known.len().abs_diff(word.len()));
        let Some((best_rank, best_known)) = best else {
            best = Some((rank, known));
            continue;
        };
        if known == best_known {
            continue;
        }
        // Singular and plural of one noun: the one that ends as the word does.
        let (plural, other) =
            if known.len() > best_known.len() { (known, best_known) } else { (best_known, known) };
        let same_noun = lexicon.vocabulary.plural_of(other) == plural;
        let ends_so = |known: &str| word.ends_with('s') == known.ends_with('s');
        if same_noun && rank.0 == best_rank.0 && ends_so(known) != ends_so(best_known) {
            if ends_so(known) {
                best = Some((rank.min(best_rank), known));
            }
        } else if rank < best_rank {
            (best, is_tied) = (Some((rank, known)), false);
        } else if rank == best_rank {
            is_tied = true;
        }
    }
    best.filter(|_| !is_tied).map(|(_, known)| known.to_owned())
}

/// The word with single letters for double ones.
fn undoubled(word: &str) -> Vec<u8> {
    let mut letters = word.as_bytes().to_vec();
    letters.dedup();
    letters
}

/// Whether two letters often sound alike.
fn is_alike(a: u8, b: u8) -> bool {
    [(b's', b'z'), (b'c', b'k'), (b'c', b's'), (b'v', b'f'), (b'g', b'j')]
        .into_iter()
        .any(|pair| pair == (a, b) || pair == (b, a))
}

/// The kind of the error that makes one word of the other.
fn slip(written: &str, known: &str) -> Slip {
    let (a, b) = (written.as_bytes(), known.as_bytes());
    let start = a.iter().zip(b).take_while(|(x, y)| x == y).count();
    let rest = a[start..].iter().rev().zip(b[start..].iter().rev()).take_while(|(x, y)| x == y).count();
    let (wrong, right) = (&a[start..a.len() - rest], &b[start..b.len() - rest]);
    let is_vowel = |letter: u8| b"aeiouy".contains(&letter);
    match (wrong, right) {
        ([i, j], [k, l]) if i == l && j == k => Slip::Exchange,
        ([], [letter]) if b[..start].last() == Some(letter) => Slip::Doubling,
        ([letter], []) if a[..start].last() == Some(letter) => Slip::Doubling,
        _ if undoubled(written) == undoubled(known) => Slip::Doubling,
        ([], [letter]) | ([letter], []) if is_vowel(*letter) => Slip::Sound,
        ([i], [k]) if is_vowel(*i) && is_vowel(*k) || is_alike(*i, *k) => Slip::Sound,
        _ => Slip::Other,
    }
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
            // The word for an object comes before a part of a name ("gas can") and a material ("maple").
            ("a wine glas, a nife and an aple", vec!["glass", "knife", "apple"]),
            // Rare nouns.
            ("two plats", vec!["plates"]),
            ("a bead and a crepe", vec![]),
            // Plurals.
            ("three boxs, two knifes, tomatos and a canvas", vec!["boxes", "knives", "tomatoes"]),
            ("a bannana, a vaze, a trey and a baterry", vec!["banana", "vase", "tray", "battery"]),
            ("bleu mugs, thre bowls bhind them, taken away", vec!["blue", "three", "behind"]),
            // Three letters: exchanged ones, and vowels of the words of the grammar.
            ("a mgu, the mgu nxt to teh plate", vec!["mug", "mug", "next", "the"]),
            ("one taller than the other, the outer ones flatter", vec![]),
            // Participles are no misspelled nouns.
            ("a fluted block and a hydrating oil", vec![]),
            // Words of the grammar.
            ("a fork next too a plate infront of a bowl", vec!["to", "in front"]),
            ("a knife on top off a book", vec!["of"]),
        ] {
            let mut source = Source::read(text);
            let words: Vec<String> =
                correct(&LEXICON, &mut source).into_iter().map(|(_, word)| word).collect();
            assert_eq!(words, expected, "{text}");
            assert_eq!(source.tokens.len(), source.spans.len(), "{text}");
        }
    }

    #[test]
    fn slips_have_the_likeliest_kind() {
        for (written, known, expected) in [
            ("palte", "plate", Slip::Exchange),
            ("glas", "glass", Slip::Doubling),
            ("muug", "mug", Slip::Doubling),
            ("plats", "plates", Slip::Sound),
            ("pincil", "pencil", Slip::Sound),
            ("vaze", "vase", Slip::Sound),
            ("baterry", "battery", Slip::Doubling),
            ("plats", "plants", Slip::Other),
        ] {
            assert_eq!(slip(written, known), expected, "{written}");
        }
    }
}
