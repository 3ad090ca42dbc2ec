//! Words that end a noun phrase.

use crate::text_parser::verbs::verbs;
use crate::text_parser::vocabulary::Vocabulary;

/// Prepositions, conjunctions, auxiliaries and participles.
const BOUNDARIES: &[&str] = &[
    "and", "or", "nor", "neither", "either", "with", "of", "on", "in", "at", "to", "by", "for", "from", "next", "near",
    "beside", "besides", "behind", "under", "between", "around", "inside", "outside", "without", "but", "is", "are",
    "was", "were", "be", "it", "them", "they", "there", "left", "right", "front", "into", "onto", "over", "above",
    "below", "beneath", "underneath", "atop", "upon", "within", "along", "alongside", "against", "containing",
    "holding", "carrying", "filled", "full", "topped", "surrounded", "flanked", "has", "have", "holds", "contains",
    "plus", "then", "while", "where", "which", "who", "as", "also", "not", "never", "except", "excluding", "minus",
    "close", "adjacent", "together", "stacked", "piled", "placed", "standing", "lying", "sitting", "resting",
    "arranged", "opposite", "facing", "instead", "rather", "should", "must", "can", "could", "would", "will", "shall",
    "may", "might", "do", "does", "dont", "doesnt", "isnt", "arent", "so", "if", "than", "per", "each", "both", "away",
    "off", "out", "through", "across", "toward", "towards", "until", "lacking", "missing", "leaning", "rotated",
    "turned", "parallel", "apart", "spaced", "including", "featuring", "using", "via", "i", "we", "you", "he", "she",
    "sits", "stands", "lies", "rests", "sit", "stand", "lie", "please", "located", "positioned", "aligned", "centered",
    "distributed", "evenly", "x", "no", "needs", "ends", "goes", "only",
];

/// Verbs that are also adjectives or nouns.
const ALSO_MODIFIERS: &[&str] = &[
    "open", "clean", "empty", "light", "level", "top", "play", "point", "count", "upright", "cover", "set", "fit",
    "return", "pack", "hook", "seal", "group", "fix", "water", "pass", "hand", "trade", "model", "paint", "spread",
    "stick", "brush", "dust", "slot", "cut", "mix", "roll", "pick", "lock", "wash", "tap", "tie", "wrap", "heat",
];

/// Whether a noun phrase ends before this word, unless it belongs to a phrase of the lexicon.
pub(in crate::text_parser) fn is_boundary(vocabulary: &Vocabulary, word: &str) -> bool {
    BOUNDARIES.contains(&word)
        || vocabulary.grammar.determiners.contains(word) && word != "other"
        || (verbs().is_form(word) && !word.ends_with("ing") && !ALSO_MODIFIERS.contains(&word))
        || (verbs().asks_for_scene(word) && !ALSO_MODIFIERS.contains(&word))
}
