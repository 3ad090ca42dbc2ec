//! Who reads pictures: a network where there are weights, classical vision where there are none.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;
use sha2::{Digest as _, Sha256};

use super::PhotographSettings;
use super::recent::{PictureKey, RecentReadings};
use imaging::Image;
use ports::{Port, ProviderError};
use runtime::Interrupt;
use vision::network::{NetworkWeightsError, TableNetwork};
use vision::{
    CandidateRegions, NetworkReadingSettings, PictureReading, VisionError, candidate_regions, read_picture,
    read_with_network,
};

/// A network, the digest of its weights, and how its answers are read.
pub struct ReadingNetwork {
    network: TableNetwork,
    sha256: String,
    settings: NetworkReadingSettings,
}

/// Why there is no network.
#[derive(Debug, thiserror::Error)]
pub enum LoadNetworkError {
    #[error("cannot read {}: {source}; name a file that training/train.py wrote, or none", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("cannot use the weights {}: {source}", path.display())]
    Unusable { path: PathBuf, source: NetworkWeightsError },
}

/// The weights that come with the program (`weights/README.md`).
const BUILT_IN: &[u8] = include_bytes!("../../../../weights/table_network.safetensors");

impl ReadingNetwork {
    /// The one that comes with the program.
    pub fn built_in(settings: NetworkReadingSettings) -> Result<Arc<Self>, LoadNetworkError> {
        let path = PathBuf::from("built-in");
        Self::read(BUILT_IN.to_vec(), settings)
            .map(Arc::new)
            .map_err(|source| LoadNetworkError::Unusable { path, source })
    }

    /// From a file that `training/train.py` wrote.
    pub fn load(path: &Path, settings: NetworkReadingSettings) -> Result<Arc<Self>, LoadNetworkError> {
        let unreadable = |source| LoadNetworkError::Unreadable { path: path.to_owned(), source };
        let unusable = |source| LoadNetworkError::Unusable { path: path.to_owned(), source };
        Self::read(std::fs::read(path).map_err(unreadable)?, settings).map(Arc::new).map_err(unusable)
    }

    fn read(safetensors: Vec<u8>, settings: NetworkReadingSettings) -> Result<Self, NetworkWeightsError> {
        let mut sha256 = String::with_capacity(64);
        for byte in Sha256::digest(&safetensors) {
            // Writing to a string cannot fail.
            let _ = write!(sha256, "{byte:02x}");
        }
        Ok(Self { network: TableNetwork::read(safetensors)?, sha256, settings })
    }
}

/// Reads pictures nobody here painted. Clones share what they have read.
#[derive(Clone)]
pub struct PictureReader {
    /// `None` = classical means.
    network: Option<Arc<ReadingNetwork>>,
    pub settings: PhotographSettings,
    recent: Arc<RecentReadings>,
}

/// What decides a reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReaderIdentity {
    #[serde(skip_serializing_if = "Option::is_none")]
    network: Option<(String, NetworkReadingSettings)>,
    #[serde(flatten)]
    settings: PhotographSettings,
}

impl PictureReader {
    /// Without a network, by classical means.
    pub fn new(network: Option<Arc<ReadingNetwork>>, settings: PhotographSettings) -> Self {
        Self { network, settings, recent: Arc::default() }
    }

    pub fn identity(&self) -> ReaderIdentity {
        let network = self.network.as_ref().map(|network| (network.sha256.clone(), network.settings.clone()));
        ReaderIdentity { network, settings: self.settings.clone() }
    }

    /// Reads the picture.
    pub fn reading(
        &self,
        picture: &Image,
        interrupt: &Interrupt,
    ) -> Result<Arc<PictureReading>, VisionError> {
        let key = PictureKey::of(picture);
        if let Some(reading) = self.recent.find(&key) {
            return Ok(reading);
        }
        let reading = Arc::new(match self.network.as_deref() {
            Some(ReadingNetwork { network, settings, .. }) => {
                read_with_network(picture, network, settings, interrupt)?
            }
            None => read_picture(picture, &self.settings.vision, interrupt)?,
        });
        self.recent.keep(key, &reading);
        Ok(reading)
    }

    /// The regions among which the network's reading chooses things; `None` where there is no network.
    pub fn candidate_regions(
        &self,
        picture: &Image,
        interrupt: &Interrupt,
    ) -> Option<Result<CandidateRegions, VisionError>> {
        let ReadingNetwork { network, settings, .. } = self.network.as_deref()?;
        Some(candidate_regions(picture, network, settings, interrupt))
    }

    /// Reads the picture for a port.
    pub(super) fn read(
        &self,
        picture: &Image,
        port: Port,
        interrupt: &Interrupt,
    ) -> Result<Arc<PictureReading>, ProviderError> {
        self.reading(picture, interrupt).map_err(|error| match error {
            VisionError::Interrupted(interrupted) => ProviderError::Interrupted(interrupted),
            other => ProviderError::Rejected { port, code: other.code(), reason: other.to_string() },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_with_the_program_can_be_loaded() {
        assert!(ReadingNetwork::built_in(test_settings::section_without("network", &["weights"])).is_ok());
    }

    #[test]
    fn what_cannot_be_loaded_is_named() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let path = folder.path().join("other.safetensors");
        let complaint = || {
            ReadingNetwork::load(&path, test_settings::section_without("network", &["weights"]))
                .err()
                .expect("is refused")
                .to_string()
        };
        assert!(
            complaint().contains("cannot read") && complaint().contains("other.safetensors: No such file")
        );
        std::fs::write(&path, "what").expect("writes");
        assert!(
            complaint().contains("other.safetensors: the file is not a safetensors file"),
            "{}",
            complaint()
        );
    }
}
