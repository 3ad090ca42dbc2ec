//! Shared helpers of the tests.

use serde_json::Value;

/// `config/default.toml`.
pub(crate) fn defaults() -> Value {
    let text = include_str!("../../../../../config/default.toml");
    serde_json::to_value(text.parse::<toml::Table>().expect("is TOML")).expect("has a JSON form")
}
