//! The objects of a scene that a noun phrase means.
//!
//! Nouns name objects at several levels, from labels to synonyms; the first level with an object that fits the rest of
//! the phrase counts. Modifiers and relations filter; then sizes and ranks pick; then the quantity is checked.

use super::modifier::{Modifier, Pick, label_has, modifiers, of_color, of_material};
use super::noun::{Number, is_noun, named};
use super::phrase::{NounPhrase, Quantity};
use super::places::{Ranking, is_between, is_in_region, is_related, rests_on, size_group};
use super::qualifier::{Direction, Qualifier, Region};
use super::{ReferenceError, nearest_names};
use crate::EditableObject;
use scene::RelationKind;

/// The objects, and which of them are new, the newest last.
pub(super) struct Selector<'a> {
    pub objects: &'a [EditableObject],
    pub newest: &'a [usize],
}

/// Objects that fit, before their number is checked.
struct Fit {
    indices: Vec<usize>,
    number: Number,
}

type Outcome<T> = Result<T, ReferenceError>;

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
        };
        if indices.len() == wanted {
            return Ok(indices);
        }
        if indices.len() < wanted {
            return Err(self.too_few(phrase, wanted, &indices));
        }
        let newest: Vec<usize> = self.newest.iter().copied().filter(|index| indices.contains(index)).collect();
        if newest.len() >= wanted {
            let mut chosen = newest[newest.len() - wanted..].to_vec();
            chosen.sort_unstable();
            return Ok(chosen);
        }
        Err(self.ambiguous(phrase, &indices))
    }

    fn fit(&self, phrase: &NounPhrase, pool: &[usize]) -> Outcome<Fit> {
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
    fn fit_by_noun(&self, phrase: &NounPhrase, pool: &[usize]) -> Outcome<Fit> {
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

    /// What fits modifiers, qualifiers and exceptions; then what ranks and sizes pick.
    fn filtered(
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

    fn picked(
        &self,
        phrase: &NounPhrase,
        mut pool: Vec<usize>,
        found: &[Modifier],
        from: Option<Direction>,
    ) -> Outcome<Vec<usize>> {
        let stated = found.iter().find_map(|modifier| match modifier {
            Modifier::Count(count) => Some(*count),
            _ => None,
        });
        let count = match (stated, phrase.quantity) {
            (Some(count), _) | (None, Quantity::Count(count)) => count,
            (None, Quantity::Both) => 2,
            _ => 1,
        };
        let picks: Vec<(Pick, &String)> = found
            .iter()
            .filter_map(|modifier| match modifier {
                Modifier::Pick(pick, word) => Some((*pick, word)),
                _ => None,
            })
            .collect();
        let is_rank = |pick: &Pick| matches!(pick, Pick::Nth(_) | Pick::Last);
        let ranks = picks.iter().filter(|(pick, _)| is_rank(pick)).count();
        if from.is_some() && ranks == 0 {
            return Err(self.not_understood(phrase, vec!["from".to_owned()]));
        }
        for (pick, word) in picks.into_iter().rev() {
            pool = self.pick(phrase, pool, pick, word, count, from.unwrap_or(Direction::Left))?;
        }
        if stated.is_some_and(|stated| stated != pool.len()) {
            return Err(match pool.len() < count {
                true => self.too_few(phrase, count, &pool),
                false => self.ambiguous(phrase, &pool),
            });
        }
        Ok(pool)
    }

    fn pick(
        &self,
        phrase: &NounPhrase,
        pool: Vec<usize>,
        pick: Pick,
        word: &str,
        count: usize,
        from: Direction,
    ) -> Outcome<Vec<usize>> {
        let (ranking, start) = match pick {
            Pick::Nth(rank) => (Ranking::from(self.objects, &pool, from), rank),
            Pick::Last => (Ranking::from(self.objects, &pool, from.opposite()), 0),
            Pick::Outermost(direction) => {
                // "the left mug" is one of several, or one that is on the left.
                let is_side = matches!(word, "left" | "right" | "front" | "back" | "rear");
                if is_side && pool.len() == 1 {
                    return self.in_region(phrase, pool, region_of(direction), false);
                }
                (Ranking::from(self.objects, &pool, direction), 0)
            }
            Pick::Extreme(measure, largest) => (Ranking::by(self.objects, &pool, measure, largest), 0),
            Pick::Center => return self.center(phrase, &pool),
            Pick::Group(measure, large) => {
                let labeled: Vec<usize> =
                    pool.iter().copied().filter(|&index| label_has(&self.objects[index], word)).collect();
                if pool.len() == 1 || !labeled.is_empty() {
                    return Ok(if labeled.is_empty() { pool } else { labeled });
                }
                return size_group(self.objects, &pool, measure, large)
                    .ok_or_else(|| self.ambiguous(phrase, &pool));
            }
        };
        if start + count > ranking.order.len() {
            return Err(self.too_few(phrase, start + count, &pool));
        }
        ranking.ranks(start, count).map_err(|among| self.ambiguous(phrase, &among))
    }

    /// The one in the center of an odd number of objects.
    fn center(&self, phrase: &NounPhrase, pool: &[usize]) -> Outcome<Vec<usize>> {
        let ranking = Ranking::from(self.objects, pool, Direction::Left);
        if pool.len() % 2 == 0 {
            return Err(self.ambiguous(phrase, pool));
        }
        ranking.ranks(pool.len() / 2, 1).map_err(|among| self.ambiguous(phrase, &among))
    }

    fn in_region(
        &self,
        phrase: &NounPhrase,
        pool: Vec<usize>,
        region: Region,
        plural: bool,
    ) -> Outcome<Vec<usize>> {
        let inside: Vec<usize> =
            pool.iter().copied().filter(|&index| is_in_region(self.objects, index, region)).collect();
        if plural || inside.len() == 1 || (pool.len() == 1 && inside.is_empty()) {
            return if inside.is_empty() { Err(self.not_found(phrase, &pool)) } else { Ok(inside) };
        }
        let direction = match (region.x, region.y) {
            (0, 0) => {
                let ranks = Ranking::by_center(self.objects, &pool).ranks(0, 1);
                return ranks.map_err(|among| self.ambiguous(phrase, &among));
            }
            (-1, 0) => Direction::Left,
            (1, 0) => Direction::Right,
            (0, -1) => Direction::Front,
            (0, 1) => Direction::Back,
            _ if inside.is_empty() => return Err(self.not_found(phrase, &pool)),
            _ => return Ok(inside),
        };
        Ranking::from(self.objects, &pool, direction)
            .ranks(0, 1)
            .map_err(|among| self.ambiguous(phrase, &among))
    }

    fn qualified(
        &self,
        phrase: &NounPhrase,
        pool: Vec<usize>,
        qualifier: &Qualifier,
        plural: bool,
    ) -> Outcome<Vec<usize>> {
        let objects = self.objects;
        let keep = |test: &dyn Fn(usize) -> bool| -> Vec<usize> {
            pool.iter().copied().filter(|&index| test(index)).collect()
        };
        match qualifier {
            Qualifier::From(_) => Ok(pool),
            Qualifier::In(region) => self.in_region(phrase, pool, *region, plural),
            Qualifier::OnTable => {
                let direct = keep(&|index| objects[index].supporter.parent.is_none());
                let all = phrase.quantity == Quantity::All || direct.is_empty();
                Ok(if all { pool } else { direct })
            }
            Qualifier::Related(kind, target) => {
                let targets = self.targets(target)?;
                let related =
                    |index, wide| targets.iter().any(|&target| is_related(objects, index, *kind, target, wide));
                let (strict, wide) = (keep(&|index| related(index, false)), keep(&|index| related(index, true)));
                // "everything on the tray" includes what is stacked there.
                let everything = phrase.quantity == Quantity::All && kind.is_support();
                let near = *kind == RelationKind::NextTo && wide.len() > 1 && strict.is_empty();
                Ok(if near {
                    strict
                } else if strict.is_empty() || everything {
                    wide
                } else {
                    strict
                })
            }
            Qualifier::Supporting(target) => {
                let targets = self.targets(target)?;
                let supports = |index, directly| {
                    targets.iter().any(|&target| rests_on(objects, target, index, directly))
                };
                let direct = keep(&|index| supports(index, true));
                Ok(if direct.is_empty() { keep(&|index| supports(index, false)) } else { direct })
            }
            Qualifier::Between(ends) => {
                let mut found = Vec::new();
                for end in ends {
                    found.extend(self.select(end, &self.all())?);
                }
                let [first, second] = found[..] else {
                    return Err(match found.len() < 2 {
                        true => self.too_few(phrase, 2, &found),
                        false => self.ambiguous(phrase, &found),
                    });
                };
                Ok(keep(&|index| is_between(objects, index, [first, second])))
            }
            Qualifier::Closest(target) | Qualifier::Farthest(target) => {
                let [target] = self.select(target, &self.all())?[..] else {
                    return Err(self.ambiguous(target, &self.targets(target)?));
                };
                let nearest = matches!(qualifier, Qualifier::Closest(_));
                let ranking = Ranking::by_distance(objects, &pool, target, nearest);
                if ranking.order.is_empty() {
                    return Err(self.not_found(phrase, &pool));
                }
                ranking.ranks(0, 1).map_err(|among| self.ambiguous(phrase, &among))
            }
        }
    }

    /// Everything that the target of a relation may be: in "the spoon in the mug" the spoon tells which mug is meant.
    fn targets(&self, target: &NounPhrase) -> Outcome<Vec<usize>> {
        match target.quantity {
            Quantity::Open | Quantity::One => Ok(self.fit(target, &self.all())?.indices),
            _ => self.select(target, &self.all()),
        }
    }

    fn all(&self) -> Vec<usize> {
        (0..self.objects.len()).collect()
    }

    /// The object of that name ("mug_1", "mug 1").
    fn index_of_name(&self, phrase: &NounPhrase) -> Option<usize> {
        let name = phrase.body.join("_");
        let has_number = name.contains(|c: char| c.is_ascii_digit());
        let found = self.objects.iter().position(|object| object.name.as_str() == name);
        found.filter(|_| has_number && phrase.whole.is_none())
    }

    /// The one object whose label is the body of two or more words.
    fn only_labeled(&self, phrase: &NounPhrase, pool: &[usize]) -> Option<usize> {
        let body = phrase.body.join(" ");
        let is_labeled = |&index: &usize| self.objects[index].label.to_lowercase().replace('-', " ") == body;
        let mut labeled = pool.iter().copied().filter(is_labeled);
        let only = labeled.next().filter(|_| labeled.next().is_none());
        only.filter(|_| phrase.body.len() > 1 && matches!(phrase.quantity, Quantity::Open | Quantity::One))
    }

    fn unknown_noun(&self, phrase: &NounPhrase) -> ReferenceError {
        let near = nearest_names(self.objects, &phrase.body.join(" "));
        let last = phrase.body.last().map_or("", String::as_str);
        let spelled_as_name = last.contains('_');
        if near.is_empty() && !spelled_as_name && !is_noun(last) && !is_noun(&phrase.body.join(" ")) {
            return self.not_understood(phrase, vec![last.to_owned()]);
        }
        ReferenceError::NotFound { phrase: phrase.text.clone(), nearest: near }
    }

    fn not_understood(&self, phrase: &NounPhrase, words: Vec<String>) -> ReferenceError {
        ReferenceError::NotUnderstood { phrase: phrase.text.clone(), words }
    }

    fn not_found(&self, phrase: &NounPhrase, near: &[usize]) -> ReferenceError {
        ReferenceError::NotFound { phrase: phrase.text.clone(), nearest: self.names(near) }
    }

    fn too_few(&self, phrase: &NounPhrase, wanted: usize, found: &[usize]) -> ReferenceError {
        ReferenceError::TooFew { phrase: phrase.text.clone(), wanted, found: self.names(found) }
    }

    fn ambiguous(&self, phrase: &NounPhrase, candidates: &[usize]) -> ReferenceError {
        ReferenceError::Ambiguous { phrase: phrase.text.clone(), candidates: self.names(candidates) }
    }

    fn names(&self, indices: &[usize]) -> Vec<scene::InstanceId> {
        indices.iter().map(|&index| self.objects[index].name.clone()).collect()
    }
}

fn region_of(direction: Direction) -> Region {
    match direction {
        Direction::Left => Region { x: -1, y: 0 },
        Direction::Right => Region { x: 1, y: 0 },
        Direction::Front => Region { x: 0, y: -1 },
        _ => Region { x: 0, y: 1 },
    }
}
