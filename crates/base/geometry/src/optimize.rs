//! Small deterministic optimizers for problems with few unknowns.
//!
//! | function | method | derivatives |
//! | --- | --- | --- |
//! | [`golden_section`] | golden-section search (Kiefer 1953) | none |
//! | [`least_squares`] | Levenberg-Marquardt (Marquardt 1963) | central differences |
//! | [`nelder_mead`] | simplex method (Nelder and Mead 1965) | none |
//! | [`pattern_search`] | coordinate pattern search (Hooke and Jeeves 1961) | none |
//!
//! All of them are local. None uses a random number: equal inputs give equal bits.

mod golden_section;
mod levenberg_marquardt;
mod nelder_mead;
mod pattern_search;

pub use golden_section::{golden_section, local_minima};
pub use levenberg_marquardt::least_squares;
pub use nelder_mead::nelder_mead;
pub use pattern_search::pattern_search;
