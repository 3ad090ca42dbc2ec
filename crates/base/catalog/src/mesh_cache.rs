//! A small cache of recently built meshes.
//!
//! The image generator, the mesh generator and the analyst's examples build each mesh of a scene two or three times.
//! Building is a pure function of the key, so results are the same with and without the cache.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use serde::Serialize;

/// Maximum number of entries; a mesh with its textures takes about 1 to 3 MB.
const CAPACITY: usize = 64;

/// Least recently used cache, by the serialized key.
pub(super) struct Cache<T> {
    entries: Mutex<Entries<T>>,
}

struct Entries<T> {
    by_key: BTreeMap<String, Entry<T>>,
    /// Counts accesses.
    now: u64,
}

struct Entry<T> {
    value: Arc<T>,
    used_at: u64,
}

impl<T> Cache<T> {
    pub(super) const fn empty() -> Self {
        Self { entries: Mutex::new(Entries { by_key: BTreeMap::new(), now: 0 }) }
    }

    /// The cached value for the key, or the result of `build`. Concurrent callers with the same key may both build;
    /// neither waits for the other.
    pub(super) fn get(&self, key: &impl Serialize, build: impl FnOnce() -> Option<T>) -> Option<Arc<T>> {
        // Floats are written so that they round-trip: equal texts are equal keys.
        let Ok(key) = serde_json::to_string(key) else { return build().map(Arc::new) };
        if let Some(value) = self.find(&key) {
            return Some(value);
        }
        let value = Arc::new(build()?);
        self.insert(key, value.clone());
        Some(value)
    }

    fn find(&self, key: &str) -> Option<Arc<T>> {
        let mut entries = self.entries.lock().ok()?;
        let entries = &mut *entries;
        entries.now += 1;
        let entry = entries.by_key.get_mut(key)?;
        entry.used_at = entries.now;
        Some(entry.value.clone())
    }

    fn insert(&self, key: String, value: Arc<T>) {
        let Ok(mut entries) = self.entries.lock() else { return };
        entries.now += 1;
        let used_at = entries.now;
        entries.by_key.insert(key, Entry { value, used_at });
        if entries.by_key.len() > CAPACITY {
            let oldest = entries.by_key.iter().min_by_key(|(_, entry)| entry.used_at);
            if let Some(key) = oldest.map(|(key, _)| key.clone()) {
                entries.by_key.remove(&key);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cache_builds_each_key_once_and_evicts_the_oldest_access() {
        let cache: Cache<usize> = Cache::empty();
        let built = std::cell::Cell::new(0);
        let order = |number: usize| {
            cache.get(&number, || {
                built.set(built.get() + 1);
                Some(number)
            })
        };
        (0..CAPACITY).for_each(|number| assert_eq!(order(number).as_deref(), Some(&number)));
        (0..CAPACITY).for_each(|number| assert_eq!(order(number).as_deref(), Some(&number)));
        assert_eq!(built.get(), CAPACITY);
        // Number 0 was just used again, so number 1 is evicted.
        order(0);
        order(CAPACITY);
        assert_eq!(built.get(), CAPACITY + 1);
        order(0);
        assert_eq!(built.get(), CAPACITY + 1);
        order(1);
        assert_eq!(built.get(), CAPACITY + 2);
        assert_eq!(cache.get(&"nothing", || None), None);
    }
}
