//! Which rotation costs least, and what the best with another up direction costs, with few looks at colors.
//!
//! Branch and bound: silhouettes alone bound an up direction's cost from below. Up directions are looked at
//! in the order of these bounds; one whose bound is above the second-best cost found needs no look. The two
//! costs are those that looking at everything would give, to the bit.

use runtime::Interrupted;

/// Costs of the rotations that share an up direction, without the picture's.
pub struct Candidates {
    /// Rotation, its extent cost, its weighted example cost with that of what was told.
    pub rotations: Vec<(usize, f64, f64)>,
    /// What the picture's cost is at least; `None` where nobody is to look.
    pub least_picture_cost: Option<f64>,
}

/// A rotation and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    pub rotation: usize,
    pub cost: f64,
}

impl Candidates {
    /// The best of them if the picture's cost is that.
    fn best(&self, picture_cost: f64) -> Placed {
        self.rotations
            .iter()
            .map(|&(rotation, extent, example)| Placed { rotation, cost: extent + picture_cost + example })
            .fold(Placed { rotation: 0, cost: f64::INFINITY }, least)
    }
}

fn least(a: Placed, b: Placed) -> Placed {
    if b.cost < a.cost || (b.cost == a.cost && b.rotation < a.rotation) { b } else { a }
}

/// The best rotation and the best with another up direction than its; the latter costs infinity where there
/// is none. `look` gives the picture's cost of an up direction, exact where the predicate holds for it (it
/// holds for every cost below one it holds for). An up direction nobody is to look at is as bad as the worst
/// of the others.
pub fn best_two(
    ups: &[Candidates],
    look: impl Fn(usize, &dyn Fn(f64) -> bool) -> Result<f64, Interrupted>,
) -> Result<[Placed; 2], Interrupted> {
    let mut known: Vec<Option<f64>> = vec![None; ups.len()];
    let mut order: Vec<(usize, f64)> = ups
        .iter()
        .enumerate()
        .filter_map(|(k, up)| up.least_picture_cost.map(|least_cost| (k, up.best(least_cost).cost)))
        .collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    for &(up, least_cost) in &order {
        let second = two_of(ups, &known)[1].cost;
        if least_cost > second {
            break;
        }
        let matters = |picture_cost: f64| ups[up].best(picture_cost).cost <= second;
        known[up] = Some(look(up, &matters)?).filter(|cost| matters(*cost));
    }
    // What nobody is to look at is at least as bad as the worst bound.
    let worst = |known: &[Option<f64>]| {
        ups.iter().zip(known).filter_map(|(up, known)| known.or(up.least_picture_cost)).fold(0.0, f64::max)
    };
    let found = two_of(ups, &known);
    let hopeless = |up: &&Candidates| up.least_picture_cost.is_none();
    if ups.iter().filter(hopeless).any(|up| up.best(worst(&known)).cost <= found[1].cost) {
        for &(up, _) in &order {
            if known[up].is_none() {
                known[up] = Some(look(up, &|_| true)?);
            }
        }
        let worst = worst(&known);
        known.iter_mut().for_each(|cost| *cost = cost.or(Some(worst)));
        return Ok(two_of(ups, &known));
    }
    Ok(found)
}

/// The best of those whose picture cost is known, and the best with another up direction.
fn two_of(ups: &[Candidates], known: &[Option<f64>]) -> [Placed; 2] {
    let none = Placed { rotation: 0, cost: f64::INFINITY };
    ups.iter().zip(known).filter_map(|(up, cost)| cost.map(|cost| up.best(cost))).fold(
        [none, none],
        |[first, second], next| {
            if least(first, next) == next { [next, first] } else { [first, least(second, next)] }
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn equals_looking_at_everything(
            costs in proptest::collection::vec((0..8_u32, 0..8_u32, 0..8_u32, proptest::bool::ANY), 6),
        ) {
            let cost = |k: u32| 0.125 * f64::from(k);
            let ups: Vec<Candidates> = (0..6)
                .map(|up| {
                    let (extent, silhouette, example, looked_at) = costs[up];
                    let first = (2 * up, cost(extent), cost(example));
                    let second = (2 * up + 1, cost(silhouette), cost(extent));
                    let least_picture_cost = looked_at.then_some(cost(silhouette));
                    Candidates { rotations: vec![first, second], least_picture_cost }
                })
                .collect();
            let picture_cost = |up: usize| cost(costs[up].1 + (costs[up].0 * 3 + costs[up].2) % 4);
            let look = |up: usize, matters: &dyn Fn(f64) -> bool| {
                let exact = picture_cost(up);
                Ok(if matters(exact) { exact } else { exact + 1.0 })
            };
            let seen = (0..6).filter(|&up| costs[up].3).map(picture_cost);
            let worst = seen.fold(0.0, f64::max);
            let mut all: Vec<(f64, usize)> = (0..6)
                .flat_map(|up| {
                    let picture = if costs[up].3 { picture_cost(up) } else { worst };
                    ups[up].rotations.iter().map(move |r| (r.1 + picture + r.2, r.0)).collect::<Vec<_>>()
                })
                .collect();
            all.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            let other = all.iter().find(|o| o.1 / 2 != all[0].1 / 2).expect("six");
            let [best, second] = best_two(&ups, look).expect("not interrupted");
            prop_assert_eq!((best.cost, best.rotation), all[0]);
            prop_assert_eq!(second.cost, other.0);
        }
    }
}
