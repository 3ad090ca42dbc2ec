//! The wiring of the laboratory's commands.

pub mod dev_providers;
pub mod evaluation;
