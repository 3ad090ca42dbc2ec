//! States of parts: "a cabinet with its drawer open", "a toolbox whose lid is closed", "a microwave with a closed
//! door".

use super::Parser;
use crate::text_parser::tokens::Token;

/// Parts that open and close.
const PARTS: &[&str] = &[
    "door", "doors", "drawer", "drawers", "lid", "lids", "flap", "flaps", "cover", "covers", "screen", "top",
    "cap",
];

impl Parser<'_, '_> {
    /// A state of a part of the subject. Whether the rule applies.
    pub(super) fn part_state(&mut self) -> bool {
        let start = self.at;
        let mut p = match self.word(0) {
            Some("with" | "having" | "whose") => start + 1,
            Some("has" | "have") if !self.subject.is_empty() => start + 1,
            Some("its" | "their") => start,
            Some("the") if self.subject.is_empty() => start,
            _ => return false,
        };
        let with = matches!(self.word(0), Some("with" | "having" | "has" | "have"));
        while matches!(self.word_at(p), Some("its" | "their" | "the" | "a" | "an" | "one" | "both" | "top")) {
            p += 1;
        }
        let is_part = |p: usize| self.word_at(p).is_some_and(|word| PARTS.contains(&word));
        let (state, end) = if is_part(p) {
            let linking = matches!(self.word_at(p + 1), Some("is" | "are" | "being"));
            let Some((state, length)) = self.state_at(p + 1 + usize::from(linking)) else { return false };
            if !with && !linking {
                return false;
            }
            (state, p + 1 + usize::from(linking) + length)
        } else {
            let Some((state, length)) = self.state_at(p).filter(|(_, length)| is_part(p + length)) else {
                return false;
            };
            (state, p + length + 1)
        };
        // "with a closed lid of glass" names an object.
        let ends = !matches!(self.tokens.get(end), Some(Token::Number(_))) && self.word_at(end) != Some("of");
        let Some(host) = self.subject.last().copied().or(self.salient).filter(|_| ends) else { return false };
        self.at = end;
        self.set_states(&[host], &state, start..end);
        true
    }
}
