//! Deletion of scenes, datasets, batches and recordings on request. It marks a row and cancels the work on it; the next
//! sweeps remove what belongs to the row, and at last the row itself (see [`crate::retention`]).

/// Result of a deletion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeleteOutcome {
    /// Deleted, now or earlier.
    Done,
    NotFound,
}
