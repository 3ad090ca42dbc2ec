//! New objects that a phrase asks for: singular with an indefinite article, and their number.

use catalog::stand_in::{Placeability, placeability};

use super::error::Reason;
use crate::chart::Chart;
use crate::nominal::{NounPhrase, Quantity};
use crate::nouns::{is_noun, is_of_catalog};
use crate::vocabulary::{theme_of, vocabulary};

/// New objects.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NewObjects {
    Objects { object: String, count: u32 },
    Clutter { count: u32, theme: Option<String> },
}

/// Number of objects of a plural without a number ("put spoons in it").
const BARE_PLURAL: u32 = 2;
/// Number of objects of "add clutter".
const CLUTTER: u32 = 5;
const GENERIC: &[&str] = &["objects", "items", "things", "stuff", "clutter", "object", "item", "thing"];
/// Words before a noun that say that there are others.
const ADDITIONAL: &[&str] = &["more", "extra", "additional", "new", "further", "other"];

/// The new objects of a phrase. `last_noun` is that of "a blue one".
pub(super) fn new_objects(
    chart: &Chart,
    phrase: &NounPhrase,
    last_noun: Option<&str>,
) -> Result<NewObjects, Reason> {
    // "three pens in a row behind the plate": what follows the noun says where as well.
    if phrase.tokens.end > phrase.body.end {
        return Err(Reason::TwoPlaces);
    }
    let mut body = phrase.body.clone();
    while ADDITIONAL.contains(&chart.word(body.start)) && body.len() > 1 {
        body.start += 1;
    }
    let count = match phrase.quantity {
        Quantity::One => Some(1),
        Quantity::Count(count) => Some(count),
        Quantity::Plural | Quantity::All | Quantity::Each | Quantity::Fraction(_) => None,
    };
    let last = chart.word(body.end.saturating_sub(1)).to_owned();
    if GENERIC.contains(&last.as_str()) {
        return clutter(chart, body, count, &last);
    }
    let mut noun = chart.written(body);
    if matches!(last.as_str(), "one" | "ones") {
        let known = last_noun.ok_or(Reason::NoAntecedent)?;
        let known = vocabulary().singular_of(known).filter(|one| is_noun(one)).unwrap_or(known.to_owned());
        noun = format!("{}{known}", &noun[..noun.len() - last.len()]);
    }
    check_noun(&noun)?;
    let opening = chart.words(phrase.tokens.start..phrase.body.start);
    let (object, count) = numbered(&noun, &opening, count, last == "ones");
    Ok(NewObjects::Objects { object, count })
}

/// The object with its article, and how many there are. "A pair of glasses" is one object.
fn numbered(noun: &str, opening: &str, count: Option<u32>, is_plural: bool) -> (String, u32) {
    let pair = opening.starts_with("a pair of");
    let some = opening.starts_with("some");
    let whole_pair = pair && is_of_catalog(&format!("pair of {}", noun.to_lowercase()));
    let two_in_one = vocabulary().is_plural_only(noun.split(" of ").next().unwrap_or_default());
    let singular = singular_of_head(noun).filter(|one| is_noun(&last_noun_of(one)) && *one != noun);
    match (count, singular) {
        _ if some && !is_plural && !two_in_one && singular_of_head(noun).is_none() => (noun.to_owned(), 1),
        (Some(2), _) if whole_pair || (pair && two_in_one) => (format!("a pair of {noun}"), 1),
        (Some(count), None) if count > 1 && two_in_one => {
            (format!("a pair of {noun}"), if some { 1 } else { count })
        }
        (Some(_), None) if some => (noun.to_owned(), 1),
        (Some(count), None) => (with_article(noun), count),
        (Some(1), Some(_)) => (with_article(noun), 1),
        (Some(count), Some(one)) => (with_article(&one), count),
        (None, Some(one)) => (with_article(&one), BARE_PLURAL),
        (None, None) if is_plural => (with_article(noun), BARE_PLURAL),
        (None, None) => (noun.to_owned(), 1),
    }
}

fn clutter(
    chart: &Chart,
    body: std::ops::Range<usize>,
    count: Option<u32>,
    last: &str,
) -> Result<NewObjects, Reason> {
    let mut start = body.start;
    while matches!(
        chart.word(start),
        "random" | "different" | "various" | "assorted" | "more" | "bits" | "pieces" | "of"
    ) {
        start += 1;
    }
    let theme = if start + 1 < body.end { chart.written(start..body.end - 1) } else { String::new() };
    let theme = (!theme.is_empty()).then_some(theme);
    if theme.as_ref().is_some_and(|theme| theme_of(theme).is_none()) {
        return Err(Reason::UnknownTheme);
    }
    let count = if last == "clutter" { CLUTTER } else { count.unwrap_or(CLUTTER) };
    Ok(NewObjects::Clutter { count, theme })
}

/// Checks that the last words are a noun for something that stands on a table.
fn check_noun(noun: &str) -> Result<(), Reason> {
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
            Some(obstacle) => return Err(Reason::NotPlaceable(obstacle.explanation())),
            None if is_noun(&phrase) => return Ok(()),
            None => {}
        }
    }
    Err(Reason::UnknownObject)
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

/// The last words of a phrase that are a noun; the last word where none are.
fn last_noun_of(phrase: &str) -> String {
    let head = phrase.split(" of ").next().unwrap_or_default().to_lowercase().replace('-', " ");
    let words: Vec<&str> = head.split(' ').collect();
    let mut suffixes = (0..words.len()).map(|start| words[start..].join(" "));
    let known = suffixes.clone().find(|suffix| is_noun(suffix));
    known.or_else(|| suffixes.next_back()).unwrap_or_default()
}

fn with_article(noun: &str) -> String {
    // "something sweet"
    if noun.to_lowercase().starts_with("something ") {
        return noun.to_owned();
    }
    let vowel = noun.starts_with(['a', 'e', 'i', 'o', 'u', 'A', 'E', 'I', 'O', 'U']);
    let like_you =
        ["uni", "use", "usb", "eu", "one"].iter().any(|start| noun.to_lowercase().starts_with(start));
    if vowel && !like_you { format!("an {noun}") } else { format!("a {noun}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_objects_are_named_by_their_label() {
        assert_eq!(definite("a red mug", 1), "the red mug");
        assert_eq!(definite("a fork", 2), "the two forks");
        assert_eq!(definite("a glass of water", 2), "the two glasses of water");
        assert_eq!(definite("a pair of scissors", 1), "the scissors");
    }
}
