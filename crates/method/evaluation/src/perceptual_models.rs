//! The three models of the visual and perceptual columns, each there if its weights are.
//!
//! Published weights are not part of the program. A model whose files are missing is no error and no number: the result
//! names the file. A file that exists and is unfit is an error.

use std::io;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use vision::clip::{ClipImageTower, ClipWeightsError};
use vision::dinov2::{Dinov2, Dinov2WeightsError};
use vision::lpips::{Lpips, LpipsNetwork, LpipsWeightsError};

/// A column of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Distance by LPIPS 0.1; lower is better.
    Lpips,
    /// Cosine of the class tokens of DINOv2, -1..1; higher is better.
    Dinov2,
    /// Cosine of the image embeddings of CLIP, -1..1; higher is better.
    Clip,
}

/// A file below the folder of weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WeightsFile {
    LpipsBackbone,
    LpipsLinearLayers,
    Dinov2Config,
    Dinov2Model,
    ClipConfig,
    ClipModel,
}

/// A file that a metric needs and that is not there.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MissingWeights {
    /// Path below the folder of weights.
    #[schemars(length(min = 1))]
    pub file: String,
}

/// A model, or the reason for its absence.
pub enum Model<M> {
    Loaded(Box<M>),
    Missing(MissingWeights),
}

/// The models that score views.
pub struct PerceptualModels {
    pub lpips: Model<Lpips>,
    pub dinov2: Model<Dinov2>,
    pub clip: Model<ClipImageTower>,
}

/// Reason why weights that are there cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum WeightsError {
    #[error(
        "cannot read the weights {file}: {source}; make the file readable, or remove it to go without the metric"
    )]
    Unreadable { file: &'static str, source: io::Error },
    #[error("cannot use the weights in lpips/: {0}; convert them as docs/models.md describes")]
    Lpips(#[from] LpipsWeightsError),
    #[error("cannot use the weights in dinov2/: {0}; download both files of one model of Hugging Face")]
    Dinov2(#[from] Dinov2WeightsError),
    #[error("cannot use the weights in clip/: {0}; download both files of one model of Hugging Face")]
    Clip(#[from] ClipWeightsError),
}

impl Metric {
    /// All of them, in the order of the paper's table.
    pub const ALL: [Self; 3] = [Self::Lpips, Self::Dinov2, Self::Clip];

    /// Name in tables.
    pub fn title(self) -> &'static str {
        match self {
            Self::Lpips => "LPIPS",
            Self::Dinov2 => "DINOv2",
            Self::Clip => "CLIP",
        }
    }

    /// Name in CSV files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lpips => "lpips",
            Self::Dinov2 => "dinov2",
            Self::Clip => "clip",
        }
    }

    /// Whether a score is closer to the reference image than another.
    pub fn is_better(self, score: f64, than: f64) -> bool {
        match self {
            Self::Lpips => score < than,
            Self::Dinov2 | Self::Clip => score > than,
        }
    }
}

impl WeightsFile {
    /// Path below the folder of weights.
    pub fn path(self) -> &'static str {
        match self {
            Self::LpipsBackbone => "lpips/backbone.safetensors",
            Self::LpipsLinearLayers => "lpips/linear_layers.safetensors",
            Self::Dinov2Config => "dinov2/config.json",
            Self::Dinov2Model => "dinov2/model.safetensors",
            Self::ClipConfig => "clip/config.json",
            Self::ClipModel => "clip/model.safetensors",
        }
    }
}

impl<M> Model<M> {
    /// The model, if it is there.
    pub fn loaded(&self) -> Option<&M> {
        match self {
            Self::Loaded(model) => Some(model),
            Self::Missing(_) => None,
        }
    }
}

impl PerceptualModels {
    /// Reads all models by `bytes_of`, which gives the content of a [`WeightsFile`] or an error; `NotFound` means a
    /// missing file. LPIPS is that of the network.
    ///
    /// # Errors
    ///
    /// A [`WeightsError`] that names the file, for a file that is there and cannot be read or used.
    pub fn read(
        network: LpipsNetwork,
        mut bytes_of: impl FnMut(WeightsFile) -> io::Result<Vec<u8>>,
    ) -> Result<Self, WeightsError> {
        let mut pair = |first, second| pair(first, second, &mut bytes_of);
        let lpips = pair(WeightsFile::LpipsBackbone, WeightsFile::LpipsLinearLayers)?;
        let dinov2 = pair(WeightsFile::Dinov2Config, WeightsFile::Dinov2Model)?;
        let clip = pair(WeightsFile::ClipConfig, WeightsFile::ClipModel)?;
        Ok(Self {
            lpips: model(lpips, |backbone, linear| Lpips::read(network, backbone, linear))?,
            dinov2: model(dinov2, |config, tensors| Dinov2::read(&config, tensors))?,
            clip: model(clip, |config, tensors| ClipImageTower::read(&config, tensors))?,
        })
    }
}

/// The contents of both files of a model, or the first that is missing.
type Files = Result<[Vec<u8>; 2], MissingWeights>;

fn pair(
    first: WeightsFile,
    second: WeightsFile,
    bytes_of: &mut impl FnMut(WeightsFile) -> io::Result<Vec<u8>>,
) -> Result<Files, WeightsError> {
    let mut contents = Vec::new();
    for file in [first, second] {
        match bytes_of(file) {
            Ok(bytes) => contents.push(bytes),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(Err(MissingWeights { file: file.path().to_owned() }));
            }
            Err(source) => return Err(WeightsError::Unreadable { file: file.path(), source }),
        }
    }
    let second = contents.pop().unwrap_or_default();
    Ok(Ok([contents.pop().unwrap_or_default(), second]))
}

fn model<M, E: Into<WeightsError>>(
    files: Files,
    read: impl FnOnce(Vec<u8>, Vec<u8>) -> Result<M, E>,
) -> Result<Model<M>, WeightsError> {
    Ok(match files {
        Ok([first, second]) => Model::Loaded(Box::new(read(first, second).map_err(Into::into)?)),
        Err(missing) => Model::Missing(missing),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_files_are_named_and_no_error() {
        let read = |present: &[WeightsFile]| {
            PerceptualModels::read(LpipsNetwork::AlexNet, |file| match present.contains(&file) {
                true => Ok(golden(file)),
                false => Err(io::ErrorKind::NotFound.into()),
            })
            .expect("golden files are fit")
        };
        let file = |model: &Model<Lpips>| match model {
            Model::Missing(missing) => missing.file.clone(),
            Model::Loaded(_) => "none".to_owned(),
        };
        assert_eq!(file(&read(&[]).lpips), "lpips/backbone.safetensors");
        assert_eq!(file(&read(&[WeightsFile::LpipsBackbone]).lpips), "lpips/linear_layers.safetensors");
        let both = read(&[WeightsFile::LpipsBackbone, WeightsFile::LpipsLinearLayers]);
        assert_eq!(file(&both.lpips), "none");
        assert!(both.clip.loaded().is_none() && both.dinov2.loaded().is_none());
        assert!(matches!(&both.clip, Model::Missing(missing) if missing.file == "clip/config.json"));
    }

    #[test]
    fn files_that_are_there_and_unfit_are_errors() {
        let read = |bytes: fn() -> io::Result<Vec<u8>>| {
            PerceptualModels::read(LpipsNetwork::Vgg16, |_| bytes()).err().expect("is refused").to_string()
        };
        let text = read(|| Ok(b"none".to_vec()));
        assert!(
            text.contains("in lpips/") && text.contains("vgg16: the file is not a safetensors file"),
            "{text}"
        );
        let text = read(|| Err(io::ErrorKind::PermissionDenied.into()));
        assert!(
            text.contains("cannot read the weights lpips/backbone.safetensors: permission denied"),
            "{text}"
        );
    }

    fn golden(file: WeightsFile) -> Vec<u8> {
        match file {
            WeightsFile::LpipsBackbone => {
                include_bytes!("../../../../tests/golden/lpips/alexnet/backbone.safetensors").to_vec()
            }
            WeightsFile::LpipsLinearLayers => {
                include_bytes!("../../../../tests/golden/lpips/alexnet/linear_layers.safetensors").to_vec()
            }
            _ => Vec::new(),
        }
    }
}
