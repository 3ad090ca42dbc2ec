//! JSON schemas of bounded numbers, for fields with `#[schemars(with = "Fraction")]`.

use schemars::JsonSchema;

/// A share.
#[derive(JsonSchema)]
pub struct Fraction(#[schemars(range(min = 0.0, max = 1.0))] pub f64);

/// A number above zero.
#[derive(JsonSchema)]
pub struct Positive(#[schemars(extend("exclusiveMinimum" = 0))] pub f64);
