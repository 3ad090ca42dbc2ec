//! Distances that a clause states: "the distance between the kettle and the toaster is 25 cm".

use super::Parser;
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::noun_phrase;

/// Between the objects and the length.
const LINKS: &[&str] = &[
    "is",
    "is about",
    "is roughly",
    "is exactly",
    "is at least",
    "should be",
    "must be",
    "has to be",
    "of",
    "equals",
    "measures",
    "amounts to",
    "shall be",
    "will be",
];

/// Maximum number of words between "between" and the length.
const MAX_WORDS: usize = 14;

impl Parser<'_, '_> {
    /// A clause that states a distance. Whether the rule applies.
    pub(super) fn stated_distance(&mut self) -> bool {
        let start = self.at;
        let noun = start + usize::from(matches!(self.word(0), Some("the" | "a")));
        let is_distance = matches!(
            self.word_at(noun),
            Some("distance" | "gap" | "space" | "spacing" | "clearance" | "separation")
        );
        if !is_distance || self.word_at(noun + 1) != Some("between") {
            return false;
        }
        // "the toaster is 25 cm": what follows the link is no size of the toaster.
        let found = (noun + 3..noun + MAX_WORDS).find_map(|last| {
            let link = self.longest(LINKS, last) + usize::from(self.is_colon(last));
            let (meters, length) = read_length(self.lexicon.vocabulary, self.tokens, last + link)?;
            (link > 0).then_some((last, link, meters, length))
        });
        let Some((last, link, meters, length)) = found else { return false };
        let tokens = &self.tokens[..last.min(self.tokens.len())];
        let Some((first, end)) = noun_phrase(self.lexicon, tokens, noun + 2) else { return false };
        let second =
            (self.word_at(end) == Some("and")).then(|| noun_phrase(self.lexicon, tokens, end + 1)).flatten();
        if first.is_table() || second.as_ref().map_or(end, |(_, end)| *end) != last {
            return false;
        }
        self.at = end;
        let before = std::mem::take(&mut self.subject);
        self.subject = self.objects_of(first, second);
        self.at = last + link + length;
        self.parsed.account.used(start..self.at);
        self.apart(meters, last + link..self.at);
        if !before.is_empty() {
            self.subject = before;
        }
        self.salient_list = self.subject.clone();
        true
    }
}
