//! Image reader: the table network and the object recognizer, with their settings and a cache.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use serde::Serialize;
use sha2::{Digest as _, Sha256};

use super::SingleViewSettings;
use super::reading_cache::{ImageKey, ReadingCache};
use imaging::{DepthImage, Image, Mask};
use ports::{Port, ProviderError, ReferenceImage};
use runtime::CancelFlag;
use vision::category_fit::CategoryFitSettings;
use vision::object_recognizer::{CategoryGuess, ObjectRecognizer};
use vision::table_network::TableNetwork;
use vision::{
    CandidateRegions, ImageReading, KnownCamera, NetworkError, NetworkReadingSettings, NetworkWeightsError,
    VisionError, candidate_regions, read_with_network,
};

/// The table network and the object recognizer, the digest of their weights, and the settings of the reader.
pub struct ReadingNetwork {
    /// Bytes of the table network.
    weights: Cow<'static, [u8]>,
    /// Read with the first image: scenes of texts need none.
    networks: OnceLock<Networks>,
    sha256: String,
    settings: NetworkReadingSettings,
}

struct Networks {
    table: TableNetwork,
    recognizer: ObjectRecognizer,
}

impl Networks {
    fn read(table: &[u8]) -> Result<Self, NetworkWeightsError> {
        let recognizer = ObjectRecognizer::read(RECOGNIZER.to_vec())?;
        Ok(Self { table: TableNetwork::read(table.to_vec(), recognizer.encoder())?, recognizer })
    }
}

/// Reason why the network cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadNetworkError {
    #[error("cannot read {}: {source}; name a file that training/train.py wrote, or \"built-in\"", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("cannot use the weights {}: {source}", path.display())]
    Unusable { path: PathBuf, source: NetworkWeightsError },
}

/// Built-in weights (`weights/README.md`).
const BUILT_IN: &[u8] = include_bytes!("../../../../../weights/table_network.safetensors");
const RECOGNIZER: &[u8] = include_bytes!("../../../../../weights/object_recognizer.safetensors");

impl ReadingNetwork {
    /// The built-in network.
    pub fn built_in(settings: NetworkReadingSettings) -> Arc<Self> {
        Arc::new(Self::new(BUILT_IN.into(), settings))
    }

    /// The network of a file from `training/train.py`.
    ///
    /// # Errors
    ///
    /// [`LoadNetworkError`] with the path and the reason.
    pub fn load(path: &Path, settings: NetworkReadingSettings) -> Result<Arc<Self>, LoadNetworkError> {
        let weights = std::fs::read(path)
            .map_err(|source| LoadNetworkError::Unreadable { path: path.to_owned(), source })?;
        let network = Self::new(weights.into(), settings);
        let read = Networks::read(&network.weights);
        let networks = read.map_err(|source| LoadNetworkError::Unusable { path: path.to_owned(), source })?;
        network.networks.get_or_init(|| networks);
        Ok(Arc::new(network))
    }

    fn new(weights: Cow<'static, [u8]>, settings: NetworkReadingSettings) -> Self {
        let digest = Sha256::new().chain_update(&weights).chain_update(RECOGNIZER).finalize();
        Self { weights, networks: OnceLock::new(), sha256: runtime::digest::hex(&digest), settings }
    }

    /// The likely categories of the objects of a reading of that image, by their pixels alone. None if the settings
    /// disable naming.
    ///
    /// # Errors
    ///
    /// [`NetworkError`] if the network has no answer, or `cancel` was set.
    pub fn guesses(
        &self,
        image: &Image,
        reading: &ImageReading,
        settings: &CategoryFitSettings,
        cancel: &CancelFlag,
    ) -> Result<Vec<Vec<CategoryGuess>>, NetworkError> {
        if settings.min_confidence >= 1.0 {
            return Ok(vec![Vec::new(); reading.objects.len()]);
        }
        let masks: Vec<&Mask> = reading.objects.iter().map(|object| &object.mask).collect();
        self.networks()?.recognizer.recognize(image, &masks, cancel)
    }

    fn networks(&self) -> Result<&Networks, NetworkError> {
        if let Some(networks) = self.networks.get() {
            return Ok(networks);
        }
        // Outside the lock: reading takes the threads of a pool, one of which may wait for this lock.
        let read = Networks::read(&self.weights)?;
        Ok(self.networks.get_or_init(|| read))
    }
}

/// Reads images from clients. Clones share their cache.
#[derive(Clone)]
pub struct ImageReader {
    network: Arc<ReadingNetwork>,
    pub settings: SingleViewSettings,
    cache: Arc<ReadingCache>,
}

/// Everything that determines a reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReaderIdentity {
    /// Digest of the weights, and the settings of the reader.
    network: (String, NetworkReadingSettings),
    #[serde(flatten)]
    settings: SingleViewSettings,
}

impl ImageReader {
    pub fn new(network: Arc<ReadingNetwork>, settings: SingleViewSettings) -> Self {
        Self { network, settings, cache: Arc::default() }
    }

    /// The reader of images whose camera has those intrinsics, in the terms of the setting.
    pub fn with_intrinsics(&self, intrinsics_px: [f64; 6]) -> Self {
        let mut settings = self.settings.clone();
        settings.sizes.intrinsics_px = intrinsics_px;
        Self::new(self.network.clone(), settings)
    }

    pub fn identity(&self) -> ReaderIdentity {
        let network = (self.network.sha256.clone(), self.network.settings.clone());
        ReaderIdentity { network, settings: self.settings.clone() }
    }

    /// Reads the image, with the depths of its pixels if they are known.
    ///
    /// # Errors
    ///
    /// A [`VisionError`] that names what was not found.
    pub fn reading(
        &self,
        image: &Image,
        depth: Option<&DepthImage>,
        cancel: &CancelFlag,
    ) -> Result<Arc<ImageReading>, VisionError> {
        let key = ImageKey::of(image, depth);
        if let Some(reading) = self.cache.find(&key) {
            return Ok(reading);
        }
        let table = &self.network.networks()?.table;
        let intrinsics = self.settings.sizes.intrinsics(image.width_px(), image.height_px());
        let known = KnownCamera { intrinsics, depth };
        let reading = Arc::new(read_with_network(image, table, &known, &self.network.settings, cancel)?);
        self.cache.keep(key, &reading);
        Ok(reading)
    }

    /// The likely categories of the objects of a reading of that image, on behalf of the analyst.
    pub(super) fn guesses(
        &self,
        image: &Image,
        reading: &ImageReading,
        cancel: &CancelFlag,
    ) -> Result<Vec<Vec<CategoryGuess>>, ProviderError> {
        let guesses = self.network.guesses(image, reading, &self.settings.naming, cancel);
        guesses.map_err(|error| Self::on_behalf(Port::Analyst, error.into()))
    }

    /// The candidate regions among which the reading selects objects.
    pub fn candidate_regions(
        &self,
        image: &Image,
        cancel: &CancelFlag,
    ) -> Result<CandidateRegions, VisionError> {
        candidate_regions(image, &self.network.networks()?.table, &self.network.settings, cancel)
    }

    /// Reads the image on behalf of a port.
    pub(super) fn read(
        &self,
        reference: &ReferenceImage,
        port: Port,
        cancel: &CancelFlag,
    ) -> Result<Arc<ImageReading>, ProviderError> {
        self.reading(&reference.image, reference.depth.as_deref(), cancel)
            .map_err(|error| Self::on_behalf(port, error))
    }

    fn on_behalf(port: Port, error: VisionError) -> ProviderError {
        match error {
            VisionError::Cancelled(cancelled) => ProviderError::Cancelled(cancelled),
            other => ProviderError::Rejected { port, code: other.code(), reason: other.to_string() },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_networks_load() {
        let network = ReadingNetwork::built_in(test_settings::section_without("network", &["weights"]));
        assert!(network.networks().is_ok());
    }

    #[test]
    fn load_error_names_file() {
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
