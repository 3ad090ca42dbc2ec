//! Orientation: "facing the laptop", "facing left", "parallel to the front edge", "rotated by 45 degrees".

use std::f64::consts::{FRAC_PI_2, PI};

use super::{Parser, PendingRelation, Referent};
use crate::text_parser::phrase::noun_phrase;
use crate::text_parser::property::Property;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

impl Parser<'_, '_> {
    /// An orientation of the current subject. Whether the rule applies.
    pub(super) fn orientation(&mut self) -> bool {
        self.facing() || self.parallel() || self.rotated()
    }

    fn facing(&mut self) -> bool {
        let Some(length) = [
            "facing",
            "which faces",
            "that faces",
            "faces",
            "face",
            "oriented toward",
            "oriented towards",
            "pointing to",
            "pointing at",
            "pointing toward",
            "pointing towards",
            "pointing",
            "turned toward",
            "turned towards",
            "looking at",
        ]
        .iter()
        .filter_map(|phrase| match_phrase(self.tokens, self.at, phrase))
        .max() else {
            return false;
        };
        let (start, mut p) = (self.at, self.at + length);
        let subjects = self.attached();
        if subjects.is_empty() {
            return false;
        }
        if let Some(other) =
            match_phrase(self.tokens, p, "each other").or_else(|| match_phrase(self.tokens, p, "one another"))
        {
            self.at = p + other;
            self.beside_each_other(RelationKind::Facing, start..p + other);
            return true;
        }
        while matches!(self.word_at(p), Some("to" | "toward" | "towards" | "the" | "away"))
            && self.is_direction(p + 1)
        {
            p += 1;
        }
        if let Some((yaw_rad, length)) = self.direction(p) {
            self.at = p + length;
            for &mention in &subjects {
                self.parsed.mentions[mention].yaw_rad = Some(yaw_rad);
            }
            self.claim_property(start..self.at, Property::Orientation, subjects);
            return true;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else {
            self.at = p;
            self.report(start..p, UnrecognizedReason::NoReferent);
            return true;
        };
        self.at = end;
        match self.refer(phrase, true) {
            Referent::Mentions(targets) => {
                self.last_target = targets.last().map(|&target| (target, end));
                self.relate_all(&subjects, RelationKind::Facing, &targets, start..p)
            }
            _ => self.report(start..p, UnrecognizedReason::NotExpressible),
        }
        true
    }

    fn is_direction(&self, at: usize) -> bool {
        self.direction(at).is_some() || matches!(self.word_at(at), Some("the" | "from"))
    }

    /// The yaw of a front that points to a side; 0 is the front edge.
    fn direction(&self, at: usize) -> Option<(f64, usize)> {
        let the = usize::from(self.word_at(at) == Some("the"));
        let yaw_rad = match self.word_at(at + the)? {
            "left" => -FRAC_PI_2,
            "right" => FRAC_PI_2,
            "front" | "viewer" | "user" | "camera" | "forward" | "forwards" | "robot" | "person" | "us"
            | "me" => 0.0,
            "back" | "backward" | "backwards" | "rear" => PI,
            _ => return None,
        };
        let side = usize::from(matches!(self.word_at(at + the + 1), Some("side" | "edge" | "end")));
        let of = ["of the table", "of the desk"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, at + the + 1 + side, phrase))
            .unwrap_or(0);
        Some((yaw_rad, the + 1 + side + of))
    }

    fn parallel(&mut self) -> bool {
        let Some(length) = ["parallel to", "parallel with", "aligned with", "in parallel to", "in line with"]
            .iter()
            .filter_map(|phrase| match_phrase(self.tokens, self.at, phrase))
            .max()
        else {
            return false;
        };
        let (start, p) = (self.at, self.at + length);
        let subjects = self.attached();
        let edge = (p..p + 6).find(|&p| matches!(self.word_at(p), Some("edge" | "side" | "border")));
        if let Some(edge) = edge
            && !subjects.is_empty()
        {
            let side = (p..edge).any(|p| matches!(self.word_at(p), Some("left" | "right" | "short")));
            let of = ["of the table", "of the desk"]
                .iter()
                .find_map(|phrase| match_phrase(self.tokens, edge + 1, phrase))
                .unwrap_or(0);
            for &mention in &subjects {
                self.parsed.mentions[mention].yaw_rad = Some(if side { FRAC_PI_2 } else { 0.0 });
            }
            self.at = edge + 1 + of;
            self.claim_property(start..self.at, Property::Orientation, subjects);
            return true;
        }
        let other = match_phrase(self.tokens, p, "each other")
            .or_else(|| match_phrase(self.tokens, p, "one another"));
        if let Some(other) = other {
            self.at = p + other;
            self.beside_each_other(RelationKind::ParallelTo, start..p + other);
            return true;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else { return false };
        if subjects.is_empty() {
            return false;
        }
        self.at = end;
        match self.refer(phrase, true) {
            Referent::Mentions(targets) => {
                self.relate_all(&subjects, RelationKind::ParallelTo, &targets, start..p)
            }
            Referent::Table => {
                for &mention in &subjects {
                    self.parsed.mentions[mention].yaw_rad = Some(0.0);
                }
                self.claim_property(start..end, Property::Orientation, subjects);
            }
            Referent::Nothing => self.report(start..p, UnrecognizedReason::NoReferent),
        }
        true
    }

    fn relate_all(
        &mut self,
        subjects: &[usize],
        kind: RelationKind,
        targets: &[usize],
        tokens: std::ops::Range<usize>,
    ) {
        for &subject in subjects {
            for &target in targets {
                let (inverse, second, distance_m) = (false, None, None);
                let relation = PendingRelation {
                    kind,
                    inverse,
                    targets: vec![target],
                    second,
                    distance_m,
                    tokens: tokens.clone(),
                };
                self.relate(subject, &relation, target);
            }
        }
    }

    /// "rotated by 45 degrees (clockwise)", "at a 45 degree angle", "turned 90 degrees to the left".
    fn rotated(&mut self) -> bool {
        let start = self.at;
        let mut p = start;
        let is_verb =
            matches!(self.word_at(p), Some("rotated" | "turned" | "angled" | "tilted" | "oriented" | "at"));
        if !is_verb {
            return false;
        }
        while matches!(
            self.word_at(p),
            Some(
                "rotated"
                    | "turned"
                    | "angled"
                    | "tilted"
                    | "oriented"
                    | "at"
                    | "by"
                    | "an"
                    | "a"
                    | "angle"
                    | "of"
                    | "about"
                    | "to"
            )
        ) {
            p += 1;
        }
        let mut sign = 1.0;
        if let Some(direction) = self.turn_direction(p) {
            sign = direction.0;
            p += direction.1;
        }
        p += usize::from(self.word_at(p) == Some("by"));
        let degrees = match self.tokens.get(p) {
            Some(Token::Number(number)) => *number,
            Some(Token::Word(word)) => match self.lexicon.vocabulary.numbers.get(word) {
                Some(number) => f64::from(*number),
                None => return false,
            },
            _ => return false,
        };
        if !matches!(self.word_at(p + 1), Some("degree" | "degrees" | "deg")) {
            return false;
        }
        p += 2;
        p += usize::from(self.word_at(p) == Some("angle"));
        if let Some(direction) = self.turn_direction(p) {
            sign = direction.0;
            p += direction.1;
        }
        self.at = p;
        let subjects = self.attached();
        if subjects.is_empty() {
            self.report(start..p, UnrecognizedReason::NoReferent);
        } else if degrees.abs() > 360.0 {
            self.report(start..p, UnrecognizedReason::OutOfRange);
        } else {
            for &mention in &subjects {
                self.parsed.mentions[mention].yaw_rad = Some(sign * degrees.to_radians());
            }
            self.claim_property(start..p, Property::Orientation, subjects);
        }
        true
    }

    /// The sign of a direction of rotation, and its number of tokens.
    fn turn_direction(&self, at: usize) -> Option<(f64, usize)> {
        [
            ("clockwise", -1.0),
            ("counter clockwise", 1.0),
            ("counterclockwise", 1.0),
            ("anticlockwise", 1.0),
            ("anti clockwise", 1.0),
            ("to the left", 1.0),
            ("to the right", -1.0),
        ]
        .into_iter()
        .find_map(|(phrase, sign)| Some((sign, match_phrase(self.tokens, at, phrase)?)))
    }
}
