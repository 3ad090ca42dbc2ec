//! Numbers, lengths, angles and factors.

use std::f64::consts::PI;

use crate::chart::Span;
use crate::lexicon::{begins_with, lexicon, split};
use crate::tokens::Token;
use crate::vocabulary::vocabulary;

/// Factor of "bigger"; that of "smaller" is its inverse.
const BIGGER: f64 = 1.25;
const SLIGHTLY_BIGGER: f64 = 1.1;
const MUCH_BIGGER: f64 = 1.5;

fn word(tokens: &[Token], at: usize) -> &str {
    tokens.get(at).filter(|token| !token.is_quoted).map_or("", |token| token.word.as_str())
}

/// The number of tokens of the longest of these phrases at an index.
fn longest(tokens: &[Token], at: usize, phrases: &[&str]) -> Option<usize> {
    phrases
        .iter()
        .map(|phrase| split(phrase))
        .filter(|phrase| begins_with(tokens, at, phrase))
        .map(|p| p.len())
        .max()
}

/// A cardinal number in digits or words, and its number of tokens: "10", "2.5", "ten", "twenty five".
pub(crate) fn number_at(tokens: &[Token], at: usize) -> Option<(f64, usize)> {
    let named = |at: usize| vocabulary().numbers.get(word(tokens, at)).map(|&number| f64::from(number));
    let first = word(tokens, at).replace(',', ".").parse::<f64>().ok().or_else(|| named(at))?;
    if !first.is_finite() || first < 0.0 || matches!(word(tokens, at), "both" | "double" | "single") {
        return None;
    }
    let (mut value, mut length) = (first, 1);
    if (20.0..100.0).contains(&value)
        && value % 10.0 == 0.0
        && let Some(ones) = named(at + 1).filter(|ones| (1.0..10.0).contains(ones))
    {
        (value, length) = (value + ones, 2);
    }
    if longest(tokens, at + length, &["and a half"]).is_some() {
        (value, length) = (value + 0.5, length + 3);
    }
    Some((value, length))
}

/// A part of one: "half", "a third", "three quarters", "30 %".
pub(crate) fn fraction_at(tokens: &[Token], at: usize) -> Option<(f64, usize)> {
    for (words, value) in [
        ("half", 0.5),
        ("a half", 0.5),
        ("one half", 0.5),
        ("a third", 1.0 / 3.0),
        ("a quarter", 0.25),
        ("a fourth", 0.25),
    ] {
        if let Some(length) = longest(tokens, at, &[words]) {
            return Some((value, length));
        }
    }
    let (value, length) = number_at(tokens, at)?;
    let part = match word(tokens, at + length) {
        "third" | "thirds" => 3.0,
        "quarter" | "quarters" | "fourth" | "fourths" => 4.0,
        "fifth" | "fifths" => 5.0,
        "tenth" | "tenths" => 10.0,
        "%" | "percent" => 100.0,
        _ => return None,
    };
    Some((value / part, length + 1))
}

/// A length in meters: "10 cm", "half a meter", "an inch", "a few centimeters" is none.
pub(crate) fn length_at(tokens: &[Token], at: usize) -> Option<(f64, usize)> {
    let about =
        longest(tokens, at, &["about", "around", "exactly", "roughly", "approximately", "some"]).unwrap_or(0);
    let start = at + about;
    let (value, length) = if let Some(length) = longest(tokens, start, &["half a", "half an"]) {
        (0.5, length)
    } else if matches!(word(tokens, start), "a" | "an") {
        (1.0, 1)
    } else {
        number_at(tokens, start)?
    };
    let unit_m = vocabulary().units.get(word(tokens, start + length))?;
    Some((value * unit_m, about + length + 1))
}

/// An angle in radians, counter-clockwise seen from above, with its direction where it is stated.
pub(crate) fn angles_at(tokens: &[Token], at: usize) -> Vec<Span<f64>> {
    let mut start = at + longest(tokens, at, &["by", "through", "about", "by about"]).unwrap_or(0);
    let sign_of = |at: usize| {
        let left = [
            "counterclockwise",
            "counter clockwise",
            "anticlockwise",
            "anti clockwise",
            "ccw",
            "to the left",
        ];
        let right = ["clockwise", "cw", "to the right"];
        let counter = longest(tokens, at, &left).map(|length| (1.0, length));
        counter.or_else(|| longest(tokens, at, &right).map(|length| (-1.0, length)))
    };
    let before = sign_of(start);
    start += before.map_or(0, |(_, length)| length);
    start += longest(tokens, start, &["by"]).unwrap_or(0);
    let Some((rad, length)) = plain_angle(tokens, start) else { return Vec::new() };
    let mut end = start + length;
    let after = sign_of(end).filter(|_| before.is_none());
    end += after.map_or(0, |(_, length)| length);
    let sign = before.or(after).map_or(1.0, |(sign, _)| sign);
    vec![Span { end, cost: 0.0, value: sign * rad }]
}

fn plain_angle(tokens: &[Token], at: usize) -> Option<(f64, usize)> {
    let turns = [
        ("a quarter turn", 0.5 * PI),
        ("a quarter of a turn", 0.5 * PI),
        ("a quarter of the way around", 0.5 * PI),
        ("a half turn", PI),
        ("half a turn", PI),
        ("half way around", PI),
        ("halfway around", PI),
        ("a full turn", 2.0 * PI),
        ("a right angle", 0.5 * PI),
    ];
    if let Some((pattern, rad)) =
        turns.into_iter().find(|(pattern, _)| longest(tokens, at, &[*pattern]).is_some())
    {
        return Some((rad, split(pattern).len()));
    }
    let minus = longest(tokens, at, &["minus"]).unwrap_or(0);
    let (value, length) = number_at(tokens, at + minus)?;
    let sign = if minus > 0 { -1.0 } else { 1.0 };
    match word(tokens, at + minus + length) {
        "degrees" | "degree" | "deg" => Some((sign * value.to_radians(), minus + length + 1)),
        "radians" | "radian" | "rad" => Some((sign * value, minus + length + 1)),
        _ => None,
    }
}

/// Factors of size: "twice as large", "20 % smaller", "a bit bigger", "three quarters of its height", "80 %".
pub(crate) fn factors_at(tokens: &[Token], at: usize) -> Vec<Span<f64>> {
    let mut found = Vec::new();
    let size_of = |at: usize| lexicon().lengths("size_of", tokens, at).into_iter().max();
    let mut add = |value: f64, end: usize| found.push(Span { end, cost: 0.0, value });
    let to = longest(tokens, at, &["to", "to about", "down to", "up to"]).unwrap_or(0);
    for (multiple, value) in
        [("twice", 2.0), ("double", 2.0), ("half", 0.5), ("triple", 3.0), ("half as", 0.5)]
    {
        if let Some(length) = longest(tokens, at + to, &[multiple])
            && let Some(size) = size_of(at + to + length)
        {
            let end = at + to + length + size;
            // "half as big again" is one and a half.
            match word(tokens, end) == "again" && multiple.starts_with("half") {
                true => add(1.5, end + 1),
                false => add(value, end),
            }
        }
    }
    if let Some((value, length)) = fraction_at(tokens, at + to) {
        let end = at + to + length;
        match word(tokens, end) {
            "bigger" | "larger" | "taller" | "wider" => add(1.0 + value, end + 1),
            "smaller" | "shorter" => add(1.0 - value, end + 1),
            _ => {
                if let Some(size) = size_of(end) {
                    add(value, end + size);
                } else if to > 0 {
                    add(value, end);
                }
            }
        }
    }
    if let Some((value, length)) = number_at(tokens, at + to) {
        let end = at + to + length;
        if let Some(times) = longest(tokens, end, &["times", "x", "fold"]) {
            add(value, end + times + size_of(end + times).unwrap_or(0));
        }
    }
    let slightly =
        longest(tokens, at, &["a little bit", "a bit", "a little", "slightly", "somewhat", "a tad"]);
    let much =
        longest(tokens, at, &["much", "a lot", "way", "far", "considerably", "significantly", "a good deal"]);
    let (factor, length) = match (slightly, much) {
        (Some(length), _) => (SLIGHTLY_BIGGER, length),
        (_, Some(length)) => (MUCH_BIGGER, length),
        _ => (BIGGER, 0),
    };
    match word(tokens, at + length) {
        "bigger" | "larger" => add(factor, at + length + 1),
        "smaller" => add(1.0 / factor, at + length + 1),
        _ => {}
    }
    found
}

/// Changes of size of verbs that say the direction: "by 20 %", "by half", "by a factor of 2", "to 80 %", "three times".
pub(crate) fn changes_at(tokens: &[Token], at: usize) -> Vec<Span<(Change, f64)>> {
    let mut found = Vec::new();
    if let Some(by) = longest(tokens, at, &["by", "by about"]) {
        if let Some(factor) = longest(tokens, at + by, &["a factor of", "factor"]) {
            let start = at + by + factor;
            found.extend(
                number_at(tokens, start).map(|(value, length)| (start + length, Change::Factor, value)),
            );
        }
        let start = at + by;
        found.extend(fraction_at(tokens, start).map(|(value, length)| (start + length, Change::Part, value)));
    }
    found.extend(factors_at(tokens, at).into_iter().map(|span| (span.end, Change::To, span.value)));
    found.into_iter().map(|(end, change, value)| Span { end, cost: 0.0, value: (change, value) }).collect()
}

/// The number that comes with a verb of size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Added to one, or taken from it.
    Part,
    /// The factor, or its inverse.
    Factor,
    /// The new size as a part of the old one.
    To,
}

/// Vague quantities and how many they stand for.
pub(crate) fn vague_count_at(tokens: &[Token], at: usize) -> Option<(u32, usize)> {
    let vague: [(&[&str], u32); 7] = [
        (&["half a dozen", "half dozen"], 6),
        (&["a dozen", "one dozen"], 12),
        (&["a couple of", "a couple", "a pair of"], 2),
        (&["a few", "some", "a handful of", "a bunch of", "a few more", "some more"], 3),
        (&["several", "a number of"], 4),
        (&["a single"], 1),
        (&["one more", "another"], 1),
    ];
    vague
        .into_iter()
        .find_map(|(patterns, count)| longest(tokens, at, patterns).map(|length| (count, length)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tokens::tokens;

    #[test]
    fn numbers_lengths_and_fractions() {
        assert_eq!(number_at(&tokens("twenty five mugs"), 0), Some((25.0, 2)));
        assert_eq!(number_at(&tokens("one and a half meters"), 0), Some((1.5, 4)));
        assert_eq!(length_at(&tokens("about 10cm"), 0), Some((0.1, 3)));
        assert_eq!(length_at(&tokens("half a meter"), 0), Some((0.5, 3)));
        assert_eq!(length_at(&tokens("ten mugs"), 0), None);
        assert_eq!(fraction_at(&tokens("three quarters"), 0), Some((0.75, 2)));
        assert_eq!(fraction_at(&tokens("80 %"), 0), Some((0.8, 2)));
    }

    #[test]
    fn angles_have_a_direction() {
        let angle = |text: &str| angles_at(&tokens(text), 0)[0].value;
        assert!((angle("45° clockwise") + 0.25 * PI).abs() < 1e-9);
        assert!((angle("by 90 degrees") - 0.5 * PI).abs() < 1e-9);
        assert!((angle("clockwise by half a turn") + PI).abs() < 1e-9);
    }

    #[test]
    fn factors_of_size() {
        for (text, factor) in [
            ("twice as large", 2.0),
            ("20 % smaller", 0.8),
            ("a bit bigger", 1.1),
            ("three quarters of its height", 0.75),
            ("half its size", 0.5),
            ("1.5 times as large", 1.5),
            ("to 80 %", 0.8),
            ("smaller", 0.8),
        ] {
            let tokens = tokens(text);
            let found = factors_at(&tokens, 0);
            assert!(
                found.iter().any(|span| span.end == tokens.len() && (span.value - factor).abs() < 1e-9),
                "{text}: {found:?}"
            );
        }
    }
}
