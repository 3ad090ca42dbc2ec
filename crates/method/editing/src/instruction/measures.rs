//! Distances, angles, factors and counts in an instruction.

use std::f64::consts::{FRAC_PI_2, PI};

use super::cursor::Cursor;
use crate::references::{number, vocabulary};

/// Angle of a turn, with its direction if it is stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Angle {
    /// Counter-clockwise.
    pub rad: f64,
    pub length: usize,
}

/// Factor of "bigger", and the inverse of "smaller".
pub(super) const BIGGER: f64 = 1.25;
const SLIGHTLY_BIGGER: f64 = 1.1;
const MUCH_BIGGER: f64 = 1.5;

const LARGER_WORDS: &[&str] = &["bigger", "larger"];

impl Cursor {
    /// A number in digits or words, with the number of tokens: "10", "2.5", "ten", "one and a half".
    pub fn number_at(&self, index: usize) -> Option<(f64, usize)> {
        let word = self.word(index);
        let value = word.parse::<f64>().ok().or_else(|| number(word).map(|count| count as f64))?;
        if !value.is_finite() || value < 0.0 {
            return None;
        }
        if self.is_at(index + 1, "and a half") { Some((value + 0.5, 4)) } else { Some((value, 1)) }
    }

    /// A length in meters, with the number of tokens: "10 cm", "half a meter", "an inch".
    pub fn distance_at(&self, index: usize) -> Option<(f64, usize)> {
        let about = usize::from(matches!(self.word(index), "about" | "around" | "exactly" | "roughly"));
        let at = index + about;
        let (value, length) = if let Some(length) = self.length_of_any(at, &["half a", "half an"]) {
            (0.5, length)
        } else if matches!(self.word(at), "a" | "an") {
            (1.0, 1)
        } else {
            self.number_at(at)?
        };
        let unit_m = vocabulary().units.get(self.word(at + length))?;
        Some((value * unit_m, about + length + 1))
    }

    /// An angle without a direction: "90 degrees", "45°", "a quarter turn".
    pub fn angle_at(&self, index: usize) -> Option<Angle> {
        let turns = [
            ("a quarter turn", 0.5 * PI),
            ("a quarter of a turn", 0.5 * PI),
            ("a half turn", PI),
            ("half a turn", PI),
            ("a full turn", 2.0 * PI),
        ];
        if let Some((pattern, rad)) = turns.into_iter().find(|(pattern, _)| self.is_at(index, pattern)) {
            return Some(Angle { rad, length: pattern.split(' ').count() });
        }
        if matches!(self.word(index), "-" | "minus") {
            let angle = self.angle_at(index + 1)?;
            return Some(Angle { rad: -angle.rad, length: angle.length + 1 });
        }
        let (value, length) = self.number_at(index)?;
        match self.word(index + length) {
            "degrees" | "degree" | "°" | "deg" => {
                Some(Angle { rad: value.to_radians(), length: length + 1 })
            }
            "radians" | "radian" | "rad" => Some(Angle { rad: value, length: length + 1 }),
            _ => None,
        }
    }

    /// The sign of a direction of rotation: counter-clockwise is positive.
    pub fn turn_direction_at(&self, index: usize) -> Option<(f64, usize)> {
        let directions: [(&[&str], f64); 2] = [
            (
                &[
                    "counterclockwise",
                    "counter clockwise",
                    "counter-clockwise",
                    "anticlockwise",
                    "anti-clockwise",
                    "ccw",
                    "to the left",
                ],
                1.0,
            ),
            (&["clockwise", "cw", "to the right"], -1.0),
        ];
        directions
            .into_iter()
            .find_map(|(patterns, sign)| self.length_of_any(index, patterns).map(|length| (sign, length)))
    }

    /// A factor of size as a complement: "twice as large", "20 % smaller", "a bit bigger", "half the size".
    pub fn factor_at(&self, index: usize) -> Option<(f64, usize)> {
        let compared = [
            "as large",
            "as big",
            "the size",
            "its size",
            "their size",
            "its current size",
            "as small",
            "the original size",
            "its original size",
            "larger",
            "bigger",
        ];
        let times = |at: usize| self.length_of_any(at, &compared).filter(|_| !self.is_at(at, "as small"));
        for (word, factor) in [("twice", 2.0), ("double", 2.0), ("half", 0.5), ("triple", 3.0)] {
            if self.is_at(index, word)
                && let Some(length) = times(index + 1)
            {
                return Some((factor, 1 + length));
            }
        }
        if let Some((value, length)) = self.number_at(index) {
            let at = index + length;
            if let Some(percent) = self.length_of_any(at, &["%", "percent", "per cent"]) {
                let at = at + percent;
                if LARGER_WORDS.contains(&self.word(at)) {
                    return Some((1.0 + value / 100.0, at + 1 - index));
                }
                return self.is_at(at, "smaller").then_some((1.0 - value / 100.0, at + 1 - index));
            }
            if self.is_at(at, "times") || self.is_at(at, "x") {
                return times(at + 1).map(|length| (value, at + 1 + length - index));
            }
            return None;
        }
        let slightly = ["a little bit", "a bit", "a little", "slightly", "somewhat"];
        let much = ["much", "a lot", "way", "far", "considerably", "significantly"];
        let (factor, length) = match (self.length_of_any(index, &slightly), self.length_of_any(index, &much))
        {
            (Some(length), _) => (SLIGHTLY_BIGGER, length),
            (_, Some(length)) => (MUCH_BIGGER, length),
            _ => (BIGGER, 0),
        };
        match self.word(index + length) {
            "bigger" | "larger" => Some((factor, length + 1)),
            "smaller" => Some((1.0 / factor, length + 1)),
            _ => None,
        }
    }

    /// Count that a quantity stands for, and its number of tokens; `None` for other words.
    pub fn quantity_at(&self, index: usize) -> Option<(u32, usize)> {
        let vague: [(&[&str], u32); 6] = [
            (&["half a dozen", "half dozen"], 6),
            (&["a dozen", "one dozen"], 12),
            (&["a couple of", "a couple", "a pair of"], 2),
            (&["a few", "some", "a handful of", "a bunch of"], 3),
            (&["several", "a number of"], 4),
            (&["a single"], 1),
        ];
        let named = vague
            .into_iter()
            .find_map(|(patterns, count)| self.length_of_any(index, patterns).map(|length| (count, length)));
        named.or_else(|| {
            let (value, length) = self.number_at(index).filter(|(value, _)| value.fract() == 0.0)?;
            let count = u32::try_from(value as i64).ok().filter(|&count| count > 0)?;
            Some((count, length))
        })
    }

    /// The yaw of a front that points to an edge or a viewer: "the front", "me", "left".
    pub fn heading_at(&self, index: usize) -> Option<(f64, usize)> {
        let of_table = |length: usize| {
            let more = self.length_of_any(index + length, &["edge", "side"]).unwrap_or(0);
            let of = self.length_of_any(index + length + more, &["of the table", "of the desk"]).unwrap_or(0);
            length + more + of
        };
        let headings: [(&[&str], f64); 4] = [
            (&["the front", "the viewer", "the camera", "me", "us", "forward", "forwards", "front"], 0.0),
            (&["the back", "away from me", "away from the viewer", "away", "backward", "backwards"], PI),
            (&["the left", "left"], -FRAC_PI_2),
            (&["the right", "right"], FRAC_PI_2),
        ];
        headings.into_iter().find_map(|(patterns, yaw_rad)| {
            self.length_of_any(index, patterns).map(|length| (yaw_rad, of_table(length)))
        })
    }
}
