//! Exceptions from exclusions: "no cutlery except spoons", "any drinkware apart from mugs is banned".

use super::Parser;
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Head, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::tokens::Token;

impl Parser<'_, '_> {
    /// An exclusion with an exception at the current position. Whether the rule applies.
    pub(super) fn exception(&mut self) -> bool {
        let negation = self.negation();
        let universal = matches!(self.word(0), Some("any" | "all" | "every"));
        if negation.is_none() && !universal {
            return false;
        }
        let mut p = self.at + negation.unwrap_or(1);
        while matches!(self.word_at(p), Some("any" | "of" | "other" | "kind" | "kinds" | "the")) {
            p += 1;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else { return false };
        let Head::Objects(whole) = &phrase.head else { return false };
        let except = phrases().list.exceptions.longest_at(self.tokens, end);
        let Some(length) = except else { return false };
        let start = end + length;
        let (kept, after, counted) = self.kept_list(start);
        let banned = phrases().exclusion.after.longest_at(self.tokens, after);
        if kept.is_empty() || negation.is_none() && banned.is_none() {
            return false;
        }
        let members = whole.iter().flat_map(|meaning| match meaning {
            Meaning::Vague(index) => self.lexicon.themes.vague[*index]
                .members
                .iter()
                .filter_map(|name| self.lexicon.index_of(name))
                .map(Meaning::Category)
                .collect::<Vec<_>>(),
            other => vec![other.clone()],
        });
        let excluded: Vec<Meaning> = members.filter(|meaning| !kept.contains(meaning)).collect();
        self.parsed.account.used(self.at..start);
        self.parsed.account.claim(phrase.head_tokens, Claimed::Exclusion(excluded.clone()));
        self.parsed.excluded.extend(excluded);
        // "no cutlery except two spoons" asks for two spoons.
        self.at = start;
        if !counted {
            self.at = after + banned.unwrap_or(0);
            self.parsed.account.used(start..self.at);
        }
        true
    }

    /// The meanings of the phrases that an exception lists, the position after them, and whether they are counted.
    fn kept_list(&self, start: usize) -> (Vec<Meaning>, usize, bool) {
        let (mut kept, mut end, mut counted) = (Vec::new(), start, false);
        // At most this many phrases.
        for _ in 0..8 {
            let comma = usize::from(end > start && matches!(self.tokens.get(end), Some(Token::Pause)));
            let and = usize::from(end > start && matches!(self.word_at(end + comma), Some("and" | "or")));
            if end > start && and == 0 {
                break;
            }
            let Some((phrase, after)) = noun_phrase(self.lexicon, self.tokens, end + comma + and) else {
                break;
            };
            let Head::Objects(meanings) = phrase.head else { break };
            counted |= phrase.count.is_some();
            kept.extend(meanings);
            end = after;
        }
        (kept, end, counted)
    }
}
