//! Negation and exclusion: "no mugs", "do not include any forks", "neither X nor Y", "a fork instead of a spoon". The
//! excluded categories are absent, also from fillings.

use super::Parser;
use crate::text_parser::account::Claimed;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::prepositions::preposition_at;
use crate::text_parser::property::Property;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::text_account::UnrecognizedReason;

/// Maximum number of tokens of a sentence that are searched for a word.
const SENTENCE: usize = 40;

impl Parser<'_, '_> {
    /// Number of tokens of the negation at the current position.
    pub(super) fn negation(&self) -> Option<usize> {
        let list = &phrases().exclusion;
        let asks = |at: usize| {
            let negation = list.negations.longest_at(self.tokens, at)?;
            Some(negation + list.asks.longest_at(self.tokens, at + negation)?)
        };
        let verb = asks(self.at);
        let subject = matches!(self.word(0), Some("i" | "we" | "you"));
        let after_subject = if subject { asks(self.at + 1).map(|length| 1 + length) } else { None };
        let plain = list.before.longest_at(self.tokens, self.at).filter(|length| {
            // "hold the mug" and "drop the mug" are instructions, "not on the plate" is a relation.
            let first = self.word(0);
            let next = self.word(*length);
            !(matches!(first, Some("hold" | "drop")) || first == Some("strike") && self.sentence_has("with"))
                && !(*length == 1
                    && matches!(first, Some("not" | "never" | "no"))
                    && (preposition_at(self.tokens, self.at + length).is_some()
                        || matches!(next, Some("more" | "less" | "fewer" | "need"))))
        });
        [verb, after_subject, plain].into_iter().flatten().max()
    }

    /// An exclusion at the current position. Whether the rule applies.
    pub(super) fn exclusion(&mut self) -> bool {
        if self.nothing_else()
            || self.anything_else()
            || self.missing_after_noun()
            || self.permission()
            || self.bare_table()
        {
            return true;
        }
        let Some(length) = self.negation() else { return false };
        let start = self.at;
        let mut p = start + length;
        while matches!(self.word_at(p), Some("for" | "any" | "of" | "also" | "either")) {
            p += 1;
        }
        let end = self.excluded_list(p);
        let Some(mut end) = end else {
            // "not" before something else: what it negates is not expressible.
            let relation = preposition_at(self.tokens, start + length).is_some();
            let reason =
                if relation { UnrecognizedReason::NotExpressible } else { UnrecognizedReason::NotSupported };
            let negates = matches!(self.word(0), Some("not" | "never" | "dont" | "without"));
            if negates {
                self.report(start..start + length, reason);
            }
            self.at = start + length;
            return negates;
        };
        self.parsed.account.used(start..p);
        // "without a fork on it", "no mugs on the table".
        let on = matches!(self.word_at(end), Some("on" | "in" | "inside" | "there" | "here" | "at"));
        if on {
            let after = end + usize::from(self.word_at(end + 1) == Some("the"));
            let place = self.word_at(after + 1);
            if matches!(
                place,
                Some("it" | "table" | "desk" | "scene" | "them" | "picture" | "image" | "surface")
            ) {
                self.parsed.account.used(end..after + 2);
                end = after + 2;
            }
        }
        while matches!(
            self.word_at(end),
            Some(
                "either"
                    | "please"
                    | "anywhere"
                    | "whatsoever"
                    | "though"
                    | "at"
                    | "all"
                    | "allowed"
                    | "wanted"
                    | "needed"
                    | "required"
                    | "permitted"
                    | "necessary"
                    | "desired"
            )
        ) && !(self.word_at(end) == Some("at") && self.word_at(end + 1) != Some("all"))
        {
            self.parsed.account.used(end..end + 1);
            end += 1;
        }
        self.at = end;
        self.after_and = false;
        true
    }

    /// A list of phrases that are excluded; the position after it.
    fn excluded_list(&mut self, from: usize) -> Option<usize> {
        let mut p = from;
        let mut end = None;
        let mut first_is_bare = true;
        while let Some((phrase, after)) = noun_phrase(self.lexicon, self.tokens, p) {
            if !matches!(phrase.head, Head::Objects(_) | Head::Unknown(_)) || phrase.is_table() {
                break;
            }
            let article = matches!(self.word_at(p), Some("a" | "an" | "the" | "some"))
                || matches!(self.tokens.get(p), Some(Token::Number(_)));
            if end.is_none() {
                first_is_bare = !article;
            }
            self.exclude(phrase);
            end = Some(after);
            let comma = matches!(self.tokens.get(after), Some(Token::Pause));
            let next = after + usize::from(comma);
            let conjunction = self.word_at(next);
            let skip = usize::from(matches!(conjunction, Some("or" | "nor" | "and")));
            let continues = match conjunction {
                Some("or" | "nor") => true,
                Some("and") => {
                    let article =
                        matches!(self.word_at(next + 1), Some("a" | "an" | "some" | "the" | "two" | "one"))
                            || matches!(self.tokens.get(next + 1), Some(Token::Number(_)));
                    // "minus the keyboard and the mouse".
                    let alike = self.word_at(from) == Some("the")
                        && self.word_at(next + 1) == Some("the")
                        && noun_phrase(self.lexicon, self.tokens, next + 1)
                            .is_some_and(|(_, end)| !self.finite_verb_at(end));
                    first_is_bare && !article || alike
                }
                // "no forks, knives or spoons".
                _ => comma && first_is_bare && self.ends_in_alternative(next),
            };
            if !continues {
                break;
            }
            p = next + skip;
            while matches!(self.word_at(p), Some("any" | "no" | "without")) {
                p += 1;
            }
            self.parsed.account.used(after..p);
        }
        end
    }

    /// Whether the comma list that continues at `from` has "or", or consists of bare nouns to the end of the sentence.
    fn ends_in_alternative(&self, from: usize) -> bool {
        let mut p = from;
        for _ in 0..8 {
            let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else { return false };
            if phrase.determiner != Determiner::New || phrase.count.is_some() {
                return false;
            }
            let comma = matches!(self.tokens.get(end), Some(Token::Pause));
            let next = end + usize::from(comma);
            match (self.tokens.get(end), self.word_at(next)) {
                (_, Some("or" | "nor" | "and")) => return true,
                (None | Some(Token::End), _) => return true,
                _ if comma => p = next,
                _ => return false,
            }
        }
        false
    }

    /// Excludes the objects of a phrase.
    pub(super) fn exclude(&mut self, phrase: NounPhrase) {
        self.parsed.account.used(phrase.tokens.clone());
        let meanings = match phrase.head {
            Head::Objects(meanings) => meanings,
            _ => Vec::new(),
        };
        // "no red mugs" excludes only some of them, which the description cannot express.
        if phrase.properties.iter().any(|(property, _)| *property != Property::Content) {
            self.report(phrase.tokens, UnrecognizedReason::NotExpressible);
            return;
        }
        self.parsed.account.claim(phrase.head_tokens, Claimed::Exclusion(meanings.clone()));
        self.parsed.excluded.extend(meanings);
    }

    /// "nothing else", "no other objects".
    fn nothing_else(&mut self) -> bool {
        let Some(length) = phrases().exclusion.closed.longest_at(self.tokens, self.at) else { return false };
        let on_it = ["on it", "on the table", "on the desk", "on top"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, self.at + length, phrase));
        let end = self.at + length + on_it.unwrap_or(0);
        self.parsed.nothing_else = true;
        self.parsed.account.claim(self.at..end, Claimed::Completion(false));
        self.at = end;
        true
    }

    /// "replace the mug with a glass", "swap out the fork: use chopsticks instead": the mug is absent. Whether the rule
    /// applies.
    pub(super) fn replacement(&mut self) -> bool {
        let verbs = ["replace", "substitute", "swap out", "switch out", "exchange"];
        let verb = self.longest(&verbs, self.at);
        if verb == 0 {
            return false;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + verb) else {
            return false;
        };
        let Head::Objects(meanings) = &phrase.head else { return false };
        let pause = usize::from(matches!(self.tokens.get(end), Some(Token::Pause | Token::End)));
        let uses = pause == 1
            && matches!(self.word_at(end + 1), Some("use" | "take" | "have" | "put" | "add"))
            && self.sentence_after(end + 1).any(|at| self.word_at(at) == Some("instead"));
        let with =
            matches!(self.word_at(end), Some("with" | "by")) || verb == 2 && self.word_at(end) == Some("for");
        // "exchange the apple with the pear" swaps two objects.
        let exchanges = self.word(0) == Some("exchange") || verb == 2 && self.instructed;
        if !uses && (!with || exchanges) {
            return false;
        }
        for mention in &mut self.parsed.mentions {
            if mention.meanings.iter().any(|meaning| meanings.contains(meaning)) {
                mention.count = Some([0, 0]);
            }
        }
        let next = end + if uses { 2 } else { 1 };
        // Before a list, the replacement is that of the list.
        let listed = noun_phrase(self.lexicon, self.tokens, next).filter(|(_, last)| self.is_colon(*last));
        let after = listed.map_or(next, |(_, last)| last);
        self.parsed.account.used(self.at..after);
        if uses {
            let instead = self.sentence_after(end + 1).find(|at| self.word_at(*at) == Some("instead"));
            self.parsed.account.used(instead.map_or(after..after, |at| at..at + 1));
        }
        self.exclude(phrase);
        self.at = after;
        self.clause_start = true;
        self.subject.clear();
        true
    }

    /// Positions from `at` to the end of its sentence.
    fn sentence_after(&self, at: usize) -> std::ops::Range<usize> {
        let rest = &self.tokens[at.min(self.tokens.len())..];
        let rest = &rest[..rest.len().min(SENTENCE)];
        let end = rest.iter().position(|token| *token == Token::End);
        at..at + end.unwrap_or(rest.len())
    }

    /// Whether the rest of the sentence has the word.
    fn sentence_has(&self, word: &str) -> bool {
        self.sentence_after(self.at).any(|at| self.word_at(at) == Some(word))
    }

    /// "minus the usual clutter", "without other decorations". Whether the rule applies.
    fn anything_else(&mut self) -> bool {
        let list = &phrases().exclusion;
        let Some(length) = list.before.longest_at(self.tokens, self.at) else { return false };
        let mut p = self.at + length;
        let first = p;
        while matches!(
            self.word_at(p),
            Some(
                "the"
                    | "any"
                    | "all"
                    | "of"
                    | "usual"
                    | "other"
                    | "additional"
                    | "extra"
                    | "further"
                    | "more"
            )
        ) {
            p += 1;
        }
        let named = self.word_at(p).is_some_and(|word| list.anything_else.has(word));
        if !named || p == first || self.word_at(p + 1) == Some("of") {
            return false;
        }
        self.parsed.nothing_else = true;
        self.parsed.account.claim(self.at..p + 1, Claimed::Completion(false));
        self.at = p + 1;
        true
    }

    /// "Spoons are fine" after "forks are banned": what may be there need not. Whether the rule applies.
    fn permission(&mut self) -> bool {
        let Some(length) = phrases().exclusion.permitted.longest_at(self.tokens, self.at) else {
            return false;
        };
        let Some(&last) = self.subject.last() else { return false };
        if self.parsed.mentions[last].tokens.end != self.at || self.parsed.mentions[last].count.is_some() {
            return false;
        }
        self.parsed.account.used(self.at..self.at + length);
        self.at += length;
        self.permitted.push(last);
        self.subject.clear();
        true
    }

    /// "a bare table except for one cactus": the cactus is all there is. Whether the rule applies.
    fn bare_table(&mut self) -> bool {
        let except = ["except for", "except", "but for", "apart from", "aside from", "save for"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, self.at, phrase));
        let Some(length) = except else { return false };
        let before: Vec<&str> =
            self.tokens[self.at.saturating_sub(5)..self.at].iter().rev().map_while(Token::word).collect();
        let bare = before.iter().any(|word| matches!(*word, "bare" | "empty" | "clear" | "blank"));
        if !bare || !before.iter().any(|word| Self::is_table_word(word)) {
            return false;
        }
        self.parsed.nothing_else = true;
        self.parsed.account.claim(self.at..self.at + length, Claimed::Completion(false));
        self.at += length;
        true
    }

    /// "The fork is missing", "a mug is not there".
    fn missing_after_noun(&mut self) -> bool {
        let Some(length) = phrases().exclusion.after.longest_at(self.tokens, self.at) else { return false };
        if self.subject.is_empty() {
            return false;
        }
        // "Plates are wanted, forks are unwanted": a verb before ends what is excluded.
        let verb = (0..self.at)
            .rev()
            .take_while(|at| !matches!(self.tokens[*at], Token::End))
            .find(|at| self.finite_verb_at(*at) || self.word_at(*at) == Some("but"))
            .unwrap_or(0);
        let mut excluded = Vec::new();
        for &mention in self.subject.iter().filter(|m| self.parsed.mentions[**m].tokens.start >= verb) {
            excluded.extend(self.parsed.mentions[mention].meanings.clone());
        }
        self.parsed.account.claim(self.at..self.at + length, Claimed::Exclusion(excluded.clone()));
        self.parsed.excluded.extend(excluded);
        self.at += length;
        true
    }

    /// Mentions of excluded categories lose their objects. A text that first asks for them contradicts itself, unless
    /// the mention is the exclusion itself.
    pub(super) fn drop_excluded(&mut self) {
        let permitted = std::mem::take(&mut self.permitted);
        let others = (0..self.parsed.mentions.len()).any(|m| {
            let mention = &self.parsed.mentions[m];
            let is_excluded = mention.meanings.iter().any(|meaning| self.parsed.excluded.contains(meaning));
            !permitted.contains(&m) && mention.count != Some([0, 0]) && !is_excluded
        });
        for m in permitted.into_iter().filter(|_| others) {
            self.parsed.mentions[m].count = Some([0, 0]);
            self.parsed.account.claims.retain(|claim| claim.meaning != Claimed::Object(m));
        }
        for m in 0..self.parsed.mentions.len() {
            let mention = &self.parsed.mentions[m];
            let is_excluded = !mention.meanings.is_empty()
                && mention.meanings.iter().any(|meaning| self.parsed.excluded.contains(meaning));
            let is_replaced = mention.count == Some([0, 0]);
            if is_excluded {
                let tokens = mention.tokens.clone();
                self.parsed.mentions[m].count = Some([0, 0]);
                self.parsed.account.claims.retain(|claim| claim.meaning != Claimed::Object(m));
                let said_missing = matches!(
                    self.word_at(tokens.end),
                    Some("is" | "are" | "isnt" | "arent" | "must" | "should")
                );
                if !said_missing && !is_replaced {
                    self.report(tokens, UnrecognizedReason::Contradiction);
                }
            }
        }
    }
}
