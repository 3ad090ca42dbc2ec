//! Clauses beside the main one: "once the tray has been emptied, ..." names objects and says nothing of the start; and
//! conjunctions with a noun in them ("in case it rains"), which name no object.

use super::Parser;
use crate::text_parser::phrase::noun_phrase;
use crate::text_parser::phrases::phrases;
use crate::text_parser::tokens::Token;
use scene::text_account::UnrecognizedReason;

impl Parser<'_, '_> {
    /// "in case", "in the meantime" at `at`: the number of words. "In case" at the end of a clause is in a case.
    pub(super) fn conjunction_at(&self, at: usize) -> Option<usize> {
        let length = phrases().agent.conjunctions.longest_at(self.tokens, at)?;
        let is_noun = matches!(self.word_at(at + length), None | Some("and" | "then" | "or"));
        let may_be_noun = length == 2 && self.word_at(at + 1) == Some("case");
        (!(is_noun && may_be_noun)).then_some(length)
    }

    /// A conjunction at the current position is reported. Whether the rule applies.
    pub(super) fn conjunction(&mut self) -> bool {
        let Some(length) = self.conjunction_at(self.at) else { return false };
        self.report(self.at..self.at + length, UnrecognizedReason::NotExpressible);
        self.at += length;
        true
    }

    /// "once the tray has been emptied, the mug is to be placed on it": the clause before the main one names objects.
    /// Whether the rule applies.
    pub(super) fn before_main_clause(&mut self) -> bool {
        let (start, end) = self.sentence_at(self.at);
        let Some(length) = phrases().agent.times.longest_at(self.tokens, start) else { return false };
        let pause = (start..end).find(|&p| self.tokens[p] == Token::Pause);
        let Some(pause) = pause.filter(|_| start == self.at) else { return false };
        let happens = (start + length..pause).any(|p| {
            matches!(self.word_at(p), Some("is" | "are" | "was" | "were" | "has" | "have" | "gets" | "got"))
        });
        let ends = self
            .subject_end(pause + 1)
            .is_some_and(|subject| subject < end && self.obliged_state(subject).is_some());
        if !happens || !ends {
            return false;
        }
        self.objects_only(start..pause);
        self.at = pause + 1;
        self.clause_start = true;
        true
    }

    /// The end of a noun phrase at `at` that names objects.
    fn subject_end(&self, at: usize) -> Option<usize> {
        let (phrase, end) = noun_phrase(self.lexicon, self.tokens, at)?;
        (!phrase.negated && !phrase.is_table()).then_some(end)
    }
}
