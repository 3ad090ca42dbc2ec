//! The account of the text: which tokens have which meaning, which are ignorable, and which have no effect.

use std::ops::Range;

use super::lexicon::{Lexicon, Meaning};
use super::property::Property;
use super::tokens::{Source, Token};
use super::vocabulary::Vocabulary;
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

/// A range of tokens with a meaning.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Claim {
    pub tokens: Range<usize>,
    pub meaning: Claimed,
}

/// The meaning of a claim; objects are mentions by index.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Claimed {
    Object(usize),
    Property { property: Property, mentions: Vec<usize> },
    Relation { kind: RelationKind, from: Vec<usize>, to: Vec<usize> },
    Arrangement(usize),
    Exclusion(Vec<Meaning>),
    Goal(usize),
    Table,
    Theme,
    Completion(bool),
    Correction(String),
}

/// A range of tokens without effect.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Report {
    pub tokens: Range<usize>,
    pub reason: UnrecognizedReason,
}

/// Number of reports that are compared with a new one.
const RECENT: usize = 16;

#[derive(Clone, Debug, Default)]
pub(super) struct Account {
    accounted: Vec<bool>,
    pub claims: Vec<Claim>,
    pub reports: Vec<Report>,
}

impl Account {
    pub fn new(tokens: usize) -> Self {
        Self { accounted: vec![false; tokens], ..Self::default() }
    }

    /// Marks tokens as part of a construction whose meaning other tokens carry.
    pub fn used(&mut self, tokens: Range<usize>) {
        for token in tokens {
            if let Some(accounted) = self.accounted.get_mut(token) {
                *accounted = true;
            }
        }
    }

    pub fn claim(&mut self, tokens: Range<usize>, meaning: Claimed) {
        self.used(tokens.clone());
        self.claims.push(Claim { tokens, meaning });
    }

    /// Adds a claim to tokens that keep their state.
    pub fn note(&mut self, tokens: Range<usize>, meaning: Claimed) {
        self.claims.push(Claim { tokens, meaning });
    }

    /// Removes the claims of exactly these tokens.
    pub fn retract(&mut self, tokens: &Range<usize>) {
        self.claims.retain(|claim| claim.tokens != *tokens);
    }

    pub fn report(&mut self, tokens: Range<usize>, reason: UnrecognizedReason) {
        let recent = self.reports.len().saturating_sub(RECENT);
        if self.reports[recent..].iter().any(|report| report.tokens == tokens) {
            return;
        }
        self.used(tokens.clone());
        self.reports.push(Report { tokens, reason });
    }

    /// Whether exactly these tokens have a meaning.
    pub fn is_claimed(&self, tokens: &Range<usize>) -> bool {
        self.claims.iter().rev().take(RECENT * RECENT).any(|claim| claim.tokens == *tokens)
    }

    pub fn is_open(&self, token: usize) -> bool {
        self.accounted.get(token).is_some_and(|accounted| !accounted)
    }

    /// Reports every remaining word that is not ignorable; neighbors with one reason are one report. What is claimed as
    /// a property and is no value of it is reported, too.
    pub fn close(&mut self, source: &Source, lexicon: &Lexicon) {
        let vocabulary = lexicon.vocabulary;
        self.report_misread(source, lexicon);
        let mut previous: Option<(usize, UnrecognizedReason)> = None;
        for token in 0..source.tokens.len() {
            let reason = match &source.tokens[token] {
                Token::Word(word) if self.is_open(token) => reason_for(word, vocabulary),
                Token::Number(_) if self.is_open(token) => Some(UnrecognizedReason::NotExpressible),
                _ => None,
            };
            let Some(reason) = reason else { continue };
            match (previous, self.reports.last_mut()) {
                (Some((end, last)), Some(report)) if end == token && last == reason => report.tokens.end += 1,
                _ => self.reports.push(Report { tokens: token..token + 1, reason }),
            }
            previous = Some((token + 1, reason));
        }
        self.reports.sort_by_key(|report| report.tokens.start);
        self.claims.sort_by_key(|claim| claim.tokens.start);
        self.spread(source, vocabulary);
    }

    /// Reports the claims of properties whose words are no value of the property.
    fn report_misread(&mut self, source: &Source, lexicon: &Lexicon) {
        let is_misread = |claim: &Claim| match &claim.meaning {
            Claimed::Property { property, .. } => !property.reads(lexicon, &source.tokens, &claim.tokens),
            _ => false,
        };
        let misread: Vec<Range<usize>> =
            self.claims.iter().filter(|claim| is_misread(claim)).map(|claim| claim.tokens.clone()).collect();
        self.claims.retain(|claim| !is_misread(claim));
        for tokens in misread {
            self.report(tokens, UnrecognizedReason::NotExpressible);
        }
    }

    /// Gives words of a construction ("without" of an exclusion, "into" of a goal) the meaning of the claim after
    /// them, or before them, in their sentence. A property is stated by its own words only.
    fn spread(&mut self, source: &Source, vocabulary: &Vocabulary) {
        let mut meaning: Vec<Option<usize>> = vec![None; source.tokens.len()];
        let mut is_covered = vec![false; source.tokens.len()];
        for (index, claim) in self.claims.iter().enumerate() {
            let is_own = matches!(claim.meaning, Claimed::Correction(_) | Claimed::Property { .. });
            for token in claim.tokens.clone() {
                if let (Some(slot), Some(covered)) = (meaning.get_mut(token), is_covered.get_mut(token)) {
                    *slot = if is_own { *slot } else { Some(index) };
                    *covered = true;
                }
            }
        }
        for token in self.reports.iter().flat_map(|report| report.tokens.clone()) {
            if let Some(covered) = is_covered.get_mut(token) {
                *covered = true;
            }
        }
        let needs = |token: usize| {
            !is_covered[token]
                && match &source.tokens[token] {
                    Token::Word(word) => !vocabulary.grammar.ignorable.contains(word),
                    Token::Number(_) => true,
                    _ => false,
                }
        };
        let nearest = |tokens: &mut dyn Iterator<Item = usize>| {
            tokens.take_while(|&token| source.tokens[token] != Token::End).find_map(|token| meaning[token])
        };
        for token in 0..source.tokens.len() {
            if !needs(token) {
                continue;
            }
            let (mut after, mut before) = (token..source.tokens.len(), (0..token).rev());
            let tokens = token..token + 1;
            match nearest(&mut after).or_else(|| nearest(&mut before)) {
                Some(index) => {
                    let meaning = self.claims[index].meaning.clone();
                    self.claims.push(Claim { tokens, meaning });
                }
                None => self.reports.push(Report { tokens, reason: UnrecognizedReason::NotExpressible }),
            }
        }
        self.reports.sort_by_key(|report| report.tokens.start);
    }
}

/// The reason to report a word that no rule has used; `None` if it is ignorable.
fn reason_for(word: &str, vocabulary: &Vocabulary) -> Option<UnrecognizedReason> {
    let grammar = &vocabulary.grammar;
    if grammar.ignorable.contains(word) {
        None
    } else if super::verbs::verbs().is_form(word) {
        Some(UnrecognizedReason::NotExpressible)
    } else if grammar.parts.contains(word) {
        Some(UnrecognizedReason::NotPlaceable)
    } else if vocabulary.is_ordinary(word) {
        Some(UnrecognizedReason::NotSupported)
    } else {
        Some(UnrecognizedReason::UnknownWord)
    }
}

#[cfg(test)]
mod tests {
    use super::super::LEXICON;
    use super::*;

    #[test]
    fn open_words_are_ignorable_or_reported_with_a_reason() {
        for (text, expected) in [
            ("there is a", vec![]),
            (
                "a zorblax frob the vintage",
                vec![(1..3, UnrecognizedReason::UnknownWord), (4..5, UnrecognizedReason::NotSupported)],
            ),
            ("and 7", vec![(1..2, UnrecognizedReason::NotExpressible)]),
        ] {
            let source = Source::read(text);
            let mut account = Account::new(source.tokens.len());
            account.close(&source, &LEXICON);
            let reports: Vec<_> = account.reports.iter().map(|r| (r.tokens.clone(), r.reason)).collect();
            assert_eq!(reports, expected, "{text}");
        }
    }
}
