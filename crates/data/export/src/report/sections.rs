//! The tables of the page.

pub mod text;
pub mod checks;
pub mod objects;
pub mod bodies;
pub mod likeness;
pub mod appraisal;
pub mod robot;
pub mod clutter;
pub mod formats;
pub mod provenance;
