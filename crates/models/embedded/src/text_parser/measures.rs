//! Measures in a text: "30 cm wide", "10x20 cm", "12 inches tall", "a height of 12 cm", "12 oz", "500 g".

use super::phrase::is_boundary;
use super::tokens::{Token, match_phrase, word};
use super::vocabulary::Vocabulary;

/// The extent that a length refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    Width,
    Depth,
    Height,
    /// The longer horizontal extent.
    Length,
    /// Both horizontal extents.
    Diameter,
    /// The largest extent.
    Unspecified,
}

/// A length of the text, meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measure {
    pub axis: Axis,
    pub meters: f64,
}

/// A measure, or several lengths joined by "x" or "by". Ounces are a volume and a mass; the category decides.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Reading {
    pub lengths: Vec<Measure>,
    pub volume_m3: Option<f64>,
    pub mass_kg: Option<f64>,
}

/// The measure at `at` and the number of tokens it takes. A number before a unit is never a count.
pub(super) fn read_measure(vocabulary: &Vocabulary, tokens: &[Token], at: usize) -> Option<(Reading, usize)> {
    numbers_first(vocabulary, tokens, at).or_else(|| name_first(vocabulary, tokens, at))
}

/// The lengths at `at`, without volumes and masses.
pub(super) fn read_length(vocabulary: &Vocabulary, tokens: &[Token], at: usize) -> Option<(f64, usize)> {
    let (reading, length) = numbers_first(vocabulary, tokens, at)?;
    match reading.lengths[..] {
        [Measure { axis: Axis::Unspecified, meters }] => Some((meters, length)),
        _ => None,
    }
}

fn numbers_first(vocabulary: &Vocabulary, tokens: &[Token], at: usize) -> Option<(Reading, usize)> {
    let mut numbers = Vec::new();
    let mut units: Vec<Option<f64>> = Vec::new();
    let mut p = at;
    loop {
        let (number, length) = number_at(vocabulary, tokens, p)?;
        p += length;
        if numbers.is_empty()
            && let Some((reading, length)) = volume_or_mass(vocabulary, tokens, p, number)
        {
            return Some((reading, p + length - at));
        }
        let unit = unit_at(vocabulary, tokens, p);
        if unit.is_some() {
            p += 1;
        }
        numbers.push(number);
        units.push(unit);
        let by = matches!(word(tokens, p), Some("x" | "by"));
        if by && number_at(vocabulary, tokens, p + 1).is_some() && numbers.len() < 3 {
            p += 1;
        } else {
            break;
        }
    }
    let common = units.iter().rev().find_map(|unit| *unit)?;
    let lengths: Vec<f64> =
        numbers.iter().zip(&units).map(|(number, unit)| number * unit.unwrap_or(common)).collect();
    let lengths = if let [meters] = lengths[..] {
        let in_between = matches!(word(tokens, p), Some("in" | "of"));
        let word_at = if in_between { p + 1 } else { p };
        let axis = word(tokens, word_at).map_or(Axis::Unspecified, axis_of);
        // "30 cm in width", not "30 cm of width".
        if axis != Axis::Unspecified {
            p = word_at + 1;
        }
        // "with 3 cm sides", "5 cm edge length".
        p += ["edge length", "edge lengths", "side length", "side lengths", "sides", "edges"]
            .iter()
            .find_map(|phrase| match_phrase(tokens, p, phrase))
            .unwrap_or(0);
        let factor = if word(tokens, p.saturating_sub(1)) == Some("radius") { 2.0 } else { 1.0 };
        vec![Measure { axis, meters: factor * meters }]
    } else {
        let axes = [Axis::Width, Axis::Depth, Axis::Height];
        lengths.iter().zip(axes).map(|(&meters, axis)| Measure { axis, meters }).collect()
    };
    Some((Reading { lengths, ..Reading::default() }, p - at))
}

/// "a height of 12 cm", "diameter: 10 cm", "a capacity of 300 ml", "weighing 2 kg".
fn name_first(vocabulary: &Vocabulary, tokens: &[Token], at: usize) -> Option<(Reading, usize)> {
    let mut p = at;
    while matches!(word(tokens, p), Some("a" | "an" | "the" | "its" | "total" | "edge" | "side" | "overall"))
    {
        p += 1;
    }
    // "a cube, edge 45 mm".
    let bare_edge = p > at
        && matches!(tokens.get(p), Some(Token::Number(_)))
        && matches!(word(tokens, p - 1), Some("edge" | "side"))
        && at.checked_sub(1).is_none_or(|before| {
            word(tokens, before).is_none_or(|word| matches!(word, "with" | "of" | "and" | "has" | "having"))
        });
    p -= usize::from(bare_edge);
    let name = word(tokens, p)?;
    let content = matches!(name, "volume" | "capacity" | "weight" | "mass" | "weighing" | "weighs" | "holds");
    let axis = axis_of(name);
    // "Ø 5 cm, h 12 cm".
    let is_sign = p == at && matches!(name, "ø" | "dia" | "diam" | "h" | "w" | "l" | "d");
    let is_noun = is_sign
        || bare_edge
        || matches!(name, "width" | "depth" | "height" | "length" | "diameter" | "thickness" | "radius");
    if !content && !is_noun {
        return None;
    }
    p += 1;
    while matches!(word(tokens, p), Some("of" | "is" | "about" | "approximately" | "around"))
        || (matches!(tokens.get(p), Some(Token::Pause)) && is_noun)
    {
        p += 1;
    }
    let (mut reading, length) = numbers_first(vocabulary, tokens, p)?;
    let is_length = !reading.lengths.is_empty();
    if is_length == content || reading.lengths.len() > 1 {
        return None;
    }
    let factor = if name == "radius" { 2.0 } else { 1.0 };
    for measure in &mut reading.lengths {
        *measure = Measure { axis, meters: factor * measure.meters };
    }
    Some((reading, p + length - at))
}

fn axis_of(word: &str) -> Axis {
    match word {
        "wide" | "width" | "broad" | "w" => Axis::Width,
        "deep" | "depth" | "d" => Axis::Depth,
        "tall" | "high" | "height" | "thick" | "thickness" | "h" => Axis::Height,
        "long" | "length" | "l" => Axis::Length,
        "diameter" | "across" | "radius" | "ø" | "dia" | "diam" => Axis::Diameter,
        _ => Axis::Unspecified,
    }
}

/// A number in digits or words: "12", "half a", "twenty five".
fn number_at(vocabulary: &Vocabulary, tokens: &[Token], at: usize) -> Option<(f64, usize)> {
    match tokens.get(at)? {
        Token::Number(number) => Some((*number, 1)),
        Token::Word(first) if first == "half" => {
            Some((0.5, 1 + usize::from(matches!(word(tokens, at + 1), Some("a" | "an")))))
        }
        Token::Word(first) if first == "quarter" => {
            let of = ["of a", "of an"].iter().find_map(|phrase| match_phrase(tokens, at + 1, phrase));
            Some((0.25, 1 + of.unwrap_or(0)))
        }
        Token::Word(first) if first == "a" || first == "an" || first == "one" => {
            // "a liter", "an inch".
            let next = word(tokens, at + 1)?;
            let is_unit = next.len() > 2 && vocabulary.units.contains_key(next)
                || next.len() > 2 && vocabulary.volumes.contains_key(next)
                || next.len() > 2 && vocabulary.masses.contains_key(next);
            is_unit.then_some((1.0, 1))
        }
        Token::Word(first) => {
            let first = *vocabulary.numbers.get(first)?;
            match word(tokens, at + 1).and_then(|next| vocabulary.numbers.get(next)) {
                Some(&unit) if (20..100).contains(&first) && unit < 10 => Some((f64::from(first + unit), 2)),
                _ => Some((f64::from(first), 1)),
            }
        }
        _ => None,
    }
}

fn volume_or_mass(
    vocabulary: &Vocabulary,
    tokens: &[Token],
    at: usize,
    number: f64,
) -> Option<(Reading, usize)> {
    let one = word(tokens, at)?;
    let two = word(tokens, at + 1).map(|next| format!("{one} {next}"));
    for (name, length) in [(two.as_deref(), 2), (Some(one), 1)] {
        let Some(name) = name else { continue };
        let volume_m3 = vocabulary.volumes.get(name).map(|unit| number * unit);
        let mass_kg = vocabulary.masses.get(name).map(|unit| number * unit);
        if volume_m3.is_some() || mass_kg.is_some() {
            return Some((Reading { lengths: Vec::new(), volume_m3, mass_kg }, length));
        }
    }
    None
}

fn unit_at(vocabulary: &Vocabulary, tokens: &[Token], at: usize) -> Option<f64> {
    let unit = word(tokens, at)?;
    if unit == "in" {
        // "6 in tall", "6 in x 4 in"; elsewhere "in" is a preposition.
        let next = word(tokens, at + 1)?;
        let is_inch = matches!(next, "x" | "by") || axis_of(next) != Axis::Unspecified;
        return is_inch.then_some(0.0254);
    }
    vocabulary.units.get(unit).copied()
}

/// The measures after a noun: "a box 30 cm wide, 20 cm deep and 10 cm high", "a jar with a height of 12 cm". Returns
/// the readings, each with the position of its first token, and the position after the last one.
pub(super) fn trailing(
    vocabulary: &Vocabulary,
    tokens: &[Token],
    at: usize,
) -> (Vec<(Reading, std::ops::Range<usize>)>, usize) {
    let mut readings = Vec::new();
    let mut end = at;
    loop {
        let mut p = end;
        if matches!(tokens.get(p), Some(Token::Pause)) {
            p += 1;
        }
        let mut connectors = 0;
        while matches!(
            word(tokens, p),
            Some(
                "and"
                    | "with"
                    | "about"
                    | "of"
                    | "measuring"
                    | "measures"
                    | "measure"
                    | "roughly"
                    | "approximately"
                    | "which"
                    | "that"
                    | "has"
                    | "dimensions"
                    | "sized"
                    | "is"
                    | "are"
                    | "having"
                    | "around"
                    | "each"
            )
        ) && connectors < 4
        {
            p += 1;
            connectors += 1;
        }
        // "with a 2 cm diameter".
        let article = usize::from(
            connectors > 0
                && matches!(word(tokens, p), Some("a" | "an"))
                && numbers_first(vocabulary, tokens, p + 1).is_some_and(|(reading, _)| {
                    reading.lengths.first().is_some_and(|measure| measure.axis != Axis::Unspecified)
                }),
        );
        p += article;
        let Some((reading, length)) = read_measure(vocabulary, tokens, p) else { break };
        let after = p + length;
        // "cubes of 5 cm in a row", but "5 cm in front of".
        let sized =
            matches!(word(tokens, p.saturating_sub(1)), Some("of" | "measuring" | "sized")) && p > end;
        let is_place = word(tokens, after) == Some("in")
            && (!sized || matches!(word(tokens, after + 1), Some("front" | "from" | "between" | "back")));
        let starts_relation = is_place
            || matches!(
                word(tokens, after),
                Some(
                    "apart"
                        | "of"
                        | "space"
                        | "spacing"
                        | "gap"
                        | "gaps"
                        | "distance"
                        | "next"
                        | "beside"
                        | "below"
                        | "from"
                        | "away"
                        | "to"
                        | "behind"
                        | "left"
                        | "right"
                        | "between"
                        | "above"
                        | "off"
                )
            );
        let names_extent = !reading.lengths.is_empty()
            && reading.lengths.iter().all(|measure| measure.axis != Axis::Unspecified);
        // "a mug and a 12 oz glass": the measure belongs to the noun after it.
        let is_part = word(tokens, after).is_none_or(|next| is_boundary(vocabulary, next))
            && !matches!(tokens.get(after), Some(Token::Number(_)))
            || quantity_name(tokens, after).is_some();
        if (starts_relation && !names_extent) || !is_part {
            break;
        }
        readings.push((reading, p..after));
        end = after + quantity_name(tokens, after).unwrap_or(0);
        if readings.len() == MAX_MEASURES {
            break;
        }
    }
    (readings, end)
}

/// Maximum number of measures after a noun.
const MAX_MEASURES: usize = 6;

/// Number of tokens of what a measure may name after its unit: "half a liter in volume".
fn quantity_name(tokens: &[Token], at: usize) -> Option<usize> {
    ["in size", "in volume", "in capacity", "in weight", "in mass"]
        .iter()
        .find_map(|phrase| match_phrase(tokens, at, phrase))
}

#[cfg(test)]
mod tests {
    use super::super::tokens::tokenize;
    use super::super::vocabulary::vocabulary;
    use super::*;

    fn read(text: &str) -> Option<(Reading, usize)> {
        read_measure(vocabulary(), &tokenize(text), 0)
    }

    #[test]
    fn lengths_carry_axes_and_units() {
        for (text, axes, meters, used) in [
            ("30 cm wide plate", &[Axis::Width][..], &[0.3][..], 3),
            ("10x20 cm tray", &[Axis::Width, Axis::Depth], &[0.1, 0.2], 4),
            ("5x6x7cm", &[Axis::Width, Axis::Depth, Axis::Height], &[0.05, 0.06, 0.07], 6),
            ("30 cm by 20 cm by 10 cm box", &[Axis::Width, Axis::Depth, Axis::Height], &[0.3, 0.2, 0.1], 8),
            ("12 inch plate", &[Axis::Unspecified], &[0.3048], 2),
            ("6 in tall", &[Axis::Height], &[0.1524], 3),
            ("diameter of 10 cm", &[Axis::Diameter], &[0.1], 4),
            ("a radius of 10 cm", &[Axis::Diameter], &[0.2], 5),
            ("900 m tall", &[Axis::Height], &[900.0], 3),
        ] {
            let (reading, length) = read(text).expect(text);
            assert_eq!(length, used, "{text}");
            assert_eq!(reading.lengths.iter().map(|m| m.axis).collect::<Vec<_>>(), axes, "{text}");
            for (measure, expected) in reading.lengths.iter().zip(meters) {
                assert!((measure.meters - expected).abs() < 1e-9, "{text}");
            }
        }
        for text in ["12 mugs", "3 in the bowl", "two plates"] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn volumes_and_masses_are_no_counts() {
        for (text, liters, kilograms) in [
            ("12 oz mug", Some(0.3549), Some(0.3402)),
            ("half a liter bottle", Some(0.5), None),
            ("330 ml can", Some(0.33), None),
            ("16 fl oz cup", Some(0.4732), None),
            ("500 g bag", None, Some(0.5)),
            ("weighing 2 pounds", None, Some(0.9072)),
            ("a capacity of 1.5 l", Some(1.5), None),
        ] {
            let (reading, _) = read(text).expect(text);
            let close = |a: Option<f64>, b: Option<f64>| match (a, b) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-3,
                (None, None) => true,
                _ => false,
            };
            assert!(close(reading.volume_m3.map(|v| 1000.0 * v), liters), "{text}: {reading:?}");
            assert!(close(reading.mass_kg, kilograms), "{text}: {reading:?}");
        }
    }

    #[test]
    fn measures_follow_their_noun() {
        for (text, count) in [
            ("30 cm wide, 20 cm deep and 10 cm high", 3),
            ("with a diameter of 10 cm and a height of 12 cm.", 2),
            ("measuring 10 x 5 x 3 cm", 1),
            ("20 cm to the right of the mug", 0),
            ("5 cm apart", 0),
            ("and a 20 cm plate", 0),
            ("and 12 oz glass", 0),
            ("and 30 cm wide tray", 0),
        ] {
            assert_eq!(trailing(vocabulary(), &tokenize(text), 0).0.len(), count, "{text}");
        }
    }
}
