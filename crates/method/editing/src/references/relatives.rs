//! Qualifiers after a noun, as a filter: relations to other objects, places on the table.

use super::modifier::{of_color, of_material};
use super::phrase::{NounPhrase, Quantity};
use super::places::{Ranking, is_between, is_related, rests_on};
use super::qualifier::{Direction, Qualifier};
use super::selection::{Outcome, Selector};
use language::vocabulary::color_of;
use scene::RelationKind;

impl Selector<'_> {
    /// The objects of a color, or of a material.
    fn of_appearance(&self, pool: &[usize], words: &str) -> Vec<usize> {
        let is_color = color_of(words).is_some();
        if is_color {
            of_color(self.objects, pool, words).1
        } else {
            of_material(self.objects, pool, words).1
        }
    }

    pub fn qualified(
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
            Qualifier::Appearance(words) => Ok(self.of_appearance(&pool, words)),
            Qualifier::NotAppearance(words) => {
                let of = self.of_appearance(&pool, words);
                Ok(keep(&|index| !of.contains(&index)))
            }
            Qualifier::In(region) => self.in_region(phrase, pool, *region, plural),
            Qualifier::Outermost(direction) => self.outermost(phrase, &pool, *direction),
            Qualifier::OnTable => {
                let direct = keep(&|index| objects[index].supporter.parent.is_none());
                let all = phrase.quantity == Quantity::All || direct.is_empty();
                Ok(if all { pool } else { direct })
            }
            Qualifier::Related(kind, target) => {
                let targets = self.targets(target)?;
                let related = |index, wide| {
                    targets.iter().any(|&target| is_related(objects, index, *kind, target, wide))
                };
                let (strict, wide) =
                    (keep(&|index| related(index, false)), keep(&|index| related(index, true)));
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

    /// As many objects as the phrase counts that are farthest in a direction.
    fn outermost(&self, phrase: &NounPhrase, pool: &[usize], direction: Direction) -> Outcome<Vec<usize>> {
        let count = match phrase.quantity {
            Quantity::Count(count) => count,
            Quantity::Both => 2,
            _ => 1,
        };
        let ranking = Ranking::from(self.objects, pool, direction);
        if ranking.order.len() < count {
            return Err(self.too_few(phrase, count, pool));
        }
        ranking.ranks(0, count).map_err(|among| self.ambiguous(phrase, &among))
    }

    /// Everything that the target of a relation may be: in "the spoon in the mug" the spoon tells which mug is meant.
    pub fn targets(&self, target: &NounPhrase) -> Outcome<Vec<usize>> {
        match target.quantity {
            Quantity::Open | Quantity::One => Ok(self.fit(target, &self.all())?.indices),
            _ => self.select(target, &self.all()),
        }
    }
}
