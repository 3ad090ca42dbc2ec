//! Objects of the scene that a command is about: phrases joined by "and", and pronouns.

use super::Reason;
use super::cursor::{Cursor, Outcome};
use super::discourse::Target;

impl Cursor {
    /// The targets at the cursor, joined by commas and "and". Each ends at a boundary or at what `stops` it.
    pub fn targets(&mut self, stops: &dyn Fn(&Self, usize) -> bool) -> Outcome<Vec<Target>> {
        let mut targets = Vec::new();
        loop {
            let start = self.at;
            if let Some(found) = self.pronoun()? {
                targets.extend(found);
            } else {
                let end = self.phrase_end(start, &|index| stops(self, index));
                if end == start {
                    return self.not_understood(start, "name the object");
                }
                self.at = end;
                let phrase = self.target_text(start, end);
                self.discourse.mention(&phrase, false);
                targets.push(Target { phrase, pronoun: false });
            }
            let next = self.at + self.connector_at(self.at);
            // "the tray and everything on it" is the tray with its contents.
            let contents = self.length_of_any(next, &["everything on it", "everything in it"]).is_some();
            if next == self.at || !self.is_phrase(next) || contents {
                return Ok(targets);
            }
            self.at = next;
        }
    }

    /// The phrase of the tokens; "other" and "one" say which.
    pub fn target_text(&self, from: usize, to: usize) -> String {
        let text = self.text(from, to);
        if self.is_at(from, "the other") && to > from + 2 {
            let noun = self.text(from + 2, to).to_lowercase();
            if let Some(other) = self.discourse.other(&noun) {
                return other;
            }
        }
        let is_noun = |index: &usize| {
            let ends = index + 1 == to || self.preposition_at(index + 1).is_some();
            matches!(self.word(*index), "one" | "ones")
                && (ends || matches!(self.word(index + 1), "that" | "which" | "with"))
        };
        if let Some(index) = (from + 1..to).find(is_noun)
            && let Some(noun) = self.discourse.last_noun()
        {
            let rest = self.text(index + 1, to);
            return format!("{} {noun} {rest}", self.text(from, index)).trim_end().to_owned();
        }
        text
    }

    /// The objects of a pronoun at the cursor; `None` if another word follows.
    pub fn pronoun(&mut self) -> Outcome<Option<Vec<Target>>> {
        let start = self.at;
        let plural = match self.word(start) {
            "it" => false,
            "them" | "they" => true,
            "that" | "this" if self.ends_pronoun(start + 1) => false,
            "those" | "these" if self.ends_pronoun(start + 1) => true,
            _ => return Ok(None),
        };
        self.at += 1;
        let Some(topic) = &self.discourse.topic else {
            return Err(self.error(start, start + 1, Reason::NoAntecedent));
        };
        if topic.removed {
            return Err(self.error(start, start + 1, Reason::Removed));
        }
        if topic.plural != plural {
            return Err(self.error(start, start + 1, Reason::UnclearPronoun));
        }
        let target = |phrase: &String| Target { phrase: phrase.clone(), pronoun: true };
        Ok(Some(topic.phrases.iter().map(target).collect()))
    }

    pub fn ends_pronoun(&self, index: usize) -> bool {
        self.is_boundary(index) || self.preposition_at(index).is_some()
    }
}
