//! The settings of `config/default.toml`, for tests: the one source of default values outside the program itself.
//!
//! Only dev-dependencies may name this crate. It must not depend on any other crate of the workspace.
//!
//! ```
//! #[derive(serde::Deserialize)]
//! struct Sizes {
//!     supersampling: u32,
//! }
//! let render: Sizes = test_settings::section("render");
//! assert!(render.supersampling >= 1);
//! ```

use serde::de::DeserializeOwned;

const DEFAULTS: &str = include_str!("../../../../config/default.toml");

/// The section at a dotted path, for example `dro` or `providers.openai`.
///
/// # Panics
///
/// Panics with the path if the section is missing or has another shape: a test cannot go on without it.
pub fn section<T: DeserializeOwned>(path: &str) -> T {
    section_without(path, &[])
}

/// As [`section`], less the keys that belong to another struct than `T`.
///
/// # Panics
///
/// As [`section`].
pub fn section_without<T: DeserializeOwned>(path: &str, keys: &[&str]) -> T {
    let mut table: toml::Table =
        DEFAULTS.parse().unwrap_or_else(|error| panic!("config/default.toml: {error}"));
    for name in path.split('.') {
        table = match table.remove(name) {
            Some(toml::Value::Table(inner)) => inner,
            _ => panic!("config/default.toml has no section {path}"),
        };
    }
    for key in keys {
        table.remove(*key);
    }
    toml::Value::Table(table)
        .try_into()
        .unwrap_or_else(|error| panic!("config/default.toml, section {path}: {error}"))
}
