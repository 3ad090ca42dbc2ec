//! Requests of a batch as submissions: checked as the server checks the body of `POST /scenes`.

use std::path::PathBuf;

use bytes::Bytes;

use crate::api::batches::refused;
use crate::api::submission::{self, SceneBody, Submission};
use crate::api::{self, Validate};
use crate::app;
use crate::app::config::Resolved;
use batches::{BatchRequest, OutputError};

/// Checks requests.
pub(super) struct Checker {
    settings: api::Settings,
    validate: Validate,
    /// Folder from which relative paths of images begin.
    folder: PathBuf,
}

impl Checker {
    pub(super) fn new(resolved: &Resolved, folder: PathBuf) -> Self {
        let settings = resolved.config.server.clone();
        Self { settings, validate: app::pipeline::validate(resolved), folder }
    }

    /// The most that a scene may cost where its request does not state it, US dollars.
    pub(super) fn usual_budget_usd(&self) -> f64 {
        self.settings.usual_budget_usd
    }

    /// The submission of a request, or what is wrong with it.
    pub(super) fn submission(&self, request: &BatchRequest) -> Result<Submission, OutputError> {
        let image = self.image(request)?;
        let body = SceneBody {
            text: request.body.text.clone(),
            seed: Some(request.body.seed()),
            labels: request.body.labels.clone(),
            options: request.body.options.clone(),
            ..SceneBody::default()
        };
        submission::validate(body, image, &self.settings, &self.validate).map_err(refused)
    }

    fn image(&self, request: &BatchRequest) -> Result<Option<Bytes>, OutputError> {
        let Some(image) = &request.body.image else { return Ok(None) };
        let path = self.folder.join(&image.path);
        let wrong = |detail: String| {
            let message = format!("the image {} {detail}", path.display());
            OutputError::new("image_unreadable", message).at("/body/image/path")
        };
        let about = std::fs::metadata(&path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
        let limit = self.settings.max_image_bytes;
        if !about.is_file() {
            return Err(wrong("is not a file".into()));
        }
        if about.len() > limit as u64 {
            return Err(wrong(format!("has {} bytes; give one of at most {limit}", about.len())));
        }
        let bytes = std::fs::read(&path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
        Ok(Some(bytes.into()))
    }
}
