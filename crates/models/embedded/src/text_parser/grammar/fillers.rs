//! Words of an instruction that state no goal: adverbs, criteria and ends that are not named.

use super::Parser;
use crate::text_parser::tokens::match_phrase;

impl Parser<'_, '_> {
    /// An end that is not named: "to a target position". Whether the rule applies.
    pub(super) fn aimless_end(&mut self) -> bool {
        let aimless = [
            "to a target position",
            "to the target position",
            "to the goal position",
            "to a goal position",
            "to the target",
            "to the goal",
            "to its target position",
            "to the target location",
            "to a different position",
            "to another place",
            "somewhere else",
        ];
        let length = aimless.iter().filter_map(|phrase| match_phrase(self.tokens, self.at, phrase)).max();
        let Some(length) = length else { return false };
        self.parsed.account.used(self.at..self.at + length);
        self.at += length;
        true
    }

    /// Adverbs and words without an effect stay open; the account reports those that are not ignorable.
    pub(super) fn filler(&mut self) -> bool {
        let closing = ["in the end", "at the end", "by the end", "when done", "as well", "one by one"];
        if let Some(length) = closing.iter().find_map(|phrase| match_phrase(self.tokens, self.at, phrase)) {
            self.parsed.account.used(self.at..self.at + length);
            self.at += length;
            return true;
        }
        // "by color", "according to their size".
        let by = ["by", "based on", "according to"]
            .iter()
            .filter_map(|phrase| match_phrase(self.tokens, self.at, phrase))
            .max();
        if let Some(by) = by {
            let own = by + usize::from(matches!(self.word(by), Some("the" | "their" | "its")));
            if matches!(
                self.word(own),
                Some("color" | "colour" | "colors" | "size" | "type" | "kind" | "shape" | "category")
            ) {
                self.parsed.account.used(self.at..self.at + own + 1);
                self.at += own + 1;
                return true;
            }
        }
        let Some(word) = self.word(0) else { return false };
        let known = self.lexicon.vocabulary.grammar.ignorable.contains(word) || word.ends_with("ly");
        let ends = matches!(word, "is" | "are" | "has" | "there" | "should" | "must");
        if !known || ends {
            return false;
        }
        self.at += 1;
        true
    }
}
