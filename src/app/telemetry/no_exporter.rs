//! In place of the exporter in a program that was built without the feature `otel`: it starts none.

use tracing_subscriber::layer::Identity;

use super::TelemetryError;
use crate::config::TelemetrySettings;

/// An exporter that cannot exist.
pub enum Traces {}

impl Traces {
    /// `None` where no endpoint is set.
    ///
    /// # Errors
    ///
    /// An endpoint is set.
    pub fn start(settings: &TelemetrySettings) -> Result<Option<Self>, TelemetryError> {
        if settings.traces_endpoint.trim().is_empty() { Ok(None) } else { Err(TelemetryError::NotBuilt) }
    }

    /// The layer that would hand spans to the exporter.
    pub fn layer<S>(&self) -> Identity {
        match *self {}
    }
}
