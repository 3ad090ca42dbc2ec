//! Prepositions, and named regions of a table top.

use super::tokens::{Token, match_phrase};
use RelationKind::{
    Around, AtBack, AtBackLeft, AtBackRight, AtCenter, AtFront, AtFrontLeft, AtFrontRight, AtLeft, AtRight,
    Behind, Between, In, InFrontOf, LeftOf, NextTo, On, RightOf,
};
use scene::RelationKind;

/// A preposition with its relation and syntax.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Preposition {
    pub kind: RelationKind,
    /// Whether subject and object are exchanged ("under", "below").
    pub inverse: bool,
    /// Whether the object is optional ("inside", "on top", "beside").
    pub may_stand_alone: bool,
    /// Whether the preposition has two objects ("between A and B").
    pub two_targets: bool,
}

/// Phrase, relation and flags: `i` inverse, `a` optional object, `2` two objects. Longer phrases come first.
const PREPOSITIONS: &[(&str, RelationKind, &str)] = &[
    ("on the left hand side of", LeftOf, ""),
    ("on the right hand side of", RightOf, ""),
    ("to the left side of", LeftOf, ""),
    ("to the right side of", RightOf, ""),
    ("on the left side of", LeftOf, ""),
    ("on the right side of", RightOf, ""),
    ("in the middle of", NextTo, ""),
    ("in the middle between", Between, "2a"),
    ("halfway between", Between, "2a"),
    ("midway between", Between, "2a"),
    ("on both sides of", NextTo, ""),
    ("on either side of", NextTo, ""),
    ("on each side of", NextTo, ""),
    ("to the left of", LeftOf, ""),
    ("to the right of", RightOf, ""),
    ("on the left of", LeftOf, ""),
    ("on the right of", RightOf, ""),
    ("at the left of", LeftOf, ""),
    ("at the right of", RightOf, ""),
    ("to the side of", NextTo, ""),
    ("by the side of", NextTo, ""),
    ("in the front of", InFrontOf, ""),
    ("in front of", InFrontOf, ""),
    ("in back of", Behind, ""),
    ("in between", Between, "2a"),
    ("on top of", On, ""),
    ("on the top of", On, ""),
    ("in the back of", Behind, ""),
    ("all around", Around, "a"),
    ("right next to", NextTo, ""),
    ("directly next to", NextTo, ""),
    ("directly behind", Behind, ""),
    ("right behind", Behind, ""),
    ("directly in front of", InFrontOf, ""),
    ("directly on top of", On, ""),
    ("right in front of", InFrontOf, ""),
    ("just behind", Behind, ""),
    ("standing on", On, ""),
    ("sitting on", On, ""),
    ("lying on", On, ""),
    ("lying in", In, ""),
    ("resting on", On, ""),
    ("stacked on", On, ""),
    ("stacked on top of", On, ""),
    ("on the surface of", On, ""),
    ("at the side of", NextTo, ""),
    ("left from", LeftOf, ""),
    ("right from", RightOf, ""),
    ("to the back of", Behind, ""),
    ("to the front of", InFrontOf, ""),
    ("at the back of", Behind, ""),
    ("at the front of", InFrontOf, ""),
    ("to the rear of", Behind, ""),
    ("opposite", NextTo, ""),
    ("in contact with", NextTo, ""),
    ("touching", NextTo, ""),
    ("followed by", NextTo, ""),
    ("in the vicinity of", NextTo, ""),
    ("on to", On, ""),
    ("in to", In, ""),
    ("inserted in", In, ""),
    ("over", On, ""),
    ("above", On, ""),
    ("close to", NextTo, ""),
    ("closer to", NextTo, ""),
    ("closest to", NextTo, ""),
    ("nearest to", NextTo, ""),
    ("nearest", NextTo, ""),
    ("closest", NextTo, ""),
    ("adjacent to", NextTo, ""),
    ("next to", NextTo, ""),
    ("close by", NextTo, "a"),
    ("left of", LeftOf, ""),
    ("right of", RightOf, ""),
    ("ahead of", InFrontOf, ""),
    ("in front", InFrontOf, "a"),
    ("to the left", LeftOf, "a"),
    ("to the right", RightOf, "a"),
    ("on top", On, "a"),
    ("piled on", On, ""),
    ("placed on", On, ""),
    ("inside of", In, ""),
    ("along with", NextTo, ""),
    ("together with", NextTo, ""),
    ("leaning against", NextTo, ""),
    ("near to", NextTo, ""),
    ("atop", On, ""),
    ("upon", On, ""),
    ("onto", On, ""),
    ("on", On, ""),
    ("inside", In, "a"),
    ("within", In, ""),
    ("into", In, ""),
    ("in", In, ""),
    ("behind", Behind, "a"),
    ("beside", NextTo, "a"),
    ("besides", NextTo, ""),
    ("alongside", NextTo, "a"),
    ("nearby", NextTo, "a"),
    ("near", NextTo, ""),
    ("by", NextTo, ""),
    ("against", NextTo, ""),
    ("around", Around, "a"),
    ("surrounding", Around, ""),
    ("sandwiched between", Between, "2a"),
    ("wedged between", Between, "2a"),
    ("nestled between", Between, "2a"),
    ("squeezed between", Between, "2a"),
    ("between", Between, "2a"),
    ("among", NextTo, ""),
    ("amid", NextTo, ""),
    ("underneath", On, "ia"),
    ("beneath", On, "i"),
    ("below", On, "i"),
    ("under", On, "i"),
];

/// The preposition at `at` and its number of words.
pub(super) fn preposition_at(tokens: &[Token], at: usize) -> Option<(Preposition, usize)> {
    let first = tokens.get(at)?.word()?;
    PREPOSITIONS
        .iter()
        .filter(|(phrase, _, _)| phrase.starts_with(first))
        .filter_map(|(phrase, kind, marks)| {
            let length = match_phrase(tokens, at, phrase)?;
            let preposition = Preposition {
                kind: *kind,
                inverse: marks.contains('i'),
                may_stand_alone: marks.contains('a'),
                two_targets: marks.contains('2'),
            };
            Some((preposition, length))
        })
        .max_by_key(|(_, length)| *length)
}

/// "on top of each other", "beside one another": the relation and the number of words.
pub(super) fn reciprocal_at(tokens: &[Token], at: usize) -> Option<(RelationKind, usize)> {
    let (preposition, length) = preposition_at(tokens, at)?;
    let other =
        ["each other", "one another"].iter().find_map(|phrase| match_phrase(tokens, at + length, phrase))?;
    Some((preposition.kind, length + other))
}

/// "in the center (of the table)", "at the back", "in the left corner", "on the far left", "to one
/// side". `None` if the words continue with an object ("in the center of the plates").
pub(super) fn place_at(
    tokens: &[Token],
    at: usize,
    is_table: &impl Fn(&str) -> bool,
) -> Option<(Vec<RelationKind>, usize)> {
    let word = |p: usize| tokens.get(p).and_then(Token::word);
    let mut p = at;
    if word(p) == Some("the") {
        // "the left third of the table holds ...".
        return place_of(tokens, at, at, "in", is_table).filter(|(_, length)| {
            let holds = word(at + length);
            *length > 2
                && matches!(holds, Some("holds" | "has" | "contains" | "carries" | "a" | "an" | "is" | "are"))
        });
    }
    if word(p) == Some("centered") && !matches!(word(p + 1), Some("between")) {
        let of = ["on the table", "on the desk", "in the table", "on the table top"];
        let length = of.iter().filter_map(|phrase| match_phrase(tokens, at + 1, phrase)).max().unwrap_or(0);
        return Some((vec![AtCenter], 1 + length));
    }
    let opener = word(p)?;
    if !matches!(
        opener,
        "in" | "at"
            | "on"
            | "to"
            | "toward"
            | "towards"
            | "near"
            | "along"
            | "from"
            | "into"
            | "onto"
            | "close"
            | "by"
    ) {
        return None;
    }
    p += 1;
    if opener == "close" || (opener == "over" && word(p) == Some("to")) {
        if word(p) != Some("to") {
            return None;
        }
        p += 1;
    }
    // "near the viewer", "close to me".
    let noun = p + usize::from(word(p) == Some("the"));
    let viewer = matches!(word(noun), Some("viewer" | "user" | "robot" | "camera" | "observer" | "operator"))
        && noun > p
        || matches!(word(p), Some("me" | "us" | "you"));
    if viewer && matches!(opener, "near" | "close") {
        return Some((vec![AtFront], noun + 1 - at));
    }
    place_of(tokens, at, p, opener, is_table)
}

/// The place whose article or noun is at `start`, after its opener.
fn place_of(
    tokens: &[Token],
    at: usize,
    start: usize,
    opener: &str,
    is_table: &impl Fn(&str) -> bool,
) -> Option<(Vec<RelationKind>, usize)> {
    let word = |p: usize| tokens.get(p).and_then(Token::word);
    let mut p = start;
    let mut article = false;
    while matches!(word(p), Some("the" | "one" | "its" | "very" | "a" | "exact")) {
        if word(p) == Some("its") {
            return None;
        }
        article = true;
        p += 1;
    }
    let mut places = Vec::new();
    let mut nouns = 0;
    while let Some(w) = word(p) {
        match w {
            "center" | "centre" | "middle" => places.push(AtCenter),
            "back" | "rear" => places.push(AtBack),
            "front" => places.push(AtFront),
            "left" => places.push(AtLeft),
            "right" => places.push(AtRight),
            // "the far left" is just the left; "the far side" is the back.
            "far"
                if matches!(word(p + 1), Some("end" | "side" | "edge" | "corner"))
                    || word(p + 2) == Some("corner") =>
            {
                places.push(AtBack)
            }
            "near"
                if matches!(word(p + 1), Some("end" | "side" | "edge" | "corner"))
                    || word(p + 2) == Some("corner") =>
            {
                places.push(AtFront)
            }
            "far" | "hand" | "upper" | "top" | "bottom" | "lower" if article && place_ahead(&word, p + 1) => {
                match w {
                    "upper" | "top" => places.push(AtBack),
                    "bottom" | "lower" => places.push(AtFront),
                    _ => {}
                }
            }
            "corner" | "side" | "edge" | "end" | "part" | "half" | "corners" | "third" | "area" | "row"
            | "region" | "zone" | "quarter" | "quadrant" | "portion" | "section" => nouns += 1,
            "table" | "desk" if places.is_empty() && is_table(w) && place_ahead(&word, p + 1) => {}
            _ => break,
        }
        p += 1;
    }
    if places.is_empty() {
        // "in a corner": any of them.
        let corner = nouns > 0 && word(p - 1) == Some("corner") && article;
        if !corner {
            return None;
        }
        places.push(AtBackRight);
    }
    // "in the table's center", "on the left and right".
    let places = corner_of(places);
    // "to the left" alone and "in front" alone are relations.
    let is_center = places == [AtCenter];
    if nouns == 0
        && !is_center
        && (matches!(opener, "to" | "toward" | "towards") || (opener == "in" && !article))
    {
        return None;
    }
    if word(p) == Some("of") {
        let mut q = p + 1;
        while matches!(word(q), Some("the" | "a" | "this" | "that" | "its"))
            || q < p + 5 && word(q).is_some_and(|w| !is_table(w)) && word(q + 1).is_some_and(is_table)
        {
            q += 1;
        }
        if word(q).is_some_and(is_table) && word(q) != Some("it") {
            return Some((places, q + 1 - at));
        }
        // "at the center of the back edge", "at the left of the front side".
        let (inner, length) = place_of(tokens, p + 1, p + 1, "at", is_table)?;
        let is_named = (p + 1..p + 1 + length)
            .any(|q| matches!(word(q), Some("edge" | "side" | "end" | "half" | "third" | "part" | "corner")));
        let both = match (&places[..], &inner[..]) {
            ([AtCenter], [_]) => inner,
            ([one], [other]) => corner_of(vec![*one, *other]),
            _ => return None,
        };
        return (is_named && both.len() == 1).then_some((both, p + 1 + length - at));
    }
    // "near the left mug" names an object.
    if nouns == 0
        && matches!(opener, "near" | "from" | "by" | "close")
        && word(p).is_some_and(|w| !matches!(w, "and" | "with" | "is"))
    {
        return None;
    }
    Some((places, p - at))
}

/// Two sides name a corner.
pub(super) fn corner_of(places: Vec<RelationKind>) -> Vec<RelationKind> {
    let corner = match places[..] {
        [AtBack, AtLeft] | [AtLeft, AtBack] => AtBackLeft,
        [AtBack, AtRight] | [AtRight, AtBack] => AtBackRight,
        [AtFront, AtLeft] | [AtLeft, AtFront] => AtFrontLeft,
        [AtFront, AtRight] | [AtRight, AtFront] => AtFrontRight,
        // "in the back center".
        [side, AtCenter] | [AtCenter, side] => side,
        _ => return places,
    };
    vec![corner]
}

fn place_ahead<'a>(word: &impl Fn(usize) -> Option<&'a str>, at: usize) -> bool {
    matches!(
        word(at),
        Some("left" | "right" | "corner" | "side" | "edge" | "end" | "back" | "front" | "center" | "middle")
    )
}

#[cfg(test)]
mod tests {
    use super::super::tokens::tokenize;
    use super::*;

    #[test]
    fn place_at_distinguishes_regions_from_relations() {
        let table = |word: &str| word == "table" || word == "desk";
        let places = |text: &str| place_at(&tokenize(text), 0, &table).map(|(places, _)| places);
        assert_eq!(places("in the center of the oak table"), Some(vec![AtCenter]));
        assert_eq!(places("in the back left corner"), Some(vec![AtBackLeft]));
        assert_eq!(places("in the top right corner of the table"), Some(vec![AtBackRight]));
        assert_eq!(places("on the left third of the table"), Some(vec![AtLeft]));
        assert_eq!(places("on the left"), Some(vec![AtLeft]));
        assert_eq!(places("at the far end of the desk"), Some(vec![AtBack]));
        assert_eq!(places("in the middle of the back edge"), Some(vec![AtBack]));
        assert_eq!(places("in the near left corner"), Some(vec![AtFrontLeft]));
        assert_eq!(places("close to the near edge"), Some(vec![AtFront]));
        assert_eq!(places("near the viewer"), Some(vec![AtFront]));
        assert_eq!(places("to the left of the mug"), None);
        assert_eq!(places("in the middle of the plates"), None);
        assert_eq!(places("in front of the mug"), None);
        assert_eq!(places("on the right side of the laptop"), None);
    }

    #[test]
    fn the_longest_preposition_wins() {
        let kind = |text: &str| preposition_at(&tokenize(text), 0).map(|(p, length)| (p.kind, length));
        assert_eq!(kind("on top of it"), Some((On, 3)));
        assert_eq!(kind("on top"), Some((On, 2)));
        assert_eq!(kind("in front of the mug"), Some((InFrontOf, 3)));
    }
}
