//! Loads the network that reads images. Weights of a file are read at start, those of the program with the first image.

use std::path::Path;
use std::sync::Arc;

use crate::config::{ConfigError, ConfigErrors, Resolved};
use embedded::single_view_reconstruction::ReadingNetwork;

/// Names the weights that come with the program.
const BUILT_IN: &str = "built-in";

/// The configured network.
///
/// # Errors
///
/// A [`ConfigErrors`] of `network.weights` if the file cannot be read or does not hold such a network.
pub fn load(resolved: &Resolved) -> Result<Arc<ReadingNetwork>, ConfigErrors> {
    let settings = &resolved.config.network;
    let network = match settings.weights.as_str() {
        BUILT_IN => return Ok(ReadingNetwork::built_in(settings.reading.clone())),
        path => ReadingNetwork::load(Path::new(path), settings.reading.clone()),
    };
    network.map_err(|error| {
        let (key, detail) = ("network.weights", error.to_string());
        ConfigErrors(vec![ConfigError { key: key.to_owned(), origin: resolved.origin(key).clone(), detail }])
    })
}
