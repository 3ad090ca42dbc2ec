//! Seeded child generators: every stage and every instance draws from its own random stream.
//!
//! A child seed depends on the parent seed and on a *name*, never on a position in a list, so adding
//! one object to a scene does not change the random numbers of the others.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sha2::{Digest, Sha256};

/// The one generator type of the program. It is portable: a seed gives the same bytes on every platform.
pub type Rng = ChaCha8Rng;

/// Seed of the child stream `name` of the stream `parent`; stable across releases.
pub fn child_seed(parent: u64, name: &str) -> u64 {
    let digest = Sha256::new().chain_update(parent.to_le_bytes()).chain_update(name.as_bytes()).finalize();
    let mut first_eight = [0_u8; 8];
    first_eight.copy_from_slice(&digest[..8]);
    u64::from_le_bytes(first_eight)
}

/// Generator of the child stream `name` of the stream `parent`.
pub fn child_rng(parent: u64, name: &str) -> Rng {
    Rng::seed_from_u64(child_seed(parent, name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn child_seeds_repeat_and_differ_by_name_and_parent() {
        assert_eq!(child_seed(7, "mug_1"), child_seed(7, "mug_1"));
        assert_ne!(child_seed(7, "mug_1"), child_seed(7, "mug_2"));
        assert_ne!(child_seed(7, "mug_1"), child_seed(8, "mug_1"));
    }
}
