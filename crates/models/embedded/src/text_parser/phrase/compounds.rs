//! Compounds: which words make another object of a known head, and which words of the grammar are heads of compounds.

use super::boundary::is_boundary;
use super::head::words_of;
use super::{Chunk, Determiner};
use crate::text_parser::lexicon::{Entry, Meaning};
use crate::text_parser::property::Property;
use crate::text_parser::tokens::{Token, word};
use crate::text_parser::verbs::verbs;
use catalog::Affordance;

/// Portions and packages that are also heads of compounds.
const PORTIONS: &[&str] = &["slice", "piece", "sheet", "tube", "pack", "packet", "bar", "wedge"];

/// Verbs whose base form is also the participle: "a cake cut in half".
const SAME_AS_PARTICIPLE: &[&str] = &["cut", "set", "put", "shut", "split", "spread", "hit"];

/// Words after a verb that says where something is.
const PREPOSITIONS: &[&str] = &[
    "on", "in", "at", "against", "near", "next", "to", "into", "onto", "behind", "beside", "under", "over",
    "by", "inside", "between", "around", "along", "upright", "up", "down", "flat", "there", "here", "from",
];

/// Groups of food; a roll of it is baked.
const FOOD: &[&str] =
    &["fruit", "vegetable", "bakery", "baked_good", "meal", "meat", "food", "sweet", "nut", "dish"];

impl Chunk<'_, '_> {
    /// "masking tape roll": a roll of goods is the goods.
    pub(super) fn is_roll_of(&self, entry: &Entry, w: &str) -> bool {
        let Some(Meaning::Category(index)) = entry.meanings.first() else { return false };
        matches!(w, "roll" | "rolls") && !FOOD.contains(&self.lexicon.categories[*index].group.as_str())
    }

    /// The noun of the text, if the category of a known head only stands in for it.
    pub(super) fn stood_in_for(&self, entry: &Entry, start: usize, end: usize) -> Option<String> {
        let head = words_of(self.tokens, start..end).collect::<Vec<_>>().join(" ");
        let head = if entry.plural { self.lexicon.vocabulary.singular_of(&head) } else { head };
        let mut modifiers = self.modifiers.clone();
        let category = match entry.meanings.first()? {
            Meaning::Category(index) => &self.lexicon.categories[*index],
            // "a dog toy" is none of the toys of the catalog.
            Meaning::Vague(_) if !modifiers.is_empty() && !entry.plural => {
                return Some(format!("{} {head}", modifiers.join(" ")));
            }
            _ => return None,
        };
        // "a foam roller": what no vessel holds belongs to the name.
        let holds = category.affords(Affordance::Container)
            || ["vessel", "bottle", "can", "package", "meal", "dish"].contains(&category.group.as_str());
        let contents =
            self.phrase.properties.iter().filter(|(property, _)| *property == Property::Content && !holds);
        modifiers.extend(contents.flat_map(|(_, range)| words_of(self.tokens, range.clone())));
        if modifiers.is_empty() {
            return entry.stands_in.then_some(head);
        }
        let noun = format!("{} {head}", modifiers.join(" "));
        // "A dessert plate" is a plate of its own kind; "a cocktail shaker" is no kind of the salt shaker.
        let is_kind = head == category.label
            && self.lexicon.nouns.nearest_by_meaning(&noun) == Some(category.label.as_str());
        (entry.stands_in || !is_kind).then_some(noun)
    }

    /// Whether a word that is also a verb or a portion is the head of a compound: "a pen rest", "a turkey slice". After
    /// one object, a verb would have another form; "a pen and a pencil rest on the desk" goes on with a preposition.
    pub(super) fn is_noun_here(&self, entry: &Entry, w: &str, at: usize) -> bool {
        let vocabulary = self.lexicon.vocabulary;
        let next = word(self.tokens, at + 1);
        let goes_on = next.is_some_and(|next| {
            PREPOSITIONS.contains(&next)
                || vocabulary.grammar.determiners.contains(next)
                || matches!(next, "it" | "them")
        });
        let is_portion = PORTIONS.contains(&w) || vocabulary.packages.contains_key(w);
        let is_verb = verbs().is_base(w)
            && !SAME_AS_PARTICIPLE.contains(&w)
            && !vocabulary.states.contains_key(w)
            && !vocabulary.grammar.piles.contains(w);
        // "Let the mug drop": after "the", a verb is a verb.
        let is_new = self.phrase.determiner == Determiner::New && self.determined;
        matches!(entry.meanings[0], Meaning::Category(_))
            && !entry.plural
            && self.phrase.count.is_none_or(|count| count == [1, 1])
            && !goes_on
            && (is_portion && self.determined || is_verb && is_new)
            && self.lexicon.nouns.is_noun(w)
    }

    /// Number of tokens of a compound of the lexicon of nouns ("steel wool", "spring roll"). The catalog's own phrases
    /// come first, and where its last word is of the catalog, that word decides.
    pub(super) fn compound_at(&self, at: usize) -> Option<usize> {
        let lexicon = self.lexicon;
        let is_compound = |length: &usize| {
            let words: Option<Vec<&str>> = (at..at + length).map(|p| word(self.tokens, p)).collect();
            words.is_some_and(|words| {
                let last = at + length - 1;
                // "the pot to the left" is no "potto".
                let is_phrase = PREPOSITIONS.contains(&words[length - 1])
                    || matches!(words[length - 1], "and" | "or" | "of" | "with" | "for" | "is" | "are");
                !is_phrase
                    && lexicon.longest_at(self.tokens, last).is_none()
                    && lexicon.longest_at(self.tokens, last + 1).is_none()
                    && lexicon.longest_at(self.tokens, at).is_none_or(|(_, known)| known < *length)
                    && lexicon.nouns.stand_in(&lexicon.vocabulary.singular_of(&words.join(" "))).is_some()
            })
        };
        [3, 2].into_iter().find(is_compound)
    }

    /// Whether a word that is also a verb, a material or a color, or has the form of an adjective, names an object:
    /// "a watch", "an iron", "a starfish".
    pub(super) fn is_noun_alone(&self, w: &str) -> bool {
        let vocabulary = self.lexicon.vocabulary;
        let is_color = vocabulary.colors.contains_key(w);
        // "two mugs: one red, one blue": only some names of colors are also nouns.
        let names_only_color = matches!(
            w,
            "red"
                | "blue"
                | "green"
                | "yellow"
                | "white"
                | "black"
                | "gray"
                | "grey"
                | "brown"
                | "pink"
                | "purple"
        );
        if names_only_color || matches!(self.tokens.get(self.at + 1), Some(Token::Number(_))) {
            return false;
        }
        let is_property = is_color || vocabulary.materials.contains_key(w);
        // "A watch": after an article, no verb follows.
        let is_verb = verbs().is_base(w) && self.phrase.determiner == Determiner::New;
        // "a rose, a coral and a white mug" lists colors.
        let lists = matches!(self.tokens.get(self.at + 1), Some(Token::Pause))
            || matches!(self.word(1), Some("and" | "or"));
        let is_last = self.word(1).is_none_or(|next| is_boundary(vocabulary, next)) && !(is_color && lists);
        self.determined
            && is_last
            && (is_property || is_verb || vocabulary.is_ordinary(w) && !vocabulary.is_listed(w))
            && self.lexicon.nouns.stand_in(&vocabulary.singular_of(w)).is_some()
    }
}
