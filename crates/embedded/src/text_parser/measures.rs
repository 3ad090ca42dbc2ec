//! Lengths in a text: "30 cm wide", "10x20 cm", "1.2 m", "12 inches tall".

use glam::DVec3;

use super::tokens::Token;
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

/// The measures at `at` and the number of tokens they take.
pub(super) fn read_measures(
    vocabulary: &Vocabulary,
    tokens: &[Token],
    at: usize,
) -> Option<(Vec<Measure>, usize)> {
    let mut numbers = Vec::new();
    let mut units: Vec<Option<f64>> = Vec::new();
    let mut p = at;
    loop {
        let number = match tokens.get(p)? {
            Token::Number(number) => *number,
            Token::Word(word) => f64::from(*vocabulary.numbers.get(word)?),
            _ => return None,
        };
        p += 1;
        let unit = unit_at(vocabulary, tokens, p);
        if unit.is_some() {
            p += 1;
        }
        numbers.push(number);
        units.push(unit);
        let by = matches!(tokens.get(p).and_then(Token::word), Some("x" | "by"));
        if by && matches!(tokens.get(p + 1), Some(Token::Number(_))) && numbers.len() < 3 {
            p += 1;
        } else {
            break;
        }
    }
    let common = units.iter().rev().find_map(|unit| *unit)?;
    let lengths: Vec<f64> =
        numbers.iter().zip(&units).map(|(number, unit)| number * unit.unwrap_or(common)).collect();
    if lengths.iter().any(|length| !(1e-4..=100.0).contains(length)) {
        return None;
    }
    let measures = if let [length] = lengths[..] {
        let in_between = matches!(tokens.get(p).and_then(Token::word), Some("in" | "of"));
        let word_at = if in_between { p + 1 } else { p };
        let axis = match tokens.get(word_at).and_then(Token::word) {
            Some("wide" | "width" | "broad") => Axis::Width,
            Some("deep" | "depth") => Axis::Depth,
            Some("tall" | "high" | "height" | "thick") => Axis::Height,
            Some("long" | "length") => Axis::Length,
            Some("diameter" | "across") => Axis::Diameter,
            _ => Axis::Unspecified,
        };
        if axis != Axis::Unspecified {
            p = word_at + 1;
        }
        vec![Measure { axis, meters: length }]
    } else {
        let axes = [Axis::Width, Axis::Depth, Axis::Height];
        lengths.iter().zip(axes).map(|(&meters, axis)| Measure { axis, meters }).collect()
    };
    Some((measures, p - at))
}

fn unit_at(vocabulary: &Vocabulary, tokens: &[Token], at: usize) -> Option<f64> {
    tokens.get(at).and_then(Token::word).and_then(|word| vocabulary.units.get(word)).copied()
}

/// Applies the lengths of the text to a size. A single length scales all extents and keeps proportions; several lengths
/// set their own extents. Results stay between a third of and three times `typical_m`.
pub(super) fn apply(measures: &[Measure], size_m: DVec3, typical_m: DVec3) -> DVec3 {
    let mut size = size_m;
    let horizontal = if size.x >= size.y { 0 } else { 1 };
    let index = |axis: Axis, size: DVec3| match axis {
        Axis::Width | Axis::Diameter => 0,
        Axis::Depth => 1,
        Axis::Height => 2,
        Axis::Length => horizontal,
        Axis::Unspecified => {
            let largest = size.max_element();
            (0..3).find(|&k| size[k] == largest).unwrap_or(0)
        }
    };
    if let [measure] = measures {
        let k = index(measure.axis, size);
        size *= measure.meters / size[k].max(1e-6);
    } else {
        for measure in measures {
            let k = index(measure.axis, size_m);
            size[k] = measure.meters;
            if measure.axis == Axis::Diameter {
                size.y = measure.meters;
            }
        }
    }
    size.clamp(typical_m / 3.0, typical_m * 3.0)
}

#[cfg(test)]
mod tests {
    use super::super::tokens::tokenize;
    use super::super::vocabulary::vocabulary;
    use super::*;

    #[test]
    fn lengths_carry_axes_and_units() {
        let read = |text: &str| read_measures(vocabulary(), &tokenize(text), 0);
        assert_eq!(read("30 cm wide plate"), Some((vec![Measure { axis: Axis::Width, meters: 0.3 }], 3)));
        let (measures, used) = read("10x20 cm tray").expect("two lengths");
        assert_eq!((measures.len(), used), (2, 4));
        assert!((measures[1].meters - 0.2).abs() < 1e-12 && measures[1].axis == Axis::Depth);
        assert_eq!(read("12 mugs"), None);
        assert_eq!(read("900 m tall"), None);
    }

    #[test]
    fn one_length_keeps_proportions() {
        let size = apply(
            &[Measure { axis: Axis::Height, meters: 0.2 }],
            DVec3::new(0.1, 0.05, 0.1),
            DVec3::new(0.1, 0.05, 0.1),
        );
        assert!((size - DVec3::new(0.2, 0.1, 0.2)).length() < 1e-12);
    }
}
