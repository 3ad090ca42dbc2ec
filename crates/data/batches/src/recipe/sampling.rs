//! Distinct numbers below a limit, drawn with a seed: the algorithm of Floyd (Bentley and Floyd, "A sample of
//! brilliance", 1987), then a shuffle. Memory and time depend on the number of draws alone.

use std::collections::BTreeSet;

use rand::RngExt;
use runtime::seed::child_rng;

/// `count` distinct numbers below `total`, in random order; `count` is at most `total`.
pub(super) fn distinct_below(total: u64, count: u64, seed: u64) -> Vec<u64> {
    let mut rng = child_rng(seed, "recipe sample");
    let mut chosen = BTreeSet::new();
    let mut drawn = Vec::with_capacity(count as usize);
    for limit in total - count..total {
        let number = rng.random_range(0..=limit);
        // Numbers drawn before are below the limit, so the limit itself is free.
        let number = if chosen.insert(number) { number } else { limit };
        chosen.insert(number);
        drawn.push(number);
    }
    for last in (1..drawn.len()).rev() {
        drawn.swap(last, rng.random_range(0..=last as u64) as usize);
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_distinct_and_below_the_total() {
        for (total, count) in [(1, 1), (10, 10), (10, 3), (u64::MAX, 1000), (5, 0)] {
            let drawn = distinct_below(total, count, 7);
            let set: BTreeSet<u64> = drawn.iter().copied().collect();
            assert_eq!((drawn.len() as u64, set.len() as u64), (count, count), "{total}");
            assert!(set.iter().all(|number| *number < total));
            assert_eq!(drawn, distinct_below(total, count, 7));
        }
        assert_ne!(distinct_below(1000, 20, 1), distinct_below(1000, 20, 2));
    }

    #[test]
    fn every_number_is_drawn_about_as_often_in_every_place() {
        let mut counts = [[0_u32; 6]; 3];
        for seed in 0..6000 {
            for (place, number) in distinct_below(6, 3, seed).into_iter().enumerate() {
                counts[place][number as usize] += 1;
            }
        }
        // The expectation is 1000 with a standard deviation of 29.
        assert!(counts.iter().flatten().all(|count| (850..1150).contains(count)), "{counts:?}");
    }
}
