//! Which network reads pictures; its weights are read once, when the program starts.

use std::path::Path;
use std::sync::Arc;

use crate::config::{ConfigError, ConfigErrors, Resolved};
use embedded::photograph::ReadingNetwork;

/// The one that comes with the program.
const BUILT_IN: &str = "built-in";

/// The configured one; `None` = pictures are read by classical means.
pub fn load(resolved: &Resolved) -> Result<Option<Arc<ReadingNetwork>>, ConfigErrors> {
    let settings = &resolved.config.network;
    let network = match settings.weights.as_str() {
        "" => return Ok(None),
        BUILT_IN => ReadingNetwork::built_in(settings.reading.clone()),
        path => ReadingNetwork::load(Path::new(path), settings.reading.clone()),
    };
    network.map(Some).map_err(|error| {
        let (key, detail) = ("network.weights", error.to_string());
        ConfigErrors(vec![ConfigError { key: key.to_owned(), origin: resolved.origin(key).clone(), detail }])
    })
}
