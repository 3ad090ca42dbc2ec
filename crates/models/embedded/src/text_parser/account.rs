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
    Property {
        property: Property,
        mentions: Vec<usize>,
    },
    Relation {
        kind: RelationKind,
        from: Vec<usize>,
        to: Vec<usize>,
    },
    /// The relations that the objects of a list have to their host ("holding").
    Linked {
        from: Vec<usize>,
        to: Vec<usize>,
    },
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
        if tokens.is_empty() {
            return;
        }
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

    /// Whether the token has been used, and not for a report.
    pub fn is_understood(&self, token: usize) -> bool {
        !self.is_open(token) && !self.reports.iter().any(|report| report.tokens.contains(&token))
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
        self.separate(source, lexicon);
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

    /// Gives every word to one kind of meaning: where claims overlap, the longer one keeps what the others leave.
    fn separate(&mut self, source: &Source, lexicon: &Lexicon) {
        let mut claims = std::mem::take(&mut self.claims);
        // "pile of" is the arrangement that it states, not a property beside it.
        let is_beside = |claim: &Claim| {
            matches!(claim.meaning, Claimed::Property { property: Property::Arrangement, .. })
        };
        claims.sort_by_key(|claim| (claim.tokens.len(), claim.tokens.start, is_beside(claim)));
        let mut owners: Vec<Option<(Range<usize>, bool)>> = vec![None; source.tokens.len()];
        for claim in claims {
            if matches!(claim.meaning, Claimed::Correction(_)) {
                self.claims.push(claim);
                continue;
            }
            let is_property = matches!(claim.meaning, Claimed::Property { .. });
            let own = (claim.tokens.clone(), is_property);
            let is_free = |token: &usize| owners.get(*token).is_some_and(Option::is_none);
            let shares = claim.tokens.clone().all(|token| {
                owners.get(token).is_some_and(|owner| owner.as_ref().is_none_or(|owner| *owner == own))
            });
            let left = if shares { claim.tokens.clone() } else { longest_run(claim.tokens.clone(), is_free) };
            let reads = match &claim.meaning {
                Claimed::Property { property, .. } => property.reads(lexicon, &source.tokens, &left),
                _ => true,
            };
            let says_more = matches!(
                claim.meaning,
                Claimed::Relation { .. }
                    | Claimed::Linked { .. }
                    | Claimed::Arrangement(_)
                    | Claimed::Goal(_)
            );
            let tokens = if !left.is_empty() && reads {
                left
            } else if says_more {
                // The objects of a row may be all that names it.
                claim.tokens.clone()
            } else {
                continue;
            };
            for token in tokens.clone() {
                if let Some(owner) = owners.get_mut(token) {
                    owner.get_or_insert((tokens.clone(), is_property));
                }
            }
            self.claims.push(Claim { tokens, meaning: claim.meaning });
        }
    }

    /// Gives words of a construction ("without" of an exclusion, "into" of a goal) the meaning of a claim in their
    /// sentence: of a word of the grammar a claim before or after it that is no name of an object, of other words the
    /// claim after or before them. A property is stated by its own words only.
    fn spread(&mut self, source: &Source, vocabulary: &Vocabulary) {
        let (mut named, mut said) = (vec![None; source.tokens.len()], vec![None; source.tokens.len()]);
        let mut is_covered = vec![false; source.tokens.len()];
        for (index, claim) in self.claims.iter().enumerate() {
            for token in claim.tokens.clone().filter(|&token| token < source.tokens.len()) {
                is_covered[token] = true;
                match claim.meaning {
                    Claimed::Correction(_) | Claimed::Property { .. } => {}
                    Claimed::Object(_) => named[token] = Some(index),
                    _ => said[token] = Some(index),
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
        let is_grammar = |token: usize| {
            source.tokens[token].word().is_some_and(|word| {
                super::verbs::verbs().is_form(word) || vocabulary.grammar.boundaries.contains(word)
            })
        };
        for token in (0..source.tokens.len()).filter(|&token| needs(token)) {
            let in_sentence = |token: &usize| source.tokens[*token] != Token::End;
            let before = || (0..token).rev().take_while(in_sentence);
            let after = || (token..source.tokens.len()).take_while(in_sentence);
            let any = |token: usize| named[token].or(said[token]);
            let of_grammar =
                || before().find_map(|token| said[token]).or_else(|| after().find_map(|token| said[token]));
            // Who acts is no name of an object.
            let acts = source.tokens[token].word().is_some_and(|word| {
                let agent = &super::phrases::phrases().agent;
                agent.names.has(word) || agent.persons.has(word)
            });
            let nearest = || after().find_map(any).or_else(|| before().find_map(any));
            let found = (acts || is_grammar(token)).then(of_grammar).flatten();
            let found = if acts { found } else { found.or_else(nearest) };
            let tokens = token..token + 1;
            match found {
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

/// The longest run of tokens with a condition, the first of equally long ones.
fn longest_run(tokens: Range<usize>, holds: impl Fn(&usize) -> bool) -> Range<usize> {
    let mut longest = tokens.start..tokens.start;
    let mut at = tokens.start;
    while at < tokens.end {
        let length = (at..tokens.end).take_while(&holds).count();
        if length > longest.len() {
            longest = at..at + length;
        }
        at += length + 1;
    }
    longest
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
