//! Names of the splits of synthetic images.

use clap::ValueEnum;

use crate::synthetic_images::Split;

/// A split, as options name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SplitName {
    Training,
    Validation,
    Test,
}

impl From<SplitName> for Split {
    fn from(name: SplitName) -> Self {
        match name {
            SplitName::Training => Self::Training,
            SplitName::Validation => Self::Validation,
            SplitName::Test => Self::Test,
        }
    }
}
