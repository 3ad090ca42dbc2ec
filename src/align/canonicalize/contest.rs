//! Which rotation costs least, and what the best with another up direction costs, with few looks at colors.
//!
//! Branch and bound: silhouettes alone bound an up direction's cost from below. Up directions are looked at
//! in the order of these bounds; one whose bound is above the second-best cost found needs no look. The two
//! costs are those that looking at everything would give, to the bit.

use super::evidence::Standing;
use crate::geometry::Interrupted;

/// Costs of the rotations that share an up direction, without the picture's.
pub struct Candidates {
    /// Rotation, its extent cost, its weighted example cost.
    pub rotations: Vec<(usize, f64, f64)>,
    /// Where the extents leave the up direction possible.
    pub standing: Option<Standing>,
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
/// is none. `look` gives the picture's cost, exact where the predicate holds for it (it holds for every cost
/// below one it holds for). An up direction nobody looked at is as bad as the worst that was seen.
pub fn best_two(
    ups: &[Candidates],
    look: impl Fn(&Standing, &dyn Fn(f64) -> bool) -> Result<f64, Interrupted>,
) -> Result<[Placed; 2], Interrupted> {
    let mut known: Vec<Option<f64>> = vec![None; ups.len()];
    let bound = |up: usize, known: &[Option<f64>]| {
        known[up].or_else(|| ups[up].standing.as_ref().map(Standing::least_cost))
    };
    let mut order: Vec<(usize, f64)> = (0..ups.len())
        .filter_map(|up| bound(up, &known).map(|least_cost| (up, ups[up].best(least_cost).cost)))
        .collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    for &(up, least_cost) in &order {
        let second = two_of(ups, &known)[1].cost;
        if least_cost > second {
            break;
        }
        let matters = |picture_cost: f64| ups[up].best(picture_cost).cost <= second;
        if let Some(standing) = &ups[up].standing {
            known[up] = Some(look(standing, &matters)?).filter(|cost| matters(*cost));
        }
    }
    // What was not seen is at least as bad as the worst bound.
    let worst = |known: &[Option<f64>]| (0..ups.len()).filter_map(|up| bound(up, known)).fold(0.0, f64::max);
    let found = two_of(ups, &known);
    let unseen = |up: &&Candidates| up.standing.is_none();
    if ups.iter().filter(unseen).any(|up| up.best(worst(&known)).cost <= found[1].cost) {
        for (up, known) in ups.iter().zip(&mut known) {
            if let (Some(standing), None) = (&up.standing, &known) {
                *known = Some(look(standing, &|_| true)?);
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
