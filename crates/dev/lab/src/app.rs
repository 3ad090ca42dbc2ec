//! Wiring of the lab commands.

pub mod mock_vendors;
pub mod evaluation;
