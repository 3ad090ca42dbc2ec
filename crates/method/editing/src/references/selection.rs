//! The objects of a scene that a noun phrase means.
//!
//! Nouns name objects at several levels, from labels to synonyms; the first level with an object that fits the rest of
//! the phrase counts. Modifiers and relations filter; then sizes and ranks pick; then the quantity is checked.

use super::modifier::{Modifier, label_has, modifiers, of_color, of_material};
use super::noun::{Number, named};
use super::phrase::{NounPhrase, Quantity};
use language::nouns::is_noun;

use super::qualifier::Qualifier;
use super::{ReferenceError, nearest_names};
use crate::EditableObject;

/// The objects, and which of them are new, the newest last.
pub(super) struct Selector<'a> {
    pub objects: &'a [EditableObject],
    pub newest: &'a [usize],
}

/// Objects that fit, before their number is checked.
pub(super) struct Fit {
    pub indices: Vec<usize>,
    pub number: Number,
}

pub(super) type Outcome<T> = Result<T, ReferenceError>;

impl Selector<'_> {
    /// The objects of the pool that a phrase means, in the order of the list.
    pub fn select(&self, phrase: &NounPhrase, pool: &[usize]) -> Outcome<Vec<usize>> {
        let Fit { mut indices, number } = self.fit(phrase, pool)?;
        indices.sort_unstable();
        let plural = number == Number::Plural || matches!(phrase.quantity, Quantity::All | Quantity::Both);
        if phrase.other && plural {
            return Err(self.not_understood(phrase, vec!["other".to_owned()]));
        }
        let wanted = match phrase.quantity {
            Quantity::All => return Ok(indices),
            Quantity::Open if number == Number::Plural => return Ok(indices),
            Quantity::Open | Quantity::One => 1,
            Quantity::Count(count) => count,
            Quantity::Both => 2,
            Quantity::Fraction(part) => ((indices.len() as f64 * part).round() as usize).max(1),
        };
        if indices.len() == wanted {
            return Ok(indices);
        }
        if indices.len() < wanted {
            return Err(self.too_few(phrase, wanted, &indices));
        }
        if phrase.choice {
            indices.truncate(wanted);
            return Ok(indices);
        }
        let newest: Vec<usize> =
            self.newest.iter().copied().filter(|index| indices.contains(index)).collect();
        if newest.len() >= wanted {
            let mut chosen = newest[newest.len() - wanted..].to_vec();
            chosen.sort_unstable();
            return Ok(chosen);
        }
        Err(self.ambiguous(phrase, &indices))
    }

    pub fn fit(&self, phrase: &NounPhrase, pool: &[usize]) -> Outcome<Fit> {
        if let Some(name) = self.index_of_name(phrase) {
            let indices = self.filtered(phrase, vec![name], &[], Number::Singular)?;
            return Ok(Fit { indices, number: Number::Singular });
        }
        if let Some(whole) = &phrase.whole {
            let pool = self.select(whole, pool)?;
            let words: Vec<String> =
                phrase.body.iter().filter(|word| !matches!(word.as_str(), "one" | "ones")).cloned().collect();
            let found = modifiers(&words, |_| false).map_err(|words| self.not_understood(phrase, words))?;
            let number = if words.is_empty() && phrase.quantity == Quantity::Open {
                Number::Plural
            } else {
                Number::Singular
            };
            return Ok(Fit { indices: self.filtered(phrase, pool, &found, number)?, number });
        }
        if let Some(index) = self.only_labeled(phrase, pool) {
            let indices = self.filtered(phrase, vec![index], &[], Number::Singular)?;
            return Ok(Fit { indices, number: Number::Singular });
        }
        self.fit_by_noun(phrase, pool)
    }

    /// The longest noun at the end of the body after words that have a meaning, at the closest level that fits.
    pub fn fit_by_noun(&self, phrase: &NounPhrase, pool: &[usize]) -> Outcome<Fit> {
        let mut first_error = None;
        for start in 0..phrase.body.len() {
            let Some(nouns) = named(self.objects, pool, &phrase.body[start..].join(" ")) else { continue };
            // "red mugs" is a color and a noun even where a label says "red mug".
            let shorter = start + 1 < phrase.body.len()
                && modifiers(&phrase.body[start..=start], |_| false).is_ok()
                && named(self.objects, pool, &phrase.body[start + 1..].join(" ")).is_some();
            if shorter {
                continue;
            }
            for level in nouns.levels {
                let is_label_word =
                    |word: &str| level.iter().any(|&index| label_has(&self.objects[index], word));
                let outcome = modifiers(&phrase.body[..start], is_label_word)
                    .map_err(|words| self.not_understood(phrase, words))
                    .and_then(|found| self.filtered(phrase, level.clone(), &found, nouns.number));
                match outcome {
                    Ok(indices) => return Ok(Fit { indices, number: nouns.number }),
                    Err(error @ ReferenceError::Ambiguous { .. }) => return Err(error),
                    Err(error) => first_error = first_error.or(Some(error)),
                }
            }
        }
        Err(first_error.unwrap_or_else(|| self.unknown_noun(phrase)))
    }

    /// Objects that fit modifiers, qualifiers and exceptions, reduced to those that ranks and sizes pick.
    pub fn filtered(
        &self,
        phrase: &NounPhrase,
        named: Vec<usize>,
        found: &[Modifier],
        number: Number,
    ) -> Outcome<Vec<usize>> {
        let plural = number == Number::Plural || !matches!(phrase.quantity, Quantity::Open | Quantity::One);
        let mut pool = named.clone();
        // Exactly one object whose label says it is preferred to those that only seem so.
        let mut labeled = named.clone();
        for modifier in found {
            let (of_label, all) = match modifier {
                Modifier::Color(words) => of_color(self.objects, &pool, words),
                Modifier::Material(words) => of_material(self.objects, &pool, words),
                Modifier::LabelWord(word) => {
                    let has = |index: &usize| label_has(&self.objects[*index], word);
                    let labeled: Vec<usize> = pool.iter().copied().filter(has).collect();
                    (labeled.clone(), labeled)
                }
                Modifier::Pick(..) | Modifier::Count(_) => continue,
            };
            labeled.retain(|index| of_label.contains(index));
            pool = all;
        }
        let mut from = None;
        for qualifier in &phrase.qualifiers {
            if let Qualifier::From(direction) = qualifier {
                from = Some(*direction);
            } else {
                pool = self.qualified(phrase, pool, qualifier, plural)?;
            }
        }
        labeled.retain(|index| pool.contains(index));
        if labeled.len() == 1 && !plural {
            pool = labeled;
        }
        if pool.is_empty() {
            return Err(self.not_found(phrase, &named));
        }
        for exception in &phrase.exceptions {
            let excluded = self.select(exception, &pool)?;
            pool.retain(|index| !excluded.contains(index));
        }
        self.picked(phrase, pool, found, from)
    }

    pub fn all(&self) -> Vec<usize> {
        (0..self.objects.len()).collect()
    }

    /// The object of that name ("mug_1", "mug 1").
    pub fn index_of_name(&self, phrase: &NounPhrase) -> Option<usize> {
        let name = phrase.body.join("_");
        let has_number = name.contains(|c: char| c.is_ascii_digit());
        let found = self.objects.iter().position(|object| object.name.as_str() == name);
        found.filter(|_| has_number && phrase.whole.is_none())
    }

    /// The one object whose label is the body of two or more words.
    pub fn only_labeled(&self, phrase: &NounPhrase, pool: &[usize]) -> Option<usize> {
        let body = phrase.body.join(" ");
        let is_labeled = |&index: &usize| self.objects[index].label.to_lowercase().replace('-', " ") == body;
        let mut labeled = pool.iter().copied().filter(is_labeled);
        let only = labeled.next().filter(|_| labeled.next().is_none());
        only.filter(|_| phrase.body.len() > 1 && matches!(phrase.quantity, Quantity::Open | Quantity::One))
    }

    pub fn unknown_noun(&self, phrase: &NounPhrase) -> ReferenceError {
        let near = nearest_names(self.objects, &phrase.body.join(" "));
        let last = phrase.body.last().map_or("", String::as_str);
        let spelled_as_name = last.contains('_');
        if near.is_empty() && !spelled_as_name && !is_noun(last) && !is_noun(&phrase.body.join(" ")) {
            return self.not_understood(phrase, vec![last.to_owned()]);
        }
        ReferenceError::not_found(self.objects, &phrase.text, near)
    }

    pub fn not_understood(&self, phrase: &NounPhrase, words: Vec<String>) -> ReferenceError {
        ReferenceError::NotUnderstood { phrase: phrase.text.clone(), words }
    }

    pub fn not_found(&self, phrase: &NounPhrase, near: &[usize]) -> ReferenceError {
        ReferenceError::not_found(self.objects, &phrase.text, self.names(near))
    }

    pub fn too_few(&self, phrase: &NounPhrase, wanted: usize, found: &[usize]) -> ReferenceError {
        ReferenceError::TooFew { phrase: phrase.text.clone(), wanted, found: self.names(found) }
    }

    pub fn ambiguous(&self, phrase: &NounPhrase, candidates: &[usize]) -> ReferenceError {
        ReferenceError::Ambiguous { phrase: phrase.text.clone(), candidates: self.names(candidates) }
    }

    pub fn names(&self, indices: &[usize]) -> Vec<scene::InstanceId> {
        indices.iter().map(|&index| self.objects[index].name.clone()).collect()
    }
}
