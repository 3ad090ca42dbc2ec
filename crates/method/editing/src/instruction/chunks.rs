//! Boundaries of noun phrases, places and clauses.

use super::cursor::Cursor;
use crate::references::{color_of, is_noun, material_of};

/// Beginnings of places, longer ones first. A distance may precede them.
const PREPOSITIONS: &[&str] = &[
    "to the left side of",
    "to the right side of",
    "on the left side of",
    "on the right side of",
    "to the left of",
    "to the right of",
    "on the left of",
    "on the right of",
    "left of",
    "right of",
    "in front of",
    "in back of",
    "behind",
    "next to",
    "close to",
    "near to",
    "adjacent to",
    "beside",
    "alongside",
    "near",
    "on top of",
    "onto",
    "on to",
    "on",
    "upon",
    "atop",
    "inside of",
    "inside",
    "into",
    "in between",
    "in",
    "between",
    "at",
    "to",
    "towards",
    "toward",
    "away from",
    "from",
    "out of",
    "off of",
    "off",
    "underneath",
    "under",
    "below",
    "beneath",
    "over",
    "above",
    "against",
    "around",
    "across",
    "beyond",
    "opposite",
    "there",
    "here",
    "forwards",
    "forward",
    "backwards",
    "backward",
    "closer",
    "somewhere",
    "anywhere",
    "away",
    "apart",
    "up",
    "down",
    "aside",
];

const BOUNDARIES: &[&str] = &[
    "", ".", ",", "and", "then", "also", "please", "thanks", "thank", "instead", "too", "so", "plus", "or",
    "as", "for",
];

/// Words that begin a phrase for objects that exist.
const DEFINITE: &[&str] = &[
    "the",
    "my",
    "our",
    "your",
    "his",
    "her",
    "their",
    "this",
    "that",
    "these",
    "those",
    "all",
    "both",
    "every",
    "each",
    "everything",
    "it",
    "them",
    "its",
];

/// Words that begin a phrase for new objects, or for any.
const INDEFINITE: &[&str] = &["a", "an", "anything", "another", "some", "several", "half", "any"];

/// Words that are a verb where an object follows them and a noun elsewhere are among these.
const VERBS: &[&str] = &[
    "add",
    "put",
    "place",
    "insert",
    "give",
    "include",
    "remove",
    "delete",
    "take",
    "clear",
    "get",
    "replace",
    "swap",
    "move",
    "shift",
    "slide",
    "bring",
    "rotate",
    "turn",
    "spin",
    "face",
    "enlarge",
    "shrink",
    "make",
    "paint",
    "color",
    "colour",
    "rename",
    "relabel",
    "stack",
    "tidy",
    "straighten",
    "change",
    "set",
    "lay",
    "push",
    "pull",
    "scale",
    "resize",
    "double",
    "halve",
    "grow",
    "recolor",
    "recolour",
    "dye",
    "call",
    "label",
    "pile",
    "point",
    "orient",
    "empty",
    "throw",
    "erase",
    "drop",
    "position",
    "relocate",
    "exchange",
    "substitute",
    "i",
    "id",
    "organize",
    "organise",
    "clean",
    "create",
    "increase",
    "reduce",
    "let",
    "lets",
    "there",
    "could",
    "can",
    "please",
    "align",
    "declutter",
    "stand",
    "clutter",
    "twist",
    "neaten",
    "arrange",
    "want",
    "need",
    "repaint",
    "spawn",
    "discard",
    "eliminate",
    "drag",
    "flip",
    "wipe",
    "do",
    "leave",
    "keep",
    "transfer",
    "triple",
    "aim",
    "finally",
    "next",
];

/// Verbs that are also nouns of objects: they are verbs where an object follows.
const VERBS_AND_NOUNS: &[&str] = &[
    "place", "paint", "color", "face", "stack", "set", "clear", "point", "pile", "scale", "label", "drop",
    "double", "empty", "turn", "shift", "slide", "stand", "clutter", "spin", "can", "clean", "next",
];

impl Cursor {
    /// The number of tokens of a beginning of a place: a distance, an adverb, a preposition.
    pub fn preposition_at(&self, index: usize) -> Option<usize> {
        let distance = self.distance_at(index).map_or(0, |(_, length)| length);
        let mut at = index + distance;
        let emphasis = [
            "directly",
            "right",
            "just",
            "immediately",
            "exactly",
            "halfway",
            "midway",
            "further",
            "a little further",
        ];
        if let Some(length) = self.length_of_any(at, &emphasis)
            && self.length_of_any(at + length, PREPOSITIONS).is_some()
            && !self.is_at(at, "right of")
            && (at == 0 || self.word(at - 1) != "the")
        {
            at += length;
        }
        if let Some(length) = self.length_of_any(at, PREPOSITIONS) {
            return Some(at + length - index);
        }
        let side = matches!(self.word(at), "left" | "right" | "back")
            && (at == 0 || self.word(at - 1) != "the")
            && (distance > 0 || self.is_boundary(at + 1) || self.is_at(at + 1, "by"));
        let by_distance = self.is_at(at, "by") && self.distance_at(at + 1).is_some();
        if side || by_distance { Some(at + 1 - index) } else { (distance > 0).then_some(distance) }
    }

    pub fn is_boundary(&self, index: usize) -> bool {
        let quoted = self.tokens.get(index).is_some_and(|token| token.quoted);
        !quoted && BOUNDARIES.contains(&self.word(index))
    }

    /// The number of tokens of commas and conjunctions.
    pub fn connector_at(&self, index: usize) -> usize {
        let mut at = index;
        while matches!(self.word(at), "," | "and" | "plus") || self.is_at(at, "as well") {
            at += if self.word(at) == "as" { 2 } else { 1 };
            if self.word(at) == "as" {
                at += 1;
            }
        }
        at - index
    }

    /// Whether a verb that begins a clause stands there.
    pub fn is_verb(&self, index: usize) -> bool {
        let word = self.word(index);
        let object =
            || self.is_beginning(index + 1) || matches!(self.word(index + 1), "up" | "away" | "out" | "off");
        VERBS.contains(&word) && (!VERBS_AND_NOUNS.contains(&word) || object() || self.is_boundary(index + 1))
    }

    pub fn is_beginning(&self, index: usize) -> bool {
        let word = self.word(index);
        DEFINITE.contains(&word)
            || INDEFINITE.contains(&word)
            || word.contains('_')
            || self.number_at(index).is_some()
    }

    /// Whether a noun phrase begins there.
    pub fn is_phrase(&self, index: usize) -> bool {
        let word = self.word(index);
        if word.is_empty() || self.is_boundary(index) || self.is_verb(index) {
            return false;
        }
        self.is_beginning(index) || is_noun(word) || color_of(word).is_some() || material_of(word).is_some()
    }

    /// Whether a definite phrase begins there: existing objects rather than new ones.
    pub fn is_definite(&self, index: usize) -> bool {
        let word = self.word(index);
        let part = |at: usize| {
            self.is_at(at, "of") && matches!(self.word(at + 1), "the" | "my" | "these" | "those" | "them")
        };
        let count = self.quantity_at(index).map_or(1, |(_, length)| length);
        DEFINITE.contains(&word) || word.contains('_') || part(index + count)
    }

    /// The end of the noun phrase that begins at an index: a boundary or what `stops` it. Places belong to it unless
    /// they stop it.
    pub fn phrase_end(&self, start: usize, stops: &dyn Fn(usize) -> bool) -> usize {
        let (mut at, mut between, mut except) = (start, false, false);
        while at < self.tokens.len() {
            let word = self.word(at);
            let but = word == "but" || self.is_at(at, "other than") || self.is_at(at, "apart from");
            except |= word == "except" || but;
            if word == "and" || word == "," {
                let next = at + self.connector_at(at);
                let joins = (between && word == "and") || (except && self.is_phrase(next));
                if !joins {
                    return at;
                }
                between = false;
                at = next;
                continue;
            }
            if self.is_boundary(at) || (at > start && stops(at)) {
                return at;
            }
            // Of "between the two plates" no conjunction follows.
            between |=
                word == "between" && !matches!(self.word(at + 1), "both") && !self.is_at(at + 1, "the two");
            at += 1;
        }
        at
    }

    /// The end of the clause: the end of the sentence, or a conjunction and another verb.
    pub fn clause_end(&self, start: usize) -> usize {
        let ends = |index: usize| {
            let next = index + self.connector_at(index);
            let verb = next > index && (self.is_verb(next) || matches!(self.word(next), "then" | "also"));
            self.is_end(index) || self.is_at(index, "then") || verb
        };
        (start..self.tokens.len()).find(|&index| ends(index)).unwrap_or(self.tokens.len())
    }

    /// The end of a noun phrase without places; "from the left" after a rank belongs to it.
    pub fn head_end(&self, start: usize) -> usize {
        self.phrase_end(start, &|index| {
            self.preposition_at(index).is_some() && !self.is_rank_origin(start, index)
        })
    }

    /// "from the left" in "the second book from the left".
    pub fn is_rank_origin(&self, start: usize, index: usize) -> bool {
        let ranked = (start..index).any(|at| {
            let word = self.word(at);
            matches!(word, "first" | "second" | "third" | "fourth" | "fifth" | "sixth" | "seventh" | "last")
                || ["2nd", "3rd", "1st", "4th", "5th"].contains(&word)
        });
        let side = matches!(self.word(index + 2), "left" | "right" | "front" | "back" | "top" | "bottom");
        ranked && self.is_at(index, "from the") && side && !matches!(self.word(index + 3), "edge" | "side")
    }
}
