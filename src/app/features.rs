//! Adapter of the feature port: weights are read once, when the program starts, and shared by all jobs.

use std::path::Path;
use std::sync::Arc;

use crate::config::{ConfigError, ConfigErrors, Resolved};
use embedded::dinov2::Dinov2FeatureExtractor;
use ports::feature_extractor::FeatureAdapter;
use ports::{FeatureExtractor, Ports};

/// Adapter that the configuration chose.
#[derive(Clone)]
pub enum Features {
    /// The descriptor among the embedded adapters, with the settings of each request.
    Descriptor,
    /// An adapter with weights, which no request changes.
    Loaded(Arc<dyn FeatureExtractor>),
}

impl Features {
    /// Reads the weights, if there are any to read.
    pub fn load(resolved: &Resolved) -> Result<Self, ConfigErrors> {
        let settings = &resolved.config.features;
        match settings.adapter {
            FeatureAdapter::Descriptor => Ok(Self::Descriptor),
            FeatureAdapter::Dinov2 => match Dinov2FeatureExtractor::load(Path::new(&settings.weights)) {
                Ok(extractor) => Ok(Self::Loaded(Arc::new(extractor))),
                Err(error) => {
                    let (key, detail) = ("features.weights", error.to_string());
                    let origin = resolved.origin(key).clone();
                    Err(ConfigErrors(vec![ConfigError { key: key.to_owned(), origin, detail }]))
                }
            },
        }
    }

    /// The ports with this one in its place.
    pub fn answer(&self, ports: Ports) -> Ports {
        match self {
            Self::Descriptor => ports,
            Self::Loaded(extractor) => Ports { feature_extractor: extractor.clone(), ..ports },
        }
    }
}
