//! (in progress)

use super::Generator;

/// Name of the category and the function that builds it.
pub const GENERATORS: &[(&str, Generator)] = &[];
