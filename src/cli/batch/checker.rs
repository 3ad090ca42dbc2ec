//! Requests of a batch as submissions: checked as the server checks the body of `POST /scenes`.

use std::path::PathBuf;

use bytes::Bytes;

use crate::app::App;
use crate::app::config::Resolved;
use crate::app::submission::Submission;
use batches::{BatchRequest, OutputError};

/// Checks requests.
pub(super) struct Checker {
    app: App,
    /// Folder from which relative paths of images begin.
    folder: PathBuf,
}

impl Checker {
    pub(super) fn new(resolved: &Resolved, folder: PathBuf) -> Self {
        Self { app: App::new(resolved), folder }
    }

    /// The most that a scene may cost where its request does not state it, US dollars.
    pub(super) fn usual_budget_usd(&self) -> f64 {
        self.app.config().server.usual_budget_usd
    }

    /// The submission of a request, or what is wrong with it.
    pub(super) fn submission(&self, request: &BatchRequest) -> Result<Submission, OutputError> {
        self.app.check_batch_request(request, self.image(request)?)
    }

    fn image(&self, request: &BatchRequest) -> Result<Option<Bytes>, OutputError> {
        let Some(image) = &request.body.image else { return Ok(None) };
        let path = self.folder.join(&image.path);
        let wrong = |detail: String| {
            let message = format!("the image {} {detail}", path.display());
            OutputError::new("image_unreadable", message).at("/body/image/path")
        };
        let about = std::fs::metadata(&path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
        let limit = self.app.config().server.max_image_bytes;
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
