//! The memory that request bodies in flight may take together, in blocks.
//!
//! A reader reserves blocks for bytes that have arrived, so that an upload that stalls holds what it sent and no more.
//! Where no block is left, the request is refused: waiting for memory would hold the memory it already has.

use std::sync::Arc;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::admission::overloaded;
use crate::problem::Problem;

/// Bytes of one block.
const BLOCK_BYTES: usize = 4096;

/// The budget; clones share it.
#[derive(Clone, Debug)]
pub struct BodyMemory {
    blocks: Arc<Semaphore>,
    total: usize,
}

impl BodyMemory {
    pub fn new(bytes: usize) -> Self {
        let total = (bytes / BLOCK_BYTES).clamp(1, Semaphore::MAX_PERMITS);
        Self { blocks: Arc::new(Semaphore::new(total)), total }
    }

    /// A reservation of nothing, to be grown.
    pub fn reservation(&self) -> Reservation {
        Reservation { memory: Some(self.clone()), permit: None }
    }

    fn report(&self) {
        let used = (self.total - self.blocks.available_permits()) * BLOCK_BYTES;
        metrics::gauge!("tabletopgen_body_memory_bytes").set(used as f64);
    }
}

/// A part of the budget; dropping it gives it back. The default holds nothing and has no budget, for bodies that come
/// from no client.
#[derive(Debug, Default)]
pub struct Reservation {
    memory: Option<BodyMemory>,
    permit: Option<OwnedSemaphorePermit>,
}

impl Reservation {
    /// Makes the reservation large enough for `bytes` in all.
    ///
    /// # Errors
    ///
    /// The [`Problem`] `overloaded` where the budget is used up; the reservation stays as it is.
    pub fn grow_to(&mut self, bytes: usize) -> Result<(), Problem> {
        let Some(memory) = &self.memory else { return Ok(()) };
        let missing = bytes.div_ceil(BLOCK_BYTES).saturating_sub(self.blocks());
        if missing == 0 {
            return Ok(());
        }
        let count = u32::try_from(missing).map_err(|_| overloaded())?;
        let more = memory.blocks.clone().try_acquire_many_owned(count).map_err(|_| overloaded())?;
        match &mut self.permit {
            Some(permit) => permit.merge(more),
            None => self.permit = Some(more),
        }
        memory.report();
        Ok(())
    }

    /// Gives back what exceeds `bytes`.
    pub fn shrink_to(&mut self, bytes: usize) {
        let excess = self.blocks().saturating_sub(bytes.div_ceil(BLOCK_BYTES));
        drop(self.permit.as_mut().and_then(|permit| permit.split(excess)));
        if let Some(memory) = &self.memory {
            memory.report();
        }
    }

    /// Reserved bytes.
    pub fn bytes(&self) -> usize {
        self.blocks() * BLOCK_BYTES
    }

    fn blocks(&self) -> usize {
        self.permit.as_ref().map_or(0, OwnedSemaphorePermit::num_permits)
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        if self.permit.take().is_some()
            && let Some(memory) = &self.memory
        {
            memory.report();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reservations_share_one_budget_and_give_it_back() {
        let memory = BodyMemory::new(10 * BLOCK_BYTES);
        let (mut one, mut other) = (memory.reservation(), memory.reservation());
        one.grow_to(6 * BLOCK_BYTES - 1).expect("fits");
        one.grow_to(BLOCK_BYTES).expect("it has more already");
        assert_eq!(one.bytes(), 6 * BLOCK_BYTES);
        assert_eq!(other.grow_to(5 * BLOCK_BYTES).expect_err("is too much").code, "overloaded");
        other.grow_to(4 * BLOCK_BYTES).expect("fits");
        one.shrink_to(1);
        assert_eq!(one.bytes(), BLOCK_BYTES);
        other.grow_to(9 * BLOCK_BYTES).expect("was given back");
        drop((one, other));
        assert_eq!(memory.blocks.available_permits(), 10);
        Reservation::default().grow_to(usize::MAX).expect("has no budget");
    }
}
