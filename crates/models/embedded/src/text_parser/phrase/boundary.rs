//! Words that end a noun phrase.

use crate::text_parser::verbs::verbs;
use crate::text_parser::vocabulary::Vocabulary;

/// Whether a noun phrase ends before this word, unless it belongs to a phrase of the lexicon.
pub(in crate::text_parser) fn is_boundary(vocabulary: &Vocabulary, word: &str) -> bool {
    vocabulary.grammar.boundaries.contains(word)
        || vocabulary.grammar.determiners.contains(word) && word != "other"
        || (verbs().is_form(word) && !word.ends_with("ing") && !verbs().may_modify(word))
        || (verbs().asks_for_scene(word) && !verbs().may_modify(word))
}
