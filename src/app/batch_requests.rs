//! The check of one request of a batch, by the rules of a request for a scene.

use bytes::Bytes;

use super::App;
use super::submission::{SceneOrder, Submission};
use super::terms::Terms;
use crate::problem::Problem;
use batches::{BatchRequest, OutputError};

impl App {
    /// Checks a request of a batch, with the content of its image if it has one.
    ///
    /// # Errors
    ///
    /// An [`OutputError`] with every violation and the place of the first.
    pub fn check_batch_request(
        &self,
        request: &BatchRequest,
        image: Option<Bytes>,
    ) -> Result<Submission, OutputError> {
        let terms = Terms {
            seed: Some(request.body.seed()),
            labels: request.body.labels.clone(),
            options: request.body.options.clone(),
            ..Terms::default()
        };
        self.check_scene(SceneOrder { text: request.body.text.clone(), image, depth: None, terms })
            .map_err(refused)
    }
}

/// The refusal of a scene as an error of a request of a batch.
fn refused(problem: Problem) -> OutputError {
    let Some(first) = problem.errors.first() else {
        return OutputError::new(problem.own_code(), problem.detail);
    };
    let pointer = format!("/body{}", first.pointer);
    let details: Vec<&str> = problem.errors.iter().map(|error| error.detail.as_str()).collect();
    OutputError::new("invalid_request", details.join("; ")).at(pointer)
}
