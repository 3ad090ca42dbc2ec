//! Phrases for objects that exist, as operations name them.

use super::error::{InstructionError, Reason};
use super::fold::Fold;
use crate::nominal::{NounPhrase, Quantity, Reference};
use crate::vocabulary::vocabulary;

/// Objects that an operation is about.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Target {
    pub phrase: String,
    pub noun: String,
    pub is_pronoun: bool,
    pub is_plural: bool,
}

impl Fold<'_, '_> {
    /// The targets of phrases; a pronoun is those of the last clause.
    pub fn targets(&mut self, phrases: &[NounPhrase]) -> Result<Vec<Target>, InstructionError> {
        let mut targets = Vec::new();
        for (index, phrase) in phrases.iter().enumerate() {
            if phrase.reference == Reference::Pronoun {
                targets.extend(self.pronoun(phrase)?);
                continue;
            }
            let mut target = self.target(phrase)?;
            // "the leftmost and the rightmost cube", "the third" after "the second plate".
            if phrase.noun.is_empty() && phrase.tokens.end == phrase.body.end {
                let following =
                    phrases[index + 1..].iter().map(|next| next.noun.as_str()).find(|noun| !noun.is_empty());
                let noun = following.or_else(|| self.discourse.last_noun()).unwrap_or_default().to_owned();
                target.phrase = format!("{} {noun}", target.phrase).trim().to_owned();
                target.noun = noun;
            }
            targets.push(target);
        }
        Ok(targets)
    }

    pub fn target(&mut self, phrase: &NounPhrase) -> Result<Target, InstructionError> {
        let words = self.without_pronouns(phrase)?;
        let text = if let Some(others) = self.others(phrase) {
            others
        } else if phrase.is_rest {
            self.rest(phrase, &words)
        } else if phrase.noun == "one" || phrase.noun == "ones" {
            self.with_noun(phrase, words)
        } else {
            self.without_other(phrase, words)
        };
        Ok(Target {
            phrase: text,
            noun: phrase.noun.clone(),
            is_pronoun: false,
            is_plural: phrase.quantity.is_plural(),
        })
    }

    /// A phrase with what its pronouns stand for: "the cup next to it".
    fn without_pronouns(&self, phrase: &NounPhrase) -> Result<String, InstructionError> {
        let inner = phrase.body.end.max(phrase.tokens.start + 1)..phrase.tokens.end;
        let is_pronoun =
            |at: &usize| matches!(self.chart.word(*at), "it" | "them") && !self.is_of_carrier(*at);
        let Some(at) = inner.clone().find(is_pronoun) else { return Ok(self.phrase(phrase)) };
        let topic =
            self.discourse.topic.as_ref().filter(|topic| !topic.is_removed && topic.phrases.len() == 1);
        // "put the spoon in the cup that is nearest to it"
        let own = self.discourse.clause_phrase.as_ref().filter(|_| self.clause.start < phrase.tokens.start);
        let Some(named) = topic.map(|topic| &topic.phrases[0]).or(own) else {
            return Err(self.error(&(at..at + 1), Reason::NoAntecedent));
        };
        let start = self.phrase(&NounPhrase { tokens: phrase.tokens.start..at, ..phrase.clone() });
        let rest = self.chart.written(at + 1..phrase.tokens.end);
        Ok(format!("{start} {named}{}{rest}", if rest.is_empty() { "" } else { " " }))
    }

    /// "the mug with the spoon in it": the pronoun is the phrase itself.
    fn is_of_carrier(&self, at: usize) -> bool {
        let start = at.saturating_sub(6);
        matches!(self.chart.word(at.saturating_sub(1)), "in" | "on" | "inside")
            && (start..at).any(|before| matches!(self.chart.word(before), "with" | "containing" | "holding"))
    }

    /// A phrase as written, its determiner in lower case.
    pub fn phrase(&self, phrase: &NounPhrase) -> String {
        let words = self.chart.written(phrase.tokens.clone());
        let first = self.chart.word(phrase.tokens.start);
        match words.get(..first.len()) {
            Some(start) if start.to_lowercase() == first && phrase.tokens.start < phrase.body.start => {
                format!("{first}{}", &words[first.len()..])
            }
            _ => words,
        }
    }

    /// "everything else" as everything but what was named.
    fn rest(&self, phrase: &NounPhrase, words: &str) -> String {
        let named = self.discourse.not_rest();
        // "else", "the rest" and "the others" are all of what follows them.
        let tail = self.chart.written(phrase.body.end..phrase.tokens.end);
        let all = if tail.is_empty() { "everything".to_owned() } else { format!("everything {tail}") };
        match named.split_last() {
            None => words.to_owned(),
            Some((last, [])) => format!("{all} except {last}"),
            Some((last, others)) => format!("{all} except {} and {last}", others.join(", ")),
        }
    }

    /// "the blue one" where the clause before named what it is one of.
    fn with_noun(&self, phrase: &NounPhrase, words: String) -> String {
        let is_last = phrase.tokens.end == phrase.body.end;
        let number = if phrase.noun == "ones" { "ones" } else { "one" };
        match self.discourse.last_noun() {
            Some(noun) => {
                let singular = vocabulary().singular_of(noun).filter(|one| crate::nouns::is_noun(one));
                let noun =
                    if number == "one" { singular.unwrap_or(noun.to_owned()) } else { noun.to_owned() };
                let end = if is_last {
                    words.len()
                } else {
                    self.chart.written(phrase.tokens.start..phrase.body.end).len()
                };
                match words.get(..end).and_then(|start| start.strip_suffix(number)) {
                    Some(stem) => format!("{stem}{noun}{}", &words[end..]),
                    None => words,
                }
            }
            _ => words,
        }
    }

    /// "the other mug" as the mug other than the one that was named.
    fn without_other(&self, phrase: &NounPhrase, words: String) -> String {
        let start = phrase.body.start;
        if self.chart.word(start) == "other" && phrase.body.len() == 2 && phrase.quantity == Quantity::One {
            return self.discourse.other(&phrase.noun).unwrap_or(words);
        }
        words
    }

    /// "the other", "the other two", "the other ones" as the objects other than the one that was named.
    fn others(&self, phrase: &NounPhrase) -> Option<String> {
        let words: Vec<&str> = phrase.body.clone().map(|at| self.chart.word(at)).collect();
        let ["other" | "others", rest @ ..] = words.as_slice() else { return None };
        let is_bare = match rest {
            [] => true,
            [count] => matches!(*count, "one" | "ones") || crate::vocabulary::number(count).is_some(),
            _ => false,
        };
        if !is_bare || phrase.tokens.end != phrase.body.end {
            return None;
        }
        let (noun, named, is_removed) = self.discourse.mentions.last()?;
        let is_many = words != ["other"] && words != ["other", "one"];
        let noun = match is_many {
            true => vocabulary().plural_of(noun),
            false => vocabulary().singular_of(noun).unwrap_or_else(|| noun.clone()),
        };
        Some(if *is_removed { format!("the {noun}") } else { format!("the {noun} other than {named}") })
    }

    /// The targets that "it" or "them" stands for.
    fn pronoun(&mut self, phrase: &NounPhrase) -> Result<Vec<Target>, InstructionError> {
        let error = |reason| self.error(&phrase.tokens, reason);
        let Some(topic) = &self.discourse.topic else { return Err(error(Reason::NoAntecedent)) };
        let is_plural = phrase.quantity != Quantity::One;
        if topic.is_removed {
            return Err(error(Reason::Removed));
        }
        if topic.phrases.is_empty() {
            return Err(error(Reason::NoAntecedent));
        }
        if is_plural != topic.is_plural {
            return Err(error(Reason::UnclearPronoun));
        }
        if topic.is_stale {
            // Right after the change, the objects of that operation are meant.
            if self.stale_at.is_some_and(|at| at + 1 == self.steps.len()) {
                let word = if is_plural { "them" } else { "it" };
                let noun = String::new();
                return Ok(vec![Target { phrase: word.to_owned(), noun, is_pronoun: true, is_plural }]);
            }
            let first = topic.phrases.first().cloned().unwrap_or_default();
            return Err(error(Reason::Changed(first)));
        }
        let target = |phrase: &String| Target {
            phrase: phrase.clone(),
            noun: String::new(),
            is_pronoun: true,
            is_plural: topic.is_plural && topic.phrases.len() == 1,
        };
        Ok(topic.phrases.iter().map(target).collect())
    }
}
