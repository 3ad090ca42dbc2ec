//! Negation and exclusion: "no mugs", "do not include any forks", "neither X nor Y", "a fork instead of a spoon". The
//! excluded categories are absent, also from fillings.

use super::Parser;
use super::exclusion_phrases::{AFTER, ASKS, CLOSED, NEGATIONS, TRIGGERS};
use crate::text_parser::account::Claimed;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::prepositions::preposition_at;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::text_account::UnrecognizedReason;

impl Parser<'_, '_> {
    /// Number of tokens of the negation at the current position.
    pub(super) fn negation(&self) -> Option<usize> {
        let longest = |phrases: &[&str], at: usize| {
            phrases.iter().filter_map(|phrase| match_phrase(self.tokens, at, phrase)).max()
        };
        let verb = NEGATIONS
            .iter()
            .filter_map(|phrase| match_phrase(self.tokens, self.at, phrase))
            .filter_map(|length| Some(length + longest(ASKS, self.at + length)?))
            .max();
        let subject = usize::from(matches!(self.word(0), Some("i" | "we" | "you")));
        let after_subject = (subject == 1).then(|| {
            NEGATIONS
                .iter()
                .filter_map(|phrase| match_phrase(self.tokens, self.at + 1, phrase))
                .filter_map(|length| Some(1 + length + longest(ASKS, self.at + 1 + length)?))
                .max()
        });
        let plain = longest(TRIGGERS, self.at).filter(|length| {
            // "hold the mug" and "drop the mug" are instructions, "not on the plate" is a relation.
            let first = self.word(0);
            let next = self.word(*length);
            !matches!(first, Some("hold" | "drop"))
                && !(*length == 1
                    && matches!(first, Some("not" | "never" | "no"))
                    && (preposition_at(self.tokens, self.at + length).is_some()
                        || matches!(next, Some("more" | "less" | "fewer" | "need"))))
        });
        [verb, after_subject.flatten(), plain].into_iter().flatten().max()
    }

    /// An exclusion at the current position. Whether the rule applies.
    pub(super) fn exclusion(&mut self) -> bool {
        if self.nothing_else() || self.missing_after_noun() || self.bare_table() {
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
        if phrase.properties.iter().any(|(property, _)| *property != "content") {
            self.report(phrase.tokens, UnrecognizedReason::NotExpressible);
            return;
        }
        self.parsed.account.claim(phrase.head_tokens, Claimed::Exclusion(meanings.clone()));
        self.parsed.excluded.extend(meanings);
    }

    /// "nothing else", "no other objects".
    fn nothing_else(&mut self) -> bool {
        let Some(length) =
            CLOSED.iter().filter_map(|phrase| match_phrase(self.tokens, self.at, phrase)).max()
        else {
            return false;
        };
        let on_it = ["on it", "on the table", "on the desk", "on top"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, self.at + length, phrase));
        let end = self.at + length + on_it.unwrap_or(0);
        self.parsed.nothing_else = true;
        self.parsed.account.claim(self.at..end, Claimed::Completion(false));
        self.at = end;
        true
    }

    /// "replace the mug with a glass": the mug is absent. Whether the rule applies.
    pub(super) fn replacement(&mut self) -> bool {
        if !matches!(self.word(0), Some("replace" | "substitute")) {
            return false;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1) else { return false };
        let Head::Objects(meanings) = &phrase.head else { return false };
        if !matches!(self.word_at(end), Some("with" | "by")) {
            return false;
        }
        for mention in &mut self.parsed.mentions {
            if mention.meanings.iter().any(|meaning| meanings.contains(meaning)) {
                mention.count = Some([0, 0]);
            }
        }
        // Before a list, the replacement is that of the list.
        let listed = noun_phrase(self.lexicon, self.tokens, end + 1).filter(|(_, last)| self.is_colon(*last));
        let after = listed.map_or(end + 1, |(_, last)| last);
        self.parsed.account.used(self.at..after);
        self.exclude(phrase);
        self.at = after;
        self.clause_start = true;
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
        let Some(length) = AFTER.iter().filter_map(|phrase| match_phrase(self.tokens, self.at, phrase)).max()
        else {
            return false;
        };
        if self.subject.is_empty() {
            return false;
        }
        // "Plates are wanted, forks are unwanted": a verb before ends what is excluded.
        let verb = (0..self.at)
            .rev()
            .take_while(|at| !matches!(self.tokens[*at], Token::End))
            .find(|at| self.finite_verb_at(*at))
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
