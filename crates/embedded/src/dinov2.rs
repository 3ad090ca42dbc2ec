//! The learned feature extractor: [DINOv2](vision::dinov2) with weights from local files.
//!
//! They are read once, when the program starts, and never fetched. The adapter's identity carries their digest, so
//! that results made with others are not taken for theirs.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;
use serde_json::json;
use sha2::{Digest as _, Sha256};

use imaging::Image;
use ports::{Adapter, Answer, Call, FeatureExtractor, Port, ProviderError};
use vision::dinov2::{Dinov2, Dinov2Error, Dinov2WeightsError};

/// Raised when the same picture and weights give other features than before.
const VERSION: u32 = 1;

/// Answers the feature port with the class token of DINOv2.
#[derive(Clone)]
pub struct Dinov2FeatureExtractor {
    model: Arc<Dinov2>,
    identity: Adapter,
}

/// Why there is no extractor.
#[derive(Debug, thiserror::Error)]
pub enum LoadWeightsError {
    #[error("cannot read {}: {source}; name a folder with model.safetensors and config.json", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("cannot use the weights {}: {source}", path.display())]
    Unusable { path: PathBuf, source: Dinov2WeightsError },
}

impl Dinov2FeatureExtractor {
    /// Reads `model.safetensors` and `config.json` in a folder, or a safetensors file and the `config.json` beside it.
    pub fn load(weights: &Path) -> Result<Self, LoadWeightsError> {
        let about = std::fs::metadata(weights).map_err(unreadable(weights))?;
        let model_path = if about.is_dir() { weights.join("model.safetensors") } else { weights.to_owned() };
        let config_path = model_path.with_file_name("config.json");
        let config = read(&config_path)?;
        let tensors = read(&model_path)?;
        let digest = digest(&tensors);
        let model = Dinov2::read(&config, tensors).map_err(|source| {
            let at_fault = matches!(source, Dinov2WeightsError::Config { .. });
            let path = if at_fault { config_path } else { model_path };
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

    fn features<'a>(&'a self, call: &'a Call, pictures: Vec<Arc<Image>>) -> Answer<'a, Vec<Vec<f32>>> {
        let model = self.model.clone();
        Box::pin(call.compute(Port::FeatureExtractor, move |interrupt| {
            pictures
                .par_iter()
                .map(|picture| model.features(picture, interrupt).map_err(provider_error))
                .collect()
        }))
    }
}

fn provider_error(error: Dinov2Error) -> ProviderError {
    let port = Port::FeatureExtractor;
    match error {
        Dinov2Error::Interrupted(interrupted) => interrupted.into(),
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

/// In lowercase hexadecimal digits.
fn digest(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// What the order of sums depends on, and with it the last bits of the features.
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
    use runtime::Cpu;
    use runtime::Interrupt;

    fn golden() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/dinov2/mlp")
    }

    #[tokio::test]
    async fn every_picture_gets_its_unit_vector_whatever_the_number_of_threads() {
        let extractor = Dinov2FeatureExtractor::load(&golden()).expect("the golden weights");
        let pictures = [[200, 30, 30, 255], [30, 30, 200, 255]].map(|c| Arc::new(Image::filled(40, 30, c)));
        let mut answers = Vec::new();
        for threads in [1, 3] {
            let call = Call::without_budget(Cpu::new(threads).expect("a pool"), Interrupt::default());
            answers.push(extractor.features(&call, pictures.to_vec()).await.expect("an answer"));
        }
        for feature in &answers[0] {
            assert!((feature.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
        }
        assert_ne!(answers[0][0], answers[0][1]);
        assert_eq!(answers[0], answers[1]);
    }

    #[tokio::test]
    async fn an_interrupted_call_says_so() {
        let extractor = Dinov2FeatureExtractor::load(&golden()).expect("the golden weights");
        let call = Call::without_budget(Cpu::new(1).expect("a pool"), Interrupt::default());
        call.interrupt.raise();
        let answer = extractor.features(&call, vec![Arc::new(Image::filled(4, 4, [9, 9, 9, 255]))]).await;
        assert!(matches!(answer, Err(ProviderError::Interrupted(_))));
    }

    #[test]
    fn the_identity_changes_with_the_weights() {
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
    fn what_cannot_be_loaded_is_named() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let complaint = || match Dinov2FeatureExtractor::load(folder.path()) {
            Ok(_) => panic!("is loaded"),
            Err(error) => error.to_string(),
        };
        let text = complaint();
        assert!(text.contains("cannot read") && text.contains("config.json"), "{text}");
        let nowhere = Dinov2FeatureExtractor::load(&folder.path().join("nowhere")).err().expect("is refused");
        assert!(nowhere.to_string().contains("nowhere: No such file"), "{nowhere}");
        std::fs::copy(golden().join("config.json"), folder.path().join("config.json")).expect("copies");
        assert!(complaint().contains("model.safetensors: No such file"), "{}", complaint());
        std::fs::write(folder.path().join("model.safetensors"), "what").expect("writes");
        assert!(complaint().contains("model.safetensors is not a safetensors file"), "{}", complaint());
        let swiglu = golden().with_file_name("swiglu").join("model.safetensors");
        std::fs::copy(swiglu, folder.path().join("model.safetensors")).expect("copies");
        let text = complaint();
        assert!(text.contains("tensor embeddings.patch_embeddings.projection.weight has shape"), "{text}");
    }
}
