//! What is wrong with a configuration: all of it at once, each with its key and where it came from.

use std::fmt;

use super::Origin;

/// One complaint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// `section.key` as it was given; empty when a whole file is at fault.
    pub key: String,
    /// Where it was said.
    pub origin: Origin,
    /// What is wrong with it, and what would do.
    pub detail: String,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.key.as_str() {
            "" => write!(f, "{}: {}", self.origin, self.detail),
            key => write!(f, "{key} ({}): {}", self.origin, self.detail),
        }
    }
}

/// Why a configuration will not do; at least one complaint.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ConfigErrors(pub Vec<ConfigError>);

impl fmt::Display for ConfigErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{error}")?;
        }
        Ok(())
    }
}
