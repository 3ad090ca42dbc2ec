//! The learned feature extractor: [DINOv2](vision::dinov2) with weights from local files.
//!
//! The weights are read once at startup and never downloaded. The adapter's identity contains their digest, so results
//! of different weights have different keys.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;
use serde_json::json;
use sha2::{Digest as _, Sha256};

use imaging::Image;
use ports::{Adapter, Answer, Call, FeatureExtractor, Port, ProviderError};
use vision::dinov2::{Dinov2, Dinov2Error, Dinov2WeightsError};

/// Version of the computation; incremented when the same image and weights give other features than before.
const VERSION: u32 = 1;

/// Answers the feature port with the class token of DINOv2.
#[derive(Clone)]
pub struct Dinov2FeatureExtractor {
    model: Arc<Dinov2>,
    identity: Adapter,
}

/// Failure to load the weights.
#[derive(Debug, thiserror::Error)]
pub enum LoadWeightsError {
    #[error("cannot read {}: {source}; name a folder with model.safetensors and config.json", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("cannot use the weights {}: {source}", path.display())]
    Unusable { path: PathBuf, source: Dinov2WeightsError },
}

impl Dinov2FeatureExtractor {
    /// Loads `model.safetensors` and `config.json` from a folder, or a safetensors file with the `config.json` beside
    /// it.
    ///
    /// # Errors
    ///
    /// `Unreadable` if a file cannot be read, `Unusable` if the weights do not match the configuration.
    pub fn load(weights: &Path) -> Result<Self, LoadWeightsError> {
        let metadata = std::fs::metadata(weights).map_err(unreadable(weights))?;
        let model_path =
            if metadata.is_dir() { weights.join("model.safetensors") } else { weights.to_owned() };
        let config_path = model_path.with_file_name("config.json");
        let config = read(&config_path)?;
        let tensors = read(&model_path)?;
        let digest = digest(&tensors);
        let model = Dinov2::read(&config, tensors).map_err(|source| {
            let is_config_error = matches!(source, Dinov2WeightsError::Config { .. });
            let path = if is_config_error { config_path } else { model_path };
            LoadWeightsError::Unusable { path, source }
        })?;
        let settings = json!({
            "architecture": model.architecture(),
            "side_px": model.side_px(),
            "vector_instructions": vector_instructions(),
        });
        let identity = Adapter::new("embedded/dinov2", &format!("{VERSION} sha256:{digest}"), &settings);
        Ok(Self { model: Arc::new(model), identity })
    }
}

impl FeatureExtractor for Dinov2FeatureExtractor {
    fn adapter(&self) -> Adapter {
        self.identity.clone()
    }

    fn features<'a>(&'a self, call: &'a Call, images: Vec<Arc<Image>>) -> Answer<'a, Vec<Vec<f32>>> {
        let model = self.model.clone();
        Box::pin(call.compute(Port::FeatureExtractor, move |cancel| {
            images.par_iter().map(|image| model.features(image, cancel).map_err(provider_error)).collect()
        }))
    }
}

fn provider_error(error: Dinov2Error) -> ProviderError {
    let port = Port::FeatureExtractor;
    match error {
        Dinov2Error::Cancelled(cancelled) => cancelled.into(),
        Dinov2Error::NotFinite => {
            let reason = format!("computing DINOv2 features of an image: {error}");
            ProviderError::Rejected { port, code: "features_not_finite", reason }
        }
        Dinov2Error::Computation(_) => ProviderError::Died { port, reason: error.to_string() },
    }
}

fn read(path: &Path) -> Result<Vec<u8>, LoadWeightsError> {
    std::fs::read(path).map_err(unreadable(path))
}

fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> LoadWeightsError {
    move |source| LoadWeightsError::Unreadable { path: path.to_owned(), source }
}

/// SHA-256 in lowercase hexadecimal digits.
fn digest(bytes: &[u8]) -> String {
    runtime::digest::hex(&Sha256::digest(bytes))
}

/// The vector instruction set, which determines the order of sums and thus the last bits of the features.
fn vector_instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            return "avx512f";
        }
        if is_x86_feature_detected!("fma") {
            return "fma";
        }
    }
    "baseline"
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::CancelFlag;
    use runtime::CpuPool;

    fn golden() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/golden/dinov2/mlp")
    }

    #[tokio::test]
    async fn features_are_unit_vectors_and_independent_of_thread_count() {
        let extractor = Dinov2FeatureExtractor::load(&golden()).expect("the golden weights");
        let images = [[200, 30, 30, 255], [30, 30, 200, 255]].map(|c| Arc::new(Image::filled(40, 30, c)));
        let mut answers = Vec::new();
        for threads in [1, 3] {
            let call = Call::without_budget(CpuPool::new(threads).expect("a pool"), CancelFlag::default());
            answers.push(extractor.features(&call, images.to_vec()).await.expect("an answer"));
        }
        for feature in &answers[0] {
            assert!((feature.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
        }
        assert_ne!(answers[0][0], answers[0][1]);
        assert_eq!(answers[0], answers[1]);
    }

    #[tokio::test]
    async fn cancelled_call_returns_error() {
        let extractor = Dinov2FeatureExtractor::load(&golden()).expect("the golden weights");
        let call = Call::without_budget(CpuPool::new(1).expect("a pool"), CancelFlag::default());
        call.cancel.cancel();
        let answer = extractor.features(&call, vec![Arc::new(Image::filled(4, 4, [9, 9, 9, 255]))]).await;
        assert!(matches!(answer, Err(ProviderError::Cancelled(_))));
    }

    #[test]
    fn identity_depends_on_weight_bytes_only() {
        let identity = |weights: &Path| Dinov2FeatureExtractor::load(weights).expect("weights").adapter();
        let folder = tempfile::tempdir().expect("temporary directory");
        for name in ["model.safetensors", "config.json"] {
            std::fs::copy(golden().join(name), folder.path().join(name)).expect("copies");
        }
        let file = folder.path().join("model.safetensors");
        assert_eq!(identity(folder.path()), identity(&golden()), "not the place counts, but the bytes");
        assert_eq!(identity(&file), identity(&golden()), "a file and its folder are the same");
        assert_eq!(identity(&golden()).name, "embedded/dinov2");
        let mut bytes = std::fs::read(&file).expect("reads");
        *bytes.last_mut().expect("bytes") ^= 1;
        std::fs::write(&file, bytes).expect("writes");
        assert_ne!(identity(folder.path()).model, identity(&golden()).model);
    }

    #[test]
    fn load_error_names_file_and_cause() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let load_error = || match Dinov2FeatureExtractor::load(folder.path()) {
            Ok(_) => panic!("is loaded"),
            Err(error) => error.to_string(),
        };
        let text = load_error();
        assert!(text.contains("cannot read") && text.contains("config.json"), "{text}");
        let nowhere = Dinov2FeatureExtractor::load(&folder.path().join("nowhere")).err().expect("is refused");
        assert!(nowhere.to_string().contains("nowhere: No such file"), "{nowhere}");
        std::fs::copy(golden().join("config.json"), folder.path().join("config.json")).expect("copies");
        assert!(load_error().contains("model.safetensors: No such file"), "{}", load_error());
        std::fs::write(folder.path().join("model.safetensors"), "what").expect("writes");
        assert!(load_error().contains("the file is not a safetensors file"), "{}", load_error());
        let swiglu = golden().with_file_name("swiglu").join("model.safetensors");
        std::fs::copy(swiglu, folder.path().join("model.safetensors")).expect("copies");
        let text = load_error();
        assert!(text.contains("tensor embeddings.patch_embeddings.projection.weight has shape"), "{text}");
    }
}
