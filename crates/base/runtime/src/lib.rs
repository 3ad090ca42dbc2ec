//! Process-level utilities: cancellation, one bounded CPU pool, child seeds, digests, spelling distances
//! and error chains as text.
//!
//! The crate knows no domain type. It must not depend on any other crate of the workspace.
//!
//! ```
//! use runtime::{CancelFlag, Cancelled};
//!
//! let cancel = CancelFlag::default();
//! let worker_copy = cancel.clone();
//! assert_eq!(worker_copy.check(), Ok(()));
//! cancel.cancel();
//! assert_eq!(worker_copy.check(), Err(Cancelled));
//! ```

pub mod cancel;
pub mod cpu;
pub mod digest;
pub mod error;
pub mod seed;
pub mod spelling;

pub use cancel::{CancelFlag, Cancelled};
pub use cpu::{ComputationFailed, CpuPool, panic_text};
pub use error::error_chain;
pub use spelling::edit_distance;
