//! Things built lately, kept for the next who orders the same: the painter, the mesh generator and the
//! analyst's examples build each mesh of a scene two or three times.
//!
//! Building is a pure function of the order, so what is handed out is the same with and without stock.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use serde::Serialize;

/// At most so many things; a mesh with its textures is some 1 to 3 MB.
const SHELVES: usize = 64;

/// Things by what was ordered.
pub(super) struct Stock<T> {
    kept: Mutex<Kept<T>>,
}

struct Kept<T> {
    by_order: BTreeMap<String, Thing<T>>,
    /// Counts orders.
    now: u64,
}

struct Thing<T> {
    built: Arc<T>,
    ordered_at: u64,
}

impl<T> Stock<T> {
    pub(super) const fn empty() -> Self {
        Self { kept: Mutex::new(Kept { by_order: BTreeMap::new(), now: 0 }) }
    }

    /// What was built for the same order, or what `build` makes of it. Two who order at the same time may both
    /// build; nobody waits for another.
    pub(super) fn get(&self, order: &impl Serialize, build: impl FnOnce() -> Option<T>) -> Option<Arc<T>> {
        // Floats are written so that they read back the same: equal texts are equal orders.
        let Ok(order) = serde_json::to_string(order) else { return build().map(Arc::new) };
        if let Some(built) = self.find(&order) {
            return Some(built);
        }
        let built = Arc::new(build()?);
        self.keep(order, built.clone());
        Some(built)
    }

    fn find(&self, order: &str) -> Option<Arc<T>> {
        let mut kept = self.kept.lock().ok()?;
        let kept = &mut *kept;
        kept.now += 1;
        let thing = kept.by_order.get_mut(order)?;
        thing.ordered_at = kept.now;
        Some(thing.built.clone())
    }

    fn keep(&self, order: String, built: Arc<T>) {
        let Ok(mut kept) = self.kept.lock() else { return };
        kept.now += 1;
        let ordered_at = kept.now;
        kept.by_order.insert(order, Thing { built, ordered_at });
        if kept.by_order.len() > SHELVES {
            let longest_ago = kept.by_order.iter().min_by_key(|(_, thing)| thing.ordered_at);
            if let Some(order) = longest_ago.map(|(order, _)| order.clone()) {
                kept.by_order.remove(&order);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_order_is_built_once_and_what_was_ordered_longest_ago_goes_first() {
        let stock: Stock<usize> = Stock::empty();
        let built = std::cell::Cell::new(0);
        let order = |number: usize| {
            stock.get(&number, || {
                built.set(built.get() + 1);
                Some(number)
            })
        };
        (0..SHELVES).for_each(|number| assert_eq!(order(number).as_deref(), Some(&number)));
        (0..SHELVES).for_each(|number| assert_eq!(order(number).as_deref(), Some(&number)));
        assert_eq!(built.get(), SHELVES);
        // Number 0 was just ordered again, so number 1 makes room.
        order(0);
        order(SHELVES);
        assert_eq!(built.get(), SHELVES + 1);
        order(0);
        assert_eq!(built.get(), SHELVES + 1);
        order(1);
        assert_eq!(built.get(), SHELVES + 2);
        assert_eq!(stock.get(&"nothing", || None), None);
    }
}
