//! Goals of pouring and filling: from which vessel into which. A substance without a vessel comes from its usual one.

use std::ops::Range;

use super::action::{Action, Path};
use super::goals::GoalDraft;
use super::{LinkKind, Parser, Referent};
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::tokens::{Token, tokenize};
use crate::text_parser::verbs::verbs;
use scene::text_account::PredicateKind;

/// Words before a substance ("some of the hot water").
const AMOUNTS: &[&str] =
    &["the", "some", "a", "more", "of", "all", "hot", "cold", "fresh", "bit", "little", "any"];

impl Parser<'_, '_> {
    /// Number of words of a substance at `at` that is no object, with the words before it.
    pub(super) fn substance_length(&self, at: usize) -> Option<usize> {
        let mut p = at;
        while self.word_at(p).is_some_and(|word| AMOUNTS.contains(&word)) {
            p += 1;
        }
        let word = self.word_at(p)?;
        let is_substance = self.lexicon.vocabulary.grammar.substances.contains(word);
        // "milk carton", "water bottle" are objects.
        let is_object = self.lexicon.longest_at(self.tokens, p).is_some_and(|(_, length)| length > 1);
        (is_substance && !is_object).then_some(p + 1 - at)
    }

    /// Whether the phrase names a substance.
    pub(super) fn is_substance(&self, phrase: &NounPhrase) -> bool {
        let words = &self.lexicon.vocabulary;
        let name = phrase.words.rsplit(' ').next().unwrap_or_default();
        words.grammar.substances.contains(name)
            || words.drinks.values().flatten().any(|drink| *drink == phrase.words)
            || matches!(name, "beans" | "contents" | "content")
    }

    /// A substance as the object of "pour" and "fill". Whether the rule applies.
    pub(super) fn substance(&mut self, action: &mut Action) -> bool {
        let length = match noun_phrase(self.lexicon, self.tokens, self.at) {
            Some((phrase, _)) if phrase.negated => return false,
            Some((phrase, end)) if self.is_substance(&phrase) => end - self.at,
            Some((phrase, _)) if matches!(phrase.head, Head::Objects(_)) => return false,
            _ => match self.substance_length(self.at) {
                Some(length) => length,
                None => return false,
            },
        };
        let tokens = self.at..self.at + length;
        self.parsed.account.used(tokens.clone());
        self.at = tokens.end;
        action.substance = Some(tokens);
        true
    }

    /// States that the content of vessels is in the targets.
    pub(super) fn poured(&mut self, action: &mut Action) {
        let targets = Self::targets(&action.paths);
        let mut vessels = Self::targets(&action.sources);
        // "use the cup to pour the oats into the bowl".
        if vessels.is_empty() {
            vessels.clone_from(&action.tools);
        }
        if vessels.is_empty() {
            vessels = Self::mentions(&action.objects);
        }
        self.use_paths(action);
        // "tilt the kettle and pour into the glass".
        if vessels.is_empty() && action.substance.is_none() && !targets.is_empty() {
            vessels.clone_from(&self.acted);
        }
        if vessels.is_empty() && !targets.is_empty() {
            vessels.extend(self.vessel_of(action.substance.clone(), &targets));
        }
        for &target in &targets {
            for &vessel in &vessels {
                if vessel != target {
                    self.goal(GoalDraft::new(PredicateKind::PouredInto, vessel).to(target), action);
                }
            }
        }
        // "empty the box": everything leaves it.
        if !targets.is_empty() {
            return;
        }
        for object in Self::mentions(&action.objects) {
            let inside: Vec<usize> = self
                .parsed
                .links
                .iter()
                .filter(|link| {
                    link.to == object && !matches!(link.kind, LinkKind::Relation(kind) if !kind.is_support())
                })
                .map(|link| link.from)
                .collect();
            for content in inside {
                self.goal(GoalDraft::new(PredicateKind::OutOf, content).to(object), action);
            }
        }
    }

    /// "fill the mug with water from the pitcher", "water the plant with the watering can".
    pub(super) fn filled(&mut self, action: &Action) {
        let mut vessels = Self::targets(&action.sources);
        vessels.extend(&action.tools);
        self.use_paths(action);
        let objects = Self::mentions(&action.objects);
        let waters = self.verb_is(action, "water");
        if vessels.is_empty() {
            let noun = if waters { Some("watering can") } else { None };
            vessels.extend(match noun {
                Some(noun) => self.usual_vessel(noun, action.verb.clone()),
                None => self.vessel_of(action.substance.clone(), &objects),
            });
        }
        for &object in &objects {
            for &vessel in &vessels {
                if vessel != object {
                    let pours = waters || action.substance.is_some() || self.is_container(vessel);
                    let kind = if pours { PredicateKind::PouredInto } else { PredicateKind::In };
                    self.goal(GoalDraft::new(kind, vessel).to(object), action);
                }
            }
        }
    }

    fn use_paths(&mut self, action: &Action) {
        let paths: Vec<&Path> = action.sources.iter().chain(&action.paths).collect();
        for path in paths {
            self.parsed.account.used(path.tokens.clone());
        }
    }

    /// The vessel of a substance: an object of the text that is called so, or the usual one.
    fn vessel_of(&mut self, substance: Option<Range<usize>>, targets: &[usize]) -> Option<usize> {
        let tokens = substance?;
        let words: Vec<&str> = self.tokens[tokens.clone()].iter().filter_map(Token::word).collect();
        let last = *words.last()?;
        let named = (0..self.parsed.mentions.len()).rev().find(|m| {
            !targets.contains(m) && self.parsed.mentions[*m].words.split(' ').any(|word| word == last)
        });
        let pours = |m: &usize| {
            const VESSELS: &[&str] =
                &["pitcher", "kettle", "teapot", "jug", "carafe", "bottle", "can", "carton", "pot"];
            let words = &self.parsed.mentions[*m].words;
            !targets.contains(m) && words.rsplit(' ').next().is_some_and(|word| VESSELS.contains(&word))
        };
        let known = named.or_else(|| (0..self.parsed.mentions.len()).rev().find(pours));
        if known.is_some() {
            return known;
        }
        let two = words.len().checked_sub(2).map(|first| words[first..].join(" "));
        let noun = two.and_then(|two| verbs().vessel_of(&two)).or_else(|| verbs().vessel_of(last))?;
        let noun = noun.to_owned();
        self.usual_vessel(&noun, tokens)
    }

    /// The earlier or new object of this noun.
    pub(super) fn usual_vessel(&mut self, noun: &str, tokens: Range<usize>) -> Option<usize> {
        let words = tokenize(noun);
        let (phrase, _) = noun_phrase(self.lexicon, &words, 0)?;
        let Head::Objects(meanings) = &phrase.head else { return None };
        let is_category = matches!(meanings.first(), Some(Meaning::Category(_)));
        let phrase = NounPhrase {
            determiner: Determiner::Definite,
            tokens: tokens.clone(),
            head_tokens: tokens,
            properties: Vec::new(),
            ..phrase
        };
        match self.refer(phrase, false) {
            Referent::Mentions(list) if is_category => list.first().copied(),
            _ => None,
        }
    }
}
