//! Parts of noun phrases: the noun, its modifiers, new objects with their number.

use super::Reason;
use super::cursor::{Cursor, Outcome};
use crate::references::{color_of, is_noun, is_of_catalog, material_of, number, theme_of, vocabulary};
use catalog::stand_in::{Placeability, placeability};
use catalog::{Affordance, Category};
use scene::SupportRelation;

/// New objects that a phrase asks for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NewObjects {
    /// Singular with an indefinite article.
    Objects {
        object: String,
        count: u32,
    },
    Clutter {
        count: u32,
        theme: Option<String>,
    },
}

/// Number of objects of a plural without a number ("put spoons in it").
const BARE_PLURAL: u32 = 2;

/// Number of objects of "add clutter".
const CLUTTER: u32 = 5;

const DETERMINERS: &[&str] = &[
    "the", "a", "an", "my", "our", "your", "his", "her", "their", "this", "that", "these", "those", "all",
    "both", "every", "each", "other", "another", "some", "its", "new", "old",
];

const SIZES: &[&str] = &[
    "small", "large", "big", "little", "tiny", "huge", "tall", "short", "long", "smallest", "largest",
    "biggest", "tallest", "shortest", "longest", "smaller", "larger", "bigger", "taller", "shorter",
    "longer",
];

const PLACES: &[&str] = &[
    "left",
    "right",
    "front",
    "back",
    "rear",
    "middle",
    "center",
    "centre",
    "leftmost",
    "rightmost",
    "nearest",
    "closest",
    "farthest",
    "furthest",
    "first",
    "second",
    "third",
    "fourth",
    "fifth",
    "sixth",
    "last",
    "top",
    "bottom",
    "on",
    "in",
    "inside",
    "under",
    "behind",
    "next",
    "near",
    "beside",
    "between",
    "by",
    "from",
    "at",
];

const GENERIC: &[&str] = &["objects", "items", "things", "stuff", "clutter", "object", "item", "thing"];

fn any_word(phrase: &str, test: impl Fn(&str) -> bool) -> bool {
    phrase.to_lowercase().split(' ').any(test)
}

/// Whether the phrase may cease to fit when its object moves.
pub(super) fn has_place(phrase: &str) -> bool {
    any_word(phrase, |word| PLACES.contains(&word))
}

pub(super) fn has_color_or_material(phrase: &str) -> bool {
    any_word(phrase, |word| color_of(word).is_some() || material_of(word).is_some())
}

pub(super) fn has_size(phrase: &str) -> bool {
    any_word(phrase, |word| SIZES.contains(&word))
}

/// The noun of a phrase, without modifiers and what follows it: "mug" of "the two red mugs on the tray" is "mugs".
pub(super) fn noun_of(phrase: &str) -> String {
    let lower = phrase.to_lowercase();
    let words: Vec<&str> = lower.split(' ').collect();
    let is_modifier = |word: &&str| {
        DETERMINERS.contains(word)
            || SIZES.contains(word)
            || color_of(word).is_some()
            || material_of(word).is_some()
            || number(word).is_some()
            || vocabulary().is_shade(word)
            || PLACES.contains(word)
    };
    let ends = |word: &&str| {
        PLACES.contains(word) || matches!(*word, "of" | "with" | "that" | "which" | "except" | "but")
    };
    // A modifier that nothing follows is the noun ("the orange", "the glass of water").
    let is_before_noun =
        |pair: &&[&str]| is_modifier(&pair[0]) && (!ends(&pair[1]) || DETERMINERS.contains(&pair[0]));
    let start = words.windows(2).take_while(is_before_noun).count();
    let follows = |word: &&&str| !ends(word) || **word == "of";
    words[start..].iter().take_while(follows).copied().collect::<Vec<_>>().join(" ")
}

/// The phrase for new objects later in the instruction: "the red mug" of "a red mug".
pub(super) fn definite(object: &str, count: u32) -> String {
    let rest = object.strip_prefix("a pair of ").or_else(|| object.split_once(' ').map(|(_, rest)| rest));
    let rest = match rest {
        Some(rest) if object.starts_with("a ") || object.starts_with("an ") => rest,
        _ => object,
    };
    if count == 1 {
        format!("the {rest}")
    } else {
        format!("the {} {}", spelled(count), plural_of_head(rest))
    }
}

fn spelled(count: u32) -> String {
    let numbers = ["zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"];
    numbers.get(count as usize).map_or_else(|| count.to_string(), |word| (*word).to_owned())
}

fn plural_of_head(phrase: &str) -> String {
    match phrase.split_once(" of ") {
        Some((head, rest)) => format!("{} of {rest}", vocabulary().plural_of(head)),
        None => vocabulary().plural_of(phrase),
    }
}

fn singular_of_head(phrase: &str) -> Option<String> {
    match phrase.split_once(" of ") {
        Some((head, rest)) => Some(format!("{} of {rest}", vocabulary().singular_of(head)?)),
        None => vocabulary().singular_of(phrase),
    }
}

fn with_article(noun: &str) -> String {
    let vowel = noun.starts_with(['a', 'e', 'i', 'o', 'u', 'A', 'E', 'I', 'O', 'U']);
    let like_you =
        ["uni", "use", "usb", "eu", "one"].iter().any(|start| noun.to_lowercase().starts_with(start));
    if vowel && !like_you { format!("an {noun}") } else { format!("a {noun}") }
}

/// The category of the noun of a phrase; `None` where it is not known.
pub(super) fn category_of(phrase: &str) -> Option<&'static Category> {
    let noun = noun_of(phrase);
    let noun = noun.split(" of ").next().unwrap_or_default();
    let is_name = |category: &&Category| category.label == noun || category.name.replace('_', " ") == noun;
    let is_alias = |category: &&Category| vocabulary().is_alias(&category.name, noun);
    let is_synonym = |category: &&Category| category.synonyms.iter().any(|synonym| synonym == noun);
    let all = || catalog::categories().iter();
    all().find(is_name).or_else(|| all().find(is_alias)).or_else(|| all().find(is_synonym))
}

/// Whether the category of a phrase holds other objects that way; true where it is not known.
pub(super) fn supports(phrase: &str, support: SupportRelation) -> bool {
    let affordance = match support {
        SupportRelation::On => Affordance::Support,
        SupportRelation::In => Affordance::Container,
    };
    category_of(phrase).is_none_or(|category| category.affords(affordance))
}

impl Cursor {
    /// New objects at the cursor, up to `end`.
    pub fn new_objects(&mut self, end: usize) -> Outcome<NewObjects> {
        let start = self.at;
        let article = self.take_any(&["another", "an", "a"]);
        if article {
            self.at = start;
        }
        let pair = self.is_at(start, "a pair of");
        let mut count = match self.quantity_at(start) {
            Some((count, length)) => {
                self.at += length;
                Some(count)
            }
            None if article => {
                self.at += 1;
                Some(1)
            }
            None => None,
        };
        let some = self.word(start) == "some";
        let _ = self.take("of");
        while self.take_any(&["more", "extra", "additional", "new", "further", "other", "second", "third"]) {}
        let words = self.text(self.at, end);
        if words.is_empty() || self.at >= end {
            return self.not_understood(start, "name the object to add");
        }
        let last = self.word(end - 1).to_owned();
        if GENERIC.contains(&last.as_str()) {
            return self.clutter(count, end);
        }
        let mut noun = words.clone();
        if matches!(last.as_str(), "one" | "ones") {
            let Some(known) = self.discourse.last_noun() else {
                return Err(self.error(start, end, Reason::NoAntecedent));
            };
            let known =
                vocabulary().singular_of(known).filter(|one| is_noun(one)).unwrap_or(known.to_owned());
            noun = format!("{}{known}", &words[..words.len() - last.len()]);
            count = count.or((last == "ones").then_some(BARE_PLURAL));
        }
        self.check_noun(&noun, start, end)?;
        // "a pair of glasses" is one object.
        let whole_pair = pair && is_of_catalog(&format!("pair of {}", noun.to_lowercase()));
        let two_in_one = vocabulary().is_plural_only(noun.split(" of ").next().unwrap_or_default());
        let singular = singular_of_head(&noun).filter(|one| is_noun(&noun_of(one)) && *one != noun);
        let (object, count) = match (count, singular) {
            (Some(2), _) if whole_pair || (pair && two_in_one && singular_of_head(&noun).is_none()) => {
                (format!("a pair of {noun}"), 1)
            }
            (Some(count), None) if count > 1 && two_in_one => {
                (format!("a pair of {noun}"), if some { 1 } else { count })
            }
            // "some coffee" is one.
            (Some(_), None) if some => (noun, 1),
            (Some(count), None) => (with_article(&noun), count),
            (Some(count), Some(_)) if count == 1 => (with_article(&noun), count),
            (Some(count), Some(one)) => (with_article(&one), count),
            (None, Some(one)) => (with_article(&one), BARE_PLURAL),
            (None, None) => (noun, 1),
        };
        self.at = end;
        Ok(NewObjects::Objects { object, count })
    }

    fn clutter(&mut self, count: Option<u32>, end: usize) -> Outcome<NewObjects> {
        let from = self.at;
        let is_clutter = self.word(end - 1) == "clutter";
        while self.take_any(&["random", "different", "various", "assorted"]) {}
        let theme = self.text(self.at, end - 1);
        let theme = (!theme.is_empty()).then_some(theme);
        if theme.as_ref().is_some_and(|theme| theme_of(theme).is_none()) {
            return Err(self.error(from, end, Reason::UnknownTheme));
        }
        self.at = end;
        let count = if is_clutter { CLUTTER } else { count.unwrap_or(CLUTTER) };
        Ok(NewObjects::Clutter { count, theme })
    }

    /// Checks that the last words are a noun for something that stands on a table.
    fn check_noun(&self, noun: &str, start: usize, end: usize) -> Outcome<()> {
        let lower = noun.to_lowercase().replace('-', " ");
        let head = lower.split(" of ").next().unwrap_or_default();
        let words: Vec<&str> = head.split(' ').collect();
        let phrases = (0..words.len()).map(|from| words[from..].join(" "));
        for phrase in std::iter::once(lower.clone()).chain(phrases) {
            let singular = vocabulary().singular_of(&phrase).unwrap_or_else(|| phrase.clone());
            let obstacle = match placeability(&phrase).or_else(|| placeability(&singular)) {
                Some(Placeability::NotPlaceable(obstacle)) => Some(obstacle),
                _ => None,
            };
            let in_catalog = is_of_catalog(&phrase) || is_of_catalog(&singular);
            match obstacle {
                _ if in_catalog => return Ok(()),
                Some(obstacle) => {
                    return Err(self.error(start, end, Reason::NotPlaceable(obstacle.explanation())));
                }
                None if is_noun(&phrase) => return Ok(()),
                None => {}
            }
        }
        Err(self.error(start, end, Reason::UnknownObject))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noun_of_a_phrase_is_without_modifiers_and_places() {
        let cases = [
            ("the two red mugs on the tray", "mugs"),
            ("the glass of water", "glass of water"),
            ("the orange", "orange"),
            ("the orange on the tray", "orange"),
            ("a large wooden cutting board", "cutting board"),
            ("the second book from the left", "book"),
            ("the leftmost cup of coffee", "cup of coffee"),
            ("mug_1", "mug_1"),
        ];
        for (phrase, noun) in cases {
            assert_eq!(noun_of(phrase), noun, "{phrase}");
        }
    }

    #[test]
    fn new_objects_are_named_by_their_label() {
        assert_eq!(definite("a red mug", 1), "the red mug");
        assert_eq!(definite("a fork", 2), "the two forks");
        assert_eq!(definite("a glass of water", 2), "the two glasses of water");
        assert_eq!(definite("a pair of scissors", 1), "the scissors");
    }
}
