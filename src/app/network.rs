//! Which network reads pictures, if any; its weights are read once, when the program starts.

use std::path::Path;
use std::sync::Arc;

use crate::config::{ConfigError, ConfigErrors, Resolved};
use crate::provider::embedded::photograph::ReadingNetwork;

/// The configured one.
pub fn load(resolved: &Resolved) -> Result<Option<Arc<ReadingNetwork>>, ConfigErrors> {
    let settings = &resolved.config.network;
    if settings.weights.is_empty() {
        return Ok(None);
    }
    let network = ReadingNetwork::load(Path::new(&settings.weights), settings.reading.clone());
    network.map(Some).map_err(|error| {
        let (key, detail) = ("network.weights", error.to_string());
        ConfigErrors(vec![ConfigError { key: key.to_owned(), origin: resolved.origin(key).clone(), detail }])
    })
}
