//! Amounts of money in whole millionths of a US dollar.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Millionths of a US dollar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct MicroUsd(pub i64);

impl MicroUsd {
    pub const ZERO: Self = Self(0);

    /// Converts an amount in dollars, rounding up.
    pub fn of_usd(usd: f64) -> Self {
        // The subtrahend removes the rounding error of amounts such as 0.07.
        Self((usd * 1e6 - 1e-6).ceil().clamp(0.0, 9e15) as i64)
    }

    /// In dollars.
    pub fn usd(self) -> f64 {
        self.0 as f64 / 1e6
    }
}

impl fmt::Display for MicroUsd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "${}.{:06}", self.0 / 1_000_000, (self.0 % 1_000_000).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_usd_rounds_up_to_millionths() {
        assert_eq!(MicroUsd::of_usd(0.07), MicroUsd(70_000));
        assert_eq!(MicroUsd::of_usd(0.000_000_4), MicroUsd(1));
        assert_eq!(MicroUsd::of_usd(0.0), MicroUsd::ZERO);
        assert_eq!(MicroUsd(1_500_001).to_string(), "$1.500001");
        assert!((MicroUsd(250_000).usd() - 0.25).abs() < 1e-12);
    }
}
