//! Ranks, sides and sizes that pick among the objects that otherwise fit.

use super::modifier::{Modifier, Pick, label_has};
use super::phrase::{NounPhrase, Quantity};
use super::places::{Ranking, is_in_region, size_group};
use super::qualifier::{Direction, Region};
use super::selection::{Outcome, Selector};

impl Selector<'_> {
    pub fn picked(
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

    pub fn pick(
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
    pub fn center(&self, phrase: &NounPhrase, pool: &[usize]) -> Outcome<Vec<usize>> {
        let ranking = Ranking::from(self.objects, pool, Direction::Left);
        if pool.len().is_multiple_of(2) {
            return Err(self.ambiguous(phrase, pool));
        }
        ranking.ranks(pool.len() / 2, 1).map_err(|among| self.ambiguous(phrase, &among))
    }

    pub fn in_region(
        &self,
        phrase: &NounPhrase,
        pool: Vec<usize>,
        region: Region,
        plural: bool,
    ) -> Outcome<Vec<usize>> {
        // The words before fit none; the caller says so.
        if pool.is_empty() {
            return Ok(pool);
        }
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
}

fn region_of(direction: Direction) -> Region {
    match direction {
        Direction::Left => Region { x: -1, y: 0 },
        Direction::Right => Region { x: 1, y: 0 },
        Direction::Front => Region { x: 0, y: -1 },
        _ => Region { x: 0, y: 1 },
    }
}
