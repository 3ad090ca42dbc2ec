//! What every long computation needs from the process: cancellation, one bounded CPU pool, and child seeds.
//!
//! The crate knows no domain type. It must not depend on any other crate of the workspace.

pub mod cpu;
pub mod interrupt;
pub mod seed;

pub use cpu::{Cpu, Died, panic_text};
pub use interrupt::{Interrupt, Interrupted};
