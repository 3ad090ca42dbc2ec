//! The rotation of minimum cost and the best one with another up direction, with few color evaluations.
//!
//! Branch and bound: silhouettes alone bound an up direction's cost from below. Up directions are evaluated in the
//! order of these bounds; one whose bound is above the second-best cost found is skipped. The two costs equal those of
//! an exhaustive evaluation, to the bit.

use runtime::Cancelled;

/// Costs of the rotations that share an up direction, without the image cost.
pub struct Candidates {
    /// Rotation, its extent cost, its weighted example cost plus hint cost.
    pub rotations: Vec<(usize, f64, f64)>,
    /// Lower bound on the image cost; `None` for an up direction that is not evaluated.
    pub min_image_cost: Option<f64>,
}

/// A rotation and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankedRotation {
    pub rotation: usize,
    pub cost: f64,
}

impl Candidates {
    /// The best of the rotations for a given image cost.
    fn best(&self, image_cost: f64) -> RankedRotation {
        self.rotations
            .iter()
            .map(|&(rotation, extent, example)| RankedRotation {
                rotation,
                cost: extent + image_cost + example,
            })
            .fold(RankedRotation { rotation: 0, cost: f64::INFINITY }, lowest)
    }
}

fn lowest(a: RankedRotation, b: RankedRotation) -> RankedRotation {
    if b.cost < a.cost || (b.cost == a.cost && b.rotation < a.rotation) { b } else { a }
}

/// The best rotation and the best one with another up direction; the latter costs infinity if there is none.
/// `evaluate` gives the image cost of an up direction, exact where the predicate holds for it (the predicate holds for
/// every cost below one it holds for). An up direction that is not evaluated gets the worst cost of the others.
pub fn best_two(
    ups: &[Candidates],
    evaluate: impl Fn(usize, &dyn Fn(f64) -> bool) -> Result<f64, Cancelled>,
) -> Result<[RankedRotation; 2], Cancelled> {
    let mut known: Vec<Option<f64>> = vec![None; ups.len()];
    let mut order: Vec<(usize, f64)> = ups
        .iter()
        .enumerate()
        .filter_map(|(k, up)| up.min_image_cost.map(|min_cost| (k, up.best(min_cost).cost)))
        .collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    for &(up, min_cost) in &order {
        let second = two_of(ups, &known)[1].cost;
        if min_cost > second {
            break;
        }
        let matters = |image_cost: f64| ups[up].best(image_cost).cost <= second;
        known[up] = Some(evaluate(up, &matters)?).filter(|cost| matters(*cost));
    }
    // An up direction that is not evaluated costs at least the worst bound.
    let worst = |known: &[Option<f64>]| {
        ups.iter().zip(known).filter_map(|(up, known)| known.or(up.min_image_cost)).fold(0.0, f64::max)
    };
    let found = two_of(ups, &known);
    let hopeless = |up: &&Candidates| up.min_image_cost.is_none();
    if ups.iter().filter(hopeless).any(|up| up.best(worst(&known)).cost <= found[1].cost) {
        for &(up, _) in &order {
            if known[up].is_none() {
                known[up] = Some(evaluate(up, &|_| true)?);
            }
        }
        let worst = worst(&known);
        known.iter_mut().for_each(|cost| *cost = cost.or(Some(worst)));
        return Ok(two_of(ups, &known));
    }
    Ok(found)
}

/// The best of the up directions with a known image cost, and the best with another up direction.
fn two_of(ups: &[Candidates], known: &[Option<f64>]) -> [RankedRotation; 2] {
    let none = RankedRotation { rotation: 0, cost: f64::INFINITY };
    ups.iter().zip(known).filter_map(|(up, cost)| cost.map(|cost| up.best(cost))).fold(
        [none, none],
        |[first, second], next| {
            if lowest(first, next) == next { [next, first] } else { [first, lowest(second, next)] }
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn best_two_equals_exhaustive_evaluation(
            costs in proptest::collection::vec((0..8_u32, 0..8_u32, 0..8_u32, proptest::bool::ANY), 6),
        ) {
            let cost = |k: u32| 0.125 * f64::from(k);
            let ups: Vec<Candidates> = (0..6)
                .map(|up| {
                    let (extent, silhouette, example, evaluated) = costs[up];
                    let first = (2 * up, cost(extent), cost(example));
                    let second = (2 * up + 1, cost(silhouette), cost(extent));
                    let min_image_cost = evaluated.then_some(cost(silhouette));
                    Candidates { rotations: vec![first, second], min_image_cost }
                })
                .collect();
            let image_cost = |up: usize| cost(costs[up].1 + (costs[up].0 * 3 + costs[up].2) % 4);
            let evaluate = |up: usize, matters: &dyn Fn(f64) -> bool| {
                let exact = image_cost(up);
                Ok(if matters(exact) { exact } else { exact + 1.0 })
            };
            let seen = (0..6).filter(|&up| costs[up].3).map(image_cost);
            let worst = seen.fold(0.0, f64::max);
            let mut all: Vec<(f64, usize)> = (0..6)
                .flat_map(|up| {
                    let image = if costs[up].3 { image_cost(up) } else { worst };
                    ups[up].rotations.iter().map(move |r| (r.1 + image + r.2, r.0)).collect::<Vec<_>>()
                })
                .collect();
            all.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            let other = all.iter().find(|o| o.1 / 2 != all[0].1 / 2).expect("six");
            let [best, second] = best_two(&ups, evaluate).expect("not interrupted");
            prop_assert_eq!((best.cost, best.rotation), all[0]);
            prop_assert_eq!(second.cost, other.0);
        }
    }
}
